"""How sure: probabilities of all causes, of none and of an unknown one, and what a record cannot tell apart."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.score import Errors, Score
from diagnosis.trying.candidates import Candidate
from diagnosis.trying.explaining import AT_NOISE, explains, left_of_fitted, misfit, stops_seen
from valvemodel.effects import differ_by_aliases, effect_of_key, jumps

SHARPNESS = 4.5
"""Power of the error by which a cause loses to one with less: models are never right to the last sample."""

NOTICE = 0.35
"""Squared error beyond the noise below which a difference tells nothing: effects below notice leave as much."""

FORM = 0.005
"""Share of the base's squared error by which a right effect in another form than ours may miss it."""

SUPPORT_NONE = 2.0
"""Log prior of no effect over one of the effects."""

COST_MORE = 1.4
"""Log prior that a second effect costs, beside its parameters; a third costs three times as much."""

COST_PARAMETER = 0.5
"""Log prior that a free parameter costs."""

UNKNOWN_NOTICE, UNKNOWN_FORM, SUPPORT_UNKNOWN = 0.7, 0.033, -0.7
"""What an effect outside the library would leave, as a squared error beyond the noise and as a share of the base's:
a cause that leaves less is believed before an unknown one; and the log prior of that."""

NOTHING_LEFT, ALMOST_NOTHING = 1.5, 0.1
"""Log-likelihood that an unknown cause loses where a known one leaves nothing beyond the noise, and the squared error
from which it loses none. Of 149 blind valves of our own whose effect was left out none that was called unknown had a
cause within 6 % of the noise, and what imitated it in others left a tenth; of those with their effects among the
candidates ten were given an unknown one of 0.15 to 0.6 there, though what was named left nothing."""

SUREST_UNKNOWN = 0.85
"""Most that an unknown cause is given: a search may have missed the best fit, a known effect may follow another law.
Of 37 blind valves of our own that were called unknown, 30 were, of the last 15 of them 13."""

COST_STOPS = 10.0
"""Log-likelihood that a cause loses which cannot make the stem rest again and again where the record shows that, unless
it explains the gap all the same."""

FORM_STAIRS, UNKNOWN_FORM_STAIRS = 0.05, 0.45
"""The same as FORM and UNKNOWN_FORM in a record with stairs: there the phase of slips is lost soon though the cause is
right, and large errors count by their logarithm. Set on some fifty blind plants of our own."""

FORM_SLIPS, UNKNOWN_FORM_SLIPS = 0.03, 0.2
"""The same for a cause that makes the stem stop and jump, in a record without stairs."""

UNKNOWN_FORM_SERIES = 0.02
"""The same as UNKNOWN_FORM where a whole series of waves comes nearest in a smooth record: it takes in most of whatever
goes with time. Of blind valves of our own eight with such a load left 0.98 to 1.34 in square, three whose friction
grew, with that left out, 1.6 to 14."""

BEHIND, BEHIND_SHARE, BEHIND_A_LAW, MOST_BEHIND = 0.01, 1e-4, 0.1, 4.0
"""Mean squared error, in units of the noise, by which a cause must lie behind another of as many effects that explains
the gap to lose a factor e in likelihood, or as a share of the base's if that is more, as forms differ by some of that;
the same where they differ by the law of the slips, as searches for one end nowhere exact, or where readings come in
coarse steps, few of which tell; and the most that it loses so. White noise alone would tell tenths of the first."""

NEARER_THAN_NONE, NEARER, FORM_BESIDE, MOST_LEFT = 0.12, 0.05, 0.02, 0.35
"""The same for one effect more, beyond what another form may leave: than none, where two effects below notice leave as
much, and than others, beside which they leave less in 97 of 100 blind plants of our own; the share of that form that is
allowed beside one more that comes to the noise, or takes in most of it; and what it leaves then: a wrong one seldom
makes up for another's form so. By some twice these numbers four of 146 blind pairs of our own lost to one effect, by
these none of 129 single ones to two."""

MOST_IMITATED, IMITATES_FROM = 6.0, 1.1
"""The most that several effects lose so against the noise, one of which hides in the base valve, and the squared error
from which they do: beside it another effect imitates what is none of the two, but seldom to the noise. Of eleven blind
valves of our own that were given such a pair the six right ones came within that, the five that imitated what was left
out did not."""

IMITATES_SHARE = 0.02
"""Share of what the other effects leave by themselves, beyond the noise, that may be left all the same: of three more
blind valves the two right ones left 0.005 and 0.014, the one that imitated 0.13."""

MORE_NUMBERS = 2
"""Free numbers that another cause may have more for it to be the nearer one by itself and not by them."""

BLOCK_WORTH = 0.5
"""Sharpness that a scored block in time is worth, up to the whole of it."""

WITHIN_ERROR = 3.0
"""Log-likelihood within which two causes cannot be told apart."""

FEW_BLOCKS = 6
"""Scored blocks below which none can be spared."""

LEAST_TRACE, LEAST_TRACE_MORE = 0.3, 1.0
"""Change of the readings, in units of the noise, below which an effect is no cause: alone, and beside another."""

WITHIN_FORM = 5.0
"""The same for declared aliases that both explain the gap: they may differ by their form alone."""

MOST_RIVALS, LEAST_RIVAL = 2, 0.05
"""Rivals that are named beside a cause, the most probable ones: a longer list helps nobody to choose; and the least
probability of one, over the cause's."""


@dataclass(frozen=True)
class Judgement:
    """Probabilities of the candidates, in their order, and of an unknown cause; they sum to 1.

    `evidence` is the log-likelihood of each candidate, without its prior; `lost` is what it loses of that, in the
    probabilities, against a nearer one that explains the gap.
    """

    probabilities: np.ndarray
    unknown: float
    evidence: np.ndarray
    lost: np.ndarray | float = 0.0


def judge(candidates: Sequence[Candidate]) -> Judgement:
    """Weigh all candidates, the base first, and an unknown cause by their error on unseen data.

    Each hypothesis expects an error: a named cause what is below notice and what another form of it may leave, an
    unknown one so much more. The likelihood falls with a power of the error beyond that. The numbers were set on some
    hundred and fifty blind plants of our own.
    """
    base = candidates[0].score
    sharpness = sharpness_of(base)
    has_stairs = base.at_rests is not None
    has_stops = stops_seen(candidates[0].fit)
    slips = np.array([makes_slips(each) for each in candidates])
    form = np.where(slips, FORM_SLIPS, FORM) if not has_stairs else np.full(len(slips), FORM_STAIRS)
    spared = [
        each.has_series or (slipping and not has_stairs) for each, slipping in zip(candidates, slips, strict=True)
    ]
    left, before, full = np.array(
        [errors_beyond_noise(each.score, base, spares=spares) for each, spares in zip(candidates, spared, strict=True)]
    ).T
    allowed = NOTICE + form * full
    evidence = -sharpness * np.log((left + allowed) / (before + allowed))
    # No effect has no form in which it could be missed, nor has a whole series of waves: only what is below notice
    # excuses it.
    formless = np.array([not each.effects or (each.has_series and not makes_slips(each)) for each in candidates])
    evidence -= sharpness * formless * np.log((1.0 + left / NOTICE) / (1.0 + left / allowed))
    if has_stops:
        # What explains the gap without them shows that they are but the short rests of a friction below notice.
        evidence -= COST_STOPS * np.array(
            [not can_stop(each) and not explains(each, candidates[0]) for each in candidates]
        )
    evidence = no_more_than_a_part(evidence, candidates)
    ends = [number for number, each in enumerate(candidates) if each.effects and explains(each, candidates[0])]
    felt = are_felt(candidates)
    lost = lost_behind([number for number in ends if felt[number]], candidates) + lost_by_imitation(candidates)
    support = evidence - lost + np.array([log_prior(each) for each in candidates])
    support[~felt] = -np.inf
    best = int(np.argmax(support))
    smooth = UNKNOWN_FORM_SERIES if candidates[best].has_series else UNKNOWN_FORM
    unknown_form = UNKNOWN_FORM_STAIRS if has_stairs else UNKNOWN_FORM_SLIPS if slips[best] else smooth
    # It is credited with no more than a known cause that leaves nothing to explain.
    least = min([best, *ends], key=lambda number: before[number])
    expected = (UNKNOWN_NOTICE + unknown_form * full[least]) / (NOTICE + form[best] * full[least] + before[least])
    unknown = SUPPORT_UNKNOWN - sharpness * math.log(expected)
    unknown -= NOTHING_LEFT * max(1.0 - left[least] / ALMOST_NOTHING, 0.0)
    named = np.logaddexp.reduce(support)
    share = min(math.exp(unknown - np.logaddexp(unknown, named)), SUREST_UNKNOWN)
    return Judgement((1.0 - share) * np.exp(support - named), share, evidence, lost)


def no_more_than_a_part(evidence: np.ndarray, candidates: Sequence[Candidate]) -> np.ndarray:
    """Return the evidence of causes, where one that comes no nearer than a part of it has no more than that part.

    What its further effect might be missed by in another form excuses nothing where that effect takes in nothing.
    """
    least = evidence.copy()
    for number, each in enumerate(candidates):
        parts = [
            evidence[other]
            for other, part in enumerate(candidates)
            if part.effects and set(part.effects) < set(each.effects) and misfit(part) <= misfit(each)
        ]
        least[number] = min([evidence[number], *parts])
    return least


def sharpness_of(base: Score) -> float:
    """Return the power of the error, less than the full one where few blocks are scored."""
    return min(SHARPNESS, BLOCK_WORTH * len(base.free.weighted))


def errors_beyond_noise(mine: Score, base: Score, *, spares: bool = False) -> tuple[float, float, float]:
    """Return the squared errors beyond the noise of a cause, and of the base with a guard and in full. [noise^2]

    What a cause gains over the base in the one block in time where it gains most does not count: what helps in a
    single one, such as the first after the start, is no effect of the valve. What it still misses there counts, and so
    does what the base misses where it is asked how much of that another form may leave. Of a load that varies at will
    the readings tell nothing while the stem rests, and whether a stem breaks away just before or after a reversal may
    hang by a hair: that `spares` the block where it misses most, of which the base's error does not count either. What
    is left of the whole record counts where it is more than of unseen data.
    """
    unseen = errors_on_some(mine, base, spares=spares)
    if mine.whole is None or base.whole is None:
        return unseen
    left, before, full = map(max, unseen, errors_on_some(mine.whole, base.whole, spares=spares))
    return left, before, full


def errors_on_some(mine: Score, base: Score, *, spares: bool) -> tuple[float, float, float]:
    """Return the errors that `errors_beyond_noise` does, on some samples. [noise^2]"""
    runs: Sequence[Errors] = mine.judged
    others: Sequence[Errors] = (base if mine.at_rests else Score(base.free, base.anchored)).judged
    if spares and len(runs[0].weighted) >= FEW_BLOCKS:
        worst = int(np.argmax(runs[0].weighted))
        runs, others = ([without_block(each, worst) for each in both] for both in (runs, others))
    left, full = excess(*(each.mean for each in runs)), excess(*(each.mean for each in others))
    if len(runs[0].weighted) < FEW_BLOCKS:
        return left, full, full
    best = int(np.argmax(others[0].weighted - runs[0].weighted))
    return left, excess(*(without_gain(one, other, best) for one, other in zip(runs, others, strict=True))), full


def without_gain(mine: Errors, base: Errors, block: int) -> float:
    """Return the mean weighted square of the base's run as if it had missed no more than a cause's in one block."""
    gain = max(float(base.weighted[block] - mine.weighted[block]), 0.0)
    return base.mean - gain / float(base.readings.sum())


def without_block(errors: Errors, block: int) -> Errors:
    """Return the errors of all blocks but one."""
    return replace(
        errors,
        squares=np.delete(errors.squares, block),
        weighted=np.delete(errors.weighted, block),
        counts=np.delete(errors.counts, block),
        readings=np.delete(errors.readings, block),
    )


def excess(one: float, other: float) -> float:
    """Return the squared error beyond the noise, of the geometric mean of two runs. [noise^2]"""
    return max(math.sqrt(one * other) - 1.0, 0.0)


def makes_slips(candidate: Candidate) -> bool:
    """Return whether a cause, which may be a sham one, makes the stem stop and jump."""
    return jumps(candidate.fit.model.effects)


def differ_by_law(candidate: Candidate, other: Candidate) -> bool:
    """Return whether two causes differ by the law alone by which the stem stops and jumps."""
    mine, theirs = (tuple(each.fit.model.effects) for each in (candidate, other))
    is_law = all(effect_of_key(key).breakaway for key in set(mine) ^ set(theirs))
    return is_law and differ_by_aliases(mine, theirs)


def reads_coarsely(candidate: Candidate) -> bool:
    """Return whether one of a cause's effects is read off the readings, as the steps in which they come are."""
    return any(effect_of_key(key).is_read_off for key in candidate.fit.model.effects)


def can_stop(candidate: Candidate) -> bool:
    """Return whether a cause can make the stem rest again and again on its way."""
    return any(effect_of_key(key).stops_again for key in candidate.fit.model.effects)


def lost_behind(ends: Sequence[int], candidates: Sequence[Candidate]) -> np.ndarray:
    """Return the log-likelihoods that causes lose against the nearest one of as many effects that explains the gap.

    What is below notice says nothing of whether there is another effect, but all causes miss that alike: of those that
    remain it is the right one that comes nearest, unless another comes nearer by more numbers, each of which takes in a
    part. A whole series of waves takes in most of it: what comes nearer by one more effect beside it counts as well,
    and what a few numbers bring to the noise is no series.

    Parameters
    ----------
    ends : sequence of int
        Numbers of the causes that explain the gap, and of which each effect is felt.
    candidates : sequence of Candidate
    """
    lost, others = np.zeros(len(candidates)), [candidates[end] for end in ends]

    def beyond(each: Candidate, other: Candidate) -> float:
        takes_most = misfit(other) < max(AT_NOISE, 1.0 + MOST_LEFT * (misfit(each) - 1.0))
        share = FORM_BESIDE if takes_most and not makes_slips(other) else 1.0
        nearer = NEARER if each.effects else NEARER_THAN_NONE
        return nearer + share * FORM * max(misfit(candidates[0]) - 1.0, 0.0)

    unit_of_form = float(np.clip(BEHIND_SHARE * misfit(candidates[0]), BEHIND, BEHIND_A_LAW))

    def behind(each: Candidate, other: Candidate, allowed: float, unit: float = BEHIND) -> float:
        is_coarse = reads_coarsely(each) or reads_coarsely(other)
        # The noise of a coarse reading is known from above only: which cause leaves less of it tells nothing.
        floor = 1.0 if is_coarse else 0.0
        unseen, fitted = (max(of(each), floor) - max(of(other), floor) for of in (misfit, left_of_fitted))
        if not (is_coarse or differ_by_law(each, other)):
            return (unseen - allowed) / unit
        # A hair may decide on what was kept back of slips or coarse steps: it lies behind in what was fitted as well.
        return (min(unseen, fitted) - allowed) / BEHIND_A_LAW

    for number, each in enumerate(candidates):
        losses = [
            behind(each, other, BEHIND * max(other.freedom - each.freedom, 0), unit_of_form)
            for other in others
            if (len(other.effects) == len(each.effects) and other.freedom <= each.freedom + MORE_NUMBERS)
            or (each.has_series and set(each.effects) < set(other.effects))
        ]
        losses += [
            behind(each, other, beyond(each, other)) for other in others if len(other.effects) == len(each.effects) + 1
        ]
        lost[number] = np.clip(max(losses, default=0.0), 0.0, MOST_BEHIND)
        if each.has_series and any(
            not other.has_series and misfit(other) < AT_NOISE and len(other.effects) <= len(each.effects) + 1
            for other in others
        ):
            lost[number] = MOST_BEHIND
    return lost


def lost_by_imitation(candidates: Sequence[Candidate]) -> np.ndarray:
    """Return the log-likelihoods that causes lose which may imitate another effect by a number that hides in the base.

    An effect that the base valve's numbers make up for has no form in which it could be missed. It is one more number
    for the effect beside it, which then comes near to what neither of them is; but seldom to a few hundredths of what
    that leaves by itself.
    """
    lost = np.zeros(len(candidates))
    beside = {frozenset(each.effects): misfit(each) for each in candidates}
    for number, each in enumerate(candidates):
        effects = [effect_of_key(key) for key in each.fit.model.effects]
        hidden = [one.key for one in effects if one.hides_in_base]
        if len(effects) > 1 and hidden and not any(one.is_jagged for one in effects):
            alone = min(beside.get(frozenset(each.effects) - {key}, 1.0) for key in hidden)
            allowed = max(IMITATES_FROM, 1.0 + IMITATES_SHARE * (alone - 1.0))
            lost[number] = np.clip((misfit(each) - allowed) / BEHIND, 0.0, MOST_IMITATED)
    return lost


def are_felt(candidates: Sequence[Candidate]) -> np.ndarray:
    """Return whether each effect of each cause changes the readings enough to be one, shape (c,).

    Less is enough where nothing simpler does: for a cause that explains the gap where none of fewer effects does.
    """
    ends = [explains(each, candidates[0]) for each in candidates]
    fewest = min((len(each.effects) for each, is_end in zip(candidates, ends, strict=True) if is_end), default=0)
    return np.array(
        [
            is_felt(each, LEAST_TRACE if is_end and len(each.effects) == fewest else LEAST_TRACE_MORE)
            for each, is_end in zip(candidates, ends, strict=True)
        ]
    )


def is_felt(candidate: Candidate, least_beside: float = LEAST_TRACE_MORE) -> bool:
    """Return whether each of a cause's effects changes the readings enough to be one, several by so much. [noise]"""
    return candidate.trace >= (LEAST_TRACE if len(candidate.effects) < 2 else least_beside)


def log_prior(candidate: Candidate) -> float:
    """Return the log prior of a cause, that of one effect without parameters being 0."""
    size = len(candidate.effects)
    if size == 0:
        return SUPPORT_NONE
    return -COST_MORE * (size - 1) ** 2 - COST_PARAMETER * candidate.freedom


def rivals_of(chosen: int, candidates: Sequence[Candidate], judgement: Judgement) -> list[tuple[str, ...]]:
    """Return the causes, of no more effects, whose error on unseen data is like the chosen one's.

    The most probable come first. The empty cause means the base alone. A cause that only adds to the chosen one is no
    rival. Beside no effect at all only those are that are declared to hide in the base: no record of current and
    position rules them out, while of others it shows that they are weak. Of these the nearest come first, however many
    numbers they take to hide.
    """
    base, mine = candidates[0], candidates[chosen]
    likely = judgement.probabilities if mine.effects else judgement.evidence
    evidence = judgement.evidence - judgement.lost if mine.effects else judgement.evidence
    felt = are_felt(candidates)
    found: list[int] = []
    for number, other in enumerate(candidates):
        if number == chosen or len(other.effects) > max(len(mine.effects), 1) or not felt[number]:
            continue
        if mine.effects and set(mine.effects) < set(other.effects):
            continue
        difference = abs(evidence[number] - evidence[chosen])
        is_alias = differ_by_aliases(mine.effects, other.effects)
        if not mine.effects and not is_alias:
            continue
        if is_alias and any(effect_of_key(key).is_chaotic for key in other.effects):
            # No search comes to the end of its error: that it lies behind says little.
            within = math.inf
        elif is_alias and explains(other, base) and explains(mine, base):
            within = WITHIN_FORM
        else:
            within = WITHIN_ERROR
        if difference < within:
            found.append(number)
    # At the noise all have the same evidence.
    found.sort(key=lambda number: (-likely[number], -judgement.evidence[number], misfit(candidates[number])))
    least = LEAST_RIVAL * judgement.probabilities[chosen] if mine.effects else -math.inf
    told = [number for number in found if judgement.probabilities[number] >= least]
    return [candidates[number].effects for number in told[:MOST_RIVALS]]
