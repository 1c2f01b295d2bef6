"""Profile likelihood: how far a parameter can go while all others make up for it as well as they can."""

from __future__ import annotations

import math

import numpy as np

from identification.determined.neighbourhood import Neighbourhood
from identification.search import Found, errors
from valvemodel.progress import Progress, tell_nobody

Ends = tuple[float | None, float | None]

MOST_STEPS = 12
"""Doublings of a step outwards, and halvings of what is left between in and out."""

PRECISION = 0.03
"""Share of its distance from the solution to which an end is found."""


def profile(near: Neighbourhood, limits: np.ndarray, progress: Progress = tell_nobody) -> dict[str, Ends]:
    """Return the ends of each parameter's interval by name, None where it is open up to the bound of the search. [SI]

    Parameters
    ----------
    near : Neighbourhood
        Of the fit.
    limits : array, shape (unknowns,)
        By how much twice the error may rise for each.
    """
    found = {}
    own = [number for number, unknown in enumerate(near.problem.unknowns) if unknown.experiment < 0]
    for count, number in enumerate(own):
        unknown = near.problem.unknowns[number]
        progress(f"profile of {unknown.name}", count / len(own))
        ends = [_end(near, number, side, float(limits[number])) for side in (-1.0, 1.0)]
        low, high = (None if x is None else float(unknown.value(x)) for x in ends)
        found[unknown.name] = (low, high)
    return found


def _end(near: Neighbourhood, number: int, side: float, limit: float) -> float | None:
    """Return the scaled value at which the profile rises by the limit, or None where it does not up to the bound."""
    x0 = float(near.point[number])
    bound = near.problem.unknowns[number].bounds[int(side > 0.0)]
    base = float(errors(near.problem, near.point[None, :])[0])
    base -= 0.5 * (x0 / near.problem.unknowns[number].prior_spread) ** 2
    start = np.delete(near.point, number)
    lean = np.delete(near.covariance[:, number], number) / near.covariance[number, number]

    def distance(x: float) -> float:
        problem, kept = near.held(number, x)
        low, high = problem.bounds
        refitted: Found = near.refit(problem, np.clip(start + lean * (x - x0), low, high), kept)
        return math.sqrt(max(2.0 * (refitted.error - base), 0.0))

    aim = math.sqrt(limit)
    step = side * aim * math.sqrt(near.covariance[number, number])
    inside, inside_distance = x0, 0.0
    for _ in range(MOST_STEPS):
        outside = min(x0 + step, bound) if side > 0.0 else max(x0 + step, bound)
        outside_distance = distance(outside)
        if outside_distance >= aim:
            break
        inside, inside_distance = outside, outside_distance
        if outside == bound:
            return None
        step *= 2.0
    for turn in range(MOST_STEPS):
        if abs(outside - inside) <= PRECISION * abs(outside - x0):
            break
        share = (aim - inside_distance) / max(outside_distance - inside_distance, 1e-12)
        # Every other time the middle: where the profile is a cliff, interpolation alone creeps.
        share = min(max(share, PRECISION), 1.0 - PRECISION) if turn % 2 == 0 else 0.5
        x = inside + share * (outside - inside)
        d = distance(x)
        if abs(d - aim) < PRECISION * aim:
            return x
        inside, inside_distance, outside, outside_distance = (
            (inside, inside_distance, x, d) if d >= aim else (x, d, outside, outside_distance)
        )
    return 0.5 * (inside + outside)
