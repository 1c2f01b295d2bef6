"""Beside slips: pairs of what makes the stem jump and what bends the line through its breakaways, bend first."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial

from diagnosis.explaining import any_explains, misfit, stops_seen
from diagnosis.trying import Candidate, Progress, Work, try_all
from identification.bent_lines import OFF_THE_LINE, BentLine, bent_line, straight_line
from identification.extension import slips_by
from identification.holdout import Holdout
from identification.stick_slip import SlipSearch, error_at_rests
from valvemodel.effects import effect_of_key

MAKERS, BENDS = 2, 4
"""Laws of stick-slip, the best alone, and effects that bend the line, the best ones, whose slips are looked at."""

BESIDE = 3
"""Effects on top of which the law is tried where no line tells which."""

SOME = 0.9
"""Share of the base's squared error below which such a law must come alone where the record shows no rests on the way:
what only looks like breakaways lies on no line either."""

WHAT = "two effects together"
"""What is said meanwhile."""

CLOSE_AT_SLIPS, MOST = 1.5, 3
"""Error at the slips, over the best one's, up to which an effect and a law are searched for whole, and how many."""

AS_WELL = 4.0
"""Error of the line, over the best one's, up to which an effect bends it as well."""


def beside_slips(
    alone: Sequence[Candidate], holdout: Holdout, pool: Executor | None, progress: Progress
) -> list[Candidate]:
    """Try what makes the stem jump on top of another effect: of one that brings its breakaways onto a line, if any.

    The other way about a search goes astray: a second effect moves each breakaway, and what then is a slip's way
    depends on it. The line needs no run of the stem.

    Parameters
    ----------
    alone : sequence of Candidate
        The base, then the effects one by one.
    holdout : Holdout
    pool : Executor or None
    progress : callable

    Returns
    -------
    list of Candidate
        Causes of two effects; empty where nothing speaks for stick-slip, a coarse reading comes nearer, one effect
        explains the gap, no line is bent and a law that is quickly searched for is not the best alone, or no two come
        nearer at the slips than a law alone.
    """
    base = alone[0]
    has_stairs = any(each.has_stairs for each in base.fit.problem.experiments)
    laws = [each for each in alone[1:] if effect_of_key(each.effects[0]).breakaway]
    makers = sorted((each for each in laws if has_stairs or not effect_of_key(each.effects[0]).is_chaotic), key=misfit)
    if not makers or any_explains(alone):
        return []
    if not stops_seen(base.fit) and misfit(makers[0]) > SOME * misfit(base):
        return []
    if any(stops_by_reading(each) and misfit(each) < misfit(makers[0]) for each in alone[1:]):
        return []
    bent = bent_lines(alone, pool, progress)
    if not bent:
        return try_all(beside_the_best(alone, makers[0]), holdout, pool, progress, WHAT)
    work = [Work(each.fit, (each.effect.key, *law.effects), True) for each in bent[:BENDS] for law in makers[:MAKERS]]
    progress("what sets how far the slips go", 0.0)
    looked = list(zip(work, (pool.map if pool else map)(slips_of, work), strict=True))
    if not any(slips for _, slips in looked):
        known = [replace(each, slips=[]) for each in work[:MAKERS]]
        return try_all(beside_the_best(alone, makers[0]) or known, holdout, pool, progress, WHAT)
    alone_at_slips = min(error_at_rests(each.fit.problem, each.fit.found.point) for each in makers)
    return try_all(nearest_at_slips(looked, alone_at_slips), holdout, pool, progress, WHAT)


def stops_by_reading(cause: Candidate) -> bool:
    """Return whether a cause of one effect lets a reading rest again and again while the stem moves on."""
    effect = effect_of_key(cause.effects[0])
    return effect.stops_again and not effect.breakaway


def nearest_at_slips(looked: Sequence[tuple[Work, list[SlipSearch]]], alone: float) -> list[Work]:
    """Return the work whose law comes nearest at the slips, each judged by itself, the best first.

    Several effects bend the line as well as each other, and the law that is better alone may be the wrong one: a quick
    look at the slips tells. What comes no nearer there than a law `alone` is not searched for whole.
    """
    begun = [(slips[0].found.error, each, slips) for each, slips in looked if slips and slips[0].found.error < alone]
    begun.sort(key=lambda one: one[0])
    return [replace(each, slips=slips) for error, each, slips in begun if error <= CLOSE_AT_SLIPS * begun[0][0]][:MOST]


def slips_of(work: Work) -> list[SlipSearch]:
    """Return what the last effect of a cause makes of the slips beside the others."""
    return slips_by(work.fit, effect_of_key(work.effects[-1]))


def bent_lines(alone: Sequence[Candidate], pool: Executor | None, progress: Progress) -> list[BentLine]:
    """Return the effects that bring the breakaways onto a line as well as the best of them does, that one first.

    Empty where breakaways are few, or lie on the line as it is.
    """
    base = alone[0].fit
    line = straight_line(base)
    if line is None:
        return []
    progress("what bends the line through the breakaways", 0.0)
    effects = [effect_of_key(each.effects[0]) for each in alone[1:]]
    laid = (pool.map if pool else map)(partial(bent_line, base, line), effects)
    bent = sorted((each for each in laid if each is not None), key=lambda each: each.line.error)
    within = max(AS_WELL * bent[0].line.error, OFF_THE_LINE * line.count) if bent else 0.0
    return [each for each in bent if each.line.error <= within]


def beside_the_best(alone: Sequence[Candidate], maker: Candidate) -> list[Work]:
    """Return what makes the stem jump, if it is the best alone, on top of the best other effects."""
    order = sorted(alone[1:], key=misfit)
    if order[0] is not maker or effect_of_key(maker.effects[0]).is_chaotic:
        return []
    quick = [each for each in order if not effect_of_key(each.effects[0]).is_jagged and not each.has_series]
    return [Work(each.fit, (*each.effects, *maker.effects), is_global=True) for each in quick[:BESIDE]]
