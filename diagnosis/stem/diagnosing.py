"""Diagnose records of force and position: the stem alone by inverse dynamics, told as any diagnosis."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from diagnosis.causes import steps_of
from diagnosis.stem.records import Joined, check_kind, join, prepared
from diagnosis.stem.regimes import regimes_of_rows
from diagnosis.stem.scoring import plain, scored_on_blocks, scored_on_other
from diagnosis.told import Told
from identification.inverse_dynamics import StemDiagnosis, StemFit, diagnose_stem
from identification.inverse_dynamics.fit import nominal_residual, root_mean_square
from valvemodel.declarations import STAGES
from valvemodel.effects import effect_of_key
from valvemodel.errors import InputError
from valvemodel.model import Model, check_valve
from valvemodel.progress import Progress, tell_nobody
from valvemodel.records import Record

if TYPE_CHECKING:
    from diagnosis.report import Evidence

STAGE = "stem"
"""Nothing else is in a record of force and position."""


@dataclass(frozen=True, eq=False, repr=False)
class StemOnlyDiagnosis(Told):
    """All that a diagnosis of the stem alone found, in SI units; the gap is one of force.

    Attributes
    ----------
    as_given : float [N]
        Root mean square error of the given valve on the scored samples.
    base_fit, found_fit : StemFit
        To all records: the base model, and the best cause.
    joined : Joined
        The signals of all records.
    """

    as_given: float
    scored_on: str
    base: Model
    found: Model
    base_fit: StemFit
    found_fit: StemFit
    joined: Joined

    @property
    def models(self) -> dict[str, Model]:
        """The refitted base and the found model, by the names of their files."""
        return {"base.json": self.base, "model.json": self.found}

    def as_json(self) -> dict[str, Any]:
        """Return the content of diagnosis.json."""
        return {
            **self._content(),
            "gap": {
                "unit": "N",
                "as_given": self.as_given,
                "refitted": self.refitted.rms,
                "with_cause": self.cause.errors.rms,
                "noise_floor": self.floor,
                "scored_on": self.scored_on,
            },
            "base": {
                "name": self.base.name,
                "file": "base.json",
                "parameters": plain(self.base_fit.parameters),
            },
            "records": list(self.joined.names),
            "warnings": list(self.warnings),
            "seconds": self.seconds,
        }

    def evidence(self) -> Evidence:
        """Return what the pictures show."""
        from diagnosis.stem.picture import evidence_of_stem

        return evidence_of_stem(self)


def diagnose_stem_records(
    records: Sequence[Record],
    model: Model,
    *,
    progress: Progress = tell_nobody,
) -> StemOnlyDiagnosis:
    """Find which effect the stem of a valve lacks, from force and position.

    Parameters
    ----------
    records : sequence of Record
        Of one stem: time [s], force [N], position [m], no current. With one, blocks in time are held out in
        turn; with several, the last record is scored on, and the others are laid end to end: a drift or a
        periodic load is taken to run on from one to the next.
    model : Model
        The valve as given: what the gap as given is of, and what the found model keeps where such records say
        nothing (diaphragm, nozzle, electromagnet).
    progress : callable
        Called with what is being done and a share of it from 0 to 1.

    Returns
    -------
    StemOnlyDiagnosis

    Raises
    ------
    InputError
        If a record has a current, lacks a signal, or does not move both ways; if sampling intervals differ.
    """
    began = time.perf_counter()
    check_kind(records)
    progress("filtering force and position", 0.0)
    each = prepared(records)
    joined = join([record.name for record in records], each)
    progress("effects of the stem one by one and in pairs", 0.1)
    diagnosis = diagnose_stem(joined.signals if len(each) == 1 else join([], each[:-1]).signals)
    if len(each) == 1:
        scored = scored_on_blocks(diagnosis)
    else:
        progress("scoring on the last record", 0.7)
        scored = scored_on_other(diagnosis, joined)
    progress("writing down what was found", 0.9)
    best = scored.causes[0]
    none = sum(cause.probability for cause in scored.causes if not cause.effects)
    base, base_notes = model_of(scored.fits[()], model, joined.names[0])
    found, found_notes = model_of(scored.fits[best.effects], model, joined.names[0])
    as_given = root_mean_square(nominal_residual(joined.signals, model.values)[joined.is_scored])
    left = [(cause.effects, cause.errors.rms) for cause in scored.causes]
    refitted = next(cause.errors for cause in scored.causes if not cause.effects)
    notes = [warning for record in records for warning in record.warnings]
    notes += [*base_notes, *found_notes, *notes_on(diagnosis, joined, model, as_given)]
    return StemOnlyDiagnosis(
        verdict=scored.verdict,
        stage=None if scored.verdict == "none" else STAGE,
        stage_probability=dict.fromkeys(STAGES, 0.0) | {STAGE: 1.0 - none},
        regimes=regimes_of_rows(joined, scored.fits[()].residual),
        causes=scored.causes,
        unknown_probability=scored.unknown,
        as_given=as_given,
        refitted=refitted,
        floor=scored.floor,
        scored_on="held-out blocks" if len(each) == 1 else "other records",
        given=model,
        base=base,
        found=found,
        base_fit=scored.fits[()],
        found_fit=scored.fits[best.effects],
        joined=joined,
        steps=steps_of(as_given, left, best.effects, scored.floor),
        warnings=tuple(dict.fromkeys(notes)),
        seconds=time.perf_counter() - began,
    )


def model_of(fit: StemFit, given: Model, name: str) -> tuple[Model, list[str]]:
    """Return the given valve with the fitted stem, and what of the fit no valve can have.

    Without a spring in the record the rate is 0. Diaphragm, nozzle and electromagnet stay as given.
    """
    values, notes = dict(given.values), []
    for key, estimate in {"spring_rate": None, **fit.parameters}.items():
        if key not in values:
            continue
        value = 0.0 if estimate is None else float(estimate.value)
        try:
            check_valve({**values, key: value})
        except InputError as error:
            notes.append(f"{error.rule}: the fit gives {value:.4g}, the model keeps the given {values[key]:.4g}")
            continue
        values[key] = value
    effects = {
        key: {each: float(estimate.value) for each, estimate in estimates.items()}
        for key, estimates in fit.by_effect().items()
    }
    return Model(name, values, effects), notes


def notes_on(diagnosis: StemDiagnosis, joined: Joined, given: Model, as_given: float) -> list[str]:
    """Return what a reader of the answer has to know about such records."""
    notes = []
    if as_given > root_mean_square(joined.signals.row_force[joined.is_scored]):
        notes.append(
            f"the given valve {given.name!r} misses the force by more than the force itself: it is another "
            "valve, and the gap as given says nothing"
        )
    notes.append(
        "force and position show the stem alone: in base.json and model.json diaphragm, nozzle and "
        f"electromagnet are those of the given valve {given.name!r}"
    )
    untold = [effect_of_key(key).title for key in diagnosis.not_applicable]
    notes.append(f"not looked for, since this record does not show them: {', '.join(untold)}")
    if not diagnosis.has_spring:
        notes.append("the record shows no spring: base.json and model.json have a spring rate of 0")
    if joined.signals.rows_left_out:
        share = joined.signals.rows_left_out / (joined.signals.rows + joined.signals.rows_left_out)
        notes.append(f"{100.0 * share:.0f} % of the samples are left out: friction has no value at rest")
    return notes
