"""Beside slips: pairs of what makes the stem jump and what bends the line through its breakaways, bend first."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from functools import partial

from diagnosis.explaining import explains, misfit
from diagnosis.trying import Candidate, Progress, Work, try_all
from identification.bent_lines import OFF_THE_LINE, bent_line, straight_line
from identification.holdout import Holdout
from valvemodel.effects import effect_of_key

MAKERS = 2
"""Laws of stick-slip that are tried beside the effect that bends the line best."""

OTHERS = 2
"""Further effects that bend the line as well, which are tried beside the better law."""

AS_WELL = 4.0
"""Error of the line, over the best one's, up to which an effect bends it as well."""


def beside_slips(
    alone: Sequence[Candidate], holdout: Holdout, pool: Executor | None, progress: Progress
) -> list[Candidate]:
    """Try what makes the stem jump on top of what brings its breakaways onto a line.

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
        Causes of two effects; empty where there are no stairs, or their breakaways lie on the line as it is.
    """
    base = alone[0].fit
    effects = [effect_of_key(each.effects[0]) for each in alone[1:]]
    makers = sorted((each for each in alone[1:] if effect_of_key(each.effects[0]).breakaway), key=misfit)
    has_stairs = any(each.has_stairs for each in base.problem.experiments)
    line = straight_line(base) if has_stairs and makers else None
    if line is None:
        return []
    progress("what bends the line through the breakaways", 0.0)
    laid = (pool.map if pool else map)(partial(bent_line, base, line), effects)
    bent = sorted((each for each in laid if each is not None), key=lambda each: each.line.error)
    if not bent:
        return []
    within = max(AS_WELL * bent[0].line.error, OFF_THE_LINE * line.count)
    others = [each for each in bent[1:] if each.line.error < within][:OTHERS]
    work = [Work(bent[0].fit, (bent[0].effect.key, *each.effects), is_global=True) for each in makers[:MAKERS]]
    found = try_all(work, holdout, pool, progress, "two effects together")
    best = min(found, key=misfit)
    if explains(best, alone[0]):
        return found
    work = [Work(each.fit, (each.effect.key, best.effects[1]), is_global=True) for each in others]
    return found + try_all(work, holdout, pool, progress, "two effects together")
