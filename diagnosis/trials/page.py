"""The page of a blind test: rates first, then pictures, then every answer that was not right."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

import diagnosis.report
from diagnosis.report.amounts import probability_text, rounded
from diagnosis.report.page import Picture
from diagnosis.report.words import cause_title, printable, tied
from diagnosis.trials import figures
from diagnosis.trials.marking import OUTCOMES
from diagnosis.trials.words import KIND_TITLES, figure_rows, rate_rows
from valvemodel.files import write_text

_FOLDERS = [Path(__file__).parent, Path(diagnosis.report.__file__).parent]


def write_page(path: Path, content: Mapping[str, Any]) -> None:
    """Write the page of a blind test's content, that of blindtest.json.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written.
    """
    write_text(path, render_page(content))


def render_page(content: Mapping[str, Any]) -> str:
    """Return the page as self-contained HTML."""
    environment = Environment(
        loader=FileSystemLoader(_FOLDERS),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["tied"] = tied
    page = environment.get_template("template.html").render(
        content=content,
        headline=headline_of(content),
        rates=list(rate_rows(content)),
        figures=list(figure_rows(content)),
        pictures=_pictures(content),
        matrices=_matrices(content),
        misses=[_miss_words(each) for each in content["results"] if not each["mark"]["is_right"]],
        outcomes=OUTCOMES,
    )
    return printable(page)


def headline_of(content: Mapping[str, Any]) -> str:
    """Return the result in one sentence."""
    right = sum(counts["right"]["hits"] for counts in content["kinds"].values())
    return f"The diagnosis was right on {right} of {content['plants']} sealed plants."


def _pictures(content: Mapping[str, Any]) -> list[Picture]:
    pictures = [
        Picture(
            Markup(figures.outcomes_picture("outcomes", content["kinds"])),
            "What came out",
            "Bars of the outcomes by kind of plant.",
        )
    ]
    if content["calibration"]["bins"]:
        pictures.append(
            Picture(
                Markup(figures.calibration_picture("calibration", content["calibration"]["bins"])),
                "Probability said, and how often it was true",
                "Points of the frequency found over the probability said, with intervals, beside the diagonal.",
            )
        )
    known = [each for each in content["results"] if each["kind"] in ("single", "pair")]
    shares = [share for each in known if (share := each["closure"].get("closed")) is not None]
    seconds = [each["computing_seconds"] for each in content["results"] if each["computing_seconds"] is not None]
    if shares:
        pictures.append(
            Picture(
                Markup(figures.share_picture("closure", shares)),
                "Gap closed on an unseen record",
                "Share of the plants over the share of the reducible gap that is closed on unseen records.",
            )
        )
    if seconds:
        pictures.append(
            Picture(
                Markup(figures.seconds_picture("seconds", seconds)),
                "Seconds of computing a record",
                "Share of the plants over the seconds that the diagnosis computed on one core.",
            )
        )
    return pictures


def _matrices(content: Mapping[str, Any]) -> list[Picture]:
    titles = {
        "single": "What is there, and what is named first: one effect",
        "left-out": "What is there but no candidate, and what is named first",
    }
    confusion = content["confusion"]
    return [
        Picture(
            Markup(figures.confusion_picture(f"confusion-{kind}", kind, confusion)),
            title,
            "Matrix of counts: a row for each effect that is there, a column for each answer.",
        )
        for kind, title in titles.items()
        if kind in confusion
    ]


def _miss_words(result: Mapping[str, Any]) -> dict[str, str]:
    laws = ", ".join(result["formulations"]).replace("_", " ")
    truth = cause_title(result["truth"]) if result["truth"] else "nothing"
    named = result["mark"]["named"]
    visibility = result["visibility"]
    return {
        "plant": result["plant"],
        "truth": f"{truth} ({laws})" if laws else truth,
        "answer": cause_title(named) if named else result["verdict"],
        "outcome": f"{result['mark']['outcome']}, {KIND_TITLES[result['kind']]}",
        "said": probability_text(result["mark"]["said"]),
        "visibility": "–" if visibility is None else rounded(visibility, 2),
    }
