"""The pictures of a diagnosis: functions that draw on given axes, and each as SVG."""

from __future__ import annotations

import itertools
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from diagnosis.report.amounts import amount, is_number, probability_text, shown_unit
from diagnosis.report.evidence import FALLING, RISING, STUCK, Evidence, Rank, RecordEvidence, Step
from diagnosis.report.svg import HALF, INK, WIDE, picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MEASURED = "#8a8a8a"
BASE, CAUSE, NOISE = "#D55E00", "#00568C", "#009E73"
"""Okabe and Ito's vermillion, blue (darker, so that it is told in grey too) and bluish green; lines differ in style
as well as in colour."""
REGIMES = {RISING: ("rising", "#3A93C8"), STUCK: ("stuck", "#8a8a8a"), FALLING: ("falling", "#C07F00")}
HELD_OUT = "#222222"

_LOOP_POINTS = 2000
_RANKS = 8
_CUT_FROM = 12.0
"""Times the next largest bar from which the bar of the valve as given is cut off."""


def draw_loop(axes: Axes, record: RecordEvidence, unit: str, cause: str) -> None:
    """Draw the signal against the current, or against position where there is none."""
    abscissa, name, abscissa_unit = _abscissa(record)
    shown_x, factor_x = shown_unit(abscissa_unit, [_largest(abscissa)])
    shown_y, factor_y = shown_unit(unit, [_largest(record.measured)])
    step = max(1, -(-len(record.time) // _LOOP_POINTS))
    x = abscissa[::step] * factor_x
    for values, style in _curves(record.measured, record.refitted, record.with_cause, cause):
        axes.plot(x, values[::step] * factor_y, **style)
    axes.set_xlabel(f"{name} [{shown_x}]")
    axes.set_ylabel(f"{signal_name(unit)} [{shown_y}]")
    _legend_above(axes)


def draw_pressure(axes: Axes, record: RecordEvidence, cause: str) -> None:
    """Draw the measured actuator pressure against the current."""
    assert record.current is not None
    assert record.measured_pressure is not None
    shown_x, factor_x = shown_unit("A", [_largest(record.current)])
    shown_y, factor_y = shown_unit("Pa", [_largest(record.measured_pressure)])
    step = max(1, -(-len(record.time) // _LOOP_POINTS))
    for values, style in _curves(record.measured_pressure, record.refitted_pressure, record.with_cause_pressure, cause):
        axes.plot(record.current[::step] * factor_x, values[::step] * factor_y, **style)
    axes.set_xlabel(f"current [{shown_x}]")
    axes.set_ylabel(f"pressure, gauge [{shown_y}]")
    _legend_above(axes)


def draw_time(axes: Axes, record: RecordEvidence, unit: str, cause: str, *, buckets: int = 350) -> None:
    """Draw the signal over time."""
    shown_t, factor_t = _time_unit(record.time)
    shown_y, factor_y = shown_unit(unit, [_largest(record.measured)])
    for values, style in _curves(record.measured, record.refitted, record.with_cause, cause):
        t, thinned = envelope(record.time, values, buckets)
        axes.plot(t * factor_t, thinned * factor_y, **style)
    axes.set_xlabel(f"time [{shown_t}]")
    axes.set_ylabel(f"{signal_name(unit)} [{shown_y}]")
    axes.margins(x=0.01)
    _legend_above(axes)


def draw_residual(
    axes: Axes, lanes: Axes, record: RecordEvidence, unit: str, cause: str, *, buckets: int = 700
) -> None:
    """Draw what the models leave over time, above lanes that show regime and held-out blocks."""
    shown_t, factor_t = _time_unit(record.time)
    before = record.measured - record.refitted
    after = None if record.with_cause is None else record.measured - record.with_cause
    shown_y, factor_y = shown_unit(unit, [_largest(before)])
    for values, style in _curves(None, before, after, cause):
        t, thinned = envelope(record.time, values, buckets)
        axes.plot(t * factor_t, thinned * factor_y, **{**style, "linestyle": "-"})
    axes.axhline(0.0, color=INK, linewidth=0.7)
    axes.set_ylabel(f"measured less model [{shown_y}]")
    axes.tick_params(labelbottom=False)
    rows = [(regime, *REGIMES[regime]) for regime in (RISING, STUCK, FALLING)]
    for row, (regime, _, colour) in enumerate(rows):
        spans = [(start * factor_t, width * factor_t) for start, width in spans_of(record, regime, buckets)]
        lanes.broken_barh(spans, (2.58 - row, 0.84), facecolors=colour, linewidth=0)
        if regime != STUCK:
            across = axes.get_xaxis_transform()
            axes.broken_barh(spans, (0, 1), facecolors=colour, alpha=0.2, linewidth=0, transform=across)
    held = [(start * factor_t, width * factor_t) for start, width in _runs(record.time, record.held_out)]
    lanes.broken_barh(held, (-0.42, 0.84), facecolors=HELD_OUT, linewidth=0)
    lanes.set_ylim(-0.6, 3.6)
    lanes.set_yticks([3, 2, 1, 0], [*(name for _, name, _ in rows), "held out"])
    lanes.tick_params(axis="y", length=0)
    lanes.grid(visible=False)
    lanes.spines["left"].set_visible(False)
    lanes.set_xlabel(f"time [{shown_t}]")
    axes.set_xlim(record.time[0] * factor_t, record.time[-1] * factor_t)
    lanes.set_xlim(axes.get_xlim())
    _legend_above(axes)


def draw_steps(axes: Axes, steps: Sequence[Step], unit: str) -> None:
    """Draw the gap shrinking step by step, a bar a step with its label and value above it."""
    steps = [step for step in steps if is_number(step.rms)]
    given, others = (steps or [Step("", 1.0)])[0].rms, max((step.rms for step in steps[1:]), default=0.0)
    is_cut = others > 0.0 and given > _CUT_FROM * others
    largest = 1.3 * others if is_cut else max(given, others) or 1.0
    shown, factor = shown_unit(unit, [largest])
    for row, step in enumerate(steps):
        colour = NOISE if "noise" in step.label else (MEASURED, BASE)[row] if row < 2 else CAUSE
        axes.barh(-row - 0.18, min(step.rms, largest) * factor, height=0.38, color=colour)
        axes.text(0, -row + 0.12, step.label, va="bottom", fontsize=9.5, clip_on=False)
        axes.text(
            largest * factor, -row + 0.12, amount(step.rms, unit, like=[given]),
            va="bottom", ha="right", fontsize=9.5, fontweight="bold",
        )  # fmt: skip
    if is_cut:
        axes.text(
            0.9 * largest * factor, -0.18, "// not to scale", color="black", va="center", ha="right", fontsize=9.5
        )
    axes.set_xlim(0, largest * factor)
    axes.set_ylim(-len(steps) + 0.55, 0.55)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    axes.grid(visible=False, axis="y")
    axes.set_xlabel(f"gap, root mean square [{shown}]")


def draw_ranking(axes: Axes, ranking: Sequence[Rank], noise_floor: float | None, unit: str) -> None:
    """Draw each candidate's gap with its interval, the best on top, and its probability at the right."""
    ranking = [rank for rank in ranking if is_number(rank.rms)][:_RANKS]
    all_rms = [rank.rms for rank in ranking] + [rank.high for rank in ranking if is_number(rank.high)]
    largest = max(all_rms, default=1.0) or 1.0
    shown, factor = shown_unit(unit, [largest])
    for row, rank in enumerate(ranking):
        colour = CAUSE if row == 0 else INK
        low, high = (end if is_number(end) else rank.rms for end in (rank.low, rank.high))
        axes.plot([low * factor, high * factor], [-row, -row], color=colour, linewidth=2.2, solid_capstyle="butt")
        axes.plot([rank.rms * factor], [-row], marker="o", markersize=5.5, color=colour)
        text = probability_text(rank.probability) if is_number(rank.probability) else ""
        axes.text(
            1.02, -row, text, transform=axes.get_yaxis_transform(), va="center",
            fontweight="bold" if row == 0 else "normal",
        )  # fmt: skip
    if noise_floor is not None and is_number(noise_floor):
        axes.axvline(noise_floor * factor, color=NOISE, linestyle=(0, (4, 2)), linewidth=1.4)
        axes.text(
            noise_floor * factor, 1.01, "noise floor", transform=axes.get_xaxis_transform(), color="#00664B",
            fontsize=8.5, va="bottom", ha="right" if noise_floor > largest / 2 else "left",
        )  # fmt: skip
    axes.text(1.02, 1.01, "probability", transform=axes.transAxes, fontsize=8.5, va="bottom")
    labels = [_wrapped(rank.label) for rank in ranking]
    axes.set_yticks([-row for row in range(len(ranking))], labels)
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(-len(ranking) + 0.4, 0.6)
    axes.set_xlim(0, largest * factor * 1.04)
    axes.spines["left"].set_visible(False)
    axes.set_xlabel(f"gap on unseen data [{shown}]")


def loop_picture(name: str, record: RecordEvidence, unit: str, cause: str) -> str:
    """Return the loop as SVG."""
    return picture(name, lambda figure: draw_loop(_half_axes(figure), record, unit, cause))


def time_picture(name: str, record: RecordEvidence, unit: str, cause: str) -> str:
    """Return the signal over time as SVG."""
    return picture(name, lambda figure: draw_time(_half_axes(figure), record, unit, cause))


def pressure_picture(name: str, record: RecordEvidence, cause: str) -> str:
    """Return the measured pressure as SVG."""
    return picture(name, lambda figure: draw_pressure(_half_axes(figure), record, cause))


def residual_picture(name: str, record: RecordEvidence, unit: str, cause: str, *, is_wide: bool) -> str:
    """Return the residual over time as SVG, for the whole width of a page or for a phone."""
    left, right = (0.075, 0.99) if is_wide else (0.165, 0.98)

    def draw(figure: Figure) -> None:
        axes = figure.add_axes((left, 0.40, right - left, 0.51))
        lanes = figure.add_axes((left, 0.135, right - left, 0.23))
        draw_residual(axes, lanes, record, unit, cause, buckets=700 if is_wide else 300)

    return picture(name, draw, WIDE if is_wide else HALF)


def steps_picture(name: str, evidence: Evidence) -> str:
    """Return the gap shrinking step by step as SVG."""
    count = max(3, len(evidence.steps))
    height = 0.62 * count + 0.55

    def draw(figure: Figure) -> None:
        draw_steps(figure.add_axes((0.05, 0.5 / height, 0.92, 1 - 0.55 / height)), evidence.steps, evidence.unit)

    return picture(name, draw, (HALF[0], height))


def ranking_picture(name: str, evidence: Evidence) -> str:
    """Return the ranking with uncertainty as SVG."""
    labels = [_wrapped(rank.label) for rank in evidence.ranking[:_RANKS]]
    lines = sum(0.36 + 0.1 * label.count("\n") for label in labels)
    longest = max((len(line) for label in labels for line in label.split("\n")), default=8)
    left = min(0.44, 0.03 + 0.0166 * longest)
    height = max(2.0, lines + 0.9)

    def draw(figure: Figure) -> None:
        axes = figure.add_axes((left, 0.5 / height, 0.82 - left, 1 - 0.8 / height))
        draw_ranking(axes, evidence.ranking, evidence.noise_floor, evidence.unit)

    return picture(name, draw, (HALF[0], height))


def profile_picture(name: str, time: np.ndarray, current: np.ndarray, *, is_wide: bool) -> str:
    """Return a designed current over time as SVG, for the whole width of a page or for a phone."""

    def draw(figure: Figure) -> None:
        axes = figure.add_axes((0.075, 0.2, 0.915, 0.76)) if is_wide else _half_axes(figure)
        shown_t, factor_t = _time_unit(time)
        axes.step(time * factor_t, 1e3 * current, where="post", color=CAUSE)
        axes.set_xlabel(f"time [{shown_t}]")
        axes.set_ylabel("current [mA]")
        axes.margins(x=0.01)

    return picture(name, draw, (WIDE[0], 2.4) if is_wide else HALF)


def envelope(time: np.ndarray, values: np.ndarray, buckets: int) -> tuple[np.ndarray, np.ndarray]:
    """Thin a signal to the lowest and the highest sample of each of some buckets, in the order of time.

    Arguments have shape (n,), results at most (2 buckets,); shorter signals come back whole.
    """
    count = len(time)
    if count <= 2 * buckets:
        return time, values
    edges = np.linspace(0, count, buckets + 1).astype(int)
    picked = []
    for start, end in itertools.pairwise(edges):
        part = values[start:end]
        if np.isnan(part).all():
            picked.append(start)
            continue
        picked.extend(sorted({start + int(np.nanargmin(part)), start + int(np.nanargmax(part))}))
    return time[picked], values[picked]


def spans_of(record: RecordEvidence, regime: int, columns: int) -> list[tuple[float, float]]:
    """Return start and width of the stretches of a regime, no finer than some columns of time. [s]"""
    time, is_there = record.time, record.mode == regime
    if len(time) > columns:
        edges = np.linspace(0, len(time), columns + 1).astype(int)[:-1]
        return _runs(time[edges], np.logical_or.reduceat(is_there, edges), end=float(time[-1]))
    return _runs(time, is_there)


def abscissa_name(record: RecordEvidence) -> str:
    """Return what the loop is drawn against; time where there is nothing else."""
    return _abscissa(record)[1]


def signal_name(unit: str) -> str:
    """Return what is compared where the gap has this unit."""
    return "force" if unit == "N" else "position"


def _runs(time: np.ndarray, is_true: np.ndarray, end: float | None = None) -> list[tuple[float, float]]:
    padded = np.concatenate(([False], np.asarray(is_true, dtype=bool), [False]))
    changes = np.flatnonzero(padded[1:] != padded[:-1])
    edges = np.append(time, time[-1] if end is None else end)
    return [
        (float(edges[start]), float(edges[stop] - edges[start]))
        for start, stop in zip(changes[::2], changes[1::2], strict=True)
    ]


def _curves(
    measured: np.ndarray | None, refitted: np.ndarray | None, with_cause: np.ndarray | None, cause: str
) -> list[tuple[np.ndarray, dict[str, Any]]]:
    """Return what there is to draw, the one to be seen best last."""
    base = {"color": BASE, "linewidth": 1.6, "linestyle": (0, (5, 2)), "label": "base refitted"}
    found = {"color": CAUSE, "linewidth": 1.1, "label": cause}
    curves = [
        (measured, {"color": MEASURED, "linewidth": 3.2, "label": "measured"}),
        (refitted, base),
        (with_cause, found),
    ]
    return [(values, style) for values, style in curves if values is not None]


def _abscissa(record: RecordEvidence) -> tuple[np.ndarray, str, str]:
    if record.current is not None:
        return record.current, "current", "A"
    if record.position is not None:
        return record.position, "position", "m"
    return record.time, "time", "s"


def _time_unit(time: np.ndarray) -> tuple[str, float]:
    length = float(time[-1] - time[0])
    if length > 4 * 3600:
        return "h", 1 / 3600
    return ("min", 1 / 60) if length > 900 else ("s", 1.0)


def _largest(values: np.ndarray) -> float:
    finite = np.abs(values[np.isfinite(values)])
    return float(finite.max()) if finite.size else 0.0


def _wrapped(label: str) -> str:
    return "\n".join(textwrap.wrap(label, 26)[:3])


def _half_axes(figure: Figure) -> Axes:
    return figure.add_axes((0.135, 0.135, 0.85, 0.77))


def _legend_above(axes: Axes) -> None:
    axes.legend(
        loc="lower left", bbox_to_anchor=(0, 1.0), ncols=3, borderaxespad=0.2, handlelength=1.8,
        columnspacing=1.3, fontsize=9,
    )  # fmt: skip
