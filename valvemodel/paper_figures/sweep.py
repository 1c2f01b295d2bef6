"""Figures 5 and 6: position against current, as Table 2 gives it and as the text describes it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from valvemodel.drawing import BLUE, GREY, INK, ORANGE, VERMILLION
from valvemodel.equations import numeric
from valvemodel.model import Model
from valvemodel.paper_figures.settled import SettledLoop, settled_loop
from valvemodel.valves import read_valve

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CORNERS = (6e-3, 20e-3, 7e-3, 20e-3)
"""States 1 to 4: up from 6 mA, down to 7 mA, up again; a state of rest begins at each turn. [A]"""

TEXT_POINTS = ((20e-3, 0.263, 1.0), (7e-3, 0.2131, -1.0))
"""Where states 2 and 4 of the text begin: current, position and the side from which the stem came. [A], [m]"""

LARGEST_GAP = 3e-4
"""Maximum gap of Table 2. [m]"""

CURVES = (
    (VERMILLION, "o", 3.5, "1: rising"),
    (GREY, "s", 3.5, "2: the stem rests"),
    (BLUE, "o", 3.5, "3: falling"),
    (ORANGE, "D", 6.5, "4: the stem rests, then rises"),
)
"""Colour, mark and its size; the last is drawn hollow around the first."""


@dataclass(frozen=True)
class Sweep:
    """One of the two figures: what the printed table gives, and two valves that move."""

    number: int
    factor: float
    printed: SettledLoop
    printed_gap: np.ndarray
    calibrated: SettledLoop
    text: SettledLoop
    closing: float
    values: Mapping[str, float]

    def as_json(self) -> dict[str, Any]:
        """Return the data behind the figure."""
        return {
            "ansatz_factor_n": self.factor,
            "as_printed": {**self.printed.as_json(), "gap": {"value": self.printed_gap, "unit": "m"}},
            "calibrated": self.calibrated.as_json(),
            "through_the_points_of_the_text": self.text.as_json(),
            "gap_of_the_text": {
                "gap_offset": {"value": self.values["gap_offset"], "unit": "m"},
                "gap_gain": {"value": self.values["gap_gain"], "unit": "m/A^0.5"},
            },
        }


def sweep(number: int, factor: float) -> Sweep:
    """Sweep the three valves with the factor n of the ansatz; it scales the current, so the gap's gain by its root."""
    table, usual = read_valve("table2").values, read_valve("calibrated").values
    coil = {name: read_valve("table2").entries[name].value for name in _COIL}
    printed_gain = numeric.gap_gain_of_coil_as_printed(**coil, ansatz_factor=factor)
    printed = Model("Table 2 as printed", {**table, "gap_gain": printed_gain})
    through = {**usual, **gap_through(TEXT_POINTS, usual)}
    gains = [math.sqrt(factor) * values["gap_gain"] for values in (usual, through)]
    calibrated, text = (
        Model(name, {**values, "gap_gain": gain})
        for name, values, gain in zip(("calibrated", "text"), (usual, through), gains, strict=True)
    )
    closing = (usual["gap_offset"] / gains[0]) ** 2
    top = min(CORNERS[1], closing - closing % 1e-3)
    loop = settled_loop(printed, CORNERS, start_position=0.0)
    return Sweep(
        number, factor, loop, numeric.coil_gap(loop.current, table["gap_offset"], printed_gain),
        _from_branch(calibrated, (CORNERS[0], top, CORNERS[2], top)), _from_branch(text, CORNERS), closing,
        {"gap_offset": through["gap_offset"], "gap_gain": gains[1]},
    )  # fmt: skip


_COIL = ("coil_turns", "magnetic_area", "supply_voltage", "leakage_coefficient", "ansatz_exponent")


def gap_through(points: tuple[tuple[float, float, float], ...], values: Mapping[str, float]) -> dict[str, float]:
    """Return the gap law whose branches pass two points; (16) solved for the gap. [m], [m/A^0.5]"""
    roots, gaps = [], []
    for current, position, side in points:
        force = values["spring_rate"] * position + side * values["coulomb_friction"]
        pressure = force / values["diaphragm_area"]
        roots.append(math.sqrt(current))
        gaps.append(math.sqrt((values["supply_pressure"] / pressure - 1.0) / values["flow_ratio"]))
    gain = (gaps[1] - gaps[0]) / (roots[0] - roots[1])
    return {"gap_offset": gaps[0] + gain * roots[0], "gap_gain": gain}


def _from_branch(model: Model, corners: tuple[float, ...]) -> SettledLoop:
    from valvemodel.linear import operating_point

    return settled_loop(model, corners, start_position=operating_point(model, current=corners[0]).position)


def draw_sweep(figure: Figure, found: Sweep) -> None:
    """Draw gap and position of the printed table above, the two valves that move below."""
    (gap, position), (usual, text) = figure.subplots(2, 2)
    milliamperes = 1e3 * found.printed.current
    gap.plot(milliamperes, 1e3 * found.printed_gap, color=VERMILLION, label="gap, eq. (31)")
    gap.axhline(1e3 * LARGEST_GAP, color=INK, linewidth=0.9, linestyle="--", label="largest gap of Table 2")
    gap.set(xlabel="current [mA]", ylabel="gap [mm]", ylim=(0.0, None), title="Table 2 as printed: the gap")
    gap.legend()
    position.plot(milliamperes, 1e3 * found.printed.position, color=VERMILLION)
    table = read_valve("table2").values
    force = table["diaphragm_area"] * float(found.printed.pressure.max())
    words = f"The pressure stays below {found.printed.pressure.max():.2g} Pa,\n{force:.2g} N on the diaphragm,"
    words += f"\nagainst a friction of {table['coulomb_friction']:g} N."
    position.text(0.05, 0.6, words, transform=position.transAxes)
    position.set(xlabel="current [mA]", ylabel="position [mm]", ylim=(-10.0, 280.0))
    position.set_title("Table 2 as printed: the stem never moves")
    _draw_loop(usual, found.calibrated, "valve set `calibrated`")
    if found.closing < CORNERS[1]:
        usual.axvline(1e3 * found.closing, color=INK, linewidth=0.9, linestyle=":")
        beside = usual.get_xaxis_transform()
        usual.text(1e3 * found.closing + 0.2, 0.97, "the nozzle closes", rotation=90, va="top", transform=beside)
    _draw_loop(text, found.text, "gap law through the two points of the text")
    if found.factor == 1.0:
        for current, place, side in TEXT_POINTS:
            text.plot(1e3 * current, 1e3 * place, "*", color=INK, markersize=12)
            text.annotate(
                f"text: {1e3 * place:g} mm", (1e3 * current, 1e3 * place), xytext=(-10 * side, -2 + 14 * side),
                textcoords="offset points", ha="right" if side > 0.0 else "left",
            )  # fmt: skip
    figure.suptitle(f"Figure {found.number}: position against current, v = 2, n = {found.factor:g}, in steps of 0.5 mA")


def _draw_loop(axes: Axes, loop: SettledLoop, title: str) -> None:
    current, position = 1e3 * loop.current, 1e3 * loop.position
    rests = np.isclose(np.diff(loop.position, prepend=np.nan), 0.0, atol=1e-6)
    curves = np.select([(loop.part == 0) & ~rests, (loop.part == 1) & rests, loop.part == 1], [0, 1, 2], 3)
    axes.plot(current, position, color="#cccccc", linewidth=1.0, zorder=1)
    for number, (colour, mark, size, label) in enumerate(CURVES):
        chosen = curves == number
        axes.plot(
            current[chosen], position[chosen], mark, label=label, zorder=2, color=colour, markersize=size,
            fillstyle="none" if number == 3 else "full",
        )  # fmt: skip
        if chosen.any():
            middle = np.flatnonzero(chosen)[int(chosen.sum()) // 2]
            axes.annotate(
                str(number + 1), (current[middle], position[middle]), xytext=(0, 7 if number in (1, 2) else -16),
                textcoords="offset points", color=colour, fontweight="bold", ha="center",
            )  # fmt: skip
    axes.set(xlabel="current [mA]", ylabel="position [mm]", title=title, xlim=(5.2, 20.8))
    axes.margins(y=0.1)
    axes.legend(loc="lower right", fontsize=8)
