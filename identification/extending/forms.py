"""Forms: which trials of an effect are of one form, of another or to another side, and which add a whole series."""

from __future__ import annotations

from identification.fit import Fit
from identification.problem import Problem
from identification.starting.screening import Trial
from identification.stick_slip.slip_search import form_of
from valvemodel.declarations import Effect, Form

SERIES_GAIN = 1.2
"""Promise of a whole series, over that of its first wave, above which it is followed."""


def alike(effect: Effect, trials: list[Trial]) -> list[list[Trial]]:
    """Return the trials in groups of one form each; each group is searched on its own."""
    groups: dict[Form, list[Trial]] = {}
    for trial in trials:
        groups.setdefault(form_of(effect, trial.problem), []).append(trial)
    return list(groups.values())


def is_another_form(effect: Effect, one: Problem, other: Problem) -> bool:
    """Return whether two problems differ in the form of an effect alone, so that a point of one is one of the other."""
    return form_of(effect, one) != form_of(effect, other) and one.unknowns == other.unknowns


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
