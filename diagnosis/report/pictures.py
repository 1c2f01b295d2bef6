"""Each picture of the page with its title and with what it shows in words."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from markupsafe import Markup

from diagnosis.report import figures
from diagnosis.report.amounts import amount, percent, probability_text
from diagnosis.report.curves import curves_picture
from diagnosis.report.evidence import Evidence, RecordEvidence
from diagnosis.report.heatmap import heat_map_picture
from diagnosis.report.naming import cause_title


@dataclass(frozen=True)
class Picture:
    """A picture with what it shows in words; `narrow` is its form for a phone, where a matrix `scrolls` instead."""

    svg: Markup
    title: str
    alternative: str
    narrow: Markup | None = None
    scrolls: bool = False


@dataclass(frozen=True)
class RecordPictures:
    """The pictures of one record."""

    name: str
    halves: tuple[Picture, ...]
    residual: Picture


def cause_label(diagnosis: Mapping[str, Any]) -> str:
    """Return the legend of the model with the cause, short enough for a picture."""
    if diagnosis["verdict"] == "none":
        return "base, best fit"
    effects: list[str] = next((cause["effects"] for cause in diagnosis.get("causes") or () if cause["effects"]), [])
    label = f"with {cause_title(effects)}" if effects else "with the cause"
    if diagnosis["verdict"] == "unknown":
        return "nearest candidate"
    return label if len(label) <= 26 else "with the cause"


def summary_pictures(evidence: Evidence) -> list[Picture]:
    """Return how the gap shrinks step by step, and the candidates."""
    pictures = []
    if evidence.steps:
        steps = ", ".join(
            f"{step.label} {amount(step.rms, evidence.unit, like=[evidence.steps[0].rms])}" for step in evidence.steps
        )
        pictures.append(
            Picture(
                Markup(figures.steps_picture("steps", evidence)),
                "The gap, step by step",
                f"Bars of the gap, root mean square: {steps}.",
            )
        )
    if evidence.ranking:
        ranking = ", ".join(
            f"{rank.label} {amount(rank.rms, evidence.unit)} ({probability_text(rank.probability)})"
            for rank in evidence.ranking[:5]
        )
        pictures.append(
            Picture(
                Markup(figures.ranking_picture("ranking", evidence)),
                "The candidates: gap left and probability",
                f"Candidates by the gap that they leave on unseen data, with their probability: {ranking}.",
            )
        )
    return pictures


def record_pictures(name: str, record: RecordEvidence, unit: str, cause: str) -> RecordPictures:
    """Return what was measured beside the models, and what they leave."""
    signal = figures.signal_name(unit)
    against = figures.abscissa_name(record)
    models = "measured and base refitted" if record.with_cause is None else f"measured, base refitted and {cause}"
    curves = f"in {record.name}: {models}; measured {signal} {_span(record.measured, unit)}."
    halves = []
    if against != "time":
        halves.append(
            Picture(
                Markup(figures.loop_picture(f"{name}-loop", record, unit, cause)),
                f"{signal.capitalize()} against {against}",
                f"Curves of {signal} against {against} {curves}",
            )
        )
    halves.append(
        Picture(
            Markup(figures.time_picture(f"{name}-time", record, unit, cause)),
            f"{signal.capitalize()} over time",
            f"Curves of {signal} over time {curves}",
        )
    )
    if record.measured_pressure is not None:
        halves.append(
            Picture(
                Markup(figures.pressure_picture(f"{name}-pressure", record, cause)),
                "Actuator pressure against current",
                f"Curves of the actuator pressure in {record.name}: {models}; measured "
                f"{_span(record.measured_pressure, 'Pa')}.",
            )
        )
    wide = figures.residual_picture(f"{name}-residual", record, unit, cause, is_wide=True)
    narrow = figures.residual_picture(f"{name}-residual-narrow", record, unit, cause, is_wide=False)
    residual = Picture(
        Markup(wide),
        "What the models leave, over time and by regime",
        f"Measured less model over time in {record.name}: {_left_in_words(record, unit, cause)}. Lanes below show "
        "where the stem rises, is stuck or falls, and which blocks were held out of the fits.",
        narrow=Markup(narrow),
    )
    return RecordPictures(record.name, tuple(halves), residual)


def residual_pictures(curves: Sequence[Mapping[str, Any]]) -> list[Picture]:
    """Return what is left of each signal over what it depends on."""
    signals = dict.fromkeys(curve["signal"] for curve in curves)
    by_signal = {signal: [curve for curve in curves if curve["signal"] == signal] for signal in signals}
    return [
        Picture(
            Markup(curves_picture(f"left-{signal}", own, is_wide=True)),
            _title_of(own[0]),
            f"{_shown(own[0])} the {signal} over {_curves_in_words(own)}.",
            narrow=Markup(curves_picture(f"left-{signal}-narrow", own, is_wide=False)),
        )
        for signal, own in by_signal.items()
    ]


def _left_in_words(record: RecordEvidence, unit: str, cause: str) -> str:
    """Say how much the models leave of a record."""
    models = {"the base refitted": record.refitted, f"the model {cause}": record.with_cause}
    left = {name: _rms(record.measured - model) for name, model in models.items() if model is not None}
    return ", ".join(f"{name} leaves {amount(rms, unit)} (root mean square)" for name, rms in left.items())


def _rms(values: np.ndarray) -> float:
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else math.nan


def _span(values: np.ndarray, unit: str) -> str:
    """Say between which values a signal runs."""
    known = values[np.isfinite(values)]
    ends = (float(known.min()), float(known.max())) if known.size else (math.nan, math.nan)
    return f"from {amount(ends[0], unit, like=ends)} to {amount(ends[1], unit, like=ends)}"


def _title_of(curve: Mapping[str, Any]) -> str:
    """Return the title of a signal's curves."""
    signal = str(curve["signal"])
    if curve.get("is_lead"):
        return f"{signal.capitalize()} that the {curve['stage']} would need by its own signals"
    return f"{signal.capitalize()} ({curve['stage']})" if curve["stage"] != "any" else signal.capitalize()


def _shown(curve: Mapping[str, Any]) -> str:
    """Say what of a signal is drawn."""
    if curve.get("is_lead"):
        return "Mean of"
    return f"{'Values' if curve.get('has_single') else 'Mean'} of what is left of"


def _curves_in_words(curves: Sequence[Mapping[str, Any]]) -> str:
    return ", ".join(f"{curve['against']} (explains {percent(curve['share'])})" for curve in curves)


def next_input(evidence: Evidence) -> Picture | None:
    """Return the designed current, if there is one."""
    if evidence.next_input is None:
        return None
    time, current = evidence.next_input
    wide, narrow = (
        Markup(figures.profile_picture(f"next-input{form}", time, current, is_wide=not form))
        for form in ("", "-narrow")
    )
    words = f"The designed current over {amount(float(time[-1] - time[0]), 's')}, {_span(current, 'A')}."
    return Picture(wide, "Designed current over time", words, narrow=narrow)


def heat_map(confusability: Mapping[str, Any] | None) -> Picture | None:
    """Return how alike the traces of the effects are, if it was computed."""
    if not confusability:
        return None
    return Picture(
        Markup(heat_map_picture("confusability", confusability)),
        "Which effect could pass for which",
        "Matrix of similarity between the traces of all effects, and how far each rises above the noise.",
        scrolls=True,
    )
