"""Sharpening: a search about a fit whose error is jagged, where a descent has come to its end."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from identification.fit import Fit, finished
from identification.problem import Problem
from identification.search import Found, descend, errors, principal_directions, roam
from valvemodel.effects import effect_of_key

WIDTHS, GENERATIONS = (2.0, 1.0, 0.3), 40
"""How far the rounds go in turn along a principal direction, in changes of the residual over the residual, and the
generations of each; a round begins where the one before ended."""


@dataclass(frozen=True)
class Patience:
    """How long a search goes on: points for each unknown, rounds, and rounds in a row that may be in vain."""

    size: int
    rounds: int
    vain: int


QUICK, SHORT = Patience(4, 9, 3), Patience(2, 6, 1)
"""Where a slip has a closed form, and where a run takes long."""

WIDTHS_IN_PHASE = (1.0, 0.5, 0.3)
"""How far the rounds go where a free run loses the phase of its slips."""

WORTH_A_ROUND = 0.95
"""Share of the error to which a round must have come not to be in vain."""


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

    patience = SHORT if any(effect_of_key(key).is_chaotic for key in fit.model.effects) else QUICK
    best, vain = fit.found.point, 0
    least = misfit(best)
    # What is at the noise, as settled loops may be from the start, lies near.
    widths = WIDTHS if least > free.noise_error else WIDTHS[-1:]
    for number in range(patience.rounds):
        before = least
        for each in yardsticks:
            found = searched_about(each, best, number, widths[number % len(widths)], size=patience.size)
            reached = misfit(found.point)
            if reached < least:
                best, least = found.point, reached
        vain = 0 if least < WORTH_A_ROUND * before else vain + 1
        if least <= free.noise_error or vain == patience.vain:
            break
    return finished(free, Found(best, float(errors(free, best[None, :])[0])))


def sharpened_in_phase(fit: Fit) -> Fit:
    """Return the best of searches about a fit by the re-anchored run, each nearer than the one before it, if any."""
    best = fit.found
    for number, widest in enumerate(WIDTHS_IN_PHASE):
        before = best.error
        found = searched_about(fit.problem, best.point, number, widest)
        best = min(best, found, key=lambda each: each.error)
        if best.error <= fit.problem.noise_error or best.error > WORTH_A_ROUND * before:
            break
    return finished(fit.problem, min(best, descend(fit.problem, best.point), key=lambda each: each.error))


def searched_about(problem: Problem, centre: np.ndarray, seed: int, widest: float, *, size: int = QUICK.size) -> Found:
    """Search about a scaled point, along the principal directions of the residuals, with a seed."""
    error = float(errors(problem, centre[None, :])[0])
    shape = np.clip(principal_directions(problem.jacobian(centre), error), -1.0, 1.0)
    count = len(centre)
    return roam(
        problem,
        centre,
        shape,
        [(-widest, widest)] * count,
        size=size,
        generations=GENERATIONS,
        enough=problem.noise_error,
        seed=seed,
        start=np.zeros(count),
    )
