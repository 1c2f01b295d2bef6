"""The exact route: the exact simulator fitted by a global search, without smoothing and without a good start."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from math import isfinite

import numpy as np

from identification.experiment import Experiment, are_loops
from identification.extending.extension import extend
from identification.fit import Fit, Masks, base_and_start_unknowns, base_box, finished, fit_base, measured
from identification.problem import Problem
from identification.sharpening import sharpened
from identification.starting.hints import starts_of
from identification.unknowns import effect_unknowns
from identification.wide import Box, is_at_noise, search_wide
from valvemodel.effects import effect_of_key, is_jagged
from valvemodel.model import Model
from valvemodel.progress import Progress, tell_nobody

MOST_UNKNOWNS = 12
"""More are not searched for at once."""


def fit_exact(
    model: Model,
    experiments: Sequence[Experiment],
    used: Masks | None = None,
    *,
    effects: Sequence[str] = (),
    progress: Progress = tell_nobody,
) -> Fit:
    """Fit base parameters and those of effects to experiments, in the exact simulator.

    Effects whose error has many minima (static friction, a tight spot) are searched for together with the base
    parameters: a base valve fitted without them lies in another valley. Where that does not come down to the noise,
    effects are added one by one as well, and the better fit counts.

    It is the default: of 100 records each it found base valves, ringing ones and ones with static friction in all. The
    smooth route is the one to take for its exact derivatives and where the bias of a smooth model is the question;
    `python -m benchmarks.identification` runs both on the same records.

    Parameters
    ----------
    model : Model
        Gives the numbers that are not fitted; the search reaches from a third to three times its fitted ones.
    experiments : sequence of Experiment
    used : sequence of arrays of bool, or None for all that was measured
    effects : sequence of str
        Keys, in the order in which they are added.
    progress : callable
        Called with what is being done and a share of it from 0 to 1.

    Returns
    -------
    Fit
    """
    fits = []
    if is_jagged(effects):
        progress("base valve and effects together", 0.0)
        fits += [fit_jointly(*case) for case in joint_problems(model, experiments, used, effects)]
        fits.sort(key=lambda fit: fit.found.error)
        if fits and is_at_noise(fits[0].problem, fits[0].found):
            return fits[0]
    progress("base valve", 1.0 / (len(effects) + 3))
    fit = fit_base(model, experiments, used)
    for number, key in enumerate(effects, 2):
        progress(key, number / (len(effects) + 3))
        fit = extend(fit, key)
    return min([fit, *fits], key=lambda each: each.found.error)


def fit_jointly(problem: Problem, box: Box) -> Fit:
    """Fit all unknowns of a problem at once; a loop, whose runs are short, is searched about to the end."""
    fit = finished(problem, search_wide(problem, box, is_jagged=True))
    return sharpened(fit) if are_loops(problem.experiments) else fit


def joint_problems(
    model: Model, experiments: Sequence[Experiment], used: Masks | None, effects: Sequence[str]
) -> Iterator[tuple[Problem, Box]]:
    """Yield a problem and its box for each combination of the effects' forms."""
    for forms in product(*(forms_of(key, experiments) for key in effects)):
        extended, added, sides = model, [], []
        for key, starts in zip(effects, forms, strict=True):
            extended = extended.with_effect(key, **starts[0])
            own = effect_unknowns(key, starts[0], of_loops=are_loops(experiments))
            neutral = {each.name: each.neutral for each in effect_of_key(key).parameters}
            for unknown in own:
                reach = [unknown.scaled(start[unknown.name]) for start in (neutral, *starts)]
                sides.append((min(reach), max(reach)))
            added += own
        unknowns = base_and_start_unknowns(extended, experiments)
        if len(unknowns) + len(added) > MOST_UNKNOWNS:
            return
        is_anchored = any(effect_of_key(key).is_chaotic for key in effects)
        problem = Problem(extended, experiments, [*unknowns, *added], used or measured(experiments), is_anchored)
        yield problem, [*base_box(unknowns, experiments), *sides]


def forms_of(key: str, experiments: Sequence[Experiment]) -> list[list[dict[str, float]]]:
    """Return the starts of an effect in groups that differ in finite parameters that a fit moves only."""
    effect = effect_of_key(key)
    readings = [experiment.position - np.nanmean(experiment.position) for experiment in experiments]
    forms: dict[tuple[object, ...], list[dict[str, float]]] = {}
    for start in starts_of(effect, list(experiments), readings):
        endless = tuple(name for name, value in start.items() if not isfinite(value))
        forms.setdefault((effect.form_at(start), endless), []).append(start)
    return list(forms.values())
