"""A search of all unknowns at once that needs no good start: screened points, descents, then one with many points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from identification.problem import Problem
from identification.search import Found, descend, errors, roam, settle, spread_evenly

Box = Sequence[tuple[float, float]]

SCREENED = 256
"""Points of an even sequence that are run once before any descent."""

FOLLOWED = 4
"""The best of them, and the centre, are followed down."""

SIZES, GENERATIONS = (8, 16, 16), 120
"""Points for each unknown of one global search after the other while none comes down to the noise; generations."""

AT_NOISE = 1.03
"""A fit whose error is within this factor of the noise has found the valve: a wrong valley leaves more."""


def is_at_noise(problem: Problem, found: Found) -> bool:
    """Return whether a fit leaves no more than noise."""
    return found.error <= AT_NOISE**2 * problem.noise_error


@threadpool_limits.wrap(limits=1)
def search_wide(problem: Problem, box: Box, *, is_jagged: bool = False) -> Found:
    """Search a box of scaled unknowns for the least error.

    First the smooth way: descents from the best of many points. Where none comes down to the noise, or the error has
    many minima, differential evolution on the exact simulator follows: there descents alone and annealing are in vain
    (`python -m benchmarks.identification --only optimisers`).

    Parameters
    ----------
    problem : Problem
    box : sequence of (low, high)
        Scaled, one for each unknown.
    is_jagged : bool
        Whether descents alone would be in vain.

    Returns
    -------
    Found
    """
    bounds = np.clip(np.array(box, float).T, *problem.bounds)
    found = None
    if not is_jagged:
        found = descend(problem, screened_and_followed(problem, bounds).point, evaluations=40, precision=1e-8)
    for seed, size in enumerate(SIZES if is_jagged else SIZES[:1]):
        if found is not None and is_at_noise(problem, found):
            break
        found = min(filter(None, (found, searched(problem, bounds, size, seed))), key=lambda each: each.error)
    assert found is not None
    return found


def screened_and_followed(problem: Problem, bounds: np.ndarray) -> Found:
    """Return the best of short descents from the best points of an even sequence, and from the centre."""
    points = spread_evenly(SCREENED, bounds, np.random.default_rng(0))
    best = np.argsort(errors(problem, points))[:FOLLOWED]
    starts = [bounds.mean(axis=0), *points[best]]
    followed = [descend(problem, start, evaluations=8, precision=1e-3) for start in starts]
    return min(followed, key=lambda each: each.error)


def searched(problem: Problem, bounds: np.ndarray, size: int, seed: int) -> Found:
    """Search globally, follow the residuals down and settle among the small steps that are left."""
    low, high = bounds
    found = roam(
        problem,
        np.zeros(len(low)),
        np.eye(len(low)),
        list(zip(low, high, strict=True)),
        size=size,
        generations=GENERATIONS,
        enough=problem.noise_error,
        seed=seed,
    )
    found = descend(problem, found.point, evaluations=30, precision=1e-8)
    return found if is_at_noise(problem, found) else settle(problem, found)
