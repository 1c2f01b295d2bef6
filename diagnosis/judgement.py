"""How sure: probabilities of all causes, of none and of an unknown one, and what a record cannot tell apart."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from diagnosis.selection import Candidate, signals, total
from valvemodel.effects import effect_of_key
from valvemodel.stages import EFFECTS

PRIOR_NONE = 0.4
PRIOR_ONE = 0.5
PRIOR_MORE = 0.1
"""Prior probability of no effect, of one, of several; each is shared by the causes of its size."""

LEAST_GAIN = 0.012
"""Share by which the error must fall for an effect to be worth naming: below it lie the simplifications of any model."""

CLOSED_HALF = 0.72
CLOSED_WIDTH = 0.07
"""Share of the reducible gap at which a cause and an unknown one are equally probable, and how fast that changes."""

WITHIN_ERROR = 3.0
"""Log-likelihood within which two causes cannot be told apart."""


@dataclass(frozen=True)
class Judgement:
    """Probabilities of the candidates, in their order, and of an unknown cause; they sum to 1."""

    probabilities: np.ndarray
    unknown: float
    support: np.ndarray


def judge(candidates: Sequence[Candidate], floor: float) -> Judgement:
    """Weigh all candidates, the base first, by their error on unseen data.

    The squared error is a log-likelihood once it is divided by how far the best exceeds the noise and by how many
    samples count as one; priors share out the probability of each number of effects.

    Parameters
    ----------
    candidates : sequence of Candidate
    floor : float [m]
        Noise of the scored readings.
    """
    totals = np.array([total(each) for each in candidates])
    base = candidates[0]
    best = candidates[int(np.argmin(totals))]
    samples = float(best.score.counts.sum()) * signals(best)
    excess = max(totals.min() / samples, 1.0) * best.score.persistence
    support = -0.5 * totals / excess + np.array([log_prior(each) for each in candidates])
    worth = np.array([not each.effects or each.score.rms < (1.0 - LEAST_GAIN) * base.score.rms or gains_pressure(each, base) for each in candidates])
    support = np.where(worth, support, -np.inf)
    weights = np.exp(support - support.max())
    weights /= weights.sum()
    unknown = unknown_probability(candidates, weights, floor)
    return Judgement(weights * (1.0 - unknown), unknown, support)


def gains_pressure(candidate: Candidate, base: Candidate) -> bool:
    """Return whether a cause lowers the weighted error of position and pressure enough to be worth naming."""
    return total(candidate) < (1.0 - LEAST_GAIN) ** 2 * total(base)


def log_prior(candidate: Candidate) -> float:
    """Return the logarithm of a cause's prior probability, a penalty for each free parameter included."""
    count = len(EFFECTS)
    size = len(candidate.effects)
    if size == 0:
        return math.log(PRIOR_NONE)
    share = PRIOR_ONE / count if size == 1 else PRIOR_MORE / math.comb(count, size)
    return math.log(share) - 0.5 * candidate.freedom


def unknown_probability(candidates: Sequence[Candidate], weights: np.ndarray, floor: float) -> float:
    """Return the probability that none of the candidates is the cause, from what they leave of the reducible gap."""
    base = candidates[0].score.rms
    likely = candidates[int(np.argmax(weights))]
    mean = total(likely) / (likely.score.counts.sum() * signals(likely))
    if mean < 1.0 + 4.0 * math.sqrt(2.0 / likely.score.counts.sum()) + 0.05:
        return 0.005
    reducible = base - floor
    closed = (base - likely.score.rms) / reducible if reducible > 0.0 else 0.0
    return float(np.clip(1.0 / (1.0 + math.exp((closed - CLOSED_HALF) / CLOSED_WIDTH)), 0.005, 0.995))


def rivals_of(chosen: int, candidates: Sequence[Candidate], judgement: Judgement) -> list[tuple[str, ...]]:
    """Return the causes, of no more effects, whose error on unseen data lies within the error of the chosen one.

    The empty cause means the base alone. A cause that only adds to the chosen one is no rival.
    """
    mine = candidates[chosen]
    found: list[tuple[float, tuple[str, ...]]] = []
    for number, other in enumerate(candidates):
        if number == chosen or len(other.effects) > max(len(mine.effects), 1) or not is_present(other):
            continue
        if set(mine.effects) < set(other.effects):
            continue
        difference = other.score.weighted - mine.score.weighted
        spread = math.sqrt(len(difference)) * float(np.std(difference)) + 1e-12
        close = bool(judgement.support[chosen] < judgement.support[number] + WITHIN_ERROR)
        if close or float(difference.sum()) < 2.0 * spread and not other.effects == () and is_near(other, mine):
            found.append((total(other), other.effects))
    return [effects for _, effects in sorted(found)][:4]


def is_near(other: Candidate, mine: Candidate) -> bool:
    """Return whether the error of a cause is within a few hundredths of another's."""
    return other.score.rms < 1.03 * mine.score.rms


def is_present(candidate: Candidate) -> bool:
    """Return whether each effect of a cause is away from its neutral value."""
    for key, values in candidate.fit.model.effects.items():
        effect = effect_of_key(key)
        if all(values[each.name] == each.neutral for each in effect.fitted) and effect.fitted:
            return False
    return True
