"""Diagnose records of one valve: where the gap lies, which effect causes it, how far it shrinks."""

from __future__ import annotations

import time
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from diagnosis.base_numbers import BaseNumber, base_numbers
from diagnosis.breakaway_curves import curves_of_ageing
from diagnosis.ceiling import ceiling_of
from diagnosis.confusability import Confusability, confusability
from diagnosis.curve import Curve
from diagnosis.display import Told
from diagnosis.hiding import with_hidden
from diagnosis.judgement import Judgement, judge, rivals_of
from diagnosis.own_signals import Explained
from diagnosis.regime_map import RegimeMap, regime_map
from diagnosis.regimes import Regime, regimes_of
from diagnosis.residual_curves import residual_curves
from diagnosis.score import Errors, closed_interval, closed_share, errors_of
from diagnosis.searching import Search
from diagnosis.sham import Control, control_of, shams_on
from diagnosis.stages import MOST_OPEN, open_stages, stage_probabilities
from diagnosis.trying import Candidate
from diagnosis.where import Where, where_of
from diagnosis.workshop import Progress, Workshop, tell_nobody
from identification.cores import begun, workers
from identification.driving.between_rows import said_of_motion, share_left_out
from identification.driving.measured_current import said_of_current
from identification.experiment import Experiment
from identification.fit import Fit, fitted_to_all, simulate_model
from identification.holdout import Holdout
from identification.timing import experiments_of
from identification.uncertainty import Estimate, estimates
from valvemodel.effects import are_aliases, effect_of_key, jumps
from valvemodel.files import make_folder, write_json
from valvemodel.model import Model
from valvemodel.quantities import format_quantity
from valvemodel.records import Record
from valvemodel.stages import EFFECTS

if TYPE_CHECKING:
    from diagnosis.next_experiment import NextExperiment
    from diagnosis.report import Evidence

SCHEMA = "valvemodel.diagnosis/1"

YARDSTICKS = {"free": "free run", "anchored": "re-anchored on the measured position every 2 s"}
"""How the gap is measured: where slips stick, a free run loses their phase even if the model is right."""


@dataclass(frozen=True)
class Cause:
    """One cause with its probability, its parameters, and how far the gap shrinks with it; no effects is `none`.

    `rivals` are the causes that the records cannot tell from it, `hiding` the effects of which they would show nothing
    beside it.
    """

    effects: tuple[str, ...]
    probability: float
    errors: Errors
    parameters: dict[str, dict[str, dict[str, Any]]]
    closed: float | None
    closed_interval: tuple[float, float] | None
    rivals: list[tuple[str, ...]]
    hiding: list[str] = field(default_factory=list)

    def as_json(self) -> dict[str, Any]:
        """Return the cause as diagnosis.json has it."""
        return {
            "effects": list(self.effects),
            "probability": self.probability,
            "parameters": self.parameters,
            "gap_after": self.errors.rms,
            "gap_closed": self.closed,
            "gap_closed_interval": None if self.closed_interval is None else list(self.closed_interval),
            "indistinguishable_from": [list(rival) for rival in self.rivals],
            "may_hide_beside": self.hiding,
        }


class Judged(Protocol):
    """What every diagnosis says, of a whole valve or of its stem alone."""

    @property
    def verdict(self) -> str: ...
    @property
    def stage(self) -> str | None: ...
    @property
    def stage_probability(self) -> dict[str, float]: ...
    @property
    def regimes(self) -> list[Regime]: ...
    @property
    def causes(self) -> list[Cause]: ...
    @property
    def unknown_probability(self) -> float: ...


def content_of(judged: Judged) -> dict[str, Any]:
    """Return the part of diagnosis.json that says which, where and how sure."""
    return {
        "schema": SCHEMA,
        "verdict": judged.verdict,
        "where": {
            "stage": judged.stage,
            "stage_probability": judged.stage_probability,
            "regimes": [asdict(regime) for regime in judged.regimes],
        },
        "causes": [cause.as_json() for cause in judged.causes],
        "unknown_probability": judged.unknown_probability,
    }


@dataclass(frozen=True, repr=False)
class Diagnosis(Told):
    """All that a diagnosis found, in SI units."""

    verdict: str
    stage: str | None
    stage_probability: dict[str, float]
    regimes: list[Regime]
    regime_map: RegimeMap
    stage_gaps: Where
    causes: list[Cause]
    unknown_probability: float
    as_given: Errors
    refitted: Errors
    floor: float
    sampling_error: float
    left_out: float
    yardstick: str
    holdout: Holdout
    given: Model
    base: Fit
    found: Fit
    base_numbers: list[BaseNumber]
    candidates: tuple[str, ...]
    tried: list[Candidate]
    confusability: Confusability
    control: Control
    ceiling: Errors
    residual_curves: list[Curve]
    steps: list[tuple[str, float]]
    warnings: tuple[str, ...]
    seconds: float
    next_experiment: NextExperiment | None = None

    @property
    def cause(self) -> Cause:
        """The cause that is shown: the most probable one, of which the verdict speaks unless it is unknown.

        Where it is, causes that are a series of waves come last.
        """
        return self.causes[0]

    @property
    def found_model(self) -> Model:
        """The refitted base, with the cause where one is named, as it goes for other records of the valve."""
        return self.found.model.without_starts()

    @property
    def open_stages(self) -> list[str]:
        """Stages in which the cause may lie as far as the records tell, the most probable first."""
        causes = [self.cause.effects, *self.cause.rivals] if self.verdict == "effect" else []
        return open_stages(self.verdict, self.stage_probability, [*causes, *((key,) for key in self.untried_aliases)])

    @property
    def not_tried(self) -> list[str]:
        """Effects that were no candidates, or that nothing called for."""
        tried = {each.effects for each in self.causes}
        return [effect.key for effect in EFFECTS if (effect.key,) not in tried]

    @property
    def untried_aliases(self) -> list[str]:
        """Effects that were no candidates and are declared to look like one that is named, or like none."""
        named = {"effect": self.cause.effects, "none": ("none",), "unknown": ()}[self.verdict]
        others = [effect.key for effect in EFFECTS if effect.key not in self.candidates]
        return [key for key in others if any(are_aliases(key, each) for each in named)]

    def as_json(self) -> dict[str, Any]:
        """Return the content of diagnosis.json."""
        content = content_of(self)
        content["where"] |= {
            "open_stages": self.open_stages,
            "regime_map": self.regime_map.as_json(),
            **self.stage_gaps.as_json(),
        }
        return {
            **content,
            "gap": {
                "unit": "m",
                "as_given": self.as_given.rms,
                "refitted": self.refitted.rms,
                "with_cause": self.cause.errors.rms,
                "noise_floor": self.floor,
                "sampling_error": self.sampling_error,
                "left_out": self.left_out,
                "scored_on": self.holdout.scored_on,
                "yardstick": YARDSTICKS[self.yardstick],
            },
            "ceiling": {
                "gap_after": self.ceiling.rms,
                "gap_closed": closed_share(self.refitted.rms, self.ceiling.rms, self.floor),
                "gap_closed_interval": closed_interval(self.refitted, self.ceiling, self.floor),
            },
            "control": asdict(self.control),
            "confusability": self.confusability.as_json(),
            "residual_curves": [curve.as_json() for curve in self.residual_curves],
            "next_experiment": None if self.next_experiment is None else self.next_experiment.as_json(),
            "base": {
                "name": self.base.model.name,
                "file": "base.json",
                "numbers": [asdict(each) for each in self.base_numbers],
            },
            "signals": ["current", "position"] + ["pressure"] * self.base.problem.has_pressure,
            "not_tried": self.not_tried,
            "untried_aliases": self.untried_aliases,
            "records": [experiment.name for experiment in self.experiments],
            "warnings": list(self.warnings),
            "seconds": self.seconds,
        }

    @property
    def experiments(self) -> list[Experiment]:
        """All experiments, fitted and scored, each once."""
        experiments = list(self.holdout.experiments)
        return experiments + [each for each in self.holdout.scored_experiments if each not in experiments]

    def evidence(self) -> Evidence:
        """Return what the pictures show."""
        from diagnosis.picture import evidence_of

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
        self.base.model.write(places["base.json"])
        self.found_model.write(places["model.json"])
        write_page(places["report.html"], content, self.evidence(), jobs=jobs)
        return places


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
    experiments, holdout, base, library = searched.experiments, searched.holdout, searched.base, searched.library
    notes = said_of_motion(notes, experiments, held) + said_of_current(experiments)
    first = searched.tried[0]
    whole_base = fitted_to_all(base, experiments)
    # What these find is asked for below: they are done beside what is looked at and fitted here.
    gaps = begun(pool, where_of, experiments, whole_base)
    likeness = begun(pool, confusability, whole_base, library)
    shams = begun(pool, shams_on, first, holdout)
    tried, hiding = with_hidden(searched.tried, Workshop(holdout, pool, progress))
    judgement = judge(tried)
    verdict = verdict_of(tried, judgement)
    order = order_of(tried, judgement)
    if verdict == "unknown":
        # What came nearest is not the cause, and a load that was found for these records is none of the next one's.
        order.sort(key=lambda number: tried[number].has_series)
    shown = tried[order[0]]
    yardstick = yardstick_of(shown)
    floor = floor_of(tried, holdout, yardstick)
    causes = causes_of(tried, order, judgement, floor, yardstick)
    as_given = errors_as_given(model, holdout, yardstick)
    control = control_of(tried, shams(), yardstick)
    progress("fitting the cause to the whole record", 0.9)
    whole = fitted_to_all(shown.fit, experiments)
    told = estimates(whole)
    causes[0] = replace(with_parameters(causes[0], whole, told), hiding=hiding)
    found = (whole, told) if verdict == "effect" else (whole_base, estimates(whole_base))
    where = gaps()
    if verdict == "unknown":
        progress("asking each stage what its own signals explain", 0.95)
        where = where.with_own_signals(pool)
    stage_probability = stage_probabilities(verdict, tried, judgement, where.measured_shares, where.explained)
    named = sorted(stage_probability, key=lambda stage: -stage_probability[stage])
    likely = [each for each in where.explained if each.stage in named[:MOST_OPEN]]
    runs = [whole_base.simulated_on(each) for each in experiments]
    residuals = [each.position - run.position[0] for each, run in zip(experiments, runs, strict=True)]
    modes = [run.mode[0] for run in runs]
    return Diagnosis(
        verdict=verdict,
        stage=named[0] if verdict != "none" and stage_probability[named[0]] > 0.0 else None,
        stage_probability=stage_probability,
        regimes=regimes_of(experiments, residuals, modes),
        regime_map=regime_map(experiments, residuals, modes),
        stage_gaps=where,
        causes=causes,
        unknown_probability=judgement.unknown,
        as_given=as_given,
        refitted=getattr(first.score, yardstick),
        floor=floor,
        sampling_error=searched.sampling_error,
        left_out=max(map(share_left_out, experiments, held)),
        yardstick=yardstick,
        holdout=holdout,
        given=model,
        base=whole_base,
        base_numbers=base_numbers(model, whole_base, *found, experiments),
        found=whole,
        candidates=tuple(effect.key for effect in library),
        tried=tried,
        confusability=likeness(),
        control=control,
        ceiling=ceiling_of(base, holdout, is_anchored=yardstick == "anchored"),
        residual_curves=curves_left(verdict, shown, experiments, whole_base, likely),
        steps=steps_of(as_given, tried, shown, floor, yardstick),
        warnings=(
            *(each for record in records for each in record.warnings),
            *notes,
            *searched.notes,
            *said_of_given(as_given, holdout),
            *control.notes,
        ),
        seconds=time.perf_counter() - began,
    )


def curves_left(
    verdict: str, shown: Candidate, experiments: Sequence[Experiment], base: Fit, likely: Sequence[Explained]
) -> list[Curve]:
    """Return what is left over what it depends on: all where no cause was found, else what a law of jumps leaves."""
    if verdict == "unknown":
        return residual_curves(experiments, base, likely)
    return curves_of_ageing(base) if verdict == "effect" and jumps(shown.effects) else []


def floor_of(candidates: Sequence[Candidate], holdout: Holdout, yardstick: str) -> float:
    """Return the floor of the gap: what noise leaves of the readings, or the best fit's error. [m]"""
    best = min(getattr(each.score, yardstick).rms for each in candidates)
    return min(holdout.floor, best)


def yardstick_of(likely: Candidate) -> str:
    """Return how the gap is measured: re-anchored where the stem sticks and slips, as a free run loses the phase."""
    return "anchored" if jumps(likely.effects) else "free"


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


def order_of(candidates: Sequence[Candidate], judgement: Judgement) -> list[int]:
    """Return the numbers of all that was tried: the most probable first, the nearer first where equally probable."""
    return sorted(
        range(len(candidates)), key=lambda number: (-judgement.probabilities[number], candidates[number].score.misfit)
    )


def causes_of(
    candidates: Sequence[Candidate], order: Sequence[int], judgement: Judgement, floor: float, yardstick: str
) -> list[Cause]:
    """Return all that was tried as causes, in an order of their numbers."""
    base: Errors = getattr(candidates[0].score, yardstick)
    causes = []
    for number in order:
        candidate = candidates[number]
        errors: Errors = getattr(candidate.score, yardstick)
        causes.append(
            Cause(
                effects=candidate.effects,
                probability=float(judgement.probabilities[number]),
                errors=errors,
                parameters=plain_parameters(candidate.fit),
                closed=closed_share(base.rms, errors.rms, floor),
                closed_interval=closed_interval(base, errors, floor),
                rivals=rivals_of(number, candidates, judgement),
            )
        )
    return causes


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


def verdict_of(candidates: Sequence[Candidate], judgement: Judgement) -> str:
    """Return `unknown` where that has most of the probability, else `effect` or `none`, as the most probable cause is.

    Many effects that each come a little nearer than none, and none of them nearer than the others, name nothing.
    """
    is_effect = np.array([bool(each.effects) for each in candidates])
    known = max(float(judgement.probabilities[each].sum()) for each in (is_effect, ~is_effect))
    if judgement.unknown > known:
        return "unknown"
    return "effect" if candidates[order_of(candidates, judgement)[0]].effects else "none"


def steps_of(
    given: Errors, candidates: Sequence[Candidate], shown: Candidate, floor: float, yardstick: str
) -> list[tuple[str, float]]:
    """Return the gap step by step: as given, base refitted, each effect added, noise floor. [m]"""

    def rms(candidate: Candidate) -> float:
        errors: Errors = getattr(candidate.score, yardstick)
        return errors.rms

    steps = [("as given", given.rms), ("base refitted", rms(candidates[0]))]
    for count in range(1, len(shown.effects) + 1):
        part = shown.effects[:count]
        for candidate in candidates:
            if set(candidate.effects) == set(part):
                steps.append((f"+ {effect_of_key(part[-1]).title}", rms(candidate)))
    return [*steps, ("noise floor", floor)]
