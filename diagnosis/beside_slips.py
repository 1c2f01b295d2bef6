"""Beside slips: pairs of what makes the stem jump and what bends the line through its breakaways, bend first."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from functools import partial

from diagnosis.explaining import explains, misfit, stops_seen
from diagnosis.trying import Candidate, Progress, Work, try_all
from identification.bent_lines import OFF_THE_LINE, BentLine, bent_line, straight_line
from identification.holdout import Holdout
from valvemodel.effects import effect_of_key

MAKERS = 2
"""Laws of stick-slip that are tried beside the effect that bends the line best."""

BESIDE = 3
"""Effects on top of which the law is tried where no line tells which."""

SOME = 0.9
"""Share of the base's squared error below which such a law must come alone where the record shows no rests on the way:
what only looks like breakaways lies on no line either."""

WHAT = "two effects together"
"""What is said meanwhile."""

OTHERS = 2
"""Further effects that bend the line as well, which are tried beside the better law."""

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
        Causes of two effects; empty where nothing speaks for stick-slip, one effect explains the gap, or no line is
        bent and stick-slip is not the best alone.
    """
    base = alone[0]
    has_stairs = any(each.has_stairs for each in base.fit.problem.experiments)
    laws = [each for each in alone[1:] if effect_of_key(each.effects[0]).breakaway]
    makers = sorted((each for each in laws if has_stairs or not effect_of_key(each.effects[0]).is_chaotic), key=misfit)
    if not makers or explains(min(alone, key=misfit), base):
        return []
    if not stops_seen(base.fit) and misfit(makers[0]) > SOME * misfit(base):
        return []
    bent = bent_lines(alone, pool, progress)
    if not bent:
        return try_all(beside_the_best(alone, makers[0]), holdout, pool, progress, WHAT)
    work = [Work(bent[0].fit, (bent[0].effect.key, *each.effects), is_global=True) for each in makers[:MAKERS]]
    found = try_all(work, holdout, pool, progress, WHAT)
    best = min(found, key=misfit)
    if explains(best, base):
        return found
    work = [Work(each.fit, (each.effect.key, best.effects[1]), is_global=True) for each in bent[1 : 1 + OTHERS]]
    return found + try_all(work, holdout, pool, progress, WHAT)


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
    quick = [each for each in order if not effect_of_key(each.effects[0]).is_jagged]
    return [Work(each.fit, (*each.effects, *maker.effects), is_global=True) for each in quick[:BESIDE]]
