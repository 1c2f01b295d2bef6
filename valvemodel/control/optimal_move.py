"""Optimal moves: the current that brings the valve to a new reading soonest, or with the least travel of the current.

Found on the smooth chain with CasADi and IPOPT, then run on the exact valve, which has the last word.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.progress import Progress, tell_nobody
from valvemodel.simulation import Trajectory, simulate
from valvemodel.smooth.chain import SmoothChain, parts_for
from valvemodel.smooth.steering import HASTE, LEISURE, Steered, SteeringProgram

CURRENT_RANGE = (4e-3, 20e-3)
"""Of the converter, Table 1. [A]"""

BAND = 0.5e-3
"""A move has arrived where the reading stays short of the target by at most this. [m]"""

MARGIN = 0.2
"""Share of the band that is kept free at both ends for what smoothing moves. [1]"""

WIDTH = 1.0
"""Smoothing width: 0.02 mm of the calibrated valve. [N]"""

DETOUR = 30.0
"""The width through which a program goes that found no end at once. [N]"""

HOLD_TIME = 0.3
"""A move ends with a current that stands still for so long, and three of each of the valve's time constants. [s]"""

TIME_CONSTANTS = (
    "coil_time_constant", "eddy_time_constant", "chamber_filling_time", "fill_time", "vent_time",
    "droop_recovery_time", "sensor_time_constant", "sensor_second_time_constant", "transport_delay",
)  # fmt: skip

WATCH_TIME = 5.0
"""The exact valve is watched for so long after a move. [s]"""

MOST_PERIODS = 2000
"""A longer program than this takes minutes."""

EASE = 2.0
"""A move of least travel may take so many times the least time, unless it is said."""


@dataclass(frozen=True)
class Move:
    """A current that was found, and what the exact valve does under it.

    Attributes
    ----------
    trajectory : Trajectory
        Of the exact valve until it has been watched at rest: one period under the start's current, then the move.
    target : float [m]
    duration : float
        From the end of that period until the exact reading stays in the band; infinite where it does not. [s]
    overshoot : float
        By how much the exact reading goes beyond the target. [m]
    travel : float
        Sum of all changes of the current. [A]
    """

    trajectory: Trajectory
    target: float
    duration: float
    overshoot: float
    travel: float

    @property
    def time(self) -> np.ndarray:
        """Instants of the current, shape (n,). [s]"""
        return self.trajectory.time

    @property
    def current(self) -> np.ndarray:
        """Current held from each instant to the next, shape (n,). [A]"""
        return self.trajectory.current

    @property
    def is_reached(self) -> bool:
        """Whether the exact reading arrives in the band and stays there."""
        return math.isfinite(self.duration)

    def as_json(self) -> dict[str, Any]:
        """Return what the move costs; the current itself is in its table."""
        return {
            "schema": "valvemodel.move/1",
            "target": {"value": self.target, "unit": "m"},
            "is_reached": self.is_reached,
            "duration": {"value": self.duration, "unit": "s"},
            "overshoot": {"value": self.overshoot, "unit": "m"},
            "travel": {"value": self.travel, "unit": "A"},
        }


@dataclass(frozen=True)
class Task:
    """What is asked of a move, in SI units."""

    model: Model
    start_current: float
    start_position: float
    target: float
    period: float
    rate: float
    current_range: tuple[float, float]
    band: float

    @property
    def rises(self) -> bool:
        """Whether the target is above the start."""
        return self.target > self.start_position

    @property
    def ends(self) -> tuple[float, float]:
        """Lowest and highest reading at the end: the band lies short of the target. [m]"""
        return (self.target - self.band, self.target) if self.rises else (self.target, self.target + self.band)

    @property
    def hold(self) -> int:
        """Periods over which the current stands still at the end."""
        numbers = self.model.numbers
        return math.ceil((HOLD_TIME + 3.0 * sum(numbers.get(name, 0.0) for name in TIME_CONSTANTS)) / self.period)


def least_time(
    model: Model,
    *,
    start_current: float,
    target: float,
    start_position: float = math.nan,
    period: float = 0.01,
    rate: float = math.inf,
    current_range: tuple[float, float] = CURRENT_RANGE,
    band: float = BAND,
    progress: Progress = tell_nobody,
) -> Move:
    """Find the current that brings a valve at rest to a new reading soonest, without overshoot.

    Parameters
    ----------
    model : Model
    start_current : float
        Under which the valve is at rest. [A]
    target : float
        Reading that is wanted and not passed. [m]
    start_position : float
        Reading at the start; by default in the middle of the stuck band. [m]
    period : float
        Of the controller: each current is held for it. [s]
    rate : float
        Greatest rate of the current. [A/s]
    current_range : (float, float) [A]
    band : float
        The move has arrived where the reading stays short of the target by at most this. [m]
    progress : callable
        Called with what is being done and a share of it from 0 to 1.

    Returns
    -------
    Move
        Of the fewest periods in which the program finds a way, run on the exact valve; never slower than the ramp.

    Raises
    ------
    InputError
        If the target cannot be reached within the range, or only in more periods than can be solved for.
    """
    task = _task(model, start_current, target, start_position, period, rate, current_range, band)
    arrival, ramp = _ramp(task)
    steered = _soonest(task, arrival, ramp, progress)[1]
    moves = [_run(task, ramp)] if steered is None else [_run(task, steered.current), _run(task, ramp)]
    return min(moves, key=lambda move: (move.duration, move.overshoot))


def least_travel(
    model: Model,
    *,
    start_current: float,
    target: float,
    within: float = math.nan,
    start_position: float = math.nan,
    period: float = 0.01,
    rate: float = math.inf,
    current_range: tuple[float, float] = CURRENT_RANGE,
    band: float = BAND,
    progress: Progress = tell_nobody,
) -> Move:
    """Find the current of least travel, the sum of its changes, that arrives within a time, without overshoot.

    Parameters
    ----------
    within : float
        Time that the move may take; by default twice the least. [s]
    model, start_current, target, start_position, period, rate, current_range, band, progress
        As in `least_time`.

    Returns
    -------
    Move

    Raises
    ------
    InputError
        As in `least_time`, and if the time is too short.
    """
    task = _task(model, start_current, target, start_position, period, rate, current_range, band)
    arrival, ramp = _ramp(task)
    if math.isnan(within):
        arrival = math.ceil(EASE * _soonest(task, arrival, ramp, progress)[0])
    else:
        arrival = math.floor(within / period + 1e-6)
    progress("least travel", 0.9)
    periods = max(arrival, len(ramp) - task.hold) + task.hold
    program = _program(task, periods)
    steered = _solved(program, arrival, np.append(ramp, np.full(periods - len(ramp), ramp[-1])), LEISURE)
    if not steered.is_sound:
        found = f"over {periods} periods the search ended without a solution"
        raise InputError("a move of least travel is sought in some hundred periods", found, "take fewer or longer ones")
    if not steered.reaches:
        arrived = f"within {within:g} s the reading misses its band by {1e3 * steered.miss:.3g} mm"
        raise InputError("a move needs the time that it takes", arrived, "give it longer, or ask for the least time")
    return _run(task, steered.current)


def _task(
    model: Model,
    start_current: float,
    target: float,
    start_position: float,
    period: float,
    rate: float,
    current_range: tuple[float, float],
    band: float,
) -> Task:
    low, high = current_range
    if not (low <= start_current <= high and period > 0.0 and rate > 0.0 and band > 0.0):
        raise InputError(
            "a move starts inside the current's range; period, rate and band are positive",
            f"got {start_current:g} A of {low:g}..{high:g} A, {period:g} s, {rate:g} A/s, {band:g} m",
            "correct it",
        )
    at_rest = simulate(
        model, time=np.array([0.0, period]), current=np.full(2, start_current), start_position=start_position
    )
    task = Task(model, start_current, float(at_rest.position[0]), target, period, rate, current_range, band)
    if abs(target - task.start_position) <= band:
        arrived = f"it is {1e3 * task.start_position:.4g} mm, the target {1e3 * target:.4g} mm"
        raise InputError("a move goes farther than its band", arrived, "choose another target or a narrower band")
    return task


def _ramp(task: Task) -> tuple[int, np.ndarray]:
    """Return the ramp at the greatest rate to a current that ends in the band, and its periods until the arrival."""
    low, high = task.current_range
    inner, outer = task.start_current, high if task.rises else low
    slowest = abs(outer - inner) / task.rate if math.isfinite(task.rate) else 0.0
    count = math.ceil(slowest / task.period) + task.hold + 1
    aim = 0.5 * sum(task.ends)

    def ramped(end: float) -> np.ndarray:
        reach = task.rate * task.period * np.arange(1, count + 1)
        return task.start_current + np.clip(end - task.start_current, -reach, reach)

    def passes(end: float) -> bool:
        reading = _exact(task, ramped(end)).position[-1]
        return bool(reading > aim) if task.rises else bool(reading < aim)

    if not passes(outer):
        raise InputError(
            "a target lies within what the current's range reaches",
            f"{1e3 * outer:g} mA ends short of {1e3 * task.target:.4g} mm",
            "choose a nearer target or a wider range",
        )
    for _ in range(40):
        middle = 0.5 * (inner + outer)
        inner, outer = (inner, middle) if passes(middle) else (middle, outer)
    current = ramped(outer)
    arrival = _periods_until(task, _exact(task, current))
    periods = arrival + task.hold
    if periods > MOST_PERIODS:
        raise InputError(
            f"a move has at most {MOST_PERIODS} periods", f"it takes about {periods}", "choose a longer period"
        )
    return arrival, current[:periods] if periods <= count else np.append(current, np.full(periods - count, current[-1]))


def _soonest(task: Task, arrival: int, ramp: np.ndarray, progress: Progress) -> tuple[int, Steered | None]:
    """Return the fewest periods in which the band can be reached, at most the ramp's, and the currents to it.

    A program in haste arrives as soon as it can; one period less is asked for until that misses.
    """
    program = _program(task, len(ramp))
    best, guess, asked = None, ramp, arrival
    while asked > 0:
        progress("least time", 1.0 - asked / (arrival + 1.0))
        steered = _solved(program, asked, guess, HASTE)
        if not steered.reaches:
            break
        best, guess, asked = steered, steered.unknowns, min(steered.arrival, asked) - 1
    return arrival if best is None else best.arrival, best


def _solved(program: SteeringProgram, arrival: int, guess: np.ndarray, prices: tuple[float, float]) -> Steered:
    """Solve at the narrow width, by way of the wide one where that does not end at once."""
    steered = program.solve(arrival, WIDTH, guess, prices)
    if steered.is_sound:
        return steered
    wide = program.solve(arrival, DETOUR, guess, prices)
    if not wide.is_sound:
        return steered
    narrow = program.solve(arrival, WIDTH, wide.unknowns, prices)
    return narrow if narrow.is_sound else wide


def _program(task: Task, periods: int) -> SteeringProgram:
    low, high = task.ends
    margin = MARGIN * task.band
    return SteeringProgram(
        SmoothChain(task.model, parts=parts_for(task.model, task.period)),
        period=task.period,
        periods=periods,
        hold=task.hold,
        start_reading=task.start_position,
        start_current=task.start_current,
        band=(low + margin, high - margin),
        current_range=task.current_range,
        rate=task.rate,
    )


def _exact(task: Task, current: np.ndarray) -> Trajectory:
    """Run the exact valve under a move, a period at the start's current before it, and watch it afterwards."""
    after = np.full(math.ceil(WATCH_TIME / task.period), current[-1])
    watched = np.concatenate([[task.start_current], current, after])
    time = task.period * np.arange(len(watched))
    return simulate(task.model, time=time, current=watched, start_position=task.start_position)


def _periods_until(task: Task, trajectory: Trajectory) -> int:
    """Return the periods of a move until the reading stays in the band; more than there are where it does not."""
    low, high = task.ends
    outside = np.flatnonzero((trajectory.position < low) | (trajectory.position > high))
    return int(outside[-1]) if len(outside) else 0


def _run(task: Task, current: np.ndarray) -> Move:
    trajectory = _exact(task, current)
    arrival = _periods_until(task, trajectory)
    beyond = (trajectory.position - task.target) * (1.0 if task.rises else -1.0)
    return Move(
        trajectory=trajectory,
        target=task.target,
        duration=arrival * task.period if arrival + 1 < len(trajectory.time) else math.inf,
        overshoot=max(float(beyond.max()), 0.0),
        travel=float(np.abs(np.diff(trajectory.current)).sum()),
    )
