"""Where: what each stage of the chain would have to answer for, from measured inputs or smallest corrections."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from diagnosis.whereabouts.corrections import PLACES, Correction, closed_of, smallest_correction, stretch_of
from diagnosis.whereabouts.own_signals import Explained, explained_by_stages
from diagnosis.whereabouts.residual_curves import gap_at, opening_of
from diagnosis.whereabouts.stage_gaps import POSITION_AT_NOISE, StageGaps, rms, stage_gaps
from identification.experiment import Experiment
from identification.fit import Fit, simulate_model
from valvemodel.declarations import BACK, FRONT, STAGES

MEASURED, CORRECTED = "measured input", "smallest correction"
"""How the gap of a stage was found."""


@dataclass(frozen=True)
class StageGap:
    """What some stages answer for.

    Attributes
    ----------
    stages : tuple of str
    method : str
        `MEASURED`: the measured input in, the output compared with the measured one. `CORRECTED`: the smallest
        correction of the output that would explain the record.
    signal, unit : str
        The output.
    gap : float [unit]
        Root mean square of the error, or of the correction.
    noise : float or None [unit]
        Of the measured output.
    gap_as_position : float [m]
        What that does to the reading, root mean square.
    share : float or None
        Of the mean squares of all stages, noise taken out; only where the inputs were measured.
    share_of_range : float
        The gap over the range of the signal in the record.
    closed : float or None
        Share of the squared gap above the noise that the correction closes.
    freedom : float or None
        Independent numbers that the correction takes.
    """

    stages: tuple[str, ...]
    method: str
    signal: str
    unit: str
    gap: float
    noise: float | None
    gap_as_position: float
    share: float | None
    share_of_range: float
    closed: float | None = None
    freedom: float | None = None


@dataclass(frozen=True, eq=False)
class Missed:
    """What the base misses most.

    Attributes
    ----------
    stretch : Experiment
        The record, or a part of it, that is missed most; driven by the measured pressure where all records have it.
    base : Fit
    start : float [m]
        First reading of the base there.
    stages : tuple of str
        Those in which the cause may lie: where the pressure was measured those behind it, if anything is missed there.
    """

    stretch: Experiment
    base: Fit
    start: float
    stages: tuple[str, ...]


@dataclass(frozen=True)
class Where:
    """The stages side by side.

    Attributes
    ----------
    stages : list of StageGap
    total, cross_term : float [m], [m^2]
        Root mean square of the whole error of position, and what its square has beyond the stages' squares; the cross
        term is None where nothing adds up: each correction alone would explain the record.
    record : str or None
        The one record that was corrected.
    missed : Missed
        What the stages may be asked about.
    explained : list of Explained
        What each stage explains of that by its own signals, where it was asked.
    """

    stages: list[StageGap]
    total: float
    cross_term: float | None
    missed: Missed
    record: str | None = None
    explained: list[Explained] = field(default_factory=list)

    @property
    def measured_shares(self) -> list[tuple[tuple[str, ...], float]]:
        """Parts of the chain with the share of the gap that arises in each; empty where that was not measured."""
        return [(each.stages, each.share) for each in self.stages if each.share is not None]

    def with_own_signals(self, pool: Executor | None) -> Where:
        """Ask each stage what its own signals explain, in the processes of a pool."""
        missed = self.missed
        return replace(
            self, explained=explained_by_stages(missed.stretch, missed.base, missed.start, missed.stages, pool)
        )

    def as_json(self) -> dict[str, Any]:
        """Return what the `where` of diagnosis.json has of it."""
        return {
            "stages": [vars(each) | {"stages": list(each.stages)} for each in self.stages],
            "stages_sum": {"unit": "m", "total": self.total, "cross_term": self.cross_term, "record": self.record},
            "own_signals": [each.as_json() for each in self.explained],
        }


def where_of(experiments: Sequence[Experiment], base: Fit) -> Where:
    """Say what each stage answers for: by the measured pressure where all records have it, else by corrections.

    Parameters
    ----------
    experiments : sequence of Experiment
    base : Fit
        Of the base to all of them.
    """
    if all(experiment.pressure is not None for experiment in experiments):
        return of_measured(stage_gaps(experiments, base), experiments)
    return of_corrections(most_missed(experiments, base, STAGES))


def of_measured(gaps: StageGaps, experiments: Sequence[Experiment]) -> Where:
    """Put the two halves of the chain side by side; sample by sample they add up to the whole error."""
    front_share, back_share = gaps.shares
    pressures = np.concatenate([np.asarray(each.pressure) for each in experiments])
    positions = np.concatenate([each.position for each in experiments])
    pressure, back = rms(gaps.pressure), rms(gaps.back)
    asked = BACK if back > POSITION_AT_NOISE * gaps.position_noise else ()
    return Where(
        [
            StageGap(
                FRONT, MEASURED, "pressure", "Pa", pressure, gaps.pressure_noise, rms(gaps.front), front_share,
                pressure / range_of(pressures),
            ),
            StageGap(
                BACK, MEASURED, "position", "m", back, gaps.position_noise, back, back_share, back / range_of(positions)
            ),
        ],
        total=rms([front + back for front, back in zip(gaps.front, gaps.back, strict=True)]),
        cross_term=gaps.cross_term,
        missed=most_missed(gaps.driven, gaps.behind, asked),
    )  # fmt: skip


def most_missed(experiments: Sequence[Experiment], base: Fit, stages: tuple[str, ...]) -> Missed:
    """Return what the base misses most, to ask some stages about."""
    errors = [each.position - base.simulated_on(each).position[0] for each in experiments]
    number = int(np.argmax([rms([error]) / each.noise for error, each in zip(errors, experiments, strict=True)]))
    stretch, first = stretch_of(experiments[number], errors[number])
    return Missed(stretch, base, base.starts[number] if first == 0 else stretch.first_reading, stages)


def of_corrections(most: Missed) -> Where:
    """Correct the output of each stage in turn."""
    stretch, base, start = most.stretch, most.base, most.start
    before, after = (smallest_correction(stretch, base, start, place) for place in PLACES)
    simulated = simulate_model(base.model, stretch, start_position=start)
    missed = rms([stretch.position - simulated.position[0]])
    values = base.model.values
    pressure = stretch.held_from(simulated.pressure[0])
    by_pressure = before.values * values["spring_rate"] / values["diaphragm_area"]
    opening, unit, moved = opening_of(base.model, pressure, by_pressure)
    opened = stretch.current if opening == "current" else gap_at(pressure, base.model)
    outputs = {
        "electromagnet": (before, opening, unit, moved, opened),
        "nozzle": (before, "pressure", "Pa", by_pressure, pressure),
        "stem": (before, "force", "N", before.values * values["spring_rate"], values["diaphragm_area"] * pressure),
        "sensor": (after, "reading", "m", after.values, stretch.position),
    }
    return Where(
        [of_correction(stage, *output, missed=missed, noise=stretch.noise) for stage, output in outputs.items()],
        total=missed,
        cross_term=None,
        missed=most,
        record=stretch.name,
    )


def of_correction(
    stage: str,
    correction: Correction,
    signal: str,
    unit: str,
    values: np.ndarray,
    output: np.ndarray,
    *,
    missed: float,
    noise: float,
) -> StageGap:
    """Say how large the correction of one stage's output is, in the unit of that output."""
    size = rms([values])
    return StageGap(
        (stage,), CORRECTED, signal, unit, size, None, rms([correction.values]), None, size / range_of(output),
        closed_of(missed, correction.left, noise), correction.freedom,
    )  # fmt: skip


def range_of(signal: np.ndarray) -> float:
    """Return the range of all that is known of a signal."""
    return float(np.nanmax(signal) - np.nanmin(signal)) or 1.0
