"""What a stage sees: how much of the gap a correction of its output explains that depends on nothing else.

An effect can only depend on what goes through its stage, and on time: in the electromagnet on the current, in the
nozzle on the pressure, in the stem on position, speed and the side on which friction acts, in the sensor on the
position. So each stage gets some functions of its own signals, and what they explain together, the base valve fitted
beside them, tells stages apart that the place of a correction alone does not.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from diagnosis.corrections import in_means, run_with_pressures
from identification.experiment import Experiment, simulate_rows
from identification.fit import Fit, measured
from identification.problem import SEARCH_TOLERANCE, Problem
from identification.search import Slopes
from identification.unknowns import start_unknown
from valvemodel.declarations import STAGES
from valvemodel.model import Model

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

LEAST_SIZE = 1e-3
"""A function is left out whose root mean square is less; that of the signals themselves is some tenths."""

UNIT, SPREAD, SPREAD_BASE = 0.01, 0.2, 0.02
"""What a function of 1 shifts the reading by, over the range of the readings; the prior spread of that, and of what the
base valve's scaled numbers move: of corrections that explain the same it is the least that is told."""

NUDGE, NUDGE_BASE = 0.1, 2e-4
"""Steps of the forward differences in functions and in the base valve's scaled numbers."""

EVALUATIONS, PRECISION = 15, 1e-3
"""Points of a search at most, and the share of the error below which a step's gain ends it."""

LAGGING = ("stem_mass", "viscous_friction")
"""Numbers of the base valve that make up for a lag elsewhere, the first without need of its own."""

DRIVING = ("diaphragm_area", "spring_preload", "spring_rate", "viscous_friction", "coulomb_friction")
"""Numbers of the base valve that tell what its friction holds."""


@dataclass(frozen=True, eq=False)
class Seen:
    """The signals of the base valve in one experiment, each of shape (n,).

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
        """Return a signal behind a lag, less the signal."""
        from scipy.signal import lfilter

        kept = float(np.exp(-np.median(np.diff(self.time)) / constant))
        behind, _ = lfilter([1.0 - kept], [1.0, -kept], signal, zi=[kept * signal[0]])
        return np.asarray(behind) - signal

    def later(self, signal: np.ndarray, delay: float) -> np.ndarray:
        """Return a signal after a dead time, less the signal."""
        return np.interp(self.time - delay, self.time, signal) - signal


Functions = dict[str, list[np.ndarray]]
"""Functions of a stage's own signals, by what they are together in words."""


def of_electromagnet(seen: Seen) -> Functions:
    """Return functions of the current, those that move it by the pressure that they make."""
    current = seen.current
    loops = [play(current, each) for each in PLAYS]
    moving = {
        "a loop of the current": [*loops, loops[1] * (current - 0.5)],
        "a lag of the current": [seen.lag(current, each) for each in LAGS],
        "a gap that creeps with time": creep(seen),
    }
    gain = seen.gain
    return {"a gap by current": along(current)} | {
        what: [gain * each for each in functions] for what, functions in moving.items()
    }


def of_nozzle(seen: Seen) -> Functions:
    """Return functions of the pressure; its lags may differ up and down, and what is drawn is made up slowly."""
    pressure = seen.pressure
    lags = [seen.lag(pressure, each) for each in LAGS]
    either = [part for each in lags for part in (np.maximum(each, 0.0), np.minimum(each, 0.0))]
    rate = np.abs(np.gradient(pressure + seen.lag(pressure, SMOOTHED), seen.time))
    drawn = [rate + seen.lag(rate, each) for each in (CARRIED, SLOW[0])]
    return {
        "another pressure by pressure": along(pressure),
        "a lag of the pressure": [*either, lags[-1] * pressure],
        "a dead time of the pressure": [seen.later(pressure, each) for each in DELAYS],
        "a pressure that sags when it changes": [*(seen.lag(pressure, each) for each in SLOW), *drawn],
    }


def of_stem(seen: Seen) -> Functions:
    """Return forces by position and speed, and friction by what it may depend on."""
    position, speed, friction = seen.position, seen.speed, seen.friction
    return {
        "a force by position": along(position),
        "a force by speed": [np.maximum(speed, 0.0), np.minimum(speed, 0.0), speed * (position - 0.5)],
        "friction by position": [friction * each for each in along(position)],
        "friction by pressure": [friction * seen.pressure],
        "friction by speed": [friction * np.exp(-np.abs(speed) / each) for each in SLIDES_AT],
        "friction by time": [friction * each for each in creep(seen)],
    }


def of_sensor(seen: Seen) -> Functions:
    """Return functions of the position."""
    position = seen.position
    return {
        "another reading by position": along(position),
        "a play of the reading": [play(position, each) for each in PLAYS],
        "a lag of the reading": [seen.lag(position, each) for each in (*LAGS, SLOW[0])],
        "a zero that creeps with time": creep(seen),
    }


OF_STAGE: dict[str, Callable[[Seen], Functions]] = dict(
    zip(STAGES, (of_electromagnet, of_nozzle, of_stem, of_sensor), strict=True)
)


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


def creep(seen: Seen) -> list[np.ndarray]:
    """Return functions of time alone."""
    return [seen.elapsed, seen.elapsed**2]


@dataclass(frozen=True, eq=False)
class Explained:
    """What the own signals of a stage explain of one experiment.

    Attributes
    ----------
    stage : str
    experiment : Experiment
    model : Model
        The base valve.
    start : float [m]
        First reading of the base valve.
    left, missed : float [m]
        Root mean square of what is missed all the same, and of what the base valve alone misses.
    left_by : dict of float [m]
        What is missed where the stage has functions of one kind alone; the kind that leaves least is first.
    lead : array, shape (n,) [m]
        The correction by that kind, as the shift of the reading at rest that it makes.
    """

    stage: str
    experiment: Experiment
    model: Model
    start: float
    left: float
    missed: float
    left_by: dict[str, float]
    lead: np.ndarray

    @property
    def excess(self) -> float:
        """Squared error beyond the noise that is left. [noise^2]"""
        return max((self.left / self.experiment.noise) ** 2 - 1.0, 0.0)

    def closed(self, left: float) -> float:
        """Return the share of the squared gap above the noise that is closed where so much is left. [m]"""
        reducible = max(self.missed**2 - self.experiment.noise**2, 1e-12 * self.missed**2)
        return float(np.clip((self.missed**2 - left**2) / reducible, 0.0, 1.0))

    def as_json(self) -> dict[str, Any]:
        """Return what diagnosis.json has of it."""
        return {
            "stage": self.stage,
            "gap_after": self.left,
            "gap_closed": self.closed(self.left),
            "closed_by": {what: self.closed(left) for what, left in self.left_by.items()},
        }


@dataclass(frozen=True, eq=False)
class Corrected:
    """The base valve on one experiment, corrected by functions; points are its own scaled numbers, then their sizes.

    Attributes
    ----------
    problem : Problem
        Of the base on the experiment.
    functions : array, shape (functions, n) [m]
    is_reading : bool
        Whether they shift the reading, else the pressure.
    begin : array, shape (m,)
        The base valve's numbers without a correction.
    """

    problem: Problem
    functions: np.ndarray
    is_reading: bool
    begin: np.ndarray

    @property
    def experiment(self) -> Experiment:
        """The experiment."""
        return self.problem.experiments[0]

    @property
    def own(self) -> int:
        """How many numbers are the base valve's own."""
        return len(self.problem.unknowns)

    @cached_property
    def spreads(self) -> np.ndarray:
        """Standard deviations of the priors."""
        return np.repeat([SPREAD_BASE, SPREAD], [self.own, len(self.functions)])

    @cached_property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Bounds of a point."""
        free = np.full(len(self.functions), np.inf)
        low, high = self.problem.bounds
        return np.concatenate([low, -free]), np.concatenate([high, free])

    def readings(self, points: np.ndarray) -> np.ndarray:
        """Return the readings at points, shape (p, n). [m]"""
        rows, shifts = self.problem.rows(points[:, : self.own], 0), points[:, self.own :] @ self.functions
        base = simulate_rows(self.experiment, rows, tolerance=SEARCH_TOLERANCE, with_pressure=True)
        if self.is_reading:
            return np.asarray(base.position + shifts)
        per_shift = rows["spring_rate"] / rows["diaphragm_area"]
        return run_with_pressures(rows, self.experiment, held(base.pressure) + per_shift[:, None] * shifts)

    def residuals(self, points: np.ndarray) -> np.ndarray:
        """Return the errors in means of neighbouring samples, each by its weight, and the priors, shape (p, r)."""
        missed = (self.experiment.position - self.readings(points)) / self.experiment.noise
        means, counts = in_means(missed)
        return np.concatenate([means * np.sqrt(counts), (points - self.begin) / self.spreads], axis=1)

    def jacobian(self, point: np.ndarray, residual: np.ndarray) -> np.ndarray:
        """Return the derivative of the residuals, shape (r,), at a point by differences, shape (r, m)."""
        steps = np.where(np.arange(len(point)) < self.own, NUDGE_BASE, NUDGE)
        steps[point + steps > self.bounds[1]] *= -1.0
        return ((self.residuals(point + np.diag(steps)) - residual) / steps[:, None]).T

    def explain(self) -> tuple[np.ndarray, float]:
        """Fit all numbers; return the correction, shape (n,), and what is left. [m]"""
        from scipy.optimize import least_squares

        low, high = self.bounds
        slopes = Slopes(lambda point: self.residuals(point[None, :])[0], self.jacobian, 1)
        found = least_squares(
            slopes.residuals, np.clip(self.begin, low + 1e-6, high - 1e-6), jac=slopes.jacobian, bounds=(low, high),
            max_nfev=EVALUATIONS, ftol=PRECISION, xtol=1e-7, x_scale="jac",
        )  # fmt: skip
        left = self.experiment.position - self.readings(found.x[None, :])[0]
        return found.x[self.own :] @ self.functions, float(np.sqrt(np.nanmean(left**2)))


def explained_by_stages(
    experiment: Experiment, base: Fit, start: float, stages: Sequence[str], pool: Executor | None
) -> list[Explained]:
    """Return what each of some stages explains of an experiment by its own signals, that which leaves least first.

    Parameters
    ----------
    experiment : Experiment
    base : Fit
        Of the base valve.
    start : float [m]
        First reading of the base.
    stages : sequence of str
    pool : Executor or None
        Whose processes are used.
    """
    found = list((pool.map if pool else map)(partial(explained_by, experiment, base, start), stages))
    return sorted(found, key=lambda each: each.left)


@threadpool_limits.wrap(limits=1)
def explained_by(experiment: Experiment, base: Fit, start: float, stage: str) -> Explained:
    """Return what one stage explains by its own signals, beside the base valve as it is fitted or without its lags."""
    pairs = [(each, x) for each, x in zip(base.unknowns, base.found.point, strict=True) if each.experiment < 0]
    unknowns = [*(each for each, _ in pairs), start_unknown(start, 0)]
    fitted = Problem(base.model, [experiment], unknowns, measured([experiment]))
    point = np.array([*(x for _, x in pairs), 0.0])
    run = simulate_rows(experiment, fitted.rows(point[None, :], 0), tolerance=SEARCH_TOLERANCE)
    missed = float(np.sqrt(np.nanmean((experiment.position - run.position[0]) ** 2)))
    bases = [(each, its, OF_STAGE[stage](seen_by(each, its))) for each, its in (
        (fitted, point), without_lags(fitted, point)
    )]  # fmt: skip
    nothing = np.zeros(len(experiment.time)), missed

    def best(kinds: Sequence[str]) -> tuple[np.ndarray, float]:
        trials = [
            beside(problem, begin, [each for kind in kinds for each in functions[kind]], stage)
            for problem, begin, functions in bases
        ]
        return min([nothing, *trials], key=lambda trial: trial[1])

    kinds = list(bases[0][2])
    alone = sorted(((kind, *best([kind])) for kind in kinds), key=lambda trial: trial[2])
    left = min(best(kinds)[1], alone[0][2])
    left_by = {kind: left for kind, _, left in alone}
    return Explained(stage, experiment, base.model, start, left, missed, left_by, alone[0][1])


def without_lags(problem: Problem, point: np.ndarray) -> tuple[Problem, np.ndarray]:
    """Return the problem of a base valve with its usual mass, and a point with its usual viscous friction.

    Where mass and friction of the fitted one made up for a lag, they hide it from its own stage.
    """
    names = [each.name for each in problem.unknowns]
    mass = names.index(LAGGING[0])
    usual = np.where([name in LAGGING for name in names], 0.0, point)
    model = problem.model.with_values(**{LAGGING[0]: problem.unknowns[mass].centre})
    unknowns = [each for each in problem.unknowns if each.name != LAGGING[0]]
    return Problem(model, problem.experiments, unknowns, problem.used), np.delete(usual, mass)


def beside(problem: Problem, point: np.ndarray, own: Sequence[np.ndarray], stage: str) -> tuple[np.ndarray, float]:
    """Return the correction that functions at a stage make beside a base valve, shape (n,), and what is left. [m]"""
    functions = np.array(own)
    sizes = np.sqrt(np.mean(functions**2, axis=1))
    is_felt = sizes > LEAST_SIZE
    extent = float(np.ptp(problem.experiments[0].position[problem.used[0]]))
    scaled = UNIT * extent * functions[is_felt] / sizes[is_felt, None]
    begin = np.concatenate([point, np.zeros(len(scaled))])
    return Corrected(problem, scaled, stage == STAGES[-1], begin).explain()


def seen_by(problem: Problem, point: np.ndarray) -> Seen:
    """Return the signals of the base valve at a point in its experiment."""
    experiment, row = problem.experiments[0], problem.rows(point[None, :], 0)
    numbers = {name: float(row[name][0]) for name in DRIVING}
    run = simulate_rows(experiment, row, tolerance=SEARCH_TOLERANCE, with_pressure=True)
    position, pressure = run.position[0], held(run.pressure)[0]
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


def held(pressures: np.ndarray) -> np.ndarray:
    """Return the pressures that are held from each sample on, of those that stand just before it, shape (p, n)."""
    return np.concatenate([pressures[:, 1:], pressures[:, -1:]], axis=1)


def over_range(signal: np.ndarray) -> np.ndarray:
    """Return a signal over its range, from 0 to 1."""
    return (signal - signal.min()) / (float(np.ptp(signal)) or 1.0)
