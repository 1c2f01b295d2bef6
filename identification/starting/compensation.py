"""Compensation: a start of an effect that the base valve's numbers make up for, beside one that makes the stem jump.

Where slips decide on the error, no slope leads from a fit without such an effect to one with it: each step on the way
shifts the slips. How the base valve makes up for it hangs little on the slips, and is found without them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from identification.fit import Fit
from identification.search import Start, descend, errors
from identification.starting.joining import joined
from identification.starting.screening import Trial, starts_on
from valvemodel.declarations import Effect
from valvemodel.effects import effect_of_key, is_jagged
from valvemodel.model import Model

EVALUATIONS, PRECISION = 15, 1e-4
"""Points of the search for the numbers that make up, and its precision: what they leave is not the end."""


def is_compensated(fit: Fit, effect: Effect) -> bool:
    """Return whether the base valve makes up for an effect, and one of a fit's effects hides by slips how it does."""
    return effect.hides_in_base and is_jagged(fit.model.effects)


def compensated_trials(fit: Fit, effect: Effect) -> list[Trial]:
    """Return the starts of an effect on top of a fit, the base valve making up for each, the most promising first."""
    trials = []
    for values in starts_on(fit, effect):
        problem, point = compensated(fit, effect, values)
        trials.append(Trial(problem, point, 2.0 * (fit.found.error - float(errors(problem, point[None, :])[0]))))
    return sorted(trials, key=lambda trial: -trial.gain)


def compensated(fit: Fit, effect: Effect, values: dict[str, float]) -> Start:
    """Return where a search begins for an effect on top of a fit, the base valve's numbers making up for it.

    The numbers are those with which the valve, without what is jagged in the fit, moves with the effect as it does
    without it.

    Parameters
    ----------
    fit : Fit
    effect : Effect
    values : dict
        Of the effect's parameters. [SI]

    Returns
    -------
    (Problem, array, shape (unknowns,))
        With the effect's unknowns last.
    """
    model = without_jagged(fit.model)
    smooth = replace(fit, model=model)
    goals = [replace(each, position=goal) for each, goal in zip(fit.problem.experiments, runs_of(smooth), strict=True)]
    own = [
        number for number, unknown in enumerate(fit.unknowns) if unknown.experiment >= 0 or unknown.name in model.values
    ]
    problem = replace(
        fit.problem,
        model=model.with_effect(effect.key, **effect.within_bounds(values)),
        experiments=goals,
        unknowns=[fit.unknowns[number] for number in own],
        is_anchored=False,
    )
    point = fit.found.point.copy()
    point[own] = descend(problem, point[own], evaluations=EVALUATIONS, precision=PRECISION).point
    return joined(fit.problem, point, effect, values)


def without_jagged(model: Model) -> Model:
    """Return a model without its effects that make the error jagged."""
    for key in [key for key in model.effects if effect_of_key(key).is_jagged]:
        model = model.without_effect(key)
    return model


def runs_of(fit: Fit) -> Sequence[np.ndarray]:
    """Return what a fit reads in each of its experiments, without coarse steps, NaN where nothing was measured. [m]"""
    return [
        np.where(np.isfinite(each.position), fit.simulated_on(each).smooth[0], np.nan)
        for each in fit.problem.experiments
    ]
