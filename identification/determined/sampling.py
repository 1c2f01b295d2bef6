"""Samples of what is likely where the error has many minima: many points that learn their steps from each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from identification.determined.neighbourhood import EVALUATIONS, PRECISION, neighbourhood_of, settled
from identification.determined.profile import Ends
from identification.determined.sensitivity import misfit
from identification.determined.uncertainty import AT_BOUND, CONFIDENCE
from identification.fit import Fit, finished
from identification.search import Found, descend, errors
from identification.unknowns import Unknown
from valvemodel.progress import Progress, tell_nobody

MEMBERS, GENERATIONS = 4, 600
"""Points for each unknown, and steps of each; the first half is left out."""

FIRST_SPREAD = 0.3
"""The points begin within so many standard deviations about the solution and spread by themselves."""

USUAL_STEP, STEP_SPREAD = 2.38, 0.5
"""Step over the difference of two points times sqrt(2 unknowns), best for a bowl, and how its logarithm varies."""

LEAP_SHARE, PARTIAL_SHARE = 0.1, 0.3
"""Share of steps that are a whole difference, so that islands are changed; share of unknowns in every other step."""

JITTER = 1e-3
"""Every step is off by so many standard deviations, so that no direction is lost."""

STRAGGLER, GATHERING = 20.0, 20
"""A point so much above the median error starts anew at another one, every so many steps of the first half."""


def sampled(fit: Fit, progress: Progress = tell_nobody, *, seed: int = 0) -> tuple[Fit, np.ndarray]:
    """Return a fit in the best minimum that is found, and points drawn from its likelihood, weak priors in it.

    Returns
    -------
    (Fit, array, shape (samples, unknowns))
        The points are scaled.

    References
    ----------
    ter Braak, Statistics and Computing 16 (2006): differential evolution Markov chain.
    """
    near = neighbourhood_of(settled(fit))
    generator = np.random.default_rng(seed)
    low, high = near.problem.bounds
    count = len(near.point)
    sizes, directions = np.linalg.eigh(near.covariance)
    shape = directions * np.sqrt(np.maximum(sizes, 0.0))
    heat = misfit(near.problem, near.point) ** 2
    points = near.point + FIRST_SPREAD * generator.standard_normal((MEMBERS * count, count)) @ shape.T
    points[0] = near.point
    points = np.clip(points, low, high)
    level = errors(near.problem, points) / heat
    kept, best = [], Found(near.point, float("inf"))
    for generation in range(GENERATIONS):
        progress(f"sampling what is likely, step {generation + 1} of {GENERATIONS}", generation / GENERATIONS)
        tried = points + _steps(points, shape, generator)
        is_inside = np.all((tried > low) & (tried < high), axis=1)
        reached = errors(near.problem, np.clip(tried, low, high)) / heat
        taken = is_inside & (np.log(generator.random(len(points))) < level - reached)
        points, level = np.where(taken[:, None], tried, points), np.where(taken, reached, level)
        if level.min() * heat < best.error:
            best = Found(points[np.argmin(level)], float(level.min()) * heat)
        if generation >= GENERATIONS // 2:
            kept.append(points)
        elif generation % GATHERING == GATHERING - 1:
            lost = level > np.median(level) + STRAGGLER
            source = generator.choice(np.flatnonzero(~lost), int(lost.sum()))
            points[lost], level[lost] = points[source], level[source]
    best = descend(near.problem, best.point, evaluations=EVALUATIONS, precision=PRECISION)
    return finished(fit.problem, best), np.concatenate(kept)


def _steps(points: np.ndarray, shape: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Return a step for each point: a difference of two others, scaled, in all or some of the unknowns."""
    members, count = points.shape
    own = np.arange(members)
    one, other = ((own + 1 + generator.integers(0, members - 1, members)) % members for _ in range(2))
    factor = USUAL_STEP / np.sqrt(2.0 * count) * np.exp(generator.normal(0.0, STEP_SPREAD, members))
    factor[generator.random(members) < LEAP_SHARE] = 1.0
    share = np.where(generator.random(members) < 0.5, PARTIAL_SHARE, 1.0)
    is_moved = generator.random((members, count)) < share[:, None]
    jitter = JITTER * generator.standard_normal((members, count)) @ shape.T
    return np.where(is_moved, factor[:, None] * (points[one] - points[other]) + jitter, 0.0)


def likely(unknowns: Sequence[Unknown], samples: np.ndarray) -> dict[str, Ends]:
    """Return the ends of each parameter's 95 % interval by name, None at a bound of the search. [SI]"""
    tails = 0.5 * (1.0 + CONFIDENCE * np.array([-1.0, 1.0]))
    quantiles = np.quantile(samples, tails, axis=0)
    found: dict[str, Ends] = {}
    for unknown, (first, last) in zip(unknowns, quantiles.T.tolist(), strict=True):
        low, high = unknown.bounds
        if unknown.experiment < 0:
            found[unknown.name] = (
                None if first - low < AT_BOUND else float(unknown.value(first)),
                None if high - last < AT_BOUND else float(unknown.value(last)),
            )
    return found
