"""Diagnose records of one valve: where the gap lies, which effect causes it, how far it shrinks."""

from __future__ import annotations

import time
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from diagnosis.base_numbers import base_numbers
from diagnosis.choosing.searching import Search
from diagnosis.judging.ceiling import ceiling_of
from diagnosis.judging.confusability import confusability
from diagnosis.judging.finding import finding_of, with_parameters
from diagnosis.judging.hiding import with_hidden
from diagnosis.judging.sham import control_of, shams_on
from diagnosis.judging.stages import MOST_OPEN, stage_probabilities
from diagnosis.score import Errors, errors_of
from diagnosis.trying.candidates import Candidate
from diagnosis.trying.workshop import Workshop
from diagnosis.valve_diagnosis import Diagnosis
from diagnosis.whereabouts.breakaway_curves import curves_of_ageing
from diagnosis.whereabouts.curve import Curve
from diagnosis.whereabouts.own_signals import Explained
from diagnosis.whereabouts.regime_map import regime_map
from diagnosis.whereabouts.regimes import regimes_of
from diagnosis.whereabouts.residual_curves import residual_curves
from diagnosis.whereabouts.where import where_of
from identification.cores import begun, workers
from identification.determined.uncertainty import estimates
from identification.driving.between_rows import said_of_motion, share_left_out
from identification.driving.measured_current import said_of_current
from identification.driving.timing import experiments_of
from identification.experiment import Experiment
from identification.fit import Fit, fitted_to_all, simulate_model
from identification.holdout import Holdout
from valvemodel.effects import jumps
from valvemodel.model import Model
from valvemodel.progress import Progress, tell_nobody
from valvemodel.quantities import format_quantity
from valvemodel.records import Record


def diagnose(
    records: Sequence[Record],
    model: Model,
    *,
    candidates: Sequence[str] | None = None,
    jobs: int | None = None,
    progress: Progress = tell_nobody,
) -> Diagnosis:
    """Find where and why a valve and its model disagree, from records with current; `diagnosis.diagnose` is the door.

    Parameters, errors and what they mean are the door's.
    """
    with workers(jobs) as pool:
        return diagnose_with(pool, records, model, candidates, progress)


def diagnose_with(
    pool: Executor | None, records: Sequence[Record], model: Model, candidates: Sequence[str] | None, progress: Progress
) -> Diagnosis:
    """Diagnose, as `diagnose` says, with the processes of a pool."""
    began = time.perf_counter()
    held, notes = experiments_of(records)
    searched = Search(model, candidates, pool, progress).on(held)
    experiments, holdout = searched.experiments, searched.holdout
    base = fitted_to_all(searched.base, experiments)
    # What these find is asked for below: they are done beside what is looked at and fitted here.
    gaps = begun(pool, where_of, experiments, base)
    likeness = begun(pool, confusability, base, searched.library)
    shams = begun(pool, shams_on, searched.tried[0], holdout)
    tried, hiding = with_hidden(searched.tried, Workshop(holdout, pool, progress))
    finding = finding_of(tried, holdout)
    verdict, yardstick = finding.verdict, finding.yardstick
    causes = finding.causes()
    as_given = errors_as_given(model, holdout, yardstick)
    control = control_of(tried, shams(), yardstick)
    progress("fitting the cause to the whole record", 0.9)
    whole = fitted_to_all(finding.shown.fit, experiments)
    told = estimates(whole)
    causes[0] = replace(with_parameters(causes[0], whole, told), hiding=hiding)
    named = (whole, told) if verdict == "effect" else (base, estimates(base))
    where = gaps()
    if verdict == "unknown":
        progress("asking each stage what its own signals explain", 0.95)
        where = where.with_own_signals(pool)
    probability = stage_probabilities(verdict, tried, finding.judgement, where.measured_shares, where.explained)
    stages = sorted(probability, key=lambda stage: -probability[stage])
    likely = [each for each in where.explained if each.stage in stages[:MOST_OPEN]]
    residuals, modes = left_by(base, experiments)
    return Diagnosis(
        verdict=verdict,
        stage=stages[0] if verdict != "none" and probability[stages[0]] > 0.0 else None,
        stage_probability=probability,
        regimes=regimes_of(experiments, residuals, modes),
        regime_map=regime_map(experiments, residuals, modes),
        stage_gaps=where,
        causes=causes,
        unknown_probability=finding.judgement.unknown,
        as_given=as_given,
        refitted=finding.refitted,
        floor=finding.floor,
        sampling_error=searched.sampling_error,
        left_out=max(map(share_left_out, experiments, held)),
        yardstick=yardstick,
        holdout=holdout,
        given=model,
        base=base,
        base_numbers=base_numbers(model, base, *named, experiments),
        found=whole,
        candidates=tuple(effect.key for effect in searched.library),
        tried=tried,
        confusability=likeness(),
        control=control,
        ceiling=ceiling_of(searched.base, holdout, is_anchored=yardstick == "anchored"),
        residual_curves=curves_left(verdict, finding.shown, experiments, base, likely),
        steps=finding.steps(as_given),
        warnings=(
            *(each for record in records for each in record.warnings),
            *said_of_motion(notes, experiments, held),
            *said_of_current(experiments),
            *searched.notes,
            *said_of_given(as_given, holdout),
            *control.notes,
        ),
        seconds=time.perf_counter() - began,
    )


def left_by(base: Fit, experiments: Sequence[Experiment]) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Return what a base leaves of each experiment [m], and the modes of its stem there."""
    runs = [base.simulated_on(each) for each in experiments]
    residuals = [each.position - run.position[0] for each, run in zip(experiments, runs, strict=True)]
    return residuals, [run.mode[0] for run in runs]


def curves_left(
    verdict: str, shown: Candidate, experiments: Sequence[Experiment], base: Fit, likely: Sequence[Explained]
) -> list[Curve]:
    """Return what is left over what it depends on: all where no cause was found, else what a law of jumps leaves."""
    if verdict == "unknown":
        return residual_curves(experiments, base, likely)
    return curves_of_ageing(base) if verdict == "effect" and jumps(shown.effects) else []


def errors_as_given(model: Model, holdout: Holdout, yardstick: str) -> Errors:
    """Score a model as it is given, started at the first readings."""
    simulated = [
        simulate_model(model, experiment, start_position=experiment.first_reading, is_anchored=yardstick == "anchored")
        for experiment in holdout.scored_experiments
    ]
    return errors_of(holdout, simulated)


def said_of_given(as_given: Errors, holdout: Holdout) -> list[str]:
    """Return what is to be said of a model as given that is farther off than the stem moves: it is of another valve."""
    scored = zip(holdout.scored_experiments, holdout.scored, strict=True)
    travel = max(float(np.ptp(experiment.position[mask])) for experiment, mask in scored)
    if as_given.rms <= travel:
        return []
    off, way = (format_quantity(each, "m", digits=2) for each in (as_given.rms, travel))
    return [
        f"the model as given is {off} off, more than the stem moves ({way}): it is another valve's, and the gap as "
        "given says nothing; give the valve's own numbers (--valve; `valvemodel valves calibrated --toml` has a form)"
    ]
