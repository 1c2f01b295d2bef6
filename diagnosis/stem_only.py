"""Diagnose records of force and position: the stem alone by inverse dynamics, told as any diagnosis."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from diagnosis.causes import Cause, content_of, steps_of
from diagnosis.display import Told
from diagnosis.regimes import Regime
from diagnosis.score import Errors, closed_interval, closed_share, persistence_of
from diagnosis.workshop import Progress, tell_nobody
from identification.experiment import Experiment
from identification.inverse_dynamics import (
    Preprocessing,
    ScoredCause,
    StemDiagnosis,
    StemFit,
    StemSignals,
    diagnose_stem,
    fit_stem,
    prepare_signals,
)
from identification.inverse_dynamics.diagnose import (
    GUARD_ROWS,
    NOTICE_RMS,
    NOTICE_SHARE,
    PARAMETER_PENALTY,
    UNKNOWN_AT,
    UNKNOWN_FROM,
)
from identification.inverse_dynamics.fit import blocks_of, nominal_residual, root_mean_square
from identification.regimes import masks_of, words_of
from valvemodel.declarations import STAGES
from valvemodel.effects import effect_of_key
from valvemodel.errors import InputError
from valvemodel.files import make_folder, write_json
from valvemodel.model import Model, check_valve
from valvemodel.records import Record

if TYPE_CHECKING:
    from diagnosis.report import Evidence, RecordEvidence

STAGE = "stem"
"""Nothing else is in a record of force and position."""

LOW_SPEED, HIGH_SPEED = 0.1, 0.75
"""Shares of the record's top speed (its 0.95 quantile) that count as near rest and as fast."""

SAME_INTERVAL = 1e-3
"""Share by which the sampling intervals of records that are laid end to end may differ."""

FEWEST_SAMPLES = 10
"""A regime with fewer samples is not listed."""

NEGLIGIBLE = 1e-9
"""Share of the base model's error below which an error is as good as none."""

NOTHING_LEFT = 1e-5
"""Share of the force below which an error is that of differentiation and no gap."""

Effects = tuple[str, ...]


@dataclass(frozen=True, eq=False, repr=False)
class StemOnlyDiagnosis(Told):
    """All that a diagnosis of the stem alone found, in SI units; the gap is one of force.

    Attributes
    ----------
    as_given : float [N]
        Root mean square error of the given valve on the scored samples.
    refitted : Errors [N^2]
    floor : float [N]
    base_fit, found_fit : StemFit
        To all records: the base model, and the best cause.
    joined : Joined
        The signals of all records.
    """

    verdict: str
    stage: str | None
    stage_probability: dict[str, float]
    regimes: list[Regime]
    causes: list[Cause]
    unknown_probability: float
    as_given: float
    refitted: Errors
    floor: float
    scored_on: str
    given: Model
    base: Model
    found: Model
    base_fit: StemFit
    found_fit: StemFit
    joined: Joined
    steps: list[tuple[str, float]]
    warnings: tuple[str, ...]
    seconds: float

    @property
    def cause(self) -> Cause:
        """The best cause."""
        return self.causes[0]

    def as_json(self) -> dict[str, Any]:
        """Return the content of diagnosis.json."""
        return {
            **content_of(self),
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
        return evidence_of(self)

    def write(self, folder: Path, *, jobs: int | None = 1) -> dict[str, Path]:
        """Write diagnosis.json, base.json, model.json and report.html, and return their places.

        So many processes draw at the same time; None is one a core.
        """
        from diagnosis.report import write_page

        folder = make_folder(folder)
        places = {name: folder / name for name in ("diagnosis.json", "base.json", "model.json", "report.html")}
        content = self.as_json()
        write_json(places["diagnosis.json"], content)
        self.base.write(places["base.json"])
        self.found.write(places["model.json"])
        write_page(places["report.html"], content, self.evidence(), jobs=jobs)
        return places


@dataclass(frozen=True, eq=False)
class Joined:
    """Signals of one or several records end to end, and to which record each decimated sample belongs."""

    names: tuple[str, ...]
    signals: StemSignals
    owner: np.ndarray

    @property
    def is_scored(self) -> np.ndarray:
        """The samples that are scored: the last record's, or of one record all, block by block in turn."""
        return self.owner == len(self.names) - 1

    @property
    def is_fitted(self) -> np.ndarray:
        """The samples of the other records but for those next to the last, which a filter mixes."""
        return self.owner[np.minimum(np.arange(len(self.owner)) + GUARD_ROWS, len(self.owner) - 1)] < (
            len(self.names) - 1
        )


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


def check_kind(records: Sequence[Record]) -> None:
    """Refuse records that are not of the stem alone."""
    if not records:
        raise InputError("a diagnosis takes at least one record", "got none", "name a file")
    for record in records:
        if record.kind != "stem":
            raise InputError(
                "records of the stem alone have force and position and no current",
                f"{record.name} has a current",
                "diagnose it apart from the records of force, or take the current out",
            )


def prepared(records: Sequence[Record]) -> list[StemSignals]:
    """Return the signals of each record, all filtered and decimated as the first."""
    first = prepare_signals(records[0])
    same = Preprocessing(cutoff_frequency=first.cutoff_frequency, factor=first.factor)
    found = [first]
    for record in records[1:]:
        if record.time is not None and abs(record.interval / first.interval - 1.0) > SAME_INTERVAL:
            raise InputError(
                "records of force that are diagnosed together have one sampling interval",
                f"{record.name} has {record.interval:g} s, {records[0].name} {first.interval:g} s",
                "resample one of them",
            )
        found.append(prepare_signals(record, same))
    return found


def join(names: Sequence[str], each: Sequence[StemSignals]) -> Joined:
    """Lay signals end to end on one clock.

    Filter and decimation are linear and treat force and regressors alike, so the balance holds across a
    joint too.
    """
    factor, interval = each[0].factor, each[0].interval
    if len(each) == 1:
        return Joined(tuple(names), each[0], np.zeros(each[0].rows, int))
    cut = [slice(0, factor * (len(one.time) // factor)) for one in each]
    sizes = [part.stop for part in cut]

    def laid(columns: list[np.ndarray]) -> np.ndarray:
        return np.concatenate([column[part] for column, part in zip(columns, cut, strict=True)])

    signals = replace(
        each[0],
        time=each[0].time[0] + interval * np.arange(sum(sizes)),
        force=laid([one.force for one in each]),
        position=laid([one.position for one in each]),
        velocity=laid([one.velocity for one in each]),
        acceleration=laid([one.acceleration for one in each]),
        direction=laid([one.direction for one in each]),
        rest_speed=max(one.rest_speed for one in each),
        position_noise=max(one.position_noise for one in each),
    )
    ends = signals.time[0] + interval * np.cumsum(sizes)
    owner = np.searchsorted(ends, signals.row_time + 0.5 * interval)
    return Joined(tuple(names), signals, owner)


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


def regimes_of_rows(joined: Joined, residual: np.ndarray) -> list[Regime]:
    """Return where the error of the base model is large, the largest first. [N]"""
    signals = joined.signals
    velocity = signals.decimate(signals.velocity)
    speed = np.abs(velocity)
    top = float(np.quantile(speed, 0.95))
    rows = Experiment(
        name="",
        time=signals.row_time,
        current=np.full(signals.rows, np.nan),
        position=signals.decimate(signals.position),
        pressure=None,
        noise=signals.position_noise,
        pressure_noise=0.0,
        block=blocks_of(signals),
    )
    masks = masks_of(rows, np.sign(velocity))
    slow, fast = LOW_SPEED * top, HIGH_SPEED * top
    masks |= {"near_rest": speed < slow, "high_speed": speed > fast}
    words = words_of([rows]) | {
        "near_rest": f"near rest, below {slow * 1e3:.3g} mm/s",
        "high_speed": f"at high speed, above {fast * 1e3:.3g} mm/s",
    }
    whole = float(np.sum(residual**2)) or 1.0
    found = []
    for name, mask in masks.items():
        if mask.sum() >= FEWEST_SAMPLES:
            share = float(np.sum(residual[mask] ** 2)) / whole
            found.append(Regime(name, words[name], root_mean_square(residual[mask]), share, float(mask.mean())))
    return sorted(found, key=lambda regime: -regime.rms)


def evidence_of(diagnosis: StemOnlyDiagnosis) -> Evidence:
    """Return what the pictures of a diagnosis show."""
    from diagnosis.picture import ranking_of
    from diagnosis.report import Evidence, Step

    return Evidence(
        records=tuple(record_evidence(diagnosis, number) for number in range(len(diagnosis.joined.names))),
        steps=tuple(Step(label, rms) for label, rms in diagnosis.steps),
        ranking=ranking_of(diagnosis.causes),
        noise_floor=diagnosis.floor,
        unit="N",
        seconds=diagnosis.seconds,
        valve_name=diagnosis.given.name,
        warnings=diagnosis.warnings,
    )


def record_evidence(diagnosis: StemOnlyDiagnosis, number: int) -> RecordEvidence:
    """Return the forces of one record, decimated; a missing sample stands where the stem rests."""
    from diagnosis.report import RecordEvidence

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
