"""Sharpening: a search about a fit whose error is jagged, where a descent has come to its end."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from identification.fit import Fit, finished
from identification.problem import Problem
from identification.search import Found, descend, errors, principal_directions, roam

WIDEST = 0.3
"""How far the search goes along a principal direction, in changes of the residual over the residual."""

SIZE, GENERATIONS, ROUNDS = 4, 20, 6
"""Points for each unknown, generations of a round, and rounds: each begins anew where the one before ended."""

WIDER, GENERATIONS_IN_PHASE = (1.0, 0.5, 0.3), 40
"""How far the rounds go where a free run loses the phase of its slips, and generations of each."""

WORTH_A_ROUND = 0.95
"""Share of the error to which a round must have come for another one."""


@threadpool_limits.wrap(limits=1)
def sharpened(fit: Fit) -> Fit:
    """Return the best of searches about a fit by the free and the re-anchored run in turn; by both together.

    A fit that is judged by the re-anchored run alone is searched about by that, from afar.
    """
    if fit.problem.is_anchored:
        return sharpened_in_phase(fit)
    free = fit.problem
    yardsticks = (free, replace(free, is_anchored=True))

    def misfit(point: np.ndarray) -> float:
        return float(np.sqrt(np.prod([errors(each, point[None, :])[0] for each in yardsticks])))

    best = fit.found.point
    least = before = misfit(best)
    for number in range(ROUNDS):
        for each in yardsticks:
            found = searched_about(each, best, number)
            reached = misfit(found.point)
            if reached < least:
                best, least = found.point, reached
        if least <= free.noise_error or least > WORTH_A_ROUND * before:
            break
        before = least
    return finished(free, Found(best, float(errors(free, best[None, :])[0])))


def sharpened_in_phase(fit: Fit) -> Fit:
    """Return the best of searches about a fit by the re-anchored run, each nearer than the one before."""
    best = fit.found
    for number, widest in enumerate(WIDER):
        found = searched_about(fit.problem, best.point, number, widest=widest, generations=GENERATIONS_IN_PHASE)
        best = min(best, found, key=lambda each: each.error)
        if best.error <= fit.problem.noise_error:
            break
    return finished(fit.problem, min(best, descend(fit.problem, best.point), key=lambda each: each.error))


def searched_about(
    problem: Problem, centre: np.ndarray, seed: int, *, widest: float = WIDEST, generations: int = GENERATIONS
) -> Found:
    """Search about a scaled point, along the principal directions of the residuals, with a seed."""
    error = float(errors(problem, centre[None, :])[0])
    shape = np.clip(principal_directions(problem.jacobian(centre), error), -1.0, 1.0)
    count = len(centre)
    return roam(
        problem,
        centre,
        shape,
        [(-widest, widest)] * count,
        size=SIZE,
        generations=generations,
        enough=problem.noise_error,
        seed=seed,
        start=np.zeros(count),
    )
