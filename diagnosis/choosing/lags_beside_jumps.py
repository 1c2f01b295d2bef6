"""Lags beside jumps: what lags on top of a law of stick-slip whose viscous friction stands in for it."""

from __future__ import annotations

from collections.abc import Sequence

from diagnosis.choosing.beside_slips import SOME, WHAT
from diagnosis.choosing.rivals import short_of_noise
from diagnosis.trying.candidates import Candidate, Work, sharpen_all, try_all
from diagnosis.trying.explaining import any_explains, misfit
from diagnosis.trying.standing import best_of, is_blunt, is_near_noise, values_alone, with_better
from diagnosis.trying.workshop import Workshop
from identification.extending.sluggishness import is_sluggish
from valvemodel.effects import effect_of_key

FAR_TOO_MUCH = 3.0
"""Viscous friction of a law alone, over that which was given, from which it stands in for a lag: slips last as long by
either. In 21 blind plants of our own without a lag it was 0.6 to 1.4 times, in two with one 9 and 17."""

MOST_TAKEN_IN = 0.2
"""Share of what the law leaves below which a lag has taken in most of it."""


def lags_beside_jumps(alone: Sequence[Candidate], workshop: Workshop) -> list[Candidate]:
    """Try what lags on top of a law in closed form that is the best alone, with far too much viscous friction for that.

    It makes the slips last as long as a lag does. No line tells: what lags shows a breakaway late. What lags by several
    laws takes long, and comes last, unless another comes to the noise or takes in most.
    """
    nearest = best_of(alone, 1)
    if not nearest or any_explains(alone):
        return []
    base, values, tried, law = alone[0], values_alone(alone), list(alone), nearest[0]
    if not is_blunt(law) or misfit(law) >= SOME * misfit(base) or not is_sluggish(law.fit, FAR_TOO_MUCH):
        return []
    lags = [key for key in values if any(each.is_lag for each in effect_of_key(key).fitted)]
    for has_laws in (False, True):
        keys = [key for key in lags if bool(effect_of_key(key).laws) == has_laws]
        work = [Work(law.fit, (*law.effects, key), is_global=False, known=values[key]) for key in keys]
        tried += try_all(work, workshop, WHAT)
        tried = with_better(tried, sharpen_all(short_of_noise(tried), workshop))
        if any(is_near_noise(each, base) or misfit(each) < MOST_TAKEN_IN * misfit(law) for each in best_of(tried, 2)):
            break
    return best_of(tried, 2)
