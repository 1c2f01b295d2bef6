"""The current that tells most about chosen parameters, found by differential evolution over patterns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from identification.design.information import Prospect, deviations, information, prospect
from identification.design.inputs import NUMBERS_A_SEGMENT, SEGMENTS, Limits, pattern_current, standard_ramp
from identification.design.repetition import observed_deviations
from identification.determined.sensitivity import differences
from valvemodel.errors import unknown_name
from valvemodel.model import Model
from valvemodel.progress import Progress, tell_nobody

SCHEMA = "valvemodel.design/1"

SIZE, GENERATIONS, JAGGED_GENERATIONS = 2, 50, 8
"""Patterns of a generation for each of their numbers, and generations: fewer where each step must be found anew."""

REPETITIONS = 20
"""Simulated repetitions of the designed test, each refitted."""

CRITERIA: dict[str, Callable[[np.ndarray], float]] = {
    "D": lambda covariance: float(np.linalg.slogdet(covariance)[1]),
    "A": lambda covariance: float(np.log(np.trace(covariance))),
}
"""What a design makes small of the covariance of the chosen parameters: by D the log of their ellipsoid's squared
volume, by A that of the sum of their relative variances."""


@dataclass(frozen=True)
class Expectation:
    """One chosen parameter: its standard deviation by the standard ramp, by the design, and as observed. [SI]"""

    name: str
    unit: str
    value: float
    ramp: float
    design: float
    observed: float | None


@dataclass(frozen=True, eq=False)
class Design:
    """A designed test.

    Attributes
    ----------
    time, current : arrays, shape (n,) [s], [A]
    expectations : tuple of Expectation
        Of the chosen parameters.
    criterion : str
        D or A.
    limits : Limits
    noise : float
        That was assumed. [m]
    repetitions : int
    evaluations : int
        Inputs that were tried.
    """

    time: np.ndarray
    current: np.ndarray
    expectations: tuple[Expectation, ...]
    criterion: str
    limits: Limits
    noise: float
    repetitions: int
    evaluations: int

    def as_json(self) -> dict[str, Any]:
        """Return the content of INPUT.json."""
        return {
            "schema": SCHEMA,
            "criterion": self.criterion,
            "parameters": {
                each.name: {
                    "value": each.value,
                    "unit": each.unit,
                    "std_standard_ramp": each.ramp,
                    "std_design": each.design,
                    "std_observed": each.observed,
                }
                for each in self.expectations
            },
            "limits": {
                "low": {"value": self.limits.low, "unit": "A"},
                "high": {"value": self.limits.high, "unit": "A"},
                "rate": {"value": self.limits.rate, "unit": "A/s"},
                "dwell": {"value": self.limits.dwell, "unit": "s"},
                "duration": {"value": self.limits.duration, "unit": "s"},
                "period": {"value": self.limits.period, "unit": "s"},
            },
            "noise": {"value": self.noise, "unit": "m"},
            "repetitions": self.repetitions,
            "inputs_tried": self.evaluations,
        }


def design(
    model: Model,
    names: Sequence[str],
    limits: Limits,
    *,
    noise: float,
    criterion: str = "D",
    repetitions: int = REPETITIONS,
    progress: Progress = tell_nobody,
    seed: int = 0,
) -> Design:
    """Find the admissible current that tells most about chosen parameters.

    The expected deviations hold near the model's own numbers: a valve that is far from them wants the design anew
    after a first fit.

    Parameters
    ----------
    model : Model
        What is known of the valve.
    names : sequence of str
        Parameters that a fit to current and position moves.
    limits : Limits
    noise : float
        White noise of the reading. [m]
    criterion : str
        D or A.
    repetitions : int
        Simulated repetitions for the observed deviations; 0 leaves them out.
    progress : callable
        Called with what is being done and a share of it from 0 to 1.
    seed : int
        The search is deterministic for a seed.

    References
    ----------
    Atkinson, Donev, Tobias: Optimum Experimental Designs (2007), D_S- and A-optimality.
    """
    ramp = prospect(model, time=limits.time, current=standard_ramp(limits), noise=noise)
    # Where slips come in jumps, a step that fits one input misleads with another.
    is_jagged = ramp.problem.is_anchored
    steps = None if is_jagged else differences(ramp.problem, ramp.point)[1]
    chosen = [number for number, unknown in enumerate(ramp.unknowns) if unknown.name in names]

    def loss(numbers: np.ndarray) -> float:
        found = prospect(model, time=limits.time, current=pattern_current(limits, numbers), noise=noise)
        return loss_of(information(found, steps), chosen, criterion)

    before = information(ramp)
    by_ramp = loss_of(before, chosen, criterion)
    best, evaluations = _searched(loss, JAGGED_GENERATIONS if is_jagged else GENERATIONS, progress, seed)
    found = prospect(model, time=limits.time, current=pattern_current(limits, best), noise=noise)
    if loss_of(information(found), chosen, criterion) > by_ramp:
        found = ramp
    after = information(found)
    observed = None
    if repetitions:
        observed = observed_deviations(found, after, repetitions, progress, seed)
    expectations = _expectations(found, deviations(before), deviations(after), observed, chosen)
    current = found.problem.experiments[0].current
    return Design(limits.time, current, expectations, criterion, limits, noise, repetitions, evaluations)


def loss_of(matrix: np.ndarray, chosen: Sequence[int], criterion: str) -> float:
    """Return what a design makes small by a criterion, from the information on all unknowns.

    Raises
    ------
    InputError
        If the criterion is none of `CRITERIA`.
    """
    if criterion not in CRITERIA:
        raise unknown_name("a criterion", criterion, CRITERIA)
    return CRITERIA[criterion](np.linalg.inv(matrix)[np.ix_(chosen, chosen)])


def _searched(
    loss: Callable[[np.ndarray], float], generations: int, progress: Progress, seed: int
) -> tuple[np.ndarray, int]:
    from scipy.optimize import differential_evolution

    generation = 0

    def report(x: np.ndarray, convergence: float = 0.0) -> None:
        nonlocal generation
        generation += 1
        progress(f"trying inputs, generation {generation} of {generations}", 0.8 * generation / generations)

    result = differential_evolution(
        loss,
        [(0.0, 1.0)] * (SEGMENTS * NUMBERS_A_SEGMENT),
        popsize=SIZE,
        maxiter=generations,
        tol=1e-6,
        polish=False,
        init="sobol",
        callback=report,
        rng=np.random.default_rng(seed),
    )
    return result.x, int(result.nfev)


def _expectations(
    found: Prospect, before: np.ndarray, after: np.ndarray, observed: np.ndarray | None, chosen: Sequence[int]
) -> tuple[Expectation, ...]:
    expectations = []
    for number in chosen:
        unknown = found.unknowns[number]
        value = float(unknown.value(found.point[number]))
        slope = unknown.slope(value)
        ramp, own = float(slope * before[number]), float(slope * after[number])
        seen = None if observed is None else float(slope * observed[number])
        expectations.append(Expectation(unknown.name, unknown.unit, value, ramp, own, seen))
    return tuple(expectations)
