"""The report: one page of HTML with its pictures and style inside, that needs no network and no script."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template
from markupsafe import Markup

from diagnosis.report import figures
from diagnosis.report.amounts import amount, probability_text
from diagnosis.report.curves import curves_picture
from diagnosis.report.evidence import Evidence, RecordEvidence
from diagnosis.report.heatmap import heat_map_picture
from diagnosis.report.where import where_section
from diagnosis.report.words import Answer, cause_title, make_answer, printable, tied
from valvemodel.files import write_text

_SHOWN_RECORDS = 3
"""Records with pictures; more would make the page heavy and tell the same again."""
_TYPESET_EFFECTS = 8


@dataclass(frozen=True)
class Picture:
    """A picture with what it shows in words; `narrow` is its form for a phone."""

    svg: Markup
    title: str
    alternative: str
    narrow: Markup | None = None


@dataclass(frozen=True)
class RecordPictures:
    """The pictures of one record."""

    name: str
    halves: tuple[Picture, ...]
    residual: Picture


def render_page(diagnosis: Mapping[str, Any], evidence: Evidence) -> str:
    """Return the report as one self-contained page of HTML.

    Parameters
    ----------
    diagnosis : mapping
        The content of `diagnosis.json`.
    evidence : Evidence
        The data behind the pictures.
    """
    answer = make_answer(diagnosis, evidence.warnings)
    shown = evidence.records[:_SHOWN_RECORDS]
    page = _template().render(
        answer=answer,
        where=where_section(diagnosis),
        evidence=evidence,
        summary_pictures=_summary_pictures(answer, evidence),
        records=[
            _record_pictures(f"r{number}", record, evidence.unit, _cause_label(diagnosis))
            for number, record in enumerate(shown)
        ],
        record_names=[record.name for record in evidence.records],
        records_left_out=[record.name for record in evidence.records[_SHOWN_RECORDS:]],
        residual_pictures=_residual_pictures(diagnosis.get("residual_curves") or ()),
        next_input=_next_input(evidence),
        heat_map=_heat_map(diagnosis.get("confusability")),
        equations=_equations(answer),
        length=_length(evidence),
    )
    return printable(page)


def write_page(path: str | Path, diagnosis: Mapping[str, Any], evidence: Evidence) -> None:
    """Write the report.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written.
    """
    write_text(Path(path), render_page(diagnosis, evidence))


@cache
def _template() -> Template:
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["tied"] = tied
    return environment.get_template("template.html")


def _cause_label(diagnosis: Mapping[str, Any]) -> str:
    """Return the legend of the model with the cause, short enough for a picture."""
    if diagnosis["verdict"] == "none":
        return "base, best fit"
    effects: list[str] = next((cause["effects"] for cause in diagnosis.get("causes") or () if cause["effects"]), [])
    label = f"with {cause_title(effects)}" if effects else "with the cause"
    if diagnosis["verdict"] == "unknown":
        return "nearest candidate"
    return label if len(label) <= 26 else "with the cause"


def _summary_pictures(answer: Answer, evidence: Evidence) -> list[Picture]:
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


def _record_pictures(name: str, record: RecordEvidence, unit: str, cause: str) -> RecordPictures:
    signal = figures.signal_name(unit)
    against = figures.abscissa_name(record)
    models = f"measured, base refitted{'' if record.with_cause is None else f' and {cause}'}"
    halves = []
    if against != "time":
        halves.append(
            Picture(
                Markup(figures.loop_picture(f"{name}-loop", record, unit, cause)),
                f"{signal.capitalize()} against {against}",
                f"Curves of {signal} against {against} in {record.name}: {models}.",
            )
        )
    halves.append(
        Picture(
            Markup(figures.time_picture(f"{name}-time", record, unit, cause)),
            f"{signal.capitalize()} over time",
            f"Curves of {signal} over time in {record.name}: {models}.",
        )
    )
    if record.measured_pressure is not None:
        halves.append(
            Picture(
                Markup(figures.pressure_picture(f"{name}-pressure", record, cause)),
                "Actuator pressure" + (" against current" if record.current is not None else " over time"),
                f"Curves of the actuator pressure in {record.name}: {models}.",
            )
        )
    wide = figures.residual_picture(f"{name}-residual", record, unit, cause, is_wide=True)
    narrow = figures.residual_picture(f"{name}-residual-narrow", record, unit, cause, is_wide=False)
    residual = Picture(
        Markup(wide),
        "What the models leave, over time and by regime",
        f"Measured less model over time in {record.name}, before and after the cause, with lanes that show "
        "where the stem rises, is stuck or falls and which blocks were held out of the fits.",
        narrow=Markup(narrow),
    )
    return RecordPictures(record.name, tuple(halves), residual)


def _residual_pictures(curves: Sequence[Mapping[str, Any]]) -> list[Picture]:
    signals = dict.fromkeys(curve["signal"] for curve in curves)
    by_signal = {signal: [curve for curve in curves if curve["signal"] == signal] for signal in signals}
    return [
        Picture(
            Markup(curves_picture(f"left-{signal}", own)),
            f"{signal.capitalize()} ({own[0]['stage']})" if own[0]["stage"] != "any" else signal.capitalize(),
            f"Curves of the residual {signal} over {', '.join(curve['against'] for curve in own)}.",
        )
        for signal, own in by_signal.items()
    ]


def _next_input(evidence: Evidence) -> Picture | None:
    if evidence.next_input is None:
        return None
    markup = figures.profile_picture("next-input", *evidence.next_input)
    return Picture(Markup(markup), "Designed current over time", "Curve of the designed current over time.")


def _heat_map(confusability: Mapping[str, Any] | None) -> Picture | None:
    if not confusability:
        return None
    return Picture(
        Markup(heat_map_picture("confusability", confusability)),
        "Which effect could pass for which",
        "Matrix of similarity between the traces of all effects, and how far each rises above the noise.",
    )


def _equations(answer: Answer) -> dict[str, Markup]:
    """Return the typeset equation of each effect in the first causes; a missing one is shown as text."""
    equations: dict[str, Markup] = {}
    for cause in answer.causes:
        for effect in cause.effects:
            if effect.equation and effect.key not in equations and len(equations) < _TYPESET_EFFECTS:
                markup = figures.equation_picture(f"equation-{effect.key}", effect.equation)
                equations[effect.key] = Markup(markup)
    return equations


def _length(evidence: Evidence) -> str:
    samples = sum(len(record.time) for record in evidence.records)
    seconds = sum(float(record.time[-1] - record.time[0]) for record in evidence.records)
    return f"{samples:,} samples, {seconds:,.0f} s"
