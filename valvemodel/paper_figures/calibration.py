"""Figures 7 and 8: a settled loop with its branches, and what self-calibration makes of six of its points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from valvemodel.control.calibration import Calibration, self_calibrate
from valvemodel.drawing import BLUE, GREY, INK, VERMILLION
from valvemodel.model import Model
from valvemodel.paper_figures.settled import SettledLoop, settled_loop
from valvemodel.valves import read_valve

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CORNERS = (4e-3, 20e-3, 4e-3)
"""Of the sweep. [A]"""

VALVES = ("linear", "calibrated")


@dataclass(frozen=True)
class Calibrated:
    """A settled loop of a valve, and what self-calibration finds on that valve."""

    loop: SettledLoop
    lines: Calibration

    @property
    def intercepts(self) -> tuple[float, float]:
        """Of the rising and of the falling line. [m]"""
        return self.lines.rising_intercept, self.lines.falling_intercept

    def as_json(self) -> dict[str, Any]:
        """Return the data behind the figure."""
        points = np.concatenate((self.lines.rising, self.lines.falling))
        return {
            "loop": self.loop.as_json(),
            "records": {
                "current": {"value": points[:, 0], "unit": "A"},
                "position": {"value": points[:, 1], "unit": "m"},
            },
            "slope": {"value": self.lines.slope, "unit": "m/A"},
            "intercepts": {"value": list(self.intercepts), "unit": "m"},
            "threshold": {"value": self.lines.threshold, "unit": "A"},
            "true_width": {
                name: {"value": width, "unit": "A", "position": {"value": place, "unit": "m"}}
                for name, (place, width) in self.true_widths().items()
            },
        }

    def true_widths(self) -> dict[str, tuple[float, float]]:
        """Return position and width of the settled loop itself, low, in the middle and high. [m], [A]"""
        branches = [self._branch(part) for part in (0, 1)]
        low, high = max(b[1].min() for b in branches), min(b[1].max() for b in branches)
        found = {}
        for name, share in (("low", 0.1), ("middle", 0.5), ("high", 0.9)):
            place = float(low + share * (high - low))
            ends = [float(np.interp(place, position, current)) for current, position in branches]
            found[name] = (place, ends[0] - ends[1])
        return found

    def _branch(self, part: int) -> tuple[np.ndarray, np.ndarray]:
        """Return current and position of a sweep where the stem moves, by growing position."""
        chosen = self.loop.part == part
        current, position = self.loop.current[chosen], self.loop.position[chosen]
        moves = np.abs(np.diff(position, prepend=np.nan)) > 1e-6
        order = np.argsort(position[moves])
        return current[moves][order], position[moves][order]


def calibrated(name: str) -> Calibrated:
    """Sweep a valve set and calibrate it."""
    valve = read_valve(name)
    model = Model(valve.name, valve.values)
    return Calibrated(settled_loop(model, CORNERS), self_calibrate(model))


def draw_settled_loops(figure: Figure, found: dict[str, Calibrated]) -> None:
    """Draw the loops side by side, each with the lines of the self-calibration and the widths that they miss."""
    for axes, (name, each) in zip(figure.subplots(1, len(found)), found.items(), strict=True):
        _draw(axes, name, each)
    figure.suptitle("Figure 7, simulated: settled loop in steps of 0.5 mA, and what self-calibration makes of it")


def _draw(axes: Axes, name: str, each: Calibrated) -> None:
    loop, span = each.loop, np.array([4e-3, 20e-3])
    axes.plot(1e3 * loop.current, 1e3 * loop.position, ".-", color=GREY, linewidth=1.0, label="settled, simulated")
    sides = (("rising", each.lines.rising, VERMILLION, "o"), ("falling", each.lines.falling, BLUE, "s"))
    for (side, points, colour, mark), intercept in zip(sides, each.intercepts, strict=True):
        line = each.lines.slope * span + intercept
        axes.plot(1e3 * span, 1e3 * line, "--", color=colour, linewidth=1.1, label=f"line of (37), {side}")
        axes.plot(*1e3 * points.T, mark, color=colour, markersize=7, label=f"records, {side}")
    lines = [f"width by (40): {1e3 * each.lines.threshold:.2f} mA"]
    for where, (place, width) in each.true_widths().items():
        lines.append(f"true width, {where} ({1e3 * place:.0f} mm): {1e3 * width:.2f} mA")
    axes.text(0.98, 0.03, "\n".join(lines), transform=axes.transAxes, ha="right", va="bottom", color=INK)
    axes.set(xlabel="current [mA]", ylabel="position [mm]", title=f"valve set `{name}`")
    axes.legend(loc="upper left", fontsize=8.5)


def draw_scheme(figure: Figure, each: Calibrated) -> None:
    """Draw steps 1 to 3 of the self-calibration with the paper's letters."""
    axes = figure.subplots()
    span = np.array([4e-3, 20e-3])
    axes.plot(1e3 * each.loop.current, 1e3 * each.loop.position, color="#cccccc", label="settled loop, simulated")
    sides = ((each.lines.rising, VERMILLION, "o", "A", 1), (each.lines.falling, BLUE, "s", "B", 4))
    for (points, colour, mark, letter, first), intercept in zip(sides, each.intercepts, strict=True):
        offset, side = ((10, -14), "left") if first == 1 else ((-10, 10), "right")
        step = "1: three loads upwards" if first == 1 else "2: three loads downwards"
        axes.plot(*1e3 * points.T, mark, color=colour, markersize=7, label=f"step {step}")
        axes.plot(1e3 * span, 1e3 * (each.lines.slope * span + intercept), "--", color=colour, linewidth=1.1)
        for number, point in enumerate(points):
            axes.annotate(
                f"($I_{first + number}$, ${letter}_{number + 1}$)", tuple(1e3 * point), xytext=offset,
                textcoords="offset points", ha=side, color=colour,
            )  # fmt: skip
        start = 1e3 * np.array([span[0], each.lines.slope * span[0] + intercept])
        words = f"$k\\,i + b_{1 if first == 1 else 2}$, b = {1e3 * intercept:.1f} mm"
        axes.annotate(words, tuple(start), xytext=(4, -16), textcoords="offset points", color=colour)
    place = float(np.mean([each.lines.rising[1, 1], each.lines.falling[1, 1]]))
    ends = [1e3 * (place - intercept) / each.lines.slope for intercept in each.intercepts]
    axes.annotate("", (ends[0], 1e3 * place), (ends[1], 1e3 * place), arrowprops={"arrowstyle": "<->", "color": INK})
    words = "step 3: $I_{threshold} = (b_2 - b_1)/k$"
    words += f"\n= {1e3 * each.lines.threshold:.2f} mA, k = {each.lines.slope:.2f} mm/mA"
    axes.annotate(words, (ends[0], 1e3 * place), xytext=(15, -75), textcoords="offset points", color=INK,
                  arrowprops={"arrowstyle": "-", "color": GREY})  # fmt: skip
    axes.set(xlabel="current [mA]", ylabel="position [mm]", title="valve set `calibrated`")
    axes.margins(y=0.1)
    axes.legend(loc="upper left")
    figure.suptitle("Figure 8, simulated: self-calibration, eqs. (35)-(40)")
