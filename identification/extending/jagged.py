"""Jagged errors: a global search for an effect with which the error has many minima."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from identification.fit import Fit
from identification.problem import Problem
from identification.search import (
    Effort,
    Found,
    descend,
    error_by_all,
    errors,
    principal_directions,
    roam,
)
from identification.starting.screening import Trial, box_of
from valvemodel.declarations import Effect

WIDEST = 2.0
"""How far a global search goes along a principal direction, in changes of the residual over the residual."""

QUICK, SHORT = (8, 80), (3, 30)
"""Points of a global search for each unknown, and generations: more where a run has a closed form, fewer where it takes
long and ends nowhere exact."""

PROMISING = 0.9
"""Share of the error without an effect below which a global search for it must have come early on, or ends."""


def search_jagged(fit: Fit, effect: Effect, trials: list[Trial], *, is_thorough: bool = False) -> tuple[Problem, Found]:
    """Search globally where the error has many minima.

    The fit's unknowns move along the principal directions of their Jacobian, each by up to twice what changes the
    residual as much as it is large; the effect's parameters move between the outermost of neutral and starts. One
    search looks at the re-anchored run and, unless that gains little or is lost at once, one at the free run; the point
    that does best by both together wins.
    """
    problem, centre = trials[0].problem, fit.found.point
    known, added = len(centre), len(problem.unknowns) - len(centre)
    shape = np.zeros((known + added, known + added))
    shape[:known, :known] = principal_directions(fit.problem.jacobian(centre), fit.found.error)
    shape[known:, known:] = np.eye(added)
    origin = np.concatenate([centre, np.zeros(added)])
    box = [(-WIDEST, WIDEST)] * known + box_of(effect, trials)
    yardsticks = [replace(problem, is_anchored=is_anchored) for is_anchored in (True, False)]
    found = []
    takes_long = effect.is_chaotic or fit.model.effects
    size, generations = SHORT if takes_long and not is_thorough else QUICK
    promising = PROMISING * float(errors(replace(fit.problem, is_anchored=True), centre[None, :])[0])
    for each in yardsticks[:1] if effect.is_chaotic else yardsticks:
        effort = Effort(size=size, generations=generations, enough=problem.noise_error)
        if each.is_anchored:
            effort["promising"] = promising
        best = roam(each, origin, shape, box, **effort)
        if each.is_anchored and best.error > promising:
            return problem, Found(best.point, float(errors(problem, best.point[None, :])[0]))
        found.append(descend(each, best.point, evaluations=10, precision=1e-4).point)
    point = min(found, key=partial(error_by_all, yardsticks))
    return problem, Found(point, float(errors(problem, point[None, :])[0]))
