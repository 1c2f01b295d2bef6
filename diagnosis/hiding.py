"""Hiding: effects for which the numbers of a cause, or of the base valve, make up, so that a record shows no trace."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor

import numpy as np

from diagnosis.judgement import judge
from diagnosis.selection import explains, misfit
from diagnosis.trying import Candidate, Progress, Work, try_all
from identification.holdout import Holdout
from valvemodel.declarations import Effect
from valvemodel.effects import effect_of_key

HIDES = 1.1
"""Factor within which the squared error of a cause must stay for an effect to hide beside it."""

FELT = 1.0
"""Change of the readings, in units of the noise, from which an effect is there and does not need to be shown."""


def with_hidden(
    tried: Sequence[Candidate], holdout: Holdout, pool: Executor | None, progress: Progress
) -> list[Candidate]:
    """Return the causes, and what hides beside the most probable one at a strength that matters.

    A search from no effect leaves at nothing what gains nothing; that it would leave no trace if it were there is what
    a reader has to know. The most probable cause, which may be none, is fitted together with each effect that is
    declared to come close to none, from a strength that would be felt; what then explains the records as well is a
    cause of its own, in place of the same one without strength.

    Parameters
    ----------
    tried : sequence of Candidate
        The base first.
    holdout, pool, progress
        As for `selection.select`.
    """
    judgement = judge(tried)
    best = tried[int(np.argmax(judgement.probabilities))]
    if len(best.effects) > 1 or not explains(best, tried[0]) or judgement.unknown > judgement.probabilities.max():
        return list(tried)
    effects = [effect_of_key(each.effects[0]) for each in tried if len(each.effects) == 1]
    work = [
        Work(best.fit, (*best.effects, effect.key), False, strongest_start(effect), is_known=True)
        for effect in effects
        if can_hide(effect) and effect.key not in best.effects
    ]
    found = try_all(work, holdout, pool, progress, "what may hide")
    hidden = {frozenset(each.effects): each for each in found if is_hidden(each, best)}
    others = [each for each in tried if frozenset(each.effects) not in hidden or each.trace >= FELT]
    known = {frozenset(each.effects) for each in others}
    return others + [each for effects, each in hidden.items() if effects not in known]


def is_hidden(found: Candidate, best: Candidate) -> bool:
    """Return whether a cause explains as well as the one that it adds an effect to, and the effect is a strong one."""
    return misfit(found) < HIDES * misfit(best) and found.trace >= FELT


def can_hide(effect: Effect) -> bool:
    """Return whether an effect is declared to come close to none, and its strength is free."""
    return "none" in effect.aliases and len(effect.fitted) == len(effect.parameters)


def strongest_start(effect: Effect) -> dict[str, float]:
    """Return the numbers of an effect at the last of their declared starts."""
    return {each.name: float(each.starts[-1]) for each in effect.parameters}
