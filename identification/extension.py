"""A fit extended by one more effect: screened starts, a local search from the best, a global one where it is needed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from threadpoolctl import threadpool_limits

from identification.breakaway import Line
from identification.compensation import compensated, compensated_trials, is_compensated
from identification.fit import Fit, finished
from identification.hints import other_forms
from identification.pressures import makes_pressure, with_pressures_of
from identification.problem import Problem
from identification.restart import is_far_off
from identification.screening import (
    LITTLE_LEFT,
    SHRUNK,
    Trial,
    as_given,
    box_of,
    joined,
    placed,
    released,
    resized,
    screened,
    starts_on,
    traded,
    withheld,
)
from identification.search import (
    LOOK_PRECISION,
    RENEWED,
    Effort,
    Found,
    Start,
    descend,
    descend_roughly,
    descend_to_end,
    error_by_all,
    errors,
    principal_directions,
    roam,
)
from identification.sharpening import searched_about
from identification.stick_slip import (
    LAWFUL,
    SlipSearch,
    error_at_rests,
    form_of,
    line_of_stairs,
    search_beside_other,
    search_near,
    search_slips,
    tempered,
)
from valvemodel.declarations import Effect, Form
from valvemodel.effects import effect_of_key, is_jagged, jumps_in_closed_form

KEPT_STARTS = 2
"""Starts that are followed down in each group, after all were screened."""

WIDEST = 2.0
"""How far a global search goes along a principal direction, in changes of the residual over the residual."""

QUICK, SHORT = (8, 80), (3, 30)
"""Points of a global search for each unknown, and generations: more where a run has a closed form, fewer where it takes
long and ends nowhere exact."""

PROMISING = 0.9
"""Share of the error without an effect below which a global search for it must have come early on, or ends."""

WORTH_POLISHING = 1e-3
"""Share of the error that a search must have gained to be followed to its end."""

GLANCE = 5
"""Points of a search that only shows which effects are worth it."""

FIRST_LOOK, FIRST_LOOK_OF_BRISTLES, FIRST_LOOK_JAGGED, FIRST_LOOK_AT_LAWS = 6, 8, 5, 25
"""Points of a search while starts are compared, where the error has more minima, where each has its own slopes, and
where laws of stick-slip are compared beside another effect."""

FURTHER = 2
"""Points on which a derivative serves while the best start is followed further."""

ABOUT = 1.0
"""How far a search about the start of a lag beside jumps goes along a principal direction, in changes of the residual
over the residual."""

HOPELESS, IN_REACH = 2.0, 5.0
"""Error over what is worth it, and over that of the noise, above which no start beside other effects is followed
further: both must be passed."""

CLOSE = 1.5
"""Error over the best one's up to which another form of an effect is followed to its end as well."""

WORTH_LONG = 0.02
"""Share of a fit's error that starts must promise to explain for an effect to be followed whose runs take long."""

SERIES_GAIN = 1.2
"""Promise of a whole series, over that of its first wave, above which it is followed."""

WORTH_FOLLOWING, WORTH_FOLLOWING_BESIDE = 0.3, 0.9
"""Share of a fit's error below which a kindred effect must have come for its base valve to be the start; and beside
another effect, where a global search ends nowhere exact."""


EXPLAINED, NEAR_KIN = 0.8, 1.5
"""Share of a fit's error at the slips below which an effect must come for the search to go on from there, and of the
error of another law of stick-slip: on a line that is held the right law may leave more than a wrong one that is not."""


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


@dataclass(frozen=True)
class Glance:
    """What a glance at an effect on top of a fit shows.

    Attributes
    ----------
    fit : Fit
        With the effect, a few points down; no worse than without.
    promised, taken_in : float
        Shares of the error without it that the start promises to explain by slopes, and that the fit has taken in.
    """

    fit: Fit
    promised: float
    taken_in: float

    @property
    def share(self) -> float:
        """The share that it shows in either way."""
        return max(self.promised, self.taken_in)


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
    is_searched = effect.is_jagged and how.is_global and trials[0].gain > 0.0
    if is_searched and effect.stops_again:
        groups = alike(effect, trials)[: 1 if effect.is_chaotic else None]
        searched = [search_jagged(fit, effect, group, is_thorough=how.is_thorough) for group in groups]
    else:
        apart = [[each] for each in trials] if how.follows_all else alike(effect, trials)
        groups = [trials] if effect.is_jagged else promising(fit, apart)
        if is_searched:
            groups.append([placed(fit, effect, trials)])
        hopeless = hopeless_from(fit, how.worth)
        searched = [followed(fit, effect, group, hopeless=hopeless) for group in groups]
    problem, best = min(searched, key=lambda pair: pair[1].error)
    if best.error > how.worth and not effect.is_chaotic:
        return finished(*((problem, best) if best.error < fit.found.error else at_neutral(fit, effect)))
    if best.error > (1.0 - WORTH_POLISHING) * fit.found.error and not effect.is_chaotic:
        return finished(*near_neutral(fit, effect, trials))
    begun = [(each, found.point) for each, found in searched if found.error < CLOSE * best.error]
    if best.error < WORTH_FOLLOWING * fit.found.error:
        # Another form may be lost in a side minimum: it goes on from where the best one came, too.
        others = {form_of(effect, each): each for each, _ in searched if is_another_form(effect, each, problem)}
        begun += [(each, best.point) for each in others.values()]
    ended = min(((each, descend_to_end(each, point)) for each, point in begun), key=lambda pair: pair[1].error)
    return finished(*(in_best_form_of_others(fit, *ended) if effect.is_read_off else ended))


@threadpool_limits.wrap(limits=1)
def glanced(fit: Fit, key: str) -> Glance:
    """Add an effect to a fit and follow its most promising start a few points down.

    Where the fit leaves little slopes tell all: the effect is at a value that changes nothing.
    """
    effect = effect_of_key(key)
    trials = screened(fit, effect)
    seen = at_neutral(fit, effect)
    if fit.found.error >= LITTLE_LEFT * fit.problem.noise_error:
        seen = glanced_down(fit, effect, trials)
    return Glance(finished(*seen), 0.5 * trials[0].gain / fit.found.error, 1.0 - seen[1].error / fit.found.error)


def glanced_down(fit: Fit, effect: Effect, trials: list[Trial]) -> tuple[Problem, Found]:
    """Follow the most promising start a few points down, and what else it may begin as; no worse than without."""
    plain = first_plain(fit, trials)
    starts = [(plain.problem, plain.point)]
    starts += starts_traded(fit, effect, form_of(effect, plain.problem))
    if makes_pressure(effect):
        starts.append((plain.problem, with_pressures_of(fit.problem, fit.found.point, *starts[0])))
    problem, best = nearest_descended(starts, evaluations=GLANCE)
    if best.error < fit.found.error:
        return problem, best
    if any(each.is_lag for each in effect.fitted):
        # One that is small shows nothing, and its runs are dear.
        return at_neutral(fit, effect)
    return near_neutral(fit, effect, trials, evaluations=GLANCE)


@threadpool_limits.wrap(limits=1)
def continued(fit: Fit) -> Fit:
    """Follow a fit that was begun down to its end."""
    return finished(*released_at_end(fit.problem, fit.found.point))


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


def slips_asked(fit: Fit, effect: Effect, how: Extension) -> list[SlipSearch]:
    """Return what an effect makes of the slips of stairs, where a search for it asks that: a global one, for a law.

    What is known of them already is not asked once more.
    """
    if how.slips is not None:
        return how.slips
    return slips_by(fit, effect, how.kin) if effect.breakaway and how.is_global else []


@threadpool_limits.wrap(limits=1)
def slips_by(fit: Fit, effect: Effect, kin: Fit | None = None, line: Line | None = None) -> list[SlipSearch]:
    """Return what the forms of an effect that makes the stem jump make of the slips of stairs, the best first.

    Parameters
    ----------
    fit : Fit
    effect : Effect
    kin : Fit or None
        The fit extended by a kindred effect.
    line : Line or None
        Through the breakaways of the fit, if it was laid.

    Returns
    -------
    list of SlipSearch
        Empty where there are no stairs, or where the slips are not explained much better than without the effect or by
        its kin, or nearly as well as by another law.
    """
    line = line or line_of_stairs(fit.problem, fit.found.point)
    if line is None:
        return []
    begun = search_slips(effect, line, forms_of(fit, effect))
    far = EXPLAINED * error_at_rests(fit.problem, fit.found.point)
    if kin is not None:
        share = EXPLAINED if breakaway_of(kin) is None else NEAR_KIN
        far = min(far, share * error_at_rests(kin.problem, kin.found.point))
    return begun if begun[0].found.error < far else []


@threadpool_limits.wrap(limits=1)
def slips_beside(begun: SlipSearch, fit: Fit, effect: Effect, line: Line) -> list[SlipSearch]:
    """Return what a law of the slips that was found beside one effect makes of them beside another, that of a fit.

    Parameters
    ----------
    begun : SlipSearch
    fit : Fit
        On a line through the breakaways with the other effect.
    effect : Effect
        The law.
    line : Line
    """
    return search_beside_other(begun, effect, line, [problem for problem, _ in forms_of(fit, effect)])


def forms_of(fit: Fit, effect: Effect) -> list[tuple[Problem, np.ndarray]]:
    """Return the problem with an effect in each of its forms, and the scaled points where searches for it begin."""
    forms: dict[Form, list[tuple[Problem, np.ndarray]]] = {}
    for start in starts_on(fit, effect):
        pair = joined(fit.problem, fit.found.point, effect, start)
        forms.setdefault(effect.form_at(start), []).append(pair)
    return [(pairs[0][0], np.array([point for _, point in pairs])) for pairs in forms.values()]


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


def of_another_form(effect: Effect, group: list[Trial]) -> list[Trial]:
    """Return the most promising start of another form than the first one, if there is one.

    A form is what of the effect acts: a lag alone, for one, or two in series.
    """
    forms = [neutral_in(effect, trial) for trial in group]
    return [trial for trial, form in zip(group, forms, strict=True) if form != forms[0]][:1]


def of_another_side(effect: Effect, group: list[Trial], kept: list[Trial]) -> list[Trial]:
    """Return the most promising start to another side of no effect than those that are kept, if there is one.

    Slopes promise most to the side where an effect that is none would lead.
    """
    known = {sides_in(effect, trial) for trial in kept}
    return [trial for trial in group if sides_in(effect, trial) not in known][:1]


def sides_in(effect: Effect, trial: Trial) -> tuple[bool, ...]:
    """Return to which side of no effect each parameter lies at a start, of those that may lie to either."""
    values = trial.problem.model.effects[effect.key]
    return tuple(values[each.name] > each.neutral for each in effect.fitted if each.low < each.neutral < each.high)


def neutral_in(effect: Effect, trial: Trial) -> frozenset[str]:
    """Return the parameters of an effect that do not act at a start."""
    values = trial.problem.model.effects[effect.key]
    return frozenset(each.name for each in effect.parameters if values[each.name] == each.neutral)


def beside(fit: Fit, effect: Effect, kin: Fit, known: dict[str, float] | None = None) -> tuple[Problem, Found]:
    """Follow the best starts of an effect down from the base valve that was fitted with a kindred one.

    Beside another effect a law of stick-slip starts from where the stem breaks away by the kindred law, and all starts
    are followed far: which comes nearest shows late.
    """
    valve = taken_over(fit, kin)
    starts = [*starts_on(fit, effect), *([known] if known else [])]
    ratio = breakaway_of(kin) if effect.breakaway and fit.model.effects else None
    if ratio is not None:
        at_ratio = [{**start, effect.breakaway: ratio} for start in starts]
        starts = list({tuple(start.values()): start for start in at_ratio}.values())
    begun = [joined(fit.problem, valve, effect, start) for start in starts]
    if ratio is not None:
        return best_descended(begun, first=FIRST_LOOK_AT_LAWS, further=15, precision=1e-4)
    begun.sort(key=lambda pair: float(errors(pair[0], pair[1][None, :])[0]))
    return best_descended(begun[:KEPT_STARTS], first=8, further=15, precision=1e-4)


def taken_over(fit: Fit, kin: Fit) -> np.ndarray:
    """Return the scaled point of a fit with what a kindred one, in whatever order of adding, made of its unknowns."""
    made = {(each.name, each.experiment): at for each, at in zip(kin.unknowns, kin.found.point, strict=True)}
    own = zip(fit.unknowns, fit.found.point, strict=True)
    return np.array([made.get((each.name, each.experiment), at) for each, at in own])


def breakaway_of(fit: Fit) -> float | None:
    """Return the breakaway force of a fit over Coulomb friction; None where no effect sets it."""
    names = {key: effect_of_key(key).breakaway for key in fit.model.effects}
    return next((fit.model.effects[key][name] for key, name in names.items() if name), None)


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


def alike(effect: Effect, trials: list[Trial]) -> list[list[Trial]]:
    """Return the trials in groups of one form each; each group is searched on its own."""
    groups: dict[Form, list[Trial]] = {}
    for trial in trials:
        groups.setdefault(form_of(effect, trial.problem), []).append(trial)
    return list(groups.values())


def is_another_form(effect: Effect, one: Problem, other: Problem) -> bool:
    """Return whether two problems differ in the form of an effect alone, so that a point of one is one of the other."""
    return form_of(effect, one) != form_of(effect, other) and one.unknowns == other.unknowns


def promising(fit: Fit, groups: list[list[Trial]]) -> list[list[Trial]]:
    """Return groups of trials without those of a whole series that promise little more than the rest."""
    plain = max(group[0].gain for group in groups if not adds_series(fit, group[0]))
    return [group for group in groups if not adds_series(fit, group[0]) or group[0].gain > SERIES_GAIN * plain]


def first_plain(fit: Fit, trials: list[Trial]) -> Trial:
    """Return the first trial that adds no whole series to a fit."""
    return next(trial for trial in trials if not adds_series(fit, trial))


def adds_series(fit: Fit, trial: Trial) -> bool:
    """Return whether a trial adds a whole series of unknowns to those of a fit."""
    return trial.problem.has_series and not fit.problem.has_series


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
