"""Stages: how probable it is that the gap lies in each, and which ones a record leaves open."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from diagnosis.judging.judgement import Judgement
from diagnosis.trying.candidates import Candidate
from diagnosis.whereabouts.own_signals import Explained
from identification.starting.hints import coarsest_grid
from valvemodel.declarations import STAGES
from valvemodel.effects import are_aliases, effect_of_key
from valvemodel.stages import EFFECTS

ALIKE = 4.0
"""What an effect hints at the stages of those like it, over what it hints at its own: it was tried and fell short."""

NEAREST = 6.0
"""Power by which the effects that come nearest hint more than those that hardly help. Set, with the numbers above and
below, on 152 blind plants of our own whose effect was no candidate."""

FOREHAND = 1.0
"""What all stages together hint at beforehand; an effect that halves the error in root mean square hints at 1.4."""

OWN_NOTICE, OWN_SHARPNESS = 0.3, 1.5
"""Squared error that a stage's own signals may leave, and the power by which more speaks against it. [noise^2] Set on
27 blind plants of our own without a cause, 8 of which had other stages before."""

MOST_OPEN = 2
"""Stages that an unknown cause is said to lie in."""


def stage_probabilities(
    verdict: str,
    candidates: Sequence[Candidate],
    judgement: Judgement,
    measured: Sequence[tuple[tuple[str, ...], float]] = (),
    explained: Sequence[Explained] = (),
) -> dict[str, float]:
    """Return the probability that the gap lies in each stage; the rest to 1 is that of no effect.

    A cause of several stages counts in each by its share, an unknown cause by what resembles it. Where the verdict is
    an unknown cause, it is that one which is placed: what came nearest is not it, and says nothing for its own stage.

    Parameters
    ----------
    verdict : str
    candidates : sequence of Candidate
    judgement : Judgement
    measured : sequence of (stages, share)
        Parts of the chain between measured signals, with the share of the gap that arises in each: what the unknown
        cause resembles is only asked within a part.
    explained : sequence of Explained
        What each stage explains by its own signals, where that was asked: the less it leaves, the more probable it is.
    """
    hints = with_own_signals(resemblance(candidates), explained)
    unknown = 1.0 if verdict == "unknown" else judgement.unknown
    shares = {stage: unknown * hint for stage, hint in hints.items()}
    for stages, share in measured:
        within = sum(hints[stage] for stage in stages)
        shares |= {stage: unknown * share * hints[stage] / within for stage in stages}
    if verdict == "unknown":
        return shares
    for candidate, probability in zip(candidates, judgement.probabilities, strict=True):
        for key in candidate.effects:
            shares[effect_of_key(key).stage] += float(probability) / len(candidate.effects)
    return shares


def resemblance(candidates: Sequence[Candidate]) -> dict[str, float]:
    """Return how much the gap resembles the effects of each stage, as shares of 1.

    An effect alone hints at its stage by the logarithm of how far it brings the error down, those that come nearest
    most of all, and more at the stages of the effects that are declared to look like it, or it like them: it was tried
    and fell short, so that what it stands in for is rather one of these. A load in waves hints at nothing: it takes in
    whatever goes with time. Where nothing helps, a stage counts by the number of effects that are known in it. Coarse
    steps that the readings themselves show hint at the sensor by what they leave, as what looks like a cause that was
    not tried.
    """
    hints = {stage: FOREHAND * sum(effect.stage == stage for effect in EFFECTS) / len(EFFECTS) for stage in STAGES}
    base = candidates[0].score.misfit
    single = [each for each in candidates if len(each.effects) == 1 and not each.has_series]
    alone = {each.effects[0]: hinted(base, each.score.misfit) for each in single}
    by_steps = hinted(base, base - left_by_steps(candidates[0]))
    most = max([by_steps, *alone.values()])

    def weight(hint: float) -> float:
        return hint * (hint / most) ** (NEAREST - 1.0) if most > 0.0 else 0.0

    for key, hint in alone.items():
        effect = effect_of_key(key)
        hints[effect.stage] += weight(hint)
        alike = {other.stage for other in EFFECTS if other is not effect and are_aliases(key, other.key)}
        for stage in alike or {effect.stage}:
            hints[stage] += ALIKE * weight(hint) / max(len(alike), 1)
    hints["sensor"] += ALIKE * weight(by_steps)
    total = sum(hints.values())
    return {stage: hint / total for stage, hint in hints.items()}


def with_own_signals(hints: dict[str, float], explained: Sequence[Explained]) -> dict[str, float]:
    """Return hints at the stages as shares of 1, those that were asked weighed by what their own signals leave."""
    weighed = {each.stage: hints[each.stage] * (OWN_NOTICE + each.excess) ** -OWN_SHARPNESS for each in explained}
    asked, total = sum(hints[stage] for stage in weighed), sum(weighed.values())
    return hints | {stage: asked * weight / total for stage, weight in weighed.items()}


def hinted(before: float, left: float) -> float:
    """Return the logarithm of how far an error comes down, at most to the noise. [noise^2]"""
    return max(math.log(before / max(left, 1.0)), 0.0)


def left_by_steps(base: Candidate) -> float:
    """Return the mean square that the coarse steps of the readings leave. [noise^2]"""
    experiments = base.fit.problem.experiments
    return float(np.mean([coarsest_grid(each)[0] ** 2 / 12.0 / each.noise**2 for each in experiments]))


def open_stages(verdict: str, probabilities: dict[str, float], causes: Sequence[tuple[str, ...]]) -> list[str]:
    """Return the stages in which the cause may lie as far as the record tells, the most probable first.

    Parameters
    ----------
    verdict : str
    probabilities : dict
        Of the stages.
    causes : sequence of tuple of str
        The cause that is named, those that it cannot be told from, and what looks alike but was no candidate.
    """
    order = sorted(probabilities, key=lambda stage: -probabilities[stage])
    if verdict == "unknown":
        return order[:MOST_OPEN]
    own = stages_of(causes)
    return [stage for stage in order if stage in own]


def stages_of(causes: Iterable[tuple[str, ...]]) -> set[str]:
    """Return the stages of the effects of causes."""
    return {effect_of_key(key).stage for effects in causes for key in effects}
