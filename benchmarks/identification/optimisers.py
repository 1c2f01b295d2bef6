"""Which optimiser finds the valve on the exact simulator: the choice of the exact route, measured at equal cost."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.identification.plants import Case, make
from identification.exact_fit import joint_problems
from identification.experiment import experiment_of
from identification.fit import finished
from identification.problem import Problem
from identification.search import Found, descend, errors, roam
from identification.wide import screened_and_followed

EVALUATIONS = 4000
"""Runs of the simulator that each may spend before its last descent; descents alone count their differences too."""

Search = Callable[[Problem, np.ndarray, np.ndarray], Found]


def descents(problem: Problem, low: np.ndarray, high: np.ndarray) -> Found:
    """Least squares with finite differences from the best of 256 points (scipy's trust region)."""
    return screened_and_followed(problem, np.array([low, high]))


def evolution(problem: Problem, low: np.ndarray, high: np.ndarray) -> Found:
    """Differential evolution, best/1/bin (scipy)."""
    count, size = len(low), 8
    box = list(zip(low, high, strict=True))
    return roam(problem, np.zeros(count), np.eye(count), box, size=size, generations=EVALUATIONS // (size * count))


def annealing(problem: Problem, low: np.ndarray, high: np.ndarray) -> Found:
    """Generalised simulated annealing (scipy)."""
    from scipy.optimize import dual_annealing

    box = list(zip(low, high, strict=True))
    found = dual_annealing(
        lambda point: float(errors(problem, point[None, :])[0]), box, maxfun=EVALUATIONS, no_local_search=True, rng=0
    )
    return Found(found.x, float(found.fun))


def rectangles(problem: Problem, low: np.ndarray, high: np.ndarray) -> Found:
    """Division of rectangles, DIRECT (scipy)."""
    from scipy.optimize import direct

    box = list(zip(low, high, strict=True))
    found = direct(lambda point: float(errors(problem, point[None, :])[0]), box, maxfun=EVALUATIONS, maxiter=10**6)
    return Found(found.x, float(found.fun))


SEARCHES: dict[str, Search] = {
    "descents": descents,
    "evolution": evolution,
    "annealing": annealing,
    "rectangles": rectangles,
}


def score_search(search: str, case: Case, repetitions: int, tick: Callable[[], None]) -> dict[str, float]:
    """Return in how many repetitions a search and a descent from its end find the valve, and its median seconds."""
    from benchmarks.identification.plants import not_found
    from identification.determined.uncertainty import estimates

    hits, seconds = 0, []
    with threadpool_limits(1):
        for seed in range(repetitions):
            made = make(case, seed)
            problem, box = next(iter(joint_problems(made.start, [experiment_of(made.record)], None, made.effects)))
            low, high = np.clip(np.array(box).T, *problem.bounds)
            began = time.perf_counter()
            end = SEARCHES[search](problem, low, high)
            found = descend(problem, end.point, evaluations=40, precision=1e-8)
            seconds.append(time.perf_counter() - began)
            hits += not not_found(made.truth, estimates(finished(problem, found)))
            tick()
    return {"successes": hits, "repetitions": repetitions, "seconds": float(np.median(seconds))}
