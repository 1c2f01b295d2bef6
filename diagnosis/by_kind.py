"""Diagnose records of either kind: of current and position, or of force and position, the stem alone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from diagnosis.diagnosing import diagnose as diagnose_valve
from diagnosis.valve_diagnosis import Diagnosis
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.progress import Progress, tell_nobody
from valvemodel.records import Record
from valvemodel.records.several import check_one_kind
from valvemodel.valves import read_valve

if TYPE_CHECKING:
    from diagnosis.stem.diagnosing import StemOnlyDiagnosis


def diagnose(
    records: Record | Sequence[Record],
    model: Model | None = None,
    *,
    candidates: Sequence[str] | None = None,
    jobs: int | None = None,
    progress: Progress = tell_nobody,
) -> Diagnosis | StemOnlyDiagnosis:
    """Find where and why a valve and its model disagree.

    Parameters
    ----------
    records : Record or sequence of Record
        Of one valve, all of one kind: time records, settled loops or of the stem alone. With one, blocks in time are
        kept back to score on; with several, the last record.
    model : Model
        The valve as given, by default the set `calibrated`; its base parameters are where the refit begins.
    candidates : sequence of str or None
        Keys of the effects that may be the cause; by default all that the records can show.
    jobs : int or None
        Processes; by default one a core.
    progress : callable
        Called with what is being done and a share of it from 0 to 1.

    Returns
    -------
    Diagnosis or StemOnlyDiagnosis
        The latter where the records have force instead of current.

    Raises
    ------
    InputError
        If there is no record or they are of several kinds, a candidate is no effect or chosen for a stem alone, none of
        them can show in the records, or a single record is too short to keep a part back.
    """
    records = [records] if isinstance(records, Record) else list(records)
    check_one_kind(records)
    if model is None:
        valve = read_valve("calibrated")
        model = Model(valve.name, valve.values)
    if records[0].kind != "stem":
        return diagnose_valve(records, model, candidates=candidates, jobs=jobs, progress=progress)
    if candidates is not None:
        raise InputError("candidates are chosen for records with current", "these have force", "leave them out")
    from diagnosis.stem.diagnosing import diagnose_stem_records

    return diagnose_stem_records(records, model, progress=progress)
