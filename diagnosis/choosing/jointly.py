"""Jointly: two effects that promise most together, whatever each of them explains alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

from diagnosis.trying.candidates import Candidate, scored
from diagnosis.trying.explaining import misfit
from diagnosis.trying.standing import of_many_numbers
from diagnosis.trying.workshop import Workshop
from identification.extending.pairs import Trace, begun, promising_pairs, traces_of
from identification.fit import Fit, finished
from identification.holdout import Holdout
from identification.problem import Problem
from identification.search import Found, Start, descend_roughly, descend_to_end
from identification.starting.joining import released
from valvemodel.effects import effect_of_key

LOOKED_AT, FOLLOWED, ENDED = 48, 12, 5
"""Starts of pairs from which a search looks about, goes on, and goes on to its end."""

LEFT_BEHIND = 5.0
"""Error over the best one's above which a search goes no further."""

FIRST_LOOK, FURTHER = 6, 10
"""Points of the search that looks about, and of the one that goes on."""

WHAT = "two effects that promise most together"
"""What is said meanwhile."""


def try_jointly(tried: Sequence[Candidate], workshop: Workshop) -> list[Candidate]:
    """Try the pairs of effects that promise most together on what the base leaves.

    The best alone need be neither of two: what each changes of the readings, with the base valve's answer to it, is
    known from its starts and from its fit alone, and all pairs are compared by what they explain at any sizes. What
    takes a global search, is read off the record or is a whole series is left out.

    Parameters
    ----------
    tried : sequence of Candidate
        The base, then the effects one by one, and whatever else was tried.
    workshop : Workshop

    Returns
    -------
    list of Candidate
        The best of them, each with the one first that is better alone.
    """
    base = tried[0].fit
    alone = {each.effects[0]: each for each in tried if len(each.effects) == 1}
    keys = [key for key in alone if is_joined(key)]
    workshop.progress(WHAT, 0.0)
    # Taken here, not once in each process.
    _ = base.own_slopes
    fits = [alone[key].fit if is_base_beside(alone[key], base) else None for key in keys]
    traces = [trace for found in workshop.map(partial(traced, base), keys, fits) for trace in found]
    pairs = promising_pairs(base, traces, LOOKED_AT)
    starts = [begun(base, each) for each in pairs]
    for points, count, of_a_form in ((FIRST_LOOK, FOLLOWED, 2), (FURTHER, ENDED, 1)):
        workshop.progress(WHAT, 0.0)
        found = list(workshop.map(partial(looked, points=points), starts))
        starts = nearest([(problem, each) for (problem, _), each in zip(starts, found, strict=True)], count, of_a_form)
    ended = list(workshop.map(partial(followed_to_end, holdout=workshop.holdout), starts))
    return [replace(each, effects=in_order(each.effects, alone)) for each in ended]


def nearest(found: Sequence[tuple[Problem, Found]], count: int, of_a_form: int) -> list[Start]:
    """Return where the best of some searches came, as starts; few of the same effects in the same form.

    What lies far behind the best of all goes no further. A form is told by the numbers that no fit moves. An effect of
    many numbers may stand in for two others: beside whatever else it comes near, and would leave no room for them.
    """
    kept: list[Start] = []
    known: Counter[object] = Counter()
    order = sorted(found, key=lambda one: one[1].error)
    for problem, each in order:
        if each.error > LEFT_BEHIND * order[0][1].error:
            break
        form = tuple((key, effect_of_key(key).form_at(values)) for key, values in sorted(problem.model.effects.items()))
        many = of_many_numbers(problem.model)
        if known[form] < of_a_form and all(known[key] < count // 2 for key in many):
            kept.append((problem, each.point))
            known.update([form, *many])
    return kept[:count]


def is_joined(key: str) -> bool:
    """Return whether an effect is tried jointly with others: a local search finds it, and has numbers to move."""
    effect = effect_of_key(key)
    return not effect.breakaway and not effect.is_read_off


def is_base_beside(cause: Candidate, base: Fit) -> bool:
    """Return whether a cause of one effect was fitted beside the base valve's own unknowns, and gained by it."""
    return not cause.has_series and cause.fit.found.error < base.found.error


def traced(base: Fit, key: str, alone: Fit | None) -> list[Trace]:
    """Return what an effect changes of what the base leaves."""
    return traces_of(base, effect_of_key(key), alone)


def in_order(effects: Sequence[str], alone: Mapping[str, Candidate]) -> tuple[str, ...]:
    """Return effects with the one first that is better alone."""
    return tuple(sorted(effects, key=lambda key: misfit(alone[key])))


def looked(start: Start, points: int) -> Found:
    """Follow a start some way down."""
    problem, point = start
    return descend_roughly(problem, point, evaluations=points)


def followed_to_end(start: Start, holdout: Holdout) -> Candidate:
    """Follow a start down to the end, with what its effects free of the base valve, and score what comes out."""
    problem, point = released(*start)
    return scored(tuple(problem.model.effects), finished(problem, descend_to_end(problem, point)), holdout)
