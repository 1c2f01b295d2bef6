"""What all that was tried comes to: the verdict, the cause that is shown, and the gap that each leaves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from diagnosis.causes import Cause, steps_of
from diagnosis.judging.judgement import Judgement, judge, rivals_of
from diagnosis.score import Errors, closed_interval, closed_share
from diagnosis.trying.candidates import Candidate
from identification.determined.uncertainty import Estimate
from identification.fit import Fit
from identification.holdout import Holdout
from valvemodel.effects import effect_of_key, jumps


@dataclass(frozen=True)
class Finding:
    """What all that was tried comes to.

    Attributes
    ----------
    tried : list of Candidate
        The base first.
    judgement : Judgement
    verdict : str
        `effect`, `none` or `unknown`.
    order : list of int
        The numbers of what was tried, in the order of telling.
    yardstick : str
        How the gap is measured: by a `free` run or by one `anchored` on the readings.
    floor : float [m]
        Of the gap.
    """

    tried: list[Candidate]
    judgement: Judgement
    verdict: str
    order: list[int]
    yardstick: str
    floor: float

    @property
    def shown(self) -> Candidate:
        """The cause that is shown."""
        return self.tried[self.order[0]]

    @property
    def refitted(self) -> Errors:
        """Errors of the refitted base."""
        return self.errors_of(self.tried[0])

    def errors_of(self, candidate: Candidate) -> Errors:
        """Return the errors of a cause by the yardstick."""
        errors: Errors = getattr(candidate.score, self.yardstick)
        return errors

    def causes(self) -> list[Cause]:
        """Return all that was tried as causes, in the order of telling."""
        return [self._cause(number) for number in self.order]

    def _cause(self, number: int) -> Cause:
        candidate = self.tried[number]
        errors = self.errors_of(candidate)
        return Cause(
            effects=candidate.effects,
            probability=float(self.judgement.probabilities[number]),
            errors=errors,
            parameters=plain_parameters(candidate.fit),
            closed=closed_share(self.refitted.rms, errors.rms, self.floor),
            closed_interval=closed_interval(self.refitted, errors, self.floor),
            rivals=rivals_of(number, self.tried, self.judgement),
        )

    def steps(self, as_given: Errors) -> list[tuple[str, float]]:
        """Return the gap step by step, from the model as given to the noise. [m]"""
        left = [(each.effects, self.errors_of(each).rms) for each in self.tried]
        return steps_of(as_given.rms, left, self.shown.effects, self.floor)


def finding_of(tried: list[Candidate], holdout: Holdout) -> Finding:
    """Return what all that was tried comes to, the base first."""
    judgement = judge(tried)
    verdict, order = verdict_of(tried, judgement), order_of(tried, judgement)
    if verdict == "unknown":
        # What came nearest is not the cause, and a load that was found for these records is none of the next one's.
        order.sort(key=lambda number: tried[number].has_series)
    yardstick = yardstick_of(tried[order[0]])
    return Finding(tried, judgement, verdict, order, yardstick, floor_of(tried, holdout, yardstick))


def verdict_of(candidates: Sequence[Candidate], judgement: Judgement) -> str:
    """Return `unknown` where that has most of the probability, else `effect` or `none`, as the most probable cause is.

    Many effects that each come a little nearer than none, and none of them nearer than the others, name nothing.
    """
    is_effect = np.array([bool(each.effects) for each in candidates])
    known = max(float(judgement.probabilities[each].sum()) for each in (is_effect, ~is_effect))
    if judgement.unknown > known:
        return "unknown"
    return "effect" if candidates[order_of(candidates, judgement)[0]].effects else "none"


def order_of(candidates: Sequence[Candidate], judgement: Judgement) -> list[int]:
    """Return the numbers of all that was tried: the most probable first, the nearer first where equally probable."""
    return sorted(
        range(len(candidates)), key=lambda number: (-judgement.probabilities[number], candidates[number].score.misfit)
    )


def yardstick_of(likely: Candidate) -> str:
    """Return how the gap is measured: re-anchored where the stem sticks and slips, as a free run loses the phase."""
    return "anchored" if jumps(likely.effects) else "free"


def floor_of(candidates: Sequence[Candidate], holdout: Holdout, yardstick: str) -> float:
    """Return the floor of the gap: what noise leaves of the readings, or the best fit's error. [m]"""
    best = min(getattr(each.score, yardstick).rms for each in candidates)
    return min(holdout.floor, best)


def plain_parameters(fit: Fit) -> dict[str, dict[str, dict[str, Any]]]:
    """Return the parameters of a fit's effects without uncertainty."""
    return {
        key: {
            each.name: {"value": values[each.name], "unit": each.unit, "std": None}
            for each in effect_of_key(key).parameters
            if np.isfinite(values[each.name]) and not (each.is_higher and values[each.name] == each.neutral)
        }
        for key, values in fit.model.effects.items()
    }


def with_parameters(cause: Cause, fit: Fit, told: Sequence[Estimate]) -> Cause:
    """Return a cause with the parameters of the fit to all data and their uncertainty."""
    parameters = plain_parameters(fit)
    for estimate in told:
        for values in parameters.values():
            if estimate.name in values:
                values[estimate.name]["std"] = estimate.std
    return replace(cause, parameters=parameters)
