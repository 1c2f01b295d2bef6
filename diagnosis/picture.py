"""The data behind the report's pictures, as far as every diagnosis has them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from diagnosis.causes import Cause
from diagnosis.report import Evidence, Rank, RecordEvidence, Step
from diagnosis.told import Told
from valvemodel.effects import effect_of_key


def evidence_of(
    diagnosis: Told,
    records: Iterable[RecordEvidence],
    *,
    unit: str,
    next_input: tuple[np.ndarray, np.ndarray] | None = None,
) -> Evidence:
    """Return what the pictures of a diagnosis show, beside its records, the unit of its gap, and what comes next."""
    return Evidence(
        records=tuple(records),
        steps=tuple(Step(label, rms) for label, rms in diagnosis.steps),
        ranking=ranking_of(diagnosis.causes),
        noise_floor=diagnosis.floor,
        unit=unit,
        seconds=diagnosis.seconds,
        valve_name=diagnosis.given.name,
        warnings=diagnosis.warnings,
        next_input=next_input,
    )


def ranking_of(causes: Sequence[Cause]) -> tuple[Rank, ...]:
    """Return the candidates with the 95 % interval of their gap, in the order of the causes."""
    ranking = []
    for cause in causes:
        rms = cause.errors.rms
        half = 1.96 * rms * math.sqrt(0.5 * cause.errors.persistence / cause.errors.counts.sum())
        label = " + ".join(effect_of_key(key).title for key in cause.effects) or "none: base refitted"
        ranking.append(Rank(label, cause.effects, rms, max(rms - half, 0.0), rms + half, cause.probability))
    return tuple(ranking)
