"""Following: where searches for an effect begin, and how the most promising starts are followed down."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import numpy as np

from identification.extending.forms import first_plain, of_another_form, of_another_side
from identification.extending.restart import is_far_off
from identification.extending.sluggishness import traded
from identification.fit import Fit
from identification.problem import Problem
from identification.search import (
    LOOK_PRECISION,
    RENEWED,
    Found,
    Start,
    descend,
    descend_roughly,
)
from identification.sharpening import searched_about
from identification.starting.hints import SHRUNK, resized
from identification.starting.joining import as_given, joined, released
from identification.starting.pressures import makes_pressure, with_pressures_of
from identification.starting.screening import LITTLE_LEFT, Trial
from identification.stick_slip.slip_search import form_of, tempered
from valvemodel.declarations import Effect, Form
from valvemodel.effects import is_jagged, jumps_in_closed_form

KEPT_STARTS = 2
"""Starts that are followed down in each group, after all were screened."""

FIRST_LOOK, FIRST_LOOK_OF_BRISTLES, FIRST_LOOK_JAGGED = 6, 8, 5
"""Points of a search while starts are compared, where the error has more minima, and where each has its own slopes."""

FURTHER = 2
"""Points on which a derivative serves while the best start is followed further."""

ABOUT = 1.0
"""How far a search about the start of a lag beside jumps goes along a principal direction, in changes of the residual
over the residual."""

HOPELESS, IN_REACH = 2.0, 5.0
"""Error over what is worth it, and over that of the noise, above which no start beside other effects is followed
further: both must be passed."""


def hopeless_from(fit: Fit, worth: float) -> float:
    """Return the error above which a look at the starts of an effect on top of a fit shows that it gains too little.

    Beside no other effect there is none: each is wanted as far as it comes.
    """
    if not fit.model.effects:
        return math.inf
    return max(HOPELESS * min(worth, fit.found.error), IN_REACH * fit.problem.noise_error)


def followed(fit: Fit, effect: Effect, group: list[Trial], *, hopeless: float = math.inf) -> tuple[Problem, Found]:
    """Follow the most promising starts of one form some way down, and what a lag takes over as well; the best further.

    Base parameters that the effect frees move last, from where all else has come: from afar they lead astray. Where
    the readings come in coarse steps they do so until the search is at its end. What has more error than is
    `hopeless` is left there.
    """
    problem, best = looked_down(fit, effect, group, hopeless=hopeless)
    if best.error > hopeless:
        return problem, best
    freed, point = (problem, best.point) if problem.reads_in_steps else released(problem, best.point)
    if freed is problem:
        return problem, best
    return freed, descend(freed, point, evaluations=10, precision=LOOK_PRECISION, renewed=RENEWED)


def looked_down(fit: Fit, effect: Effect, group: list[Trial], *, hopeless: float) -> tuple[Problem, Found]:
    """Follow the most promising starts some way down, and the best of them further, without what the effect frees."""
    follow = partial(best_descended, further=10, hopeless=hopeless)
    if fit.found.error < LITTLE_LEFT * fit.problem.noise_error or group[0].problem.has_series:
        return follow([(group[0].problem, group[0].point)], first=FIRST_LOOK)
    starts = starts_from(fit, effect, group)
    if is_jagged(group[0].problem.model.effects):
        return follow(starts, first=FIRST_LOOK_JAGGED, renewed=1)
    return follow(starts, first=FIRST_LOOK_OF_BRISTLES if effect.takes_long else FIRST_LOOK)


def starts_from(fit: Fit, effect: Effect, group: list[Trial]) -> list[Start]:
    """Return where searches from the most promising trials begin.

    The base valve as given is one more start of the most promising of all where no other effect was fitted with it yet,
    or its mass was led far off, and of another form in any case.
    """
    kept, others = group[:KEPT_STARTS], [] if effect.takes_long else of_another_form(effect, group)
    as_known = [group[0], *others] if not fit.model.effects or is_far_off(fit) else others
    starts = [(trial.problem, trial.point) for trial in [*kept, *of_another_side(effect, group, kept)]]
    starts += [(trial.problem, as_given(fit, trial.point)) for trial in as_known]
    lagging = starts_traded(fit, effect, form_of(effect, group[0].problem))
    starts += lagging
    if jumps_in_closed_form(fit.model.effects):
        starts += [searched_from(*each) for each in lagging]
    if makes_pressure(effect):
        for trial in kept:
            begun = with_pressures_of(fit.problem, fit.found.point, trial.problem, trial.point)
            starts.append((trial.problem, descend_roughly(trial.problem, begun, evaluations=15).point))
    return starts


def starts_traded(fit: Fit, effect: Effect, form: Form) -> list[Start]:
    """Return where a lag of a form takes over what the base valve has too much of; none where there is nothing."""
    return [joined(fit.problem, fit.found.point + move, effect, values) for values, move in traded(fit, effect, [form])]


def searched_from(problem: Problem, point: np.ndarray) -> Start:
    """Return where a search about a start ends, by the re-anchored run: from afar slips fall elsewhere."""
    return problem, searched_about(tempered(problem, is_anchored=True), point, 0, ABOUT).point


def best_descended(
    starts: Sequence[Start],
    *,
    first: int,
    further: int,
    precision: float = LOOK_PRECISION,
    renewed: int = RENEWED,
    hopeless: float = math.inf,
) -> tuple[Problem, Found]:
    """Follow all starts down for a few evaluations, and the best of them further, to a precision.

    The best is left where it is if it has more error than is `hopeless`.
    """
    problem, best = nearest_descended(starts, evaluations=first, renewed=renewed)
    if best.error > hopeless:
        return problem, best
    return problem, descend(
        problem, best.point, evaluations=further, precision=precision, renewed=min(renewed, FURTHER)
    )


def nearest_descended(starts: Sequence[Start], *, evaluations: int, renewed: int = RENEWED) -> tuple[Problem, Found]:
    """Follow all starts down for a few evaluations and return where the best of them came."""
    begun = [
        (problem, descend_roughly(problem, point, evaluations=evaluations, renewed=renewed))
        for problem, point in starts
    ]
    return min(begun, key=lambda pair: pair[1].error)


def near_neutral(fit: Fit, effect: Effect, trials: list[Trial], *, evaluations: int = 10) -> tuple[Problem, Found]:
    """Follow the most promising start down from a small part of its size; the fit as it was where that is in vain."""
    small = resized(effect, first_plain(fit, trials).problem.model.effects[effect.key], SHRUNK)
    problem, point = joined(fit.problem, fit.found.point, effect, small)
    best = descend(problem, point, evaluations=evaluations, precision=1e-4, renewed=RENEWED)
    return (problem, best) if best.error <= fit.found.error else at_neutral(fit, effect)


def at_neutral(fit: Fit, effect: Effect) -> tuple[Problem, Found]:
    """Return the fit as it was, with an effect at a value that changes nothing."""
    neutral = {parameter.name: parameter.neutral for parameter in effect.parameters}
    problem, point = joined(fit.problem, fit.found.point, effect, neutral)
    return problem, Found(point, fit.found.error)
