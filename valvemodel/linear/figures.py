"""Figures of a linearisation and of a limit cycle, drawn on a given figure."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import control as ct
import numpy as np

from valvemodel.drawing import BLUE, GREEN, GREY, INK, VERMILLION
from valvemodel.linear.feedback import Gains, margins, open_loop
from valvemodel.linear.limit_cycle import LimitCycle, describing_response
from valvemodel.linear.loop import Loop
from valvemodel.linear.simulated import run_loop
from valvemodel.linear.state_space import Linearisation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STYLES = {
    "rising": {"color": VERMILLION, "linestyle": "-"},
    "falling": {"color": BLUE, "linestyle": "--"},
    "stuck": {"color": GREEN, "linestyle": "-."},
}
"""Modes differ in line as well as in colour."""

PARTS = (
    ("current_to_pressure", "current to pressure", "kPa/mA", 1e-6),
    ("pressure_to_position", "pressure to position", "mm/kPa", 1e6),
    ("current_to_reading", "current to reading", "mm/mA", 1.0),
)
POINTS = 400
GAINS = np.concatenate(([0.0], np.geomspace(1e-3, 1e3, 600)))
"""Of the root locus, over the gains given."""

SHOWN_TURNS = 3.0
LETTERS_PER_INCH = 9.5
"""Of a title."""


def moving(found: Sequence[Linearisation]) -> list[Linearisation]:
    """Return those in which the stem moves."""
    return [each for each in found if np.any(each.pressure_to_position.dcgain() != 0.0)]


def frequencies(found: Sequence[Linearisation]) -> np.ndarray:
    """Return frequencies around all poles. [rad/s]"""
    poles = np.concatenate([np.abs(each.current_to_reading.poles()) for each in found] or [np.ones(1)])
    poles = poles[poles > 0.0] if np.any(poles > 0.0) else np.ones(1)
    return np.geomspace(0.03 * poles.min(), 10.0 * poles.max(), POINTS)


def draw_bode(figure: Figure, found: Sequence[Linearisation]) -> None:
    """Draw gain and phase from current to pressure, to position and to the reading, a line for each mode."""
    axes = figure.subplots(2, len(PARTS), sharex=True)
    omega = frequencies(found)
    for column, (name, title, unit, scale) in enumerate(PARTS):
        for each in found:
            answer = getattr(each, name)(1j * omega)
            if np.any(answer != 0.0):
                style = STYLES[each.point.mode]
                axes[0, column].loglog(omega, scale * np.abs(answer), label=each.point.mode, **style)
                axes[1, column].semilogx(omega, np.degrees(np.unwrap(np.angle(answer))), **style)
        axes[0, column].set_title(title)
        axes[0, column].set_ylabel(f"gain [{unit}]")
        axes[1, column].set_ylabel("phase [deg]")
        axes[1, column].set_xlabel("frequency [rad/s]")
        axes[0, column].legend()
    silent = [each.point.mode for each in found if each not in moving(found)]
    note = f"; {', '.join(silent)}: the stem does not move" if silent else ""
    _title(figure, f"{heading(found)}{note}")


def _title(figure: Figure, text: str) -> None:
    """Write a title that is broken where the figure ends."""
    figure.suptitle(textwrap.fill(text, int(LETTERS_PER_INCH * figure.get_figwidth())))


def heading(found: Sequence[Linearisation]) -> str:
    """Return what was linearised and where."""
    model = found[0].model
    effects = f" with {', '.join(sorted(model.effects))}" if model.effects else ""
    return f"{model.name}{effects} at {1e3 * found[0].point.current:.4g} mA"


def draw_root_locus(figure: Figure, found: Sequence[Linearisation], gains: Gains) -> None:
    """Draw where the closed loop's poles go as all gains of the PID grow together."""
    found = moving(found)
    axes = figure.subplots(1, len(found), squeeze=False)[0]
    for each, place in zip(found, axes, strict=True):
        loop = open_loop(each, gains)
        loci = ct.root_locus_map(loop, gains=GAINS).loci
        place.plot(loci.real, loci.imag, color=GREY, linewidth=1.2)
        here, zeros = ct.feedback(loop).poles(), loop.zeros()
        place.plot(loop.poles().real, loop.poles().imag, "x", color=INK, markersize=7, label="open loop: poles")
        place.plot(zeros.real, zeros.imag, "o", color=INK, fillstyle="none", label="open loop: zeros")
        place.plot(here.real, here.imag, "s", color=STYLES[each.point.mode]["color"], label="closed, gains as given")
        place.axvline(0.0, color=INK, linewidth=0.8)
        sizes = np.abs(np.concatenate((loop.poles(), here)))
        reach, slowest = 3.0 * sizes.max(), sizes[sizes > 1e-9 * sizes.max()].min()
        for axis in (place.set_xscale, place.set_yscale):
            axis("symlog", linthresh=slowest)
        place.set(
            xlim=(-reach, reach), ylim=(-reach, reach), title=f"{each.point.mode} (axes: linear near 0, then log)"
        )
        place.set(xlabel="real part [1/s]", ylabel="imaginary part [rad/s]")
        place.tick_params(axis="x", labelrotation=45)
        place.legend(fontsize=8, loc="upper right")
    _title(figure, f"{heading(found)}: closed-loop poles as the gains grow from 0, {words_of(gains)}")


def words_of(gains: Gains) -> str:
    """Return the gains with their units."""
    words = [f"{gains.proportional:.3g} mA/mm", f"{gains.integral:.3g} mA/(mm s)"]
    return "PID " + ", ".join([*words, f"{gains.derivative:.3g} mA s/mm"] if gains.derivative else words)


def draw_margins(figure: Figure, found: Sequence[Linearisation], gains: Gains) -> None:
    """Draw the open loop of PID and valve with its crossovers and margins."""
    upper, lower = figure.subplots(2, 1, sharex=True)
    found = moving(found)
    omega = np.union1d(frequencies(found), np.geomspace(1e-2, 1e2, POINTS))
    for each in found:
        answer, style = open_loop(each, gains)(1j * omega), STYLES[each.point.mode]
        got = margins(each, gains)
        upper.loglog(omega, np.abs(answer), label=f"{each.point.mode}: {_margin_words(got)}", **style)
        phase = np.degrees(np.unwrap(np.angle(answer)))
        lower.semilogx(omega, phase, **style)
        for frequency, axis in ((got["gain_crossover"], upper), (got["phase_crossover"], lower)):
            if math.isfinite(frequency) and frequency > 0.0:
                level = 1.0 if axis is upper else np.interp(frequency, omega, phase)
                axis.plot(frequency, level, "o", color=style["color"])
    upper.axhline(1.0, color=INK, linewidth=0.8)
    lower.axhline(-180.0, color=INK, linewidth=0.8)
    upper.set_ylabel("open-loop gain [1]")
    lower.set(ylabel="phase [deg]", xlabel="frequency [rad/s]")
    upper.legend(fontsize=8.5)
    _title(figure, f"{heading(found)}: margins, {words_of(gains)}")


def _margin_words(got: dict[str, float]) -> str:
    gain = "no limit" if not math.isfinite(got["gain_margin"]) else f"{got['gain_margin']:.3g}"
    phase = "none" if not math.isfinite(got["phase_margin"]) else f"{math.degrees(got['phase_margin']):.0f} deg"
    return f"gain margin {gain}, phase margin {phase}" + ("" if got["is_stable"] else ", unstable")


def draw_limit_cycle(figure: Figure, loop: Loop, cycles: dict[str, LimitCycle | None]) -> None:
    """Draw the harmonic balance beside the simulated course of the loop."""
    left, right = figure.subplots(1, 2)
    _draw_balance(left, loop)
    known = cycles["simulation"] or cycles["return_map"]
    duration = SHOWN_TURNS * known.period if known else 20.0 * (loop.lag + loop.dead_time + 1.0 / loop.integral)
    mapped = cycles["return_map"]
    values = run_loop(loop, duration=duration, start=None if mapped is None else mapped.states)
    time = loop.period * np.arange(len(values))
    right.plot(time, 1e3 * values, color=BLUE, label="exact simulation")
    right.axhline(1e3 * loop.setpoint, color=INK, linewidth=0.9, linestyle="--", label="set point")
    for name, colour in (("return_map", VERMILLION), ("describing_function", GREEN)):
        if (cycle := cycles[name]) is not None:
            words = f"{cycle.source}: {cycle.period:.4g} s, {1e3 * cycle.amplitude:.3g} mm"
            band = 1e3 * (loop.setpoint + np.array([-1.0, 1.0]) * cycle.amplitude)
            right.hlines(band, *time[[0, -1]], color=colour, linestyle=":", label=words)
    right.set(xlabel="time [s]", ylabel="controlled variable [mm]", title="limit cycle")
    right.margins(y=0.35)
    right.legend(fontsize=8.5, loc="upper right")
    figure.suptitle(
        f"{heading([loop.point])}, {words_of(Gains(loop.proportional, loop.integral))}{_process_words(loop)}"
    )


def _process_words(loop: Loop) -> str:
    return f", around a lag of {loop.lag:g} s and a dead time of {loop.dead_time:g} s" if loop.has_process else ""


def _draw_balance(axes: Any, loop: Loop) -> None:
    balance = describing_response(loop)
    answer = balance.response.response
    inside = np.abs(answer) < 4.0
    axes.plot(answer.real[inside], answer.imag[inside], color=BLUE, label="linear part, growing frequency")
    axes.plot(
        balance.N_vals.real, balance.N_vals.imag, color=VERMILLION, linestyle="--", label="-1/N, growing amplitude"
    )
    for place, (_, frequency) in zip(balance.positions, balance.intersections, strict=True):
        axes.plot(place.real, place.imag, "o", color=INK)
        spot = {"xytext": (8, -14), "textcoords": "offset points"}
        axes.annotate(f"{2 * math.pi / frequency:.3g} s", (place.real, place.imag), **spot)
    axes.plot(-1.0, 0.0, "+", color=INK)
    axes.set(xlim=(-2.6, 0.6), ylim=(-2.6, 0.6), xlabel="real part [1]", ylabel="imaginary part [1]")
    axes.set_title("harmonic balance" if balance.intersections else "harmonic balance: no intersection")
    axes.legend(fontsize=8.5, loc="lower right")
