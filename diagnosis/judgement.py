"""How sure: probabilities of all causes, of none and of an unknown one, and what a record cannot tell apart."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from diagnosis.score import Errors, closed_share
from diagnosis.selection import Candidate, explains
from valvemodel.effects import effect_of_key
from valvemodel.stages import EFFECTS

PRIOR_NONE = 0.4
PRIOR_ONE = 0.5
PRIOR_MORE = 0.1
"""Prior probability of no effect, of one, of several; each is shared by the causes of its size."""

FORM_ERROR = 0.1
"""Share of an effect's own trace by which a right effect in another form than ours may miss it."""

MOST_SAMPLES = 400.0
"""Samples that an error counts for at most: models are never right to the last of thousands."""

CLOSED_HALF = 0.65
CLOSED_WIDTH = 0.08
"""Share of the reducible gap at which a cause and an unknown one are equally probable, and how fast that changes."""

NOISE_REACHED = 1.15
"""Mean weighted square of the errors up to which nothing is left for an unknown cause."""

WITHIN_ERROR = 3.0
"""Log-likelihood within which two causes cannot be told apart."""

FEW_BLOCKS = 6
"""Scored blocks below which none can be spared."""

LEAST_TRACE = 0.3
"""Change of the readings, in units of the noise, below which a cause is the same model as without it."""

WITHIN_FORM = 8.0
"""The same for declared aliases that both explain the gap: they may differ by their form alone."""

MOST_RIVALS = 4


@dataclass(frozen=True)
class Judgement:
    """Probabilities of the candidates, in their order, and of an unknown cause; they sum to 1.

    `evidence` is the log-likelihood of each candidate, without its prior.
    """

    probabilities: np.ndarray
    unknown: float
    evidence: np.ndarray


def judge(candidates: Sequence[Candidate], floors: tuple[float, float]) -> Judgement:
    """Weigh all candidates, the base first, by their error on unseen data.

    Parameters
    ----------
    candidates : sequence of Candidate
    floors : (float, float) [m]
        Noise floor of the free and of the re-anchored run.
    """
    evidence = np.array([evidence_of(each, candidates) for each in candidates])
    support = evidence + np.array([log_prior(each) for each in candidates])
    support[np.array([each.trace < LEAST_TRACE for each in candidates])] = -np.inf
    weights = np.exp(support - support.max())
    weights /= weights.sum()
    likely = candidates[int(np.argmax(weights))]
    unknown = unknown_probability(likely, candidates[0], floors)
    return Judgement(weights * (1.0 - unknown), unknown, evidence)


def evidence_of(candidate: Candidate, candidates: Sequence[Candidate]) -> float:
    """Return the log-likelihood of a candidate, the mean of the two yardsticks'.

    The mean squared error counts above a part of the base's excess over the noise, the error of form that even the
    right effect may have; samples count as many as are independent, and not more than can be believed.
    """
    total = 0.0
    for yardstick in ("free", "anchored"):
        mine: Errors = getattr(candidate.score, yardstick)
        all_of_them: list[Errors] = [getattr(each.score, yardstick) for each in candidates]
        base = all_of_them[0]
        best = min(all_of_them, key=lambda each: each.mean)
        form_error = FORM_ERROR**2 * max(base.mean - 1.0, 0.0)
        samples = min(best.counts.sum() * best.signals / best.persistence, MOST_SAMPLES)
        total -= 0.25 * samples * math.log((lasting_mean(mine, base) + form_error) / (1.0 + form_error))
    return total


def lasting_mean(mine: Errors, base: Errors) -> float:
    """Return the mean weighted square as it would be without the one block in time that gains most over the base.

    What helps in a single block, such as the first after the start, is no effect of the valve.
    """
    if len(mine.weighted) < FEW_BLOCKS:
        return mine.mean
    rest = np.arange(len(mine.weighted)) != int(np.argmax(base.weighted - mine.weighted))
    return float(base.mean * mine.weighted[rest].sum() / base.weighted[rest].sum())


def log_prior(candidate: Candidate) -> float:
    """Return the logarithm of a cause's prior probability, a penalty for each free parameter included."""
    count = len(EFFECTS)
    size = len(candidate.effects)
    if size == 0:
        return math.log(PRIOR_NONE)
    share = PRIOR_ONE / count if size == 1 else PRIOR_MORE ** (size - 1) / math.comb(count, size)
    return math.log(share) - 0.5 * candidate.freedom


def unknown_probability(likely: Candidate, base: Candidate, floors: tuple[float, float]) -> float:
    """Return the probability that no candidate is the cause, from what the most probable leaves of the gap.

    The yardstick that is kinder to it counts: a right stick-slip model loses its phase in a free run.
    """
    if likely.score.misfit < NOISE_REACHED:
        return 0.005
    closed = max(
        closed_share(base.score.free.rms, likely.score.free.rms, floors[0]) or 0.0,
        closed_share(base.score.anchored.rms, likely.score.anchored.rms, floors[1]) or 0.0,
    )
    return float(np.clip(1.0 / (1.0 + math.exp((closed - CLOSED_HALF) / CLOSED_WIDTH)), 0.005, 0.995))


def rivals_of(chosen: int, candidates: Sequence[Candidate], judgement: Judgement) -> list[tuple[str, ...]]:
    """Return the causes, of no more effects, whose error on unseen data is like the chosen one's.

    The empty cause means the base alone. A cause that only adds to the chosen one is no rival.
    """
    base, mine = candidates[0], candidates[chosen]
    found: list[tuple[float, tuple[str, ...]]] = []
    for number, other in enumerate(candidates):
        if number == chosen or len(other.effects) > max(len(mine.effects), 1) or other.trace < LEAST_TRACE:
            continue
        if mine.effects and set(mine.effects) < set(other.effects):
            continue
        difference = abs(judgement.evidence[number] - judgement.evidence[chosen])
        is_alias = are_aliases(mine.effects, other.effects) and explains(other, base) and explains(mine, base)
        if difference < (WITHIN_FORM if is_alias else WITHIN_ERROR):
            found.append((-judgement.evidence[number], other.effects))
    return [effects for _, effects in sorted(found)][:MOST_RIVALS]


def are_aliases(effects: tuple[str, ...], others: tuple[str, ...]) -> bool:
    """Return whether two causes differ by one effect for which the other is declared to come close."""
    mine, theirs = set(effects) - set(others), set(others) - set(effects)
    if len(mine) != 1 or len(theirs) != 1:
        return False
    (one,), (other,) = mine, theirs
    return other in effect_of_key(one).aliases or one in effect_of_key(other).aliases
