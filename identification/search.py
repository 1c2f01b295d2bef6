"""Searches: a local one that follows the residuals, and a global one for errors with many minima."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from identification.problem import Problem


@dataclass(frozen=True)
class Found:
    """Where a search ended: the scaled point and its error (half the sum of squared residuals)."""

    point: np.ndarray
    error: float


def descend(problem: Problem, start: np.ndarray, *, evaluations: int = 25, precision: float = 1e-6) -> Found:
    """Follow the residuals down from a start (trust-region reflective, scipy)."""
    from scipy.optimize import least_squares

    low, high = problem.bounds
    inside = np.clip(start, low + 1e-9, high - 1e-9)
    result = least_squares(
        lambda point: problem.residuals(point[None, :])[0],
        inside,
        jac=problem.jacobian,
        bounds=(low, high),
        max_nfev=evaluations,
        ftol=precision,
        xtol=1e-7,
        gtol=1e-12,
        x_scale="jac",
    )
    return Found(result.x, float(result.cost))


def errors(problem: Problem, points: np.ndarray) -> np.ndarray:
    """Return half the sum of squared residuals at each scaled point, shape (p,)."""
    residuals = problem.residuals(points)
    return 0.5 * np.einsum("pr,pr->p", residuals, residuals)


def roam(
    problem: Problem,
    origin: np.ndarray,
    shape: np.ndarray,
    box: list[tuple[float, float]],
    *,
    size: int,
    generations: int,
    seed: int = 0,
) -> Found:
    """Search globally over scaled points origin + shape u with u in a box (differential evolution, scipy).

    Parameters
    ----------
    problem : Problem
    origin : array, shape (unknowns,)
    shape : array, shape (unknowns, unknowns)
    box : list of (low, high), one for each component of u
    size : int
        Points of a generation for each unknown.
    generations : int
    seed : int
        The search is deterministic for a seed.
    """
    from scipy.optimize import differential_evolution

    low, high = problem.bounds

    def points_of(u: np.ndarray) -> np.ndarray:
        return np.clip(origin + np.atleast_2d(u.T) @ shape.T, low, high)

    result = differential_evolution(
        lambda u: errors(problem, points_of(u)),
        box,
        popsize=size,
        maxiter=generations,
        tol=1e-9,
        polish=False,
        vectorized=True,
        updating="deferred",
        init="sobol",
        rng=np.random.default_rng(seed),
    )
    return Found(points_of(result.x)[0], float(result.fun))
