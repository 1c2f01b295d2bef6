"""Functions of what goes through a stage: of its own signals, and of time.

An effect can only depend on these: in the electromagnet on the current, in the nozzle on the pressure, in the stem on
position, speed and the side on which friction acts, in the sensor on the position.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from identification.experiment import simulate_rows
from identification.problem import SEARCH_TOLERANCE, Problem
from valvemodel.declarations import STAGES

KNOTS = 10
"""Places along the range of a signal between which a function of it is linear."""

PLAYS, LAGS, SLOW = (0.02, 0.06, 0.15), (0.03, 0.1, 0.3), (2.0, 8.0)
"""Half widths of plays, over the range of the signal, and time constants of lags, fast and slow. [s]"""

DELAYS = (0.05, 0.12)
"""Dead times of a line. [s]"""

SMOOTHED, CARRIED = 0.05, 0.4
"""Time constants with which a rate is taken, and with which what it draws is made up at once. [s]"""

SLIDES_AT = (0.1, 0.5)
"""Speeds over their root mean square within which friction falls."""

GRID = 33
"""Currents between which the slope of the pressure over it is taken."""

DRIVING = ("diaphragm_area", "spring_preload", "spring_rate", "viscous_friction", "coulomb_friction")
"""Numbers of the base valve that tell what its friction holds."""

Functions = dict[str, list[np.ndarray]]
"""Functions by what they are together in words; each of shape (n,)."""


@dataclass(frozen=True, eq=False)
class Seen:
    """The signals of the base valve in one experiment, each of shape (n,), from each sample on.

    Attributes
    ----------
    time, current, pressure, position : array
        The last three over their ranges, from 0 to 1.
    speed, friction : array
        Over the root mean square; over the Coulomb friction, from -1 to 1, in a stem at rest what holds it.
    """

    time: np.ndarray
    current: np.ndarray
    pressure: np.ndarray
    position: np.ndarray
    speed: np.ndarray
    friction: np.ndarray

    @property
    def gain(self) -> np.ndarray:
        """Pressure that a change of the current makes, both over their ranges."""
        order = np.argsort(self.current)
        grid = np.linspace(0.0, 1.0, GRID)
        slopes = np.gradient(np.interp(grid, self.current[order], self.pressure[order]), grid)
        return np.interp(self.current, grid, slopes)

    @property
    def elapsed(self) -> np.ndarray:
        """Time over the length of the record, from the middle."""
        return self.time / self.time[-1] - 0.5

    def lag(self, signal: np.ndarray, constant: float) -> np.ndarray:
        """Return a signal, held from each sample on, behind a lag, less the signal."""
        moved = -np.expm1(-np.diff(self.time) / constant)
        behind = [float(signal[0])]
        for value, share in zip(signal[:-1].tolist(), moved.tolist(), strict=True):
            behind.append(behind[-1] + share * (value - behind[-1]))
        return np.array(behind) - signal

    def later(self, signal: np.ndarray, delay: float) -> np.ndarray:
        """Return a signal after a dead time, less the signal."""
        return np.interp(self.time - delay, self.time, signal) - signal

    def creep(self) -> list[np.ndarray]:
        """Return functions of time alone."""
        return [self.elapsed, self.elapsed**2]


def along(signal: np.ndarray) -> list[np.ndarray]:
    """Return hats along the range of a signal, which sum to 1."""
    lowest, highest = np.quantile(signal, [0.005, 0.995])
    knots = np.linspace(lowest, highest, KNOTS)
    return [np.interp(signal, knots, each) for each in np.eye(KNOTS)]


def play(signal: np.ndarray, half_width: float) -> np.ndarray:
    """Return a signal behind a play, less the signal."""
    behind, last = [], float(signal[0])
    for value in signal.tolist():
        last = min(max(last, value - half_width), value + half_width)
        behind.append(last)
    return np.array(behind) - signal


def of_electromagnet(seen: Seen) -> tuple[Functions, Functions]:
    """Return functions of the current, those that move it by the pressure that they make."""
    current, gain = seen.current, seen.gain
    loops = [play(current, each) for each in PLAYS]
    loops.append(loops[1] * (current - 0.5))
    still = {"another curve of the current": along(current), "a loop of the current": [gain * each for each in loops]}
    return still, {
        "a lag of the current": [gain * seen.lag(current, each) for each in LAGS],
        "a gap that creeps with time": [gain * each for each in seen.creep()],
    }


def of_nozzle(seen: Seen) -> tuple[Functions, Functions]:
    """Return functions of the pressure; its lags may differ up and down, and what is drawn is made up slowly."""
    pressure = seen.pressure
    lags = [seen.lag(pressure, each) for each in LAGS]
    either = [part for each in lags for part in (np.maximum(each, 0.0), np.minimum(each, 0.0))]
    rate = np.abs(np.gradient(pressure + seen.lag(pressure, SMOOTHED), seen.time))
    drawn = [rate + seen.lag(rate, each) for each in (CARRIED, SLOW[0])]
    return {"another curve of the pressure": along(pressure)}, {
        "a lag of the pressure": [*either, lags[-1] * pressure],
        "a dead time of the pressure": [seen.later(pressure, each) for each in DELAYS],
        "a pressure that sags when it changes": [*(seen.lag(pressure, each) for each in SLOW), *drawn],
    }


def of_stem(seen: Seen) -> tuple[Functions, Functions]:
    """Return forces by position and speed, and friction by what it may depend on."""
    position, speed, friction = seen.position, seen.speed, seen.friction
    still = {
        "a force by position": along(position),
        "friction by position": [friction * each for each in along(position)],
        "friction by pressure": [friction * seen.pressure],
    }
    return still, {
        "a force by speed": [np.maximum(speed, 0.0), np.minimum(speed, 0.0), speed * (position - 0.5)],
        "friction by speed": [friction * np.exp(-np.abs(speed) / each) for each in SLIDES_AT],
        "friction by time": [friction * each for each in seen.creep()],
    }


def of_sensor(seen: Seen) -> tuple[Functions, Functions]:
    """Return functions of the position."""
    position = seen.position
    still = {
        "another curve of the reading": along(position),
        "a play of the reading": [play(position, each) for each in PLAYS],
    }
    return still, {
        "a lag of the reading": [seen.lag(position, each) for each in (*LAGS, SLOW[0])],
        "a zero that creeps with time": seen.creep(),
    }


OF_STAGE: dict[str, Callable[[Seen], tuple[Functions, Functions]]] = dict(
    zip(STAGES, (of_electromagnet, of_nozzle, of_stem, of_sensor), strict=True)
)
"""Functions of each stage: those that need no time, and those that act in it, which a settled loop does not show."""


def functions_of(stage: str, problem: Problem, point: np.ndarray) -> Functions:
    """Return the functions of a stage that the experiment of a problem can show, for the base valve at a point."""
    still, in_time = OF_STAGE[stage](seen_by(problem, point))
    return still if problem.experiments[0].is_loop else still | in_time


def seen_by(problem: Problem, point: np.ndarray) -> Seen:
    """Return the signals of the base valve at a point in its experiment."""
    experiment, row = problem.experiments[0], problem.rows(point[None, :], 0)
    numbers = {name: float(row[name][0]) for name in DRIVING}
    run = simulate_rows(experiment, row, tolerance=SEARCH_TOLERANCE, with_pressure=True)
    position, pressure = run.position[0], experiment.held_from(run.pressure[0])
    speed = np.gradient(position, experiment.time)
    driving = numbers["diaphragm_area"] * pressure - numbers["spring_preload"] - numbers["spring_rate"] * position
    friction = (driving - numbers["viscous_friction"] * speed) / numbers["coulomb_friction"]
    return Seen(
        time=experiment.time,
        current=over_range(experiment.current),
        pressure=over_range(pressure),
        position=over_range(position),
        speed=speed / (float(np.sqrt(np.mean(speed**2))) or 1.0),
        friction=np.clip(friction, -1.0, 1.0),
    )


def over_range(signal: np.ndarray) -> np.ndarray:
    """Return a signal over its range, from 0 to 1."""
    return (signal - signal.min()) / (float(np.ptp(signal)) or 1.0)
