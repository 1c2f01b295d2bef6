"""Figure of a contest: every controller's course on the same set points, and its integral of error."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from valvemodel.control.contest import Contest, Entry
from valvemodel.quantities import format_quantity

SETPOINT, POSITION, CURRENT = "#444444", "#0072B2", "#D55E00"
"""Okabe and Ito's colours, told apart by all."""

COLUMNS = 4
ROOM = 6.0
"""Factor by which the axis of the bars goes on, for their names."""
MILLI = 1e3


def draw_contest(contest: Contest, places: list[Path]) -> None:
    """Draw a contest into image files; the suffix says which kind."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    rows = -(-(len(contest.entries) + 2) // COLUMNS)
    with mpl.rc_context({"font.size": 8.5, "axes.grid": True, "grid.alpha": 0.3, "svg.hashsalt": "valvemodel"}):
        figure = Figure(figsize=(4.2 * COLUMNS, 3.5 * rows + 0.8), layout="constrained")
        FigureCanvasAgg(figure)
        grid = figure.add_gridspec(2 * rows, COLUMNS, height_ratios=[2.0, 1.0] * rows)
        first = None
        for index, entry in enumerate(contest.entries):
            row, column = divmod(index, COLUMNS)
            upper = figure.add_subplot(grid[2 * row, column], sharex=first, sharey=first)
            first = first or upper
            lower = figure.add_subplot(grid[2 * row + 1, column], sharex=first)
            _draw_entry(upper, lower, entry, is_leftmost=column == 0)
        row, column = divmod(len(contest.entries), COLUMNS)
        _draw_bars(figure.add_subplot(grid[2 * row : 2 * row + 2, column:]), contest)
        figure.suptitle(_heading(contest), fontsize=11)
        figure.draw_without_rendering()
        figure.set_layout_engine("none")
        for place in places:
            figure.savefig(place, dpi=110, metadata={"Date": None} if place.suffix == ".svg" else None)


def _heading(contest: Contest) -> str:
    scenario, model = contest.scenario, contest.bench.model
    effects = ", ".join(sorted(model.effects)) or "no effects: static equals sliding friction"
    conditions = f"period {1e3 * scenario.period:g} ms, noise {_noise(contest)}"
    return (
        f"{model.name} ({effects}), {conditions}; each controller tuned by {contest.budget} runs on other set points"
        "\nset point (dashed) and stem position above, current below"
    )


def _noise(contest: Contest) -> str:
    import numpy as np

    return format_quantity(float(np.std(contest.scenario.noise)), "m", digits=2)


def _draw_entry(upper: Any, lower: Any, entry: Entry, *, is_leftmost: bool) -> None:
    run = entry.run
    upper.plot(run.time, MILLI * run.setpoint, color=SETPOINT, linestyle="--", linewidth=0.9, drawstyle="steps-post")
    upper.plot(run.time, MILLI * run.position, color=POSITION, linewidth=1.1)
    lower.plot(run.time, MILLI * run.current, color=CURRENT, linewidth=0.8, drawstyle="steps-post")
    lower.set_ylim(3.5, 20.5)
    lower.set_yticks([4, 12, 20])
    upper.tick_params(labelbottom=False)
    lower.set_xlabel("time [s]")
    if is_leftmost:
        upper.set_ylabel("position [mm]")
        lower.set_ylabel("current [mA]")
    measured = entry.overall
    upper.set_title(
        f"{entry.kind.title}\nsettled {100 * measured['settled_share']:.0f} %, "
        f"overshoot {MILLI * measured['overshoot']:.2g} mm, {measured['reversals']:.0f} reversals",
        fontsize=8.5,
    )


def _draw_bars(axes: Any, contest: Contest) -> None:
    entries = contest.entries[::-1]
    integrals = [MILLI * entry.overall["integral_absolute_error"] for entry in entries]
    axes.barh(range(len(entries)), integrals, color=POSITION)
    axes.set_xscale("log")
    for row, (entry, value) in enumerate(zip(entries, integrals, strict=True)):
        axes.text(value, row, f"  {value:.3g}   {entry.kind.title}", va="center", fontsize=8)
    axes.set_yticks([])
    axes.set_xlim(0.7 * min(integrals), ROOM * max(integrals))
    axes.set_xlabel("integral of the absolute error [mm s], log scale")
    axes.set_title("all set points together; shorter is better", fontsize=8.5)
    axes.grid(visible=False, axis="y")
