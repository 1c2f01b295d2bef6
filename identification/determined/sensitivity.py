"""How a record would change with each number, and which combinations of numbers it hardly shows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from identification.determined.uncertainty import UNDETERMINED_SHARE
from identification.fit import Fit
from identification.problem import FINE_TOLERANCE, Problem
from identification.unknowns import Unknown
from valvemodel.effects import is_jagged
from valvemodel.quantities import format_quantity

SEEN = 1.0
"""A step is wide enough once all readings together change by so many standard deviations of the noise."""

SMALLEST_STEP, WIDEST_STEP = 1e-6, 0.5
"""Steps in scaled unknowns: from 1e-6 doubled until the noise lets the change be seen."""

NAMED_SHARE = 0.3
"""A parameter that moves by less than this share of the one that moves most is left out of the words."""

GROWTH = 0.01
"""The change that a combination is described at: 1 % of the parameter that moves most."""


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Change of all readings with the scaled unknowns, start positions taken out.

    Attributes
    ----------
    unknowns : tuple of Unknown
        Of the valve and its effects.
    steps : array, shape (n,)
        Half the width that each central difference was taken over, in the scaled unknown.
    columns : array, shape (r, n) [noise]
        Change of each reading with each unknown, less what a change of the start positions could imitate. The noise is
        that of the readings or, where that is more, what the fit leaves of them.
    is_anchored : bool
        Whether the run was put anew on the readings, as it is for a model whose slips come in jumps.
    """

    unknowns: tuple[Unknown, ...]
    steps: np.ndarray
    columns: np.ndarray
    is_anchored: bool


@dataclass(frozen=True, eq=False)
class Direction:
    """One combination of parameters, orthogonal to the others where each counts in units of its prior.

    Attributes
    ----------
    unknowns : tuple of Unknown
    change : array, shape (n,)
        Of the scaled unknowns, where the largest grows by 1 %.
    reading : float
        Change of the reading that goes with it, root mean square. [noise]
    seen : float
        The same for all readings together: how many of its own standard deviations the change is.
    narrowing : float
        Share of the prior's width that is left after the record.
    """

    unknowns: tuple[Unknown, ...]
    change: np.ndarray
    reading: float
    seen: float
    narrowing: float

    @property
    def is_determined(self) -> bool:
        """Whether the record narrows this combination to less than half of its prior."""
        return self.narrowing < UNDETERMINED_SHARE

    @property
    def names(self) -> list[str]:
        """The parameters that take a good part in it, the largest first."""
        order = np.argsort(-np.abs(self.change))
        return [self.unknowns[each].name for each in order if abs(self.change[each]) >= NAMED_SHARE * GROWTH]

    @property
    def words(self) -> str:
        """The combination, what it does to the reading, and whether that determines it."""
        amounts = {each.name: (part, _amount(each, abs(part))) for each, part in self.parts}
        sides: dict[bool, list[str]] = {True: [], False: []}
        for name in self.names:
            sides[amounts[name][0] > 0.0].append(f"{name} by {amounts[name][1]}")
        if len(self.names) == 1:
            combination = f"{self.names[0]} growing by {amounts[self.names[0]][1]}"
        else:
            combination = f"{' and '.join(sides[True])} growing{' together' if len(sides[True]) > 1 else ''}"
        if sides[False]:
            combination += f" with {' and '.join(sides[False])} shrinking"
        reading = format_quantity(self.reading, "1", digits=2)
        sentence = f"{combination} would change the reading by {reading} noise standard deviations"
        if not self.is_determined:
            return f"{sentence}: not determined"
        largest, part = max(self.parts, key=lambda pair: abs(pair[1]))
        return f"{sentence}: determined to {_amount(largest, part / self.seen)}"

    @property
    def parts(self) -> list[tuple[Unknown, float]]:
        """Each unknown with its change."""
        return list(zip(self.unknowns, self.change.tolist(), strict=True))

    def as_json(self) -> dict[str, Any]:
        """Return the part of fit.json."""
        return {
            "words": self.words,
            "change": {each.name: {"value": part * (1.0 if each.is_logarithmic else each.spread),
                                   "unit": "of itself" if each.is_logarithmic else each.unit}
                       for each, part in self.parts},
            "reading_change": self.reading,
            "all_readings_change": self.seen,
            "determined": self.is_determined,
        }  # fmt: skip


def sensitivity_of(fit: Fit) -> Sensitivity:
    """Return how the exact trajectory at the solution changes with each unknown of the valve and its effects."""
    problem = exact_problem(fit)
    columns, steps = differences(problem, fit.found.point)
    of_start = np.array([unknown.experiment >= 0 for unknown in fit.unknowns])
    basis, _ = np.linalg.qr(columns[:, of_start])
    kept = columns[:, ~of_start] / misfit(problem, fit.found.point)
    own = tuple(unknown for unknown in fit.unknowns if unknown.experiment < 0)
    return Sensitivity(own, steps[~of_start], kept - basis @ (basis.T @ kept), problem.is_anchored)


def misfit(problem: Problem, point: np.ndarray) -> float:
    """Return the root mean square of the weighted residuals, at least 1."""
    residual = problem.residuals(point[None, :])[0][: -len(point)]
    return max(float(np.sqrt(np.mean(residual**2))), 1.0)


def exact_problem(fit: Fit) -> Problem:
    """Return the problem of a fit of fine runs, without priors, re-anchored where it is jagged."""
    flat = tuple(replace(unknown, prior_spread=np.inf) for unknown in fit.unknowns)
    is_anchored = fit.problem.is_anchored or is_jagged(fit.model.effects)
    return replace(fit.problem, unknowns=flat, tolerance=FINE_TOLERANCE, is_anchored=is_anchored)


def differences(problem: Problem, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the change of the residuals with each scaled unknown, and the steps it was taken over.

    Central differences, each step doubled until the noise lets the change be seen: under held inputs the instant of a
    slip moves in jumps of a sample, so that the derivative by the friction at which it breaks away is zero almost
    everywhere, and only a finite step means something. What one such jump shows at once counts as just seen.

    Returns
    -------
    (array, shape (r, unknowns), array, shape (unknowns,))
        The change over the step [noise], half the width of the step.
    """
    low, high = problem.bounds
    steps = np.full(len(point), SMALLEST_STEP)
    columns = np.empty((0, len(point)))
    left = np.arange(len(point))
    while left.size:
        offsets = np.diag(steps)[left]
        above, below = np.clip(point + offsets, low, high), np.clip(point - offsets, low, high)
        residuals = problem.residuals(np.vstack([above, below]))
        change = (residuals[: len(left)] - residuals[len(left) :]).T
        if not columns.size:
            columns = np.empty((len(change), len(point)))
        size = np.linalg.norm(change, axis=0)
        widths = np.maximum((above - below).sum(axis=1), SMALLEST_STEP)
        columns[:, left] = change * (np.minimum(1.0, 4.0 * SEEN / np.maximum(size, SEEN)) / widths)
        left = left[(size < 2.0 * SEEN) & (steps[left] < WIDEST_STEP)]
        steps[left] *= 2.0
    return columns, steps


def directions_of(sensitivity: Sensitivity) -> list[Direction]:
    """Return the combinations of parameters, the one that the record shows least first.

    They are the right singular vectors of the sensitivity, each unknown counted in units of its prior.
    """
    prior = np.array([unknown.prior_spread for unknown in sensitivity.unknowns])
    _, sizes, vectors = np.linalg.svd(sensitivity.columns * prior, full_matrices=False)
    readings = len(sensitivity.columns) - len(sensitivity.unknowns)
    found = []
    for size, vector in zip(sizes[::-1], vectors[::-1], strict=True):
        change = vector * prior
        change = change * (GROWTH / change[np.argmax(np.abs(change))])
        seen = float(np.linalg.norm(sensitivity.columns @ change))
        narrowing = float(1.0 / np.hypot(1.0, size))
        found.append(Direction(sensitivity.unknowns, change, seen / np.sqrt(readings), seen, narrowing))
    return found


def _amount(unknown: Unknown, change: float) -> str:
    """Say a change of a scaled unknown: in percent, or in its unit where it may be zero."""
    if unknown.is_logarithmic:
        return f"{format_quantity(100.0 * change, '1', digits=2)} %"
    return format_quantity(change * unknown.spread, unknown.unit, digits=2)
