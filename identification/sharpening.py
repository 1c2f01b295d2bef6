"""Sharpening: a search about a fit whose error is jagged, where a descent has come to its end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from identification.experiment import Experiment
from identification.fit import Fit, finished, measured
from identification.problem import Problem
from identification.search import Found, descend, error_by_all, errors, points_beside, principal_directions, roam
from identification.unknowns import start_unknown
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

TRIED, AT_ONCE, WIDEST, NARROWEST = 1024, 64, 3.0, 0.01
"""Points about a fit at which a slip that hangs by a hair may fall the other way, and how many are run at once; how far
away they lie, in changes of the residuals by as much as the noise of one reading."""

AS_GOOD = 2.0
"""By how much the error of a point may be more than the least to be as good: within the fit's own uncertainty."""


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
        return float(np.sqrt(error_by_all(yardsticks, point)))

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


@threadpool_limits.wrap(limits=1)
def steadied(fit: Fit, experiments: Sequence[Experiment]) -> Fit:
    """Return a fit whose stem jumps, at the point that does best on all that was measured of those that are as good.

    Whether the stem breaks away may hang by a hair where it was not fitted: of numbers that the fitted samples do not
    tell apart some have it go, and some have it stay and be off until the next slip. What was kept back chooses among
    those, and is no longer unseen in that: it speaks for a law as far as any of them are right there.

    Parameters
    ----------
    fit : Fit
    experiments : sequence of Experiment
        Those of the fit first, then others.
    """
    problem, centre = fit.problem, fit.found.point
    generator = np.random.default_rng(0)
    sizes = np.geomspace(NARROWEST, WIDEST, TRIED)
    moves = sizes[:, None] * generator.standard_normal((TRIED, len(centre)))
    points = points_beside(problem, centre, directions_at(problem, centre, 0.5), moves)
    most = fit.found.error + AS_GOOD
    found = np.concatenate([errors(problem, some, most) for some in np.array_split(points, TRIED // AT_ONCE)])
    near = found <= most
    tried, here = np.vstack([centre, points[near]]), np.append(fit.found.error, found[near])
    left = [errors_on_all(problem, experiments, tried, is_anchored=is_anchored) for is_anchored in (False, True)]
    best = int(np.argmin(left[0] * left[1]))
    return fit if best == 0 else finished(problem, Found(tried[best], float(here[best])))


def errors_on_all(
    problem: Problem, experiments: Sequence[Experiment], points: np.ndarray, *, is_anchored: bool
) -> np.ndarray:
    """Return the errors on all that was measured of some experiments, shape (p,), those of the problem first.

    The others start at their first readings, and all else where it usually does.
    """
    everything = replace(problem, used=measured(problem.experiments), is_anchored=is_anchored)
    left = errors(everything, points)
    others = experiments[len(problem.experiments) :]
    if others:
        known, model = {unknown.name for unknown in problem.unknowns}, problem.model
        known -= {each.name for key in model.effects for each in effect_of_key(key).parameters if each.is_start}
        pairs = [(n, each) for n, each in enumerate(problem.unknowns) if each.experiment < 0 and each.name in known]
        starts = [start_unknown(each.first_reading, number) for number, each in enumerate(others)]
        unseen = replace(
            everything,
            model=model.without_starts(),
            experiments=others,
            unknowns=[*(each for _, each in pairs), *starts],
            used=measured(others),
        )
        kept = points[:, [number for number, _ in pairs]]
        left = left + errors(unseen, np.hstack([kept, np.zeros((len(points), len(starts)))]))
    return left


def searched_about(problem: Problem, centre: np.ndarray, seed: int, widest: float, *, size: int = QUICK.size) -> Found:
    """Search about a scaled point, along the principal directions of the residuals, with a seed."""
    shape = directions_at(problem, centre, float(errors(problem, centre[None, :])[0]))
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


def directions_at(problem: Problem, centre: np.ndarray, error: float) -> np.ndarray:
    """Return the principal directions of the residuals at a scaled point, each as long as what adds an error."""
    return np.clip(principal_directions(problem.jacobian(centre), error), -1.0, 1.0)
