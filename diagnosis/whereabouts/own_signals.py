"""What a stage sees: how much of the gap a correction of its output explains that depends on nothing else.

Each stage gets functions of its own signals. What they explain together, the base valve fitted beside them, tells
stages apart that the place of a correction alone does not; what explains most by itself is a lead.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from diagnosis.whereabouts.corrections import closed_of, in_means, run_with_pressures
from diagnosis.whereabouts.stage_functions import functions_of
from identification.cores import mapped
from identification.experiment import Experiment, simulate_rows
from identification.fit import Fit, measured
from identification.problem import DIFFERENCE, LOST, SEARCH_TOLERANCE, Problem
from identification.search import descend
from identification.unknowns import start_unknown
from valvemodel.declarations import STAGES
from valvemodel.model import Model

LEAST_SIZE = 1e-3
"""A function is left out whose root mean square is less; that of the signals themselves is some tenths."""

UNIT, SPREAD, SPREAD_BASE = 0.01, 0.2, 0.02
"""What a function of 1 shifts the reading by, over the range of the readings; the prior spread of that, and of what the
base valve's scaled numbers move: of corrections that explain the same it is the least that is told."""

NUDGE = 0.1
"""Step of the forward differences in functions."""

EVALUATIONS, PRECISION = 15, 1e-3
"""Points of a search at most, and the share of the error below which a step's gain ends it."""

LAGGING = ("stem_mass", "viscous_friction")
"""Numbers of the base valve that make up for a lag elsewhere, the first without need of its own."""


@dataclass(frozen=True, eq=False)
class Trial:
    """A base valve with a correction.

    Attributes
    ----------
    model : Model
        The base valve beside the correction.
    start : float [m]
        Its first reading.
    values : array, shape (n,) [m]
        The correction, as the shift of the reading at rest that it makes.
    left : float [m]
        Root mean square of what is missed all the same.
    """

    model: Model
    start: float
    values: np.ndarray
    left: float


@dataclass(frozen=True, eq=False)
class Explained:
    """What the own signals of a stage explain of one experiment.

    Attributes
    ----------
    stage : str
    experiment : Experiment
    missed, left : float [m]
        Root mean square of what is missed without and with functions of all kinds, the base valve fitted beside them.
    left_by : dict of float [m]
        What is missed with functions of one kind alone; the kind that leaves least is first.
    lead : Trial
        The one with that kind.
    """

    stage: str
    experiment: Experiment
    missed: float
    left: float
    left_by: dict[str, float]
    lead: Trial

    @property
    def excess(self) -> float:
        """Squared error beyond the noise that is left. [noise^2]"""
        return max((self.left / self.experiment.noise) ** 2 - 1.0, 0.0)

    def closed(self, left: float) -> float | None:
        """Return the share of the squared gap above the noise that is closed where so much is left [m], if any is."""
        return closed_of(self.missed, left, self.experiment.noise)

    def as_json(self) -> dict[str, Any]:
        """Return what diagnosis.json has of it."""
        return {
            "stage": self.stage,
            "record": self.experiment.name,
            "gap_after": self.left,
            "gap_closed": self.closed(self.left),
            "closed_by": {what: self.closed(left) for what, left in self.left_by.items()},
        }


@dataclass(frozen=True, eq=False)
class WithFunctions:
    """The base valve on one experiment with functions on top; points are its own scaled numbers, then their sizes.

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
    has_series = False
    """No number is one of a series that costs a run each."""

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
        return run_with_pressures(
            rows, self.experiment, self.experiment.held_from(base.pressure) + per_shift[:, None] * shifts
        )

    def residuals(self, points: np.ndarray) -> np.ndarray:
        """Return the errors in means of neighbouring samples, each by its weight, and the priors, shape (p, r)."""
        readings = self.readings(points)
        missed = (self.experiment.position - readings) / self.experiment.noise
        means, counts = in_means(np.where(np.isfinite(readings), missed, LOST))
        return np.concatenate([means * np.sqrt(counts), (points - self.begin) / self.spreads], axis=1)

    def jacobian(self, point: np.ndarray, known: np.ndarray) -> np.ndarray:
        """Return the derivative of the residuals, `known` at a point, there by differences, shape (r, m)."""
        steps = np.where(np.arange(len(point)) < self.own, DIFFERENCE, NUDGE)
        steps[point + steps > self.bounds[1]] *= -1.0
        return ((self.residuals(point + np.diag(steps)) - known) / steps[:, None]).T

    def explain(self) -> Trial:
        """Fit all numbers."""
        point = descend(self, self.begin, evaluations=EVALUATIONS, precision=PRECISION).point
        own = point[: self.own]
        left = self.experiment.position - self.readings(point[None, :])[0]
        return Trial(
            self.problem.model.with_values(**self.problem.values(own)),
            self.problem.starts(own)[0],
            point[self.own :] @ self.functions,
            float(np.sqrt(np.nanmean(left**2))),
        )


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
    found = mapped(pool, partial(explained_by, experiment, base, start), stages)
    return sorted(found, key=lambda each: each.left)


def explained_by(experiment: Experiment, base: Fit, start: float, stage: str) -> Explained:
    """Return what one stage explains by its own signals, beside the base valve as it is fitted or without its lags.

    What the base valve explains of this experiment alone, fitted to it once more, is none of the stage's.
    """
    pairs = [(each, x) for each, x in zip(base.unknowns, base.found.point, strict=True) if each.experiment < 0]
    unknowns = [*(each for each, _ in pairs), start_unknown(start, 0)]
    fitted = Problem(base.model, [experiment], unknowns, measured([experiment]))
    bases = [(fitted, np.array([*(x for _, x in pairs), 0.0]))]
    bases.append(without_lags(*bases[0]))
    functions = [functions_of(stage, *each) for each in bases]

    def best(kinds: Sequence[str]) -> Trial:
        trials = [
            beside(*each, [function for kind in kinds for function in its[kind]], stage)
            for each, its in zip(bases, functions, strict=True)
        ]
        return min(trials, key=lambda trial: trial.left)

    kinds = list(functions[0])
    nothing = best([])
    alone = {kind: min(best([kind]), nothing, key=lambda trial: trial.left) for kind in kinds}
    order = sorted(kinds, key=lambda kind: alone[kind].left)
    lead = alone[order[0]]
    left_by = {kind: alone[kind].left for kind in order}
    return Explained(stage, experiment, nothing.left, min(best(kinds).left, lead.left), left_by, lead)


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


def beside(problem: Problem, point: np.ndarray, own: Sequence[np.ndarray], stage: str) -> Trial:
    """Return what functions at a stage, or none, make of the gap beside a base valve."""
    functions = np.array(own).reshape(len(own), len(problem.experiments[0].time))
    sizes = np.sqrt(np.mean(functions**2, axis=1))
    is_felt = sizes > LEAST_SIZE
    extent = float(np.ptp(problem.experiments[0].position[problem.used[0]]))
    scaled = UNIT * extent * functions[is_felt] / sizes[is_felt, None]
    begin = np.concatenate([point, np.zeros(len(scaled))])
    return WithFunctions(problem, scaled, stage == STAGES[-1], begin).explain()
