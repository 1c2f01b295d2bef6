"""The data behind the report's pictures of a stem alone, taken from its diagnosis."""

from __future__ import annotations

import numpy as np

from diagnosis.picture import evidence_of
from diagnosis.report import Evidence, RecordEvidence
from diagnosis.stem.diagnosing import StemOnlyDiagnosis
from identification.inverse_dynamics.fit import nominal_residual


def evidence_of_stem(diagnosis: StemOnlyDiagnosis) -> Evidence:
    """Return what the pictures of a stem's diagnosis show."""
    records = [record_evidence(diagnosis, number) for number in range(len(diagnosis.joined.names))]
    return evidence_of(diagnosis, records, unit="N")


def record_evidence(diagnosis: StemOnlyDiagnosis, number: int) -> RecordEvidence:
    """Return the forces of one record, decimated; a missing sample stands where the stem rests."""
    joined = diagnosis.joined
    signals, is_own = joined.signals, joined.owner == number
    row_time = signals.row_time[is_own]
    gaps = np.flatnonzero(np.diff(row_time) > 1.5 * signals.row_interval) + 1

    def shown(values: np.ndarray) -> np.ndarray:
        return np.insert(values[is_own], gaps, np.nan)

    force = signals.row_force
    direction = np.sign(signals.decimate(signals.velocity))
    start = row_time[0] if number else 0.0
    return RecordEvidence(
        name=joined.names[number],
        time=np.insert(row_time, gaps, row_time[gaps - 1] + signals.row_interval) - start,
        current=None,
        measured=shown(force),
        as_given=shown(force - nominal_residual(signals, diagnosis.given.values)),
        refitted=shown(force - diagnosis.base_fit.residual),
        with_cause=shown(force - diagnosis.found_fit.residual) if diagnosis.cause.effects else None,
        held_out=np.full(len(row_time) + len(gaps), number == len(joined.names) - 1),
        mode=np.nan_to_num(shown(direction)).astype(int),
        position=shown(signals.decimate(signals.position)),
    )
