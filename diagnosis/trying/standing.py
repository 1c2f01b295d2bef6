"""Standing: how causes that were tried stand to each other, and what each of them may be worth."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from diagnosis.trying.candidates import Candidate, moved_in
from diagnosis.trying.explaining import AT_NOISE, allowed, explains, misfit
from valvemodel.effects import differ_by_aliases, effect_of_key, jumps_in_closed_form, takes_long
from valvemodel.model import Model

SHARPENED = 2
"""Best causes that are searched about where they make the stem stop and jump, and leave something to explain."""

NEAR_THE_BEST = 2.0
"""Causes whose squared error is within this factor of the best of their size are tried with one more effect, or
searched about."""

SETTLED_SHARE = 0.025
"""Share of the base's error, in root mean square, that a cause may leave beside the noise for only those that are alike
to be looked for."""

OUT_OF_REACH = 3.0
"""What the best two effects leave over what may be left, times what they leave over the best alone, from which no other
order, form or start brings two effects to the noise: of 28 blind records that two explained it was at most 0.9."""

MANY_NUMBERS = 4
"""Free numbers from which an effect may stand in for one of fewer: a tight spot of any place, width and shape does."""

EXPLAINS_MUCH, EXPLAINS_SOME = 0.5, 0.75
"""Share of the base's squared error below which a cause must come whose runs take long for others to be tried on top of
it, and for it to be tried on top of others, or to stay where the other of two makes room."""


def best_of(tried: Sequence[Candidate], size: int) -> list[Candidate]:
    """Return the causes of so many effects, the best first."""
    return sorted((each for each in tried if len(each.effects) == size), key=misfit)


def as_tried(cause: Candidate, tried: Sequence[Candidate]) -> Candidate:
    """Return a cause as it came nearest since it was tried."""
    return min((each for each in tried if set(each.effects) == set(cause.effects)), key=misfit)


def alone_of(tried: Sequence[Candidate]) -> dict[str, Candidate]:
    """Return the causes of one effect by its key, in the order in which they were tried."""
    return {each.effects[0]: each for each in tried if len(each.effects) == 1}


def values_alone(tried: Sequence[Candidate]) -> dict[str, dict[str, float]]:
    """Return the values of each effect as fitted alone. [SI]"""
    return {key: dict(each.fit.model.effects[key]) for key, each in alone_of(tried).items()}


def with_better(tried: Sequence[Candidate], others: Sequence[Candidate]) -> list[Candidate]:
    """Return the causes, each as the one of the same effects that comes nearest, in whatever order of adding.

    Of two that are as near it is the later one: more was done to it. It knows of all orders that were tried.
    """
    alike: dict[frozenset[str], list[Candidate]] = {}
    for each in (*tried, *others):
        alike.setdefault(frozenset(each.effects), []).append(each)
    return [replace(min(reversed(causes), key=misfit), orders=orders_of(causes)) for causes in alike.values()]


def orders_of(tried: Iterable[Candidate]) -> frozenset[tuple[str, ...]]:
    """Return the orders in which causes were tried, their last effect on top of the others."""
    return frozenset().union(*(each.orders for each in tried))


def unlike(causes: Sequence[Candidate]) -> list[Candidate]:
    """Return causes without those that differ from one before them by a declared alias.

    These are exchanged later, but for what takes long.
    """
    kept: list[Candidate] = []
    for cause in causes:
        is_exchanged = all(is_quick(key) for key in cause.effects)
        if not is_exchanged or not any(differ_by_aliases(cause.effects, each.effects) for each in kept):
            kept.append(cause)
    return kept


def is_near_noise(candidate: Candidate, base: Candidate) -> bool:
    """Return whether a cause is as near the noise as the right one in another form can be expected to come."""
    return misfit(candidate) <= AT_NOISE + SETTLED_SHARE**2 * (misfit(base) - 1.0)


def is_settled(candidate: Candidate, base: Candidate) -> bool:
    """Return whether a cause is as near the noise as the right one, and is none that may come there in its place.

    Only what is alike can come as near. A whole series of waves, or an effect of many numbers, may come there in the
    place of something else.
    """
    is_plain = not (candidate.has_series or of_many_numbers(candidate.fit.model))
    return is_plain and is_near_noise(candidate, base)


def stands_in(candidate: Candidate) -> bool:
    """Return whether an effect of a cause has so many free numbers that it may stand in for another, at little cost."""
    many = of_many_numbers(candidate.fit.model)
    return any(not effect_of_key(key).takes_long for key in many) or candidate.has_series


def of_many_numbers(model: Model) -> list[str]:
    """Return the effects of a model that have so many free numbers, what starts them and a series of one aside."""
    return [key for key, moved in moved_in(model).items() if sum(each.is_own for each in moved) >= MANY_NUMBERS]


def is_out_of_reach(tried: Sequence[Candidate]) -> bool:
    """Return whether the best two effects leave so much, and so little less than the best alone, that none explain it.

    Where one of the nearest makes the stem jump, or takes long to run, the error is jagged, and tells less.
    """
    pairs, single = best_of(tried, 2)[:SHARPENED], min(misfit(each) for each in tried if len(each.effects) < 2)
    is_far = misfit(pairs[0]) ** 2 > OUT_OF_REACH * allowed(tried[0]) * single
    return is_far and not any(map(breaks_away, pairs))


def is_read_off(candidate: Candidate) -> bool:
    """Return whether all numbers of a cause are read off the record."""
    return bool(candidate.effects) and all(effect_of_key(key).is_read_off for key in candidate.effects)


def has_read_off(candidate: Candidate) -> bool:
    """Return whether one of a cause's effects is read off the record."""
    return any(effect_of_key(key).is_read_off for key in candidate.effects)


def is_laid_on_top(candidate: Candidate) -> bool:
    """Return whether a cause of one effect is laid on top of another's fit, not under it."""
    return candidate.has_series or is_read_off(candidate)


def breaks_away(candidate: Candidate) -> bool:
    """Return whether one of a cause's effects makes the stem stop and jump, or takes long to run."""
    effects = [effect_of_key(key) for key in candidate.effects]
    return any(each.breakaway or each.takes_long for each in effects)


def is_quick(key: str) -> bool:
    """Return whether a search for an effect beside another takes no global search and no long runs."""
    effect = effect_of_key(key)
    return not effect.is_jagged and not effect.takes_long


def is_dear(key: str) -> bool:
    """Return whether runs with an effect are dear: the pressure moves between the samples, or bristles do."""
    effect = effect_of_key(key)
    return effect.takes_long or (effect.acts_in_time and effect.acts_on_pressure)


def is_worth_its_time(candidate: Candidate, base: Candidate, share: float = EXPLAINS_MUCH) -> bool:
    """Return whether a cause is tried together with more: where its runs take long, only if it explains so much."""
    return not takes_long(candidate.effects) or misfit(candidate) < share * misfit(base)


def blunt(order: Sequence[Candidate], base: Candidate) -> list[Candidate]:
    """Return those of the first of some causes whose search may have ended beside the least error.

    A whole series of waves has too many numbers for it.
    """
    near = [each for each in order[:SHARPENED] if misfit(each) < NEAR_THE_BEST * misfit(order[0])]
    return [
        each
        for each in near
        if not (each.has_series or each.is_sharpened)
        and (is_blunt(each) or loses_phase(each))
        and not explains(each, base)
    ]


def loses_phase(candidate: Candidate) -> bool:
    """Return whether one of a cause's effects lets a free run lose the phase of its slips."""
    return any(effect_of_key(key).is_chaotic for key in candidate.effects)


def is_blunt(candidate: Candidate) -> bool:
    """Return whether a cause makes the stem stop and jump, and a search about its fit ends in good time."""
    return jumps_in_closed_form(candidate.effects) and not candidate.has_series
