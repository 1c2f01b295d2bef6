"""Figure of the claims: where each holds over the grid, and where SC-PID fails and what mends it."""

from __future__ import annotations

from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np

from valvemodel.control.claims import claims_of, shares_along
from valvemodel.control.grid import KEYS, Grid
from valvemodel.control.kinds import kind_of

PLANES = (
    ("friction_ratio", "gain_factor"),
    ("friction_ratio", "friction_growth"),
    ("period_factor", "noise_factor"),
)
"""Pairs of factors; a square shows the share of cases over all other factors."""


def draw_claims(grid: Grid, place: Path) -> None:
    """Draw the claims into an image file."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    rows = [(f"“{text}”", holds) for text, holds in claims_of(grid).values()]
    rows.append(("SC-PID fails: a set point not settled, or a cycle beyond the band", ~grid.is_well("sc_pid_mean")))
    with mpl.rc_context({"font.size": 8.5}):
        figure = Figure(figsize=(13.5, 2.45 * (len(rows) + 1) + 0.7), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.add_gridspec(len(rows) + 1, len(PLANES))
        for row, (text, holds) in enumerate(rows):
            for column, plane in enumerate(PLANES):
                image = _draw_plane(figure.add_subplot(axes[row, column]), grid, holds, plane)
                if column == 0:
                    title = f"{fill(text, 62)}: {100 * holds.mean():.0f} % of {holds.size} cases"
                    figure.axes[-1].set_title(title, loc="left", fontsize=9.5, fontweight="bold")
        bar = figure.colorbar(image, ax=figure.axes, shrink=0.35, aspect=40, pad=0.01)
        bar.set_label("share of cases in which it holds [%]")
        _draw_mends(figure.add_subplot(axes[len(rows), :]), grid)
        figure.suptitle(
            f"The paper's claims on {grid.model.name}: gains tuned once at F_s/F_c = 1.2, "
            f"{1e3 * grid.period:g} ms and {1e3 * grid.noise:g} mm of noise, then everything varied",
            fontsize=11,
        )
        figure.savefig(place, dpi=100)


def _draw_plane(axes: Any, grid: Grid, holds: np.ndarray, plane: tuple[str, str]) -> Any:
    names = list(grid.factors)
    shares = 100.0 * shares_along(grid, holds, *(names.index(name) for name in plane)).T
    image = axes.imshow(shares, origin="lower", aspect="auto", cmap="cividis", vmin=0.0, vmax=100.0)
    for (row, column), share in np.ndenumerate(shares):
        axes.text(column, row, f"{share:.0f}", ha="center", va="center", color="black" if share > 55.0 else "white")
    for axis, name in ((axes.xaxis, plane[0]), (axes.yaxis, plane[1])):
        levels = grid.factors[name]
        axis.set_ticks(range(len(levels)), [_level(grid, name, level) for level in levels])
        axis.set_label_text(_LABELS[name])
    return image


_LABELS = {
    "friction_ratio": "F_s / F_c [1]",
    "gain_factor": "gains over tuned [1]",
    "period_factor": "controller period [ms]",
    "noise_factor": "noise [mm]",
    "friction_growth": "friction grown by [%]",
}


def _level(grid: Grid, name: str, level: float) -> str:
    if name == "period_factor":
        return f"{1e3 * grid.period * level:g}"
    if name == "noise_factor":
        return f"{1e3 * grid.noise * level:g}"
    return f"{100.0 * level:g}" if name == "friction_growth" else f"{level:g}"


def _draw_mends(axes: Any, grid: Grid) -> None:
    fails = ~grid.is_well("sc_pid_mean")
    order = sorted(KEYS, key=lambda key: grid.is_well(key).mean())
    for row, key in enumerate(order):
        well = grid.is_well(key)
        axes.barh(row + 0.2, 100.0 * well.mean(), 0.38, color="#0072B2", label="of all cases" if row == 0 else None)
        mended = 100.0 * well[fails].mean() if fails.any() else 0.0
        axes.barh(row - 0.2, mended, 0.38, color="#E69F00", label="of SC-PID's failures" if row == 0 else None)
        axes.text(100.0 * well.mean() + 0.5, row + 0.2, f"{100.0 * well.mean():.0f}", va="center", fontsize=8)
        axes.text(mended + 0.5, row - 0.2, f"{mended:.0f}", va="center", fontsize=8)
    axes.set_yticks(range(len(order)), [kind_of(key).title for key in order])
    axes.set_xlim(0.0, 105.0)
    axes.set_xlabel("settles at every set point, no cycle beyond the band [%]")
    axes.set_title("What does better, and what mends SC-PID", loc="left", fontsize=9.5, fontweight="bold")
    axes.legend(loc="lower right")
    axes.grid(visible=True, axis="x", alpha=0.3)
