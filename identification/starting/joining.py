"""Joining: a problem and its point with an effect added, or with base parameters freed, withheld or as given."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from identification.experiment import are_loops
from identification.fit import Fit
from identification.problem import Problem
from identification.unknowns import base_unknowns, effect_unknowns, freed_by
from valvemodel.declarations import Effect


def joined(problem: Problem, point: np.ndarray, effect: Effect, start: dict[str, float]) -> tuple[Problem, np.ndarray]:
    """Return the problem with an effect's unknowns added, and its scaled point at a start of theirs, within bounds."""
    start = effect.within_bounds(start)
    added = effect_unknowns(effect.key, start, of_loops=are_loops(problem.experiments))
    extended = replace(
        problem,
        model=problem.model.with_effect(effect.key, **start),
        is_anchored=problem.is_anchored or effect.is_chaotic,
        unknowns=[*problem.unknowns, *added],
    )
    scaled = np.array([unknown.scaled(start[unknown.name]) for unknown in added])
    return extended, np.concatenate([point, scaled])


def released(problem: Problem, point: np.ndarray) -> tuple[Problem, np.ndarray]:
    """Return a problem with the base parameters that its effects free among the unknowns, and its scaled point.

    They start as they were given. Where nothing is to be released both are as they were.
    """
    names = freed_by(problem.model.effects, with_pressure=problem.has_pressure)
    names.difference_update(unknown.name for unknown in problem.unknowns)
    freed = [unknown for unknown in base_unknowns(problem.model) if unknown.name in names]
    if not freed:
        return problem, point
    scaled = [unknown.scaled(problem.model.values[unknown.name]) for unknown in freed]
    return replace(problem, unknowns=[*problem.unknowns, *freed]), np.concatenate([point, scaled])


def withheld(problem: Problem, point: np.ndarray) -> tuple[Problem, np.ndarray]:
    """Return a problem with the base parameters that its effects free as they were given, and its scaled point."""
    freed = freed_by(problem.model.effects, with_pressure=problem.has_pressure)
    kept = [number for number, unknown in enumerate(problem.unknowns) if unknown.name not in freed]
    return replace(problem, unknowns=[problem.unknowns[number] for number in kept]), point[kept]


def as_given(fit: Fit, point: np.ndarray) -> np.ndarray:
    """Return a scaled point with the base valve's numbers as they were given: those refitted without an effect mislead.

    Parameters
    ----------
    fit : Fit
        Without the effect; its unknowns come first in the point.
    point : array, shape (unknowns,)
    """
    given = point.copy()
    for number, unknown in enumerate(fit.unknowns):
        if unknown.name in fit.model.values:
            given[number] = 0.0
    return given
