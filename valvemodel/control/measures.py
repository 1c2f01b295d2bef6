"""What a closed loop's course is judged by; each measure says its definition and unit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

BAND_SHARE = 0.01
"""Share of the rated travel within which a position counts as at its set point: 2.5 mm of 250 mm."""

REVERSAL_SHARE = 1e-3
"""Share of the rated travel by which a stem must come back for a reversal to count: 0.25 mm of 250 mm."""

TAIL = 0.5
"""Last share of a step in which steady error and limit cycle are read."""


@dataclass(frozen=True)
class Measures:
    """Measures of one step of the set point; each is defined by the function of its name."""

    settling_time: float
    overshoot: float
    steady_error: float
    integral_absolute_error: float
    reversals: int
    travelled_distance: float
    limit_cycle_amplitude: float
    limit_cycle_period: float


UNITS = {
    "settling_time": "s",
    "overshoot": "m",
    "steady_error": "m",
    "integral_absolute_error": "m*s",
    "reversals": "1",
    "travelled_distance": "m",
    "limit_cycle_amplitude": "m",
    "limit_cycle_period": "s",
}
"""Unit of each measure."""


def settling_time(position: np.ndarray, setpoint: float, *, period: float, band: float) -> float:
    """Return the time from the step to the last entry into the set point's band; infinite if it is not kept. [s]"""
    outside = np.flatnonzero(np.abs(position - setpoint) > band)
    if len(outside) == 0:
        return 0.0
    last = int(outside[-1])
    return float("inf") if last == len(position) - 1 else period * (last + 1)


def overshoot(position: np.ndarray, setpoint: float) -> float:
    """Return how far the stem went beyond the set point, in the direction in which it had to go. [m]"""
    side = 1.0 if setpoint >= position[0] else -1.0
    return float(max(np.max(side * (position - setpoint)), 0.0))


def steady_error(position: np.ndarray, setpoint: float) -> float:
    """Return the mean of set point less position over the tail. [m]"""
    return float(setpoint - np.mean(tail_of(position)))


def integral_absolute_error(position: np.ndarray, setpoint: np.ndarray | float, *, period: float) -> float:
    """Return the integral of the absolute error, samples held over their period. [m*s]"""
    return float(period * np.sum(np.abs(position - setpoint)))


def reversals(position: np.ndarray, *, least: float) -> int:
    """Return how often the stem turned back by more than `least` [m]. [1]"""
    return max(len(turning_points(position, least=least)) - 2, 0)


def travelled_distance(position: np.ndarray) -> float:
    """Return the way that the stem went, up and down added. [m]"""
    return float(np.sum(np.abs(np.diff(position))))


def limit_cycle(position: np.ndarray, *, period: float, least: float) -> tuple[float, float]:
    """Return half the swing [m] and the period [s] of a lasting oscillation; (0, infinity) where there is none.

    It lasts if the tail holds two whole swings of more than `least` [m] at least, and the later half of it swings no
    less than half as far as the earlier one. The period is the mean time between maxima, or minima.
    """
    tail = tail_of(position)
    turns = turning_points(tail, least=least)[1:-1]
    if len(turns) < 4:
        return 0.0, float("inf")
    swings = np.abs(np.diff(tail[turns]))
    half = len(swings) // 2
    if swings[half:].mean() < 0.5 * swings[:half].mean():
        return 0.0, float("inf")
    times = period * np.asarray(turns, float)
    return float(0.5 * swings.mean()), float(np.mean(times[2:] - times[:-2]))


def tail_of(position: np.ndarray) -> np.ndarray:
    """Return the last part of a step."""
    return position[len(position) - max(round(TAIL * len(position)), 1) :]


def turning_points(position: np.ndarray, *, least: float) -> list[int]:
    """Return the samples at which the stem starts, turns back by more than `least` [m], and ends its last swing."""
    values = _moves_only(position)
    turns, extreme, side = [0], 0, 0.0
    for index, value in values[1:]:
        away = value - position[extreme]
        if side * away >= 0.0 and away != 0.0 and (side != 0.0 or abs(away) > least):
            side, extreme = (side or np.sign(away)), index
        elif side * away < -least:
            turns.append(extreme)
            side, extreme = -side, index
    return turns if extreme == turns[-1] else [*turns, extreme]


def _moves_only(position: np.ndarray) -> list[tuple[int, float]]:
    """Return the samples at which the stem starts, ends or changes its direction."""
    moves = np.diff(position)
    kept = np.flatnonzero(moves)
    signs = np.sign(moves[kept])
    turns = kept[np.flatnonzero(np.diff(signs)) + 1] if len(kept) else kept
    places = np.unique(np.r_[0, turns, len(position) - 1])
    return [(int(place), float(position[place])) for place in places]


def measures_of(position: np.ndarray, setpoint: float, *, period: float, rated_travel: float) -> Measures:
    """Measure one step: the course of the stem's position at a constant set point, shape (n,) [m]."""
    least = REVERSAL_SHARE * rated_travel
    amplitude, cycle = limit_cycle(position, period=period, least=least)
    return Measures(
        settling_time(position, setpoint, period=period, band=BAND_SHARE * rated_travel),
        overshoot(position, setpoint),
        steady_error(position, setpoint),
        integral_absolute_error(position, setpoint, period=period),
        reversals(position, least=least),
        travelled_distance(position),
        amplitude,
        cycle,
    )


def overall(measures: Sequence[Measures]) -> dict[str, float]:
    """Put the steps of a run together.

    Integral, reversals and distance are summed; settling time and period are means over the steps that have them,
    beside the share of steps that settled; overshoot, amplitude and the size of the steady error are the largest.
    """
    columns = {name: np.array([asdict(each)[name] for each in measures], float) for name in UNITS}
    settled = np.isfinite(columns["settling_time"])
    cycles = np.isfinite(columns["limit_cycle_period"])
    return {
        "settling_time": float(columns["settling_time"][settled].mean()) if settled.any() else float("inf"),
        "settled_share": float(settled.mean()),
        "overshoot": float(columns["overshoot"].max()),
        "steady_error": float(np.abs(columns["steady_error"]).max()),
        "integral_absolute_error": float(columns["integral_absolute_error"].sum()),
        "reversals": float(columns["reversals"].sum()),
        "travelled_distance": float(columns["travelled_distance"].sum()),
        "limit_cycle_amplitude": float(columns["limit_cycle_amplitude"].max()),
        "limit_cycle_period": float(columns["limit_cycle_period"][cycles].mean()) if cycles.any() else float("inf"),
    }
