"""Pressures: what a measured one tells by itself, and the gap at which another law gives those at rest of a fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from identification.experiment import Experiment, simulate_rows
from identification.problem import Problem
from identification.search import Found, descend
from identification.unknowns import GAP, OF_GAP
from valvemodel.declarations import Effect

LEVELS, HOLD, LIGHT = 9, 1.0, 1e3
"""Currents at which pressures are compared, how long each is held [s], and the pressure that counts as 1 [Pa]."""

MOST_EVALUATIONS = 30


def told_by_pressure(problem: Problem) -> list[int]:
    """Return which unknowns a measured pressure tells by itself; none where there is no pressure."""
    return [n for n, unknown in enumerate(problem.unknowns) if problem.has_pressure and unknown.name in OF_GAP]


def seen_by_pressure(problem: Problem, point: np.ndarray, told: list[int]) -> tuple[Problem, Found]:
    """Fit the unknowns that the pressure tells, whose numbers are given, to it alone, whatever the stem does."""
    blind = [
        replace(experiment, noise=np.inf, position=np.nan_to_num(experiment.position))
        for experiment in problem.experiments
    ]
    front = replace(problem, experiments=blind, unknowns=[problem.unknowns[n] for n in told])
    return front, descend(front, point[told], evaluations=15, precision=1e-5)


def makes_pressure(effect: Effect) -> bool:
    """Return whether an effect changes the pressure at rest under a current."""
    return effect.acts_on_pressure and not effect.acts_in_time


def with_pressures_of(fitted: Problem, found: np.ndarray, problem: Problem, point: np.ndarray) -> np.ndarray:
    """Return a scaled point that is another problem's, but for the gap, which gives the pressures at rest of that.

    An effect that brings another law of the pressure leads a search astray that begins with the gap of the law before.

    Parameters
    ----------
    fitted : Problem
    found : array, shape (unknowns,)
        Of that problem.
    problem : Problem
        With the unknowns of the one before first, and those of the effect.
    point : array, shape (more unknowns,)
        Gives the numbers of the effect.
    """
    from scipy.optimize import least_squares

    columns = [number for number, unknown in enumerate(fitted.unknowns) if unknown.name in GAP]
    if not columns:
        return point
    currents = np.concatenate([experiment.current for experiment in fitted.experiments])
    levels = np.linspace(currents.min(), currents.max(), LEVELS)
    wanted = pressures_at_rest(fitted, found, levels)

    def moved(move: np.ndarray) -> np.ndarray:
        there = np.concatenate([found, point[len(found) :]])
        there[columns] = move
        return there

    low, high = (bound[columns] for bound in problem.bounds)
    return moved(
        least_squares(
            lambda move: (pressures_at_rest(problem, moved(move), levels) - wanted) / LIGHT,
            np.clip(found[columns], low + 1e-9, high - 1e-9),
            bounds=(low, high),
            max_nfev=MOST_EVALUATIONS,
        ).x
    )


def pressures_at_rest(problem: Problem, point: np.ndarray, currents: np.ndarray) -> np.ndarray:
    """Return the pressures to which currents settle at a scaled point, shape (n,), but for what acts in time. [Pa]"""
    count = len(currents)
    held = Experiment(
        name="at rest",
        time=HOLD * np.arange(count + 1.0),
        current=np.append(currents, currents[-1]),
        position=np.zeros(count + 1),
        pressure=None,
        noise=1.0,
        pressure_noise=1.0,
        block=np.zeros(count + 1, int),
    )
    rows = problem.rows_without(lambda effect: effect.acts_in_time, point[None, :], 0)
    return np.asarray(simulate_rows(held, rows, tolerance=problem.tolerance, with_pressure=True).pressure[0, 1:])
