"""The data behind the report's pictures, taken from a diagnosis."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from diagnosis.causes import Cause
from diagnosis.report import Evidence, Rank, RecordEvidence, Step
from diagnosis.valve_diagnosis import Diagnosis
from identification.experiment import Experiment
from identification.fit import simulate_model
from valvemodel.effects import effect_of_key


def evidence_of(diagnosis: Diagnosis) -> Evidence:
    """Return what the pictures of a diagnosis show."""
    designed = diagnosis.next_experiment
    return Evidence(
        records=tuple(record_evidence(diagnosis, experiment) for experiment in diagnosis.experiments),
        steps=tuple(Step(label, rms) for label, rms in diagnosis.steps),
        ranking=ranking_of(diagnosis.causes),
        noise_floor=diagnosis.floor,
        unit="m",
        seconds=diagnosis.seconds,
        valve_name=diagnosis.given.name,
        warnings=diagnosis.warnings,
        next_input=None if designed is None else (designed.time, designed.current),
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


def record_evidence(diagnosis: Diagnosis, experiment: Experiment) -> RecordEvidence:
    """Return one record beside what the models say of it."""
    given = simulate_model(diagnosis.given, experiment, start_position=experiment.first_reading)
    base = diagnosis.base.simulated_on(experiment)
    found = diagnosis.found.simulated_on(experiment) if diagnosis.cause.effects else None
    held_out = np.zeros(len(experiment.time), bool)
    for scored, mask in zip(diagnosis.holdout.scored_experiments, diagnosis.holdout.scored, strict=True):
        if scored is experiment:
            held_out = mask
    return RecordEvidence(
        name=experiment.name,
        time=experiment.record_time,
        current=experiment.current,
        measured=experiment.position,
        as_given=given.position[0],
        refitted=base.position[0],
        with_cause=None if found is None else found.position[0],
        held_out=held_out,
        mode=base.mode[0].astype(int),
        measured_pressure=experiment.pressure,
        refitted_pressure=None if experiment.pressure is None else base.pressure[0],
        with_cause_pressure=None if experiment.pressure is None or found is None else found.pressure[0],
    )
