"""Causes of a stem's gap, scored on what their fits had not seen: blocks in time, or another record."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from diagnosis.causes import Cause
from diagnosis.score import Errors, closed_interval, closed_share, persistence_of
from diagnosis.stem.records import Joined
from identification.inverse_dynamics import ScoredCause, StemDiagnosis, StemFit, fit_stem
from identification.inverse_dynamics.diagnose import (
    NOTICE_RMS,
    NOTICE_SHARE,
    PARAMETER_PENALTY,
    UNKNOWN_AT,
    UNKNOWN_FROM,
)
from identification.inverse_dynamics.fit import blocks_of, root_mean_square

NEGLIGIBLE = 1e-9
"""Share of the base model's error below which an error is as good as none."""

NOTHING_LEFT = 1e-5
"""Share of the force below which an error is that of differentiation and no gap."""

Effects = tuple[str, ...]


@dataclass(frozen=True)
class Scored:
    """Causes, the most probable first, with their fits to all records."""

    verdict: str
    causes: list[Cause]
    fits: dict[Effects, StemFit]
    unknown: float
    floor: float


def scored_on_blocks(diagnosis: StemDiagnosis) -> Scored:
    """Return the causes of one record as they were scored on the blocks that a fit had not seen."""
    blocks = np.unique(blocks_of(diagnosis.signals), return_inverse=True)[1]
    counts = np.bincount(blocks)
    listed = [each for each in diagnosis.causes if each.fit.is_admissible or not each.effects]
    causes = []
    for each in listed:
        squares = each.block_errors * counts
        persistence = max(1.0, persistence_of(each.fit.residual))
        causes.append(
            Cause(
                effects=each.effects,
                probability=each.probability,
                errors=Errors(squares, squares, counts, counts, persistence),
                parameters=parameters_of(each.fit),
                closed=each.gap_closed,
                closed_interval=each.gap_closed_interval,
                rivals=list(each.indistinguishable_from),
            )
        )
    fits = {each.effects: each.fit for each in listed}
    force = root_mean_square(diagnosis.signals.row_force)
    return judged(causes, fits, diagnosis.unknown_probability, diagnosis.gap.noise_floor, force)


def scored_on_other(diagnosis: StemDiagnosis, joined: Joined) -> Scored:
    """Score the causes that the other records call for on the last one, and weigh them by it alone."""
    listed = [each for each in diagnosis.causes if not each.effects or not each.is_below_notice]
    signals, is_scored, has_spring = joined.signals, joined.is_scored, diagnosis.has_spring
    scores, fits = {}, {}
    for each in listed:
        unseen = fit_stem(signals, effects=each.effects, train=joined.is_fitted, has_spring=has_spring)
        scores[each.effects] = errors_of_rows(unseen.residual[is_scored], blocks_of(signals)[is_scored])
        fits[each.effects] = fit_stem(signals, effects=each.effects, has_spring=has_spring)
    floor = min(diagnosis.gap.noise_floor, *(score.rms for score in scores.values()))
    weights, unknown = weigh(listed, scores, floor)
    causes = [
        Cause(
            effects=each.effects,
            probability=weights[each.effects],
            errors=scores[each.effects],
            parameters=parameters_of(fits[each.effects]),
            closed=closed_share(scores[()].rms, scores[each.effects].rms, floor),
            closed_interval=closed_interval(scores[()], scores[each.effects], floor),
            rivals=list(each.indistinguishable_from),
        )
        for each in listed
        if fits[each.effects].is_admissible or not each.effects
    ]
    total = sum(cause.probability for cause in causes) + unknown
    causes = [replace(cause, probability=cause.probability / total) for cause in causes]
    return judged(causes, fits, unknown / total, floor, root_mean_square(signals.row_force))


def judged(causes: Sequence[Cause], fits: dict[Effects, StemFit], unknown: float, floor: float, force: float) -> Scored:
    """Sort causes and say the verdict.

    Where the base comes down to the noise, a cause that is not clearly better leaves its probability to it: a
    wrong name is worse than none. Where it leaves nothing to speak of beside the force, every cause does.
    """
    base = next(cause for cause in causes if not cause.effects)
    is_perfect = base.errors.rms < NOTHING_LEFT * force
    if is_perfect:
        unknown = 0.0
    if is_perfect or base.errors.rms < UNKNOWN_FROM * floor:
        kept = [each for each in causes if each.effects and not is_perfect and () not in each.rivals]
        rest = 1.0 - unknown - sum(each.probability for each in kept)
        causes = [
            each if any(each is one for one in kept) else replace(each, probability=0.0 if each.effects else rest)
            for each in causes
        ]
    order = sorted(causes, key=lambda cause: (-cause.probability, cause.errors.rms))
    best = order[0]
    verdict = "unknown" if unknown > best.probability else ("effect" if best.effects else "none")
    return Scored(verdict, order, fits, unknown, floor)


def errors_of_rows(errors: np.ndarray, blocks: np.ndarray) -> Errors:
    """Score errors by block. [N]"""
    numbers = np.unique(blocks, return_inverse=True)[1]
    squares = np.bincount(numbers, errors**2)
    counts = np.bincount(numbers)
    return Errors(squares, squares, counts, counts, max(1.0, persistence_of(errors)))


def weigh(
    listed: Sequence[ScoredCause], scores: Mapping[Effects, Errors], floor: float
) -> tuple[dict[Effects, float], float]:
    """Return the probability of each cause and of an unknown one, from another record's errors.

    The likelihood, the penalty, the least gain and the bounds of `unknown` are those of `diagnose_stem`.
    """
    base = scores[()]
    best = max(min(score.rms for score in scores.values()), NEGLIGIBLE * base.rms, math.ulp(0.0))
    least = max(NOTICE_SHARE * (base.rms - floor), NOTICE_RMS * base.rms)
    support = {}
    for each in listed:
        score = scores[each.effects]
        samples = float(score.counts.sum()) / score.persistence
        is_worth = not each.effects or base.rms - score.rms >= least
        value = -0.5 * samples * (score.rms / best) ** 2 - PARAMETER_PENALTY * each.parameter_count
        support[each.effects] = value if is_worth else -math.inf
    highest = max(support.values())
    weights = {effects: math.exp(value - highest) for effects, value in support.items()}
    total = sum(weights.values())
    weights = {effects: weight / total for effects, weight in weights.items()}
    excess = (base.rms / floor - UNKNOWN_FROM) / (UNKNOWN_AT - UNKNOWN_FROM) if floor > 0.0 else 1.0
    unknown = weights[()] * min(max(excess, 0.0), 1.0)
    weights[()] -= unknown
    return weights, unknown


def plain(estimates: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return estimates as the JSON has them."""
    return {
        name: {
            "value": float(each.value),
            "unit": each.unit,
            "std": None if each.std is None else float(each.std),
        }
        for name, each in estimates.items()
    }


def parameters_of(fit: StemFit) -> dict[str, dict[str, dict[str, Any]]]:
    """Return the parameters of a fit's effects."""
    return {key: plain(estimates) for key, estimates in fit.by_effect().items()}
