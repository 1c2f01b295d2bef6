"""Hiding: effects for which the numbers of a cause, or of the base valve, make up, so that a record shows no trace."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.judging.judgement import WITHIN_ERROR, Judgement, judge
from diagnosis.trying.candidates import Candidate, Work, try_all
from diagnosis.trying.explaining import is_fitted, leaves_little, misfit
from diagnosis.trying.workshop import Workshop
from valvemodel.declarations import Effect
from valvemodel.effects import effect_of_key, is_jagged

HIDES = 1.1
"""Factor within which the squared error of a cause, or the noise, must stay for an effect to hide beside it."""

MOST_SAID = 2
"""Effects that are said to hide beside a cause."""

ASTRAY, SMALLER, SMALLEST = 2.0, 0.3, 0.1
"""Factor in squared error from which an effect at its strongest start has led a cause into a side minimum, and the
shares of that start from which it is tried once more, and then where the stem sticks."""

FELT = 1.0
"""Change of the readings, in units of the noise, from which an effect is there and does not need to be shown."""


def with_hidden(tried: Sequence[Candidate], workshop: Workshop) -> tuple[list[Candidate], list[str]]:
    """Look at what hides beside the most probable cause at a strength that matters.

    A search from no effect leaves at nothing what gains nothing; that it would leave no trace if it were there is what
    a reader has to know. The most probable cause, which may be none, is fitted together with each effect that is
    declared to come close to none, from a strength that would be felt.

    Parameters
    ----------
    tried : sequence of Candidate
        The base first.
    workshop : Workshop

    Returns
    -------
    list of Candidate
        The causes; beside none, effects that hide at their strength instead of at nothing.
    list of str
        Effects that hide beside the most probable cause, the best hidden first: those, and what was tried together with
        it and came no nearer than can be told. Empty where that cause is none or has two effects, and where an unknown
        one is more probable.
    """
    judgement = judge(tried)
    chosen = int(np.argmax(judgement.probabilities))
    best = tried[chosen]
    if len(best.effects) > 1 or judgement.unknown > judgement.probabilities.max():
        return list(tried), []
    beside = alike_beside(chosen, tried, judgement) if best.effects else []
    # What a whole series of waves leaves may be what hides beside it.
    if not leaves_little(best, tried[0]):
        return list(tried), said(beside, best)
    unfelt = [each.effects[0] for each in tried if len(each.effects) == 1 and (best.effects or each.trace < FELT)]
    keys = [key for key in unfelt if effect_of_key(key).hides_in_base and key not in best.effects]
    hidden: list[Candidate] = []
    for share in (1.0, SMALLER, SMALLEST) if sticks(best) else (1.0, SMALLER):
        found = try_all([beside_at(best, key, share) for key in keys], workshop, "what may hide")
        hidden += (each for each in found if is_hidden(each, best))
        keys = [each.effects[-1] for each in found if is_astray(each, best)]
    hidden.sort(key=misfit)
    if best.effects:
        return list(tried), said([*beside, *hidden], best)
    replaced = {each.effects for each in hidden}
    return [*(each for each in tried if each.effects not in replaced), *hidden], []


def beside_at(best: Candidate, key: str, share: float = 1.0) -> Work:
    """Return a cause together with an effect as work, from a share of the effect's strongest start alone."""
    start = {name: share * value for name, value in strongest_start(effect_of_key(key)).items()}
    return Work(best.fit, (*best.effects, key), is_global=False, known=start, is_known=True)


def alike_beside(chosen: int, tried: Sequence[Candidate], judgement: Judgement) -> list[Candidate]:
    """Return what was tried together with a cause, can hide, and is within the error of it; the most probable first."""
    best, found = set(tried[chosen].effects), []
    for number, each in enumerate(tried):
        added = set(each.effects) - best
        if not best < set(each.effects) or len(added) > 1 or not effect_of_key(min(added)).hides_in_base:
            continue
        if each.trace >= FELT and abs(judgement.evidence[number] - judgement.evidence[chosen]) < WITHIN_ERROR:
            found.append(number)
    return [tried[number] for number in sorted(found, key=lambda number: -judgement.probabilities[number])]


def said(hidden: Sequence[Candidate], best: Candidate) -> list[str]:
    """Return the effects that causes add to the best one, as many as are said, each once."""
    added = (min(set(each.effects) - set(best.effects)) for each in hidden)
    return list(dict.fromkeys(added))[:MOST_SAID]


def is_hidden(found: Candidate, best: Candidate) -> bool:
    """Return whether a cause explains as well as the one that it adds an effect to, and the effect is a strong one.

    Where the stem sticks in places a hair may decide on a stretch that was kept back: what was fitted tells.
    """
    is_as_near = misfit(found) < HIDES * max(misfit(best), 1.0) or (sticks(best) and is_fitted(found))
    return is_as_near and found.trace >= FELT


def is_astray(found: Candidate, best: Candidate) -> bool:
    """Return whether an effect led a cause into a side minimum; where the stem sticks it need not lead far."""
    return misfit(found) > ASTRAY * misfit(best) or (sticks(best) and not is_hidden(found, best))


def sticks(cause: Candidate) -> bool:
    """Return whether a cause makes the stem stick in places, so that its error is jagged."""
    return is_jagged(cause.effects)


def strongest_start(effect: Effect) -> dict[str, float]:
    """Return the numbers of an effect at the last of their declared starts, by the first of its laws."""
    return {each.name: float(each.starts[-1 if each.is_fitted else 0]) for each in effect.parameters}
