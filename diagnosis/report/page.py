"""The report: one page of HTML with its pictures and style inside, that needs no network and no script."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template
from markupsafe import Markup

from diagnosis.report import pictures
from diagnosis.report.evidence import Evidence
from diagnosis.report.naming import printable, tied
from diagnosis.report.svg import equation_picture
from diagnosis.report.where import where_section
from diagnosis.report.words import Answer, make_answer
from identification.cores import begun, workers
from valvemodel.files import write_text

_SHOWN_RECORDS = 3
"""Records with pictures; more would make the page heavy and tell the same again."""


def render_page(diagnosis: Mapping[str, Any], evidence: Evidence, *, jobs: int | None = 1) -> str:
    """Return the report as one self-contained page of HTML.

    Parameters
    ----------
    diagnosis : mapping
        The content of `diagnosis.json`.
    evidence : Evidence
        The data behind the pictures.
    jobs : int or None
        Processes that draw at the same time; None for one a core.
    """
    import matplotlib.figure  # noqa: F401  Here, not once in each process.

    answer = make_answer(diagnosis, evidence.warnings)
    cause = pictures.cause_label(diagnosis)
    with workers(jobs) as pool:
        # The dearest first.
        heat_map = begun(pool, pictures.heat_map, diagnosis.get("confusability"))
        records = [
            begun(pool, pictures.record_pictures, f"r{number}", record, evidence.unit, cause)
            for number, record in enumerate(evidence.records[:_SHOWN_RECORDS])
        ]
        residuals = begun(pool, pictures.residual_pictures, diagnosis.get("residual_curves") or ())
        summary = begun(pool, pictures.summary_pictures, evidence)
        equations = begun(pool, _equations, answer)
        next_input = begun(pool, pictures.next_input, evidence)
        page = page_template().render(
            answer=answer,
            where=where_section(diagnosis),
            evidence=evidence,
            summary_pictures=summary(),
            records=[drawn() for drawn in records],
            record_names=[record.name for record in evidence.records],
            records_left_out=[record.name for record in evidence.records[_SHOWN_RECORDS:]],
            residual_pictures=residuals(),
            next_input=next_input(),
            heat_map=heat_map(),
            equations=equations(),
            length=_length(evidence),
        )
    return printable(page)


def write_page(path: str | Path, diagnosis: Mapping[str, Any], evidence: Evidence, *, jobs: int | None = 1) -> None:
    """Write the report, as `render_page` does.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written.
    """
    write_text(Path(path), render_page(diagnosis, evidence, jobs=jobs))


@cache
def page_template(*folders: Path) -> Template:
    """Return the template of the first of some folders; it may include what the others and this one hold."""
    environment = Environment(
        loader=FileSystemLoader([*folders, Path(__file__).parent]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["tied"] = tied
    return environment.get_template("template.html")


def _equations(answer: Answer) -> dict[str, Markup]:
    """Return the typeset equation of each effect that is told about; one that cannot be typeset is shown as text."""
    return {
        effect.key: Markup(equation_picture(f"equation-{effect.key}", effect.equation))
        for effect, _ in answer.told
        if effect.equation
    }


def _length(evidence: Evidence) -> str:
    samples = sum(len(record.time) for record in evidence.records)
    seconds = sum(float(record.time[-1] - record.time[0]) for record in evidence.records)
    return f"{samples:,} samples, {seconds:,.0f} s"
