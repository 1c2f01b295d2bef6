"""Refits near a solution: one unknown held, or other readings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from identification.determined.sensitivity import differences, exact_problem, misfit
from identification.fit import Fit, finished
from identification.problem import Problem
from identification.search import Found, descend, roam
from valvemodel.effects import is_jagged
from valvemodel.model import Model

EVALUATIONS, PRECISION = 8, 1e-7
"""Of a local descent from the solution: it is near its end."""

REACH = 4.0
"""A search near a jagged solution goes this many standard deviations along each principal direction."""

SIZE, GENERATIONS = 3, 25
"""Points of a global search for each unknown, and generations."""

SETTLING_REACHES = (100.0, 40.0, 15.0, 5.0)
"""Reaches of the searches, one after the other, that settle a jagged fit in the best minimum around. [deviations]"""

MOST_ROUNDS, NEGLIGIBLE_GAIN = 4, 0.5
"""Rounds of such searches, and the gain in half the squared residuals below which the last round ends them."""


@dataclass(frozen=True, eq=False)
class Neighbourhood:
    """A solution and its surroundings.

    Attributes
    ----------
    problem : Problem
        Of the fit, with its priors; re-anchored where the error has many minima.
    point : array, shape (unknowns,)
    covariance : array, shape (unknowns, unknowns)
        What the sensitivities say, in scaled unknowns: how far a search goes.
    has_many_minima : bool
    """

    problem: Problem
    point: np.ndarray
    covariance: np.ndarray
    has_many_minima: bool

    def refit(self, problem: Problem, start: np.ndarray, kept: Sequence[int]) -> Found:
        """Search the surroundings for the best point of a problem with some of the unknowns.

        Parameters
        ----------
        problem : Problem
            With the unknowns of this one that `kept` numbers.
        start : array, shape (len(kept),)
        kept : sequence of int
        """
        if not self.has_many_minima:
            return descend(problem, start, evaluations=EVALUATIONS, precision=PRECISION)
        return self.search(problem, start, kept, reach=REACH)

    def search(self, problem: Problem, start: np.ndarray, kept: Sequence[int], *, reach: float) -> Found:
        """Search globally as far as `reach` standard deviations along each principal direction, then descend."""
        sizes, directions = np.linalg.eigh(self.covariance[np.ix_(kept, kept)])
        shape = directions * np.sqrt(np.maximum(sizes, 0.0))
        best = roam(problem, start, shape, [(-reach, reach)] * len(start), size=SIZE, generations=GENERATIONS)
        return descend(problem, best.point, evaluations=EVALUATIONS, precision=PRECISION)

    def held(self, number: int, x: float) -> tuple[Problem, list[int]]:
        """Return the problem with one unknown held at a scaled value, and the numbers of the others."""
        unknown = self.problem.unknowns[number]
        value = float(unknown.value(x))
        model = self.problem.model
        if unknown.name in model.values:
            model = model.with_values(**{unknown.name: value})
        else:
            effects = {
                key: {name: value if name == unknown.name else own for name, own in given.items()}
                for key, given in model.effects.items()
            }
            model = Model(model.name, model.values, effects)
        kept = [other for other in range(len(self.point)) if other != number]
        return replace(self.problem, model=model, unknowns=[self.problem.unknowns[each] for each in kept]), kept


def neighbourhood_of(fit: Fit) -> Neighbourhood:
    """Return the surroundings of a fit."""
    exact = exact_problem(fit)
    columns, _ = differences(exact, fit.found.point)
    prior = np.array([unknown.prior_spread for unknown in fit.unknowns])
    information = columns.T @ columns / misfit(exact, fit.found.point) ** 2 + np.diag(prior**-2.0)
    problem = replace(fit.problem, is_anchored=exact.is_anchored)
    return Neighbourhood(problem, fit.found.point, np.linalg.inv(information), is_jagged(fit.model.effects))


def settled(fit: Fit) -> Fit:
    """Return a fit whose error has many minima in the best minimum that is found around it."""
    for _ in range(MOST_ROUNDS):
        before = fit.found.error
        for reach in SETTLING_REACHES:
            near = neighbourhood_of(fit)
            found = near.search(fit.problem, near.point, range(len(near.point)), reach=reach)
            if found.error < fit.found.error:
                fit = finished(fit.problem, found)
        if before - fit.found.error < NEGLIGIBLE_GAIN:
            break
    return fit
