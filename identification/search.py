"""Searches: a local one that follows the residuals, and a global one for errors with many minima."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Protocol, Required, TypedDict, Unpack

import numpy as np

from identification.experiment import score_rows
from identification.problem import LOST, Problem
from valvemodel import runs

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult


SETTLING_REACH, SETTLING_EVALUATIONS = 0.1, 50
"""First size of a simplex, in changes of the residual over the residual, and its evaluations for each unknown."""


CONVERGED = 1e-2
"""Spread of the errors of a global search's points, over their mean, at which a local search goes on."""

ROUNDING = 1.0 + 1e-9
"""Factor by which an error may be above another one by rounding alone."""

LOOKED = 16
"""Generations after which a global search must have come below an error that was set, or ends."""

END_EVALUATIONS, END_PRECISION = 40, 1e-6
"""Points of a search that is followed to its end, and the precision there."""

MORE_EVALUATIONS, STILL_FALLING = 20, 0.98
"""Points by which such a search goes on that was not at its end, as long as the error falls by that factor."""

LOOK_PRECISION = 1e-3
"""Share of the error below which a step's gain ends a search that only looks about."""

RENEWED, RENEWED_SERIES = 3, 8
"""After how many points the derivative is taken anew, and where a series of unknowns makes it dear."""


Start = tuple[Problem, np.ndarray]
"""Where a search begins: a problem and a scaled point, shape (unknowns,)."""


@dataclass(frozen=True)
class Found:
    """Where a search ended: scaled point, error (half the sum of squared residuals), and whether it may go on."""

    point: np.ndarray
    error: float
    may_go_on: bool = False


class Slopes:
    """Residuals and their derivative on the way of a search.

    The derivative is taken by differences, which costs a run for each unknown, at the first of so many points; at the
    others it is what it was, bent to the change of the residuals on the way (Broyden 1965).

    Parameters
    ----------
    residuals_at, slopes_at : callable
        Residuals, shape (r,), at a point, shape (m,), and their derivative there, shape (r, m), from both.
    renewed : int
        After how many points the derivative is taken anew.
    """

    def __init__(
        self,
        residuals_at: Callable[[np.ndarray], np.ndarray],
        slopes_at: Callable[[np.ndarray, np.ndarray], np.ndarray],
        renewed: int,
    ) -> None:
        self.residuals_at, self.slopes_at, self.renewed, self.asked = residuals_at, slopes_at, renewed, 0
        self.known: dict[bytes, np.ndarray] = {}
        self.last: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None

    @property
    def is_bent(self) -> bool:
        """Whether the last derivative was not taken anew."""
        return (self.asked - 1) % self.renewed != 0

    def residuals(self, point: np.ndarray) -> np.ndarray:
        """Return the residuals at a point, shape (r,)."""
        self.known[point.tobytes()] = residual = self.residuals_at(point)
        return residual

    def jacobian(self, point: np.ndarray) -> np.ndarray:
        """Return the derivative of the residuals at a point where they were asked for, shape (r, m)."""
        residual = self.known[point.tobytes()]
        if self.last is None or self.asked % self.renewed == 0:
            slopes = self.slopes_at(point, residual)
        else:
            before, residual_before, slopes = self.last
            move = point - before
            missed = residual - residual_before - slopes @ move
            # By rows of the transpose, as derivatives by differences come.
            slopes = (slopes.T + np.outer(move / (move @ move), missed)).T
        self.asked += 1
        self.known = {point.tobytes(): residual}
        self.last = (point.copy(), residual, slopes)
        return slopes


class Turned:
    """The residuals of a search and their derivative, turned so that no more of them count than unknowns, and one.

    Sums of squares and what the slopes say of them stay, and a step takes no decomposition of all residuals.
    """

    def __init__(self, slopes: Slopes) -> None:
        self.slopes = slopes

    def residuals(self, point: np.ndarray) -> np.ndarray:
        """Return the residuals at a point as their size and zeros, shape (m + 1,)."""
        turned = np.zeros(len(point) + 1)
        turned[0] = np.linalg.norm(self.slopes.residuals(point))
        return turned

    def jacobian(self, point: np.ndarray) -> np.ndarray:
        """Return the derivative, turned as the residuals at a point where they were asked for, shape (m + 1, m)."""
        slopes = self.slopes.jacobian(point)
        columns = np.vstack([self.slopes.known[point.tobytes()], slopes.T]).T
        triangle = np.asarray(np.linalg.qr(columns, mode="r"))
        triangle[0] *= np.copysign(1.0, triangle[0, 0])
        turned = np.zeros((len(point) + 1, len(point)))
        turned[: len(triangle)] = triangle[:, 1:]
        return turned


class Residuals(Protocol):
    """What is followed down: weighted residuals of scaled points, as `Problem` has them."""

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]: ...
    @property
    def has_series(self) -> bool: ...
    def residuals(self, points: np.ndarray) -> np.ndarray: ...
    def jacobian(self, point: np.ndarray, known: np.ndarray) -> np.ndarray: ...


def descend(
    problem: Residuals, start: np.ndarray, *, evaluations: int = 25, precision: float = 1e-6, renewed: int = 1
) -> Found:
    """Follow the residuals down from a start (trust-region reflective, scipy).

    Parameters
    ----------
    problem : Residuals
    start : array, shape (unknowns,)
    evaluations : int
        Points at most.
    precision : float
        Share of the error below which a step's gain ends the search.
    renewed : int
        After how many points the derivative is taken by differences again: 1 is always.
    """
    from scipy.optimize import least_squares

    low, high = problem.bounds
    inside = np.clip(start, low + 1e-9, high - 1e-9)
    slopes = Slopes(
        lambda point: problem.residuals(point[None, :])[0],
        problem.jacobian,
        RENEWED_SERIES if problem.has_series else renewed,
    )
    turned = Turned(slopes)
    result = least_squares(
        turned.residuals,
        inside,
        jac=turned.jacobian,
        bounds=(low, high),
        max_nfev=evaluations,
        ftol=precision,
        xtol=1e-7,
        gtol=1e-12,
        x_scale="jac",
    )
    # A derivative of many columns that was bent again and again may end a search before its end.
    return Found(result.x, float(result.cost), result.status == 0 or (problem.has_series and slopes.is_bent))


def descend_roughly(problem: Problem, start: np.ndarray, *, evaluations: int, renewed: int = RENEWED) -> Found:
    """Follow the residuals some way down from a start by rough runs; the error is that of the problem all the same."""
    rough = replace(problem, tolerance=problem.rough_tolerance)
    found = descend(rough, start, evaluations=evaluations, precision=LOOK_PRECISION, renewed=renewed)
    return Found(found.point, float(errors(problem, found.point[None, :])[0]))


def descend_to_end(problem: Problem, start: np.ndarray) -> Found:
    """Follow the residuals down from a start to the end, and on from there as long as that comes nearer."""
    follow = partial(descend, problem, precision=END_PRECISION, renewed=RENEWED if problem.is_smooth else 1)
    found, before = follow(start, evaluations=END_EVALUATIONS), math.inf
    while found.may_go_on and found.error < STILL_FALLING * before:
        before = found.error
        found = follow(found.point, evaluations=MORE_EVALUATIONS)
    return found


def errors(problem: Problem, points: np.ndarray, most: np.ndarray | float = np.inf) -> np.ndarray:
    """Return half the sum of squared residuals at each scaled point, shape (p,); none are kept where it can do without.

    Parameters
    ----------
    problem : Problem
    points : array, shape (p, unknowns)
    most : array, shape (p,), or float
        Errors beyond which it does not matter by how much: such a run may end early, and is then as bad as a lost one.
    """
    if problem.has_pressure:
        residuals = problem.residuals(points)
        return 0.5 * np.einsum("pr,pr->p", residuals, residuals)
    sums = ((points / problem.prior_spreads) ** 2).sum(axis=1)
    for number, (experiment, used) in enumerate(zip(problem.experiments, problem.used, strict=True)):
        anchors = experiment.anchors if problem.is_anchored else runs.FREE
        rows = problem.rows(points, number)
        sums += score_rows(
            experiment,
            used,
            rows,
            tolerance=problem.tolerance,
            anchors=anchors,
            in_closed_form=problem.settles,
            within=problem.within,
            most=2.0 * ROUNDING * np.asarray(most) - sums,
        )
    lost = LOST * sum(int(used.sum()) for used in problem.used)
    return 0.5 * np.where(np.isfinite(sums), sums, lost)


def error_by_all(problems: Sequence[Problem], point: np.ndarray) -> float:
    """Return the product of the errors of a scaled point by several yardsticks, as are the free and re-anchored run."""
    return float(np.prod([errors(each, point[None, :])[0] for each in problems]))


def principal_directions(jacobian: np.ndarray, error: float) -> np.ndarray:
    """Return the principal directions of residuals, one in a column, shape (unknowns, unknowns).

    Each is as long as what changes the residuals as much as they are large.

    Parameters
    ----------
    jacobian : array, shape (r, unknowns)
    error : float
        Half the sum of the squared residuals.
    """
    _, sizes, directions = np.linalg.svd(jacobian, full_matrices=False)
    return np.asarray(directions.T * (np.sqrt(2.0 * error) / np.maximum(sizes, 1e-9 * sizes[0])))


def points_beside(problem: Problem, origin: np.ndarray, shape: np.ndarray, moves: np.ndarray) -> np.ndarray:
    """Return the scaled points origin + shape u within the bounds for each u of some moves, shape (p, unknowns).

    Parameters
    ----------
    problem : Problem
    origin : array, shape (unknowns,)
    shape : array, shape (unknowns, m)
    moves : array, shape (p, m)
    """
    return np.asarray(np.clip(origin + moves @ shape.T, *problem.bounds))


class Effort(TypedDict, total=False):
    """How a global search goes about it.

    Attributes
    ----------
    size : int
        Points of a generation for each component of u, rounded up to a power of two in all.
    generations : int
    enough : float
        Error at which the search ends early.
    promising : float
        Error that it must have come down to after `LOOKED` generations, or it ends then.
    seed : int
        The search is deterministic for a seed.
    start : array, shape (m,), or None
        A u that is among the first points.
    """

    size: Required[int]
    generations: Required[int]
    enough: float
    promising: float
    seed: int
    start: np.ndarray | None


def roam(
    problem: Problem, origin: np.ndarray, shape: np.ndarray, box: list[tuple[float, float]], **effort: Unpack[Effort]
) -> Found:
    """Search globally over scaled points origin + shape u with u in a box, shape (unknowns, m)."""
    return roam_through(problem, partial(points_beside, problem, origin, shape), box, **effort)


def roam_through(
    problem: Problem,
    points_of: Callable[[np.ndarray], np.ndarray],
    box: list[tuple[float, float]],
    **effort: Unpack[Effort],
) -> Found:
    """Search globally over the scaled points, shape (p, unknowns), that belong to u, shape (p, m), in a box."""
    moves, error = roam_over(lambda moves, most: errors(problem, points_of(moves), most), box, **effort)
    return Found(points_of(moves[None, :])[0], error)


def roam_over(
    errors_of: Callable[[np.ndarray, np.ndarray], np.ndarray], box: list[tuple[float, float]], **effort: Unpack[Effort]
) -> tuple[np.ndarray, float]:
    """Search globally over u in a box (differential evolution, scipy); return the best u, shape (m,), and its error.

    Trials take most numbers from the mutant of the best point: the valleys of k, F_c, c0, E run across the axes.

    Parameters
    ----------
    errors_of : callable
        Errors, shape (p,), of u, shape (p, m), and of the errors beyond which each does not matter, shape (p,): those
        of the points that they are to replace.
    box : list of (low, high)
        One for each component of u, m in all.
    effort
        As `Effort` says.
    """
    from scipy.optimize import differential_evolution

    def end_early(intermediate_result: OptimizeResult) -> None:
        most[:] = intermediate_result.population_energies
        is_vain = intermediate_result.nit == LOOKED and intermediate_result.fun > effort.get("promising", math.inf)
        if intermediate_result.fun <= effort.get("enough", 0.0) or is_vain:
            raise StopIteration

    generator = np.random.default_rng(effort.get("seed", 0))
    points = 1 << (effort["size"] * len(box) - 1).bit_length()
    most = np.full(points, np.inf)
    result = differential_evolution(
        lambda u: errors_of(np.atleast_2d(u.T), most),
        box,
        maxiter=effort["generations"],
        tol=CONVERGED,
        mutation=(0.4, 0.9),
        recombination=0.9,
        callback=end_early,
        polish=False,
        vectorized=True,
        updating="deferred",
        init=spread_evenly(points, np.array(box).T, generator),
        rng=generator,
        x0=effort.get("start"),
    )
    return result.x, float(result.fun)


def spread_evenly(count: int, bounds: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Return points that fill a box evenly, shape (count, m), of low and high bounds, shape (2, m).

    The additive recurrence on powers of the generalised golden ratio (Roberts 2018). `scipy.stats` has Sobol's, but
    takes 0.7 s to import.
    """
    low, high = bounds
    dimensions, ratio = len(low), 2.0
    for _ in range(60):
        ratio = (1.0 + ratio) ** (1.0 / (dimensions + 1))
    steps = ratio ** -np.arange(1.0, dimensions + 1)
    return low + (high - low) * ((generator.random(dimensions) + np.outer(np.arange(count), steps)) % 1.0)


def settle(problem: Problem, found: Found) -> Found:
    """Settle among the small steps of a jagged error, along the principal directions of the residuals (Nelder-Mead)."""
    from scipy.optimize import minimize

    shape = principal_directions(problem.jacobian(found.point), found.error)
    count = len(found.point)
    points_of = partial(points_beside, problem, found.point, shape)
    result = minimize(
        lambda u: float(errors(problem, points_of(u[None, :]))[0]),
        np.zeros(count),
        method="Nelder-Mead",
        options={
            "initial_simplex": np.vstack([np.zeros(count), SETTLING_REACH * np.eye(count)]),
            "maxfev": SETTLING_EVALUATIONS * count,
            "xatol": 1e-6,
            "fatol": 1e-3,
        },
    )
    return Found(points_of(result.x[None, :])[0], float(result.fun)) if result.fun < found.error else found
