"""A fit extended by one more effect: screened starts, a local search from the best, a global one where it is needed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from identification.extending.following import (
    IN_REACH,
    at_neutral,
    followed,
    hopeless_from,
    near_neutral,
)
from identification.extending.forms import alike, is_another_form, promising
from identification.extending.jagged import search_jagged
from identification.extending.kin import beside
from identification.fit import Fit, finished
from identification.problem import Problem
from identification.search import Found, descend_to_end, errors
from identification.starting.compensation import compensated, compensated_trials, is_compensated
from identification.starting.hints import other_forms
from identification.starting.joining import joined, released, withheld
from identification.starting.screening import Trial, placed, screened
from identification.stick_slip.slip_laws import slips_by
from identification.stick_slip.slip_search import LAWFUL, SlipSearch, form_of, search_near
from valvemodel.declarations import Effect
from valvemodel.effects import effect_of_key

WORTH_POLISHING = 1e-3
"""Share of the error that a search must have gained to be followed to its end."""

CLOSE = 1.5
"""Error over the best one's up to which another form of an effect is followed to its end as well."""

WORTH_LONG = 0.02
"""Share of a fit's error that starts must promise to explain for an effect to be followed whose runs take long."""

WORTH_FOLLOWING, WORTH_FOLLOWING_BESIDE = 0.3, 0.9
"""Share of a fit's error below which a kindred effect must have come for its base valve to be the start; and beside
another effect, where a global search ends nowhere exact."""


@dataclass(frozen=True, kw_only=True)
class Extension:
    """How a fit is extended by one more effect.

    Attributes
    ----------
    known : dict or None
        Values of the effect from another fit, one more start. [SI]
    kin : Fit or None
        The fit extended by a kindred effect, or by this one beside another: where that explains much, its base valve is
        the start, in place of a global search.
    is_global : bool
        Whether an effect whose error has many minima is searched for globally, which takes seconds.
    worth : float
        Error above which a fit is not followed to its end.
    promise : float
        Share of the fit's error that starts must promise to explain to be followed.
    slips : list of SlipSearch or None
        What `slips_asked` found; None where it was not asked.
    follows_all : bool
        Whether every start is followed by itself, not the most promising of each form alone.
    is_thorough : bool
        Whether a global search takes its time beside other effects as well.
    """

    known: dict[str, float] | None = None
    kin: Fit | None = None
    is_global: bool = True
    worth: float = math.inf
    promise: float = 0.0
    slips: list[SlipSearch] | None = None
    follows_all: bool = False
    is_thorough: bool = False


AS_USUAL = Extension()
"""An extension of which nothing else is said."""


@threadpool_limits.wrap(limits=1)
def extend(fit: Fit, key: str, how: Extension = AS_USUAL) -> Fit:
    """Add an effect to a fit and fit all unknowns anew.

    Parameters
    ----------
    fit : Fit
        Of the model without the effect; its unknowns stay free.
    key : str
        The effect.
    how : Extension

    Returns
    -------
    Fit
        The best found, no worse than the fit without; it may be the model with the effect at a value that changes
        nothing.
    """
    effect = effect_of_key(key)
    begun = slips_asked(fit, effect, how)
    if not begun:
        return extended(fit, effect, how)
    stepped = finished(*search_near(begun))
    if (effect.is_chaotic and how.kin is None) or stepped.found.error < LAWFUL * stepped.problem.noise_error:
        return stepped
    # Breakaways of another law lie on no line: it is searched for whatever it promises, and to its end.
    anew = Extension(known=how.known, kin=how.kin, is_thorough=how.is_thorough)
    return min(stepped, extended(fit, effect, anew), key=lambda each: each.found.error)


def extended(fit: Fit, effect: Effect, how: Extension) -> Fit:
    """Add an effect to a fit from screened starts: locally, globally where it is jagged, or beside its kin."""
    if fit.problem.is_in_steps:
        return beside_steps(fit, effect, how)
    worth_following = WORTH_FOLLOWING_BESIDE if fit.model.effects else WORTH_FOLLOWING
    if how.kin is not None and how.kin.found.error < worth_following * fit.found.error:
        return finished(*beside(fit, effect, how.kin, how.known))
    trials = screened(fit, effect, how.known)
    if is_compensated(fit, effect):
        trials = sorted([*trials, *compensated_trials(fit, effect)], key=lambda trial: -trial.gain)
    if trials[0].gain < max(how.promise, WORTH_LONG if effect.takes_long else 0.0) * 2.0 * fit.found.error:
        return finished(*at_neutral(fit, effect))
    searched = searched_in_groups(fit, effect, trials, how)
    problem, best = min(searched, key=lambda pair: pair[1].error)
    if best.error > how.worth and not effect.is_chaotic:
        return finished(*((problem, best) if best.error < fit.found.error else at_neutral(fit, effect)))
    if best.error > (1.0 - WORTH_POLISHING) * fit.found.error and not effect.is_chaotic:
        return finished(*near_neutral(fit, effect, trials))
    ended = followed_to_end(fit, effect, searched)
    return finished(*(in_best_form_of_others(fit, *ended) if effect.is_read_off else ended))


def searched_in_groups(fit: Fit, effect: Effect, trials: list[Trial], how: Extension) -> list[tuple[Problem, Found]]:
    """Search from the trials of each form by itself: globally where that is asked for, else some way down."""
    is_searched = effect.is_jagged and how.is_global and trials[0].gain > 0.0
    if is_searched and effect.stops_again:
        groups = alike(effect, trials)[: 1 if effect.is_chaotic else None]
        return [search_jagged(fit, effect, group, is_thorough=how.is_thorough) for group in groups]
    apart = [[each] for each in trials] if how.follows_all else alike(effect, trials)
    groups = [trials] if effect.is_jagged else promising(fit, apart)
    if is_searched:
        groups.append([placed(fit, effect, trials)])
    hopeless = hopeless_from(fit, how.worth)
    return [followed(fit, effect, group, hopeless=hopeless) for group in groups]


def followed_to_end(fit: Fit, effect: Effect, searched: Sequence[tuple[Problem, Found]]) -> tuple[Problem, Found]:
    """Follow the best of some searches, and the forms that come close to it, down to the end; return the best."""
    problem, best = min(searched, key=lambda pair: pair[1].error)
    begun = [(each, found.point) for each, found in searched if found.error < CLOSE * best.error]
    if best.error < WORTH_FOLLOWING * fit.found.error:
        # Another form may be lost in a side minimum: it goes on from where the best one came, too.
        others = {form_of(effect, each): each for each, _ in searched if is_another_form(effect, each, problem)}
        begun += [(each, best.point) for each in others.values()]
    return min(((each, descend_to_end(each, point)) for each, point in begun), key=lambda pair: pair[1].error)


def beside_steps(fit: Fit, effect: Effect, how: Extension) -> Fit:
    """Add an effect to a fit to readings in coarse steps, as if they were but noisy; only then within the steps.

    What lies within a step says nothing of the way: a start that is a little off, or a fit that leaves few readings
    beyond, has slopes of a few samples only. What is not nearer within the steps by then, nor in reach of the noise, is
    left. A kindred fit, and what a fit is worth, are of errors within the steps.
    """
    problem, point = replace(fit.problem, within=0.0), fit.found.point
    noisy = finished(problem, Found(point, float(errors(problem, point[None, :])[0])))
    asked = Extension(known=how.known, is_global=how.is_global, promise=how.promise, follows_all=how.follows_all)
    begun = extended(noisy, effect, asked)
    in_steps, start = replace(begun.problem, within=fit.problem.within), begun.found.point
    most = max(fit.found.error, IN_REACH * fit.problem.noise_error)
    if begun.found.error >= noisy.found.error or float(errors(in_steps, start[None, :])[0]) > most:
        return finished(*at_neutral(fit, effect))
    problem, ended = in_best_form(effect, *released_at_end(in_steps, start))
    return finished(*((problem, ended) if ended.error < fit.found.error else at_neutral(fit, effect)))


@threadpool_limits.wrap(limits=1)
def extend_from(fit: Fit, key: str, values: dict[str, float], *, worth: float = math.inf) -> Fit:
    """Add an effect to a fit and fit all unknowns anew, from its values in another fit alone. [SI]

    A search that comes to no less than an error that it is `worth` does not go on to its end.
    """
    effect = effect_of_key(key)
    if effect.is_read_off:
        # A fit that took the steps for noise may have led astray what it freed.
        problem, point = joined(*withheld(fit.problem, fit.found.point), effect, values)
        return finished(*in_best_form_of_others(fit, *released_at_end(problem, point)))
    starts = [joined(fit.problem, fit.found.point, effect, values)]
    if is_compensated(fit, effect):
        starts.insert(0, compensated(fit, effect, values))
    trials = [Trial(*start, gain=0.0) for start in starts]
    problem, best = followed(fit, effect, trials, hopeless=hopeless_from(fit, worth))
    return finished(*((problem, best) if best.error > worth else released_at_end(problem, best.point)))


@threadpool_limits.wrap(limits=1)
def continued(fit: Fit) -> Fit:
    """Follow a fit that was begun down to its end."""
    return finished(*released_at_end(fit.problem, fit.found.point))


def slips_asked(fit: Fit, effect: Effect, how: Extension) -> list[SlipSearch]:
    """Return what an effect makes of the slips of stairs, where a search for it asks that: a global one, for a law.

    What is known of them already is not asked once more.
    """
    if how.slips is not None:
        return how.slips
    return slips_by(fit, effect, how.kin) if effect.breakaway and how.is_global else []


def in_best_form(effect: Effect, problem: Problem, ended: Found) -> tuple[Problem, Found]:
    """Follow each other form of an effect in which the same numbers move from where one ended; return the best.

    Steps that are taken for noise may hide which form is right.
    """
    values = dict(problem.model.effects[effect.key])
    forms = [each for each in other_forms(effect, values) if effect.free_at(each) == effect.free_at(values)]
    others = [replace(problem, model=problem.model.with_effect(effect.key, **each)) for each in forms]
    ends = [(problem, ended), *(released_at_end(each, ended.point) for each in others)]
    return min(ends, key=lambda pair: pair[1].error)


def in_best_form_of_others(fit: Fit, problem: Problem, ended: Found) -> tuple[Problem, Found]:
    """Follow the other forms of a fit's effects, to which steps were noise, where these explain much beside them."""
    if ended.error < WORTH_FOLLOWING * fit.found.error:
        for key in fit.model.effects:
            problem, ended = in_best_form(effect_of_key(key), problem, ended)
    return problem, ended


def released_at_end(problem: Problem, point: np.ndarray) -> tuple[Problem, Found]:
    """Follow a start down to the end, and from there on with what the effects free of the base valve, if they do."""
    ended = descend_to_end(problem, point)
    freed, start = released(problem, ended.point)
    return (problem, ended) if freed is problem else (freed, descend_to_end(freed, start))
