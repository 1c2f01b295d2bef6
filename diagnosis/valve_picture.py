"""The data behind the report's pictures of a whole valve, taken from its diagnosis."""

from __future__ import annotations

import numpy as np

from diagnosis.picture import evidence_of
from diagnosis.report import Evidence, RecordEvidence
from diagnosis.valve_diagnosis import Diagnosis
from identification.experiment import Experiment
from identification.fit import simulate_model


def evidence_of_valve(diagnosis: Diagnosis) -> Evidence:
    """Return what the pictures of a valve's diagnosis show."""
    designed = diagnosis.next_experiment
    records = [record_evidence(diagnosis, experiment) for experiment in diagnosis.experiments]
    next_input = None if designed is None else (designed.time, designed.current)
    return evidence_of(diagnosis, records, unit="m", next_input=next_input)


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
