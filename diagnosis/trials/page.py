"""The page of a blind test: rates first, then pictures, then every answer that was not right."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from markupsafe import Markup

from diagnosis.report.amounts import percent, probability_text, rounded
from diagnosis.report.naming import cause_title, printable
from diagnosis.report.page import page_template
from diagnosis.report.pictures import Picture
from diagnosis.trials import figures
from diagnosis.trials.marking import OUTCOMES
from diagnosis.trials.words import KIND_TITLES, figure_rows, rate_rows
from valvemodel.files import write_text


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
    page = page_template(Path(__file__).parent).render(
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
            f"Bars of the outcomes by kind of plant: {_outcomes_in_words(content['kinds'])}.",
        )
    ]
    if content["calibration"]["bins"]:
        pictures.append(
            Picture(
                Markup(figures.calibration_picture("calibration", content["calibration"]["bins"])),
                "Probability said, and how often it was true",
                f"Frequency found over the probability said: {_bins_in_words(content['calibration']['bins'])}.",
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
                f"Share of the plants over the share of the reducible gap that is closed on unseen records: in the "
                f"median {percent(median(shares))}.",
            )
        )
    if seconds:
        pictures.append(
            Picture(
                Markup(figures.seconds_picture("seconds", seconds)),
                "Seconds of computing a record",
                f"Share of the plants over the seconds that the diagnosis computed on one core: in the median "
                f"{rounded(median(seconds), 2)} s.",
            )
        )
    return pictures


def _outcomes_in_words(kinds: Mapping[str, Any]) -> str:
    counts = {
        name: ", ".join(f"{count} {outcome}" for outcome, count in kind["outcomes"].items())
        for name, kind in kinds.items()
    }
    return "; ".join(f"{name}: {words}" for name, words in counts.items())


def _bins_in_words(bins: Sequence[Mapping[str, Any]]) -> str:
    known = [each for each in bins if each["found"]["of"]]
    return ", ".join(
        f"{percent(each['found']['share'])} where {percent(each['said'])} was said ({each['found']['of']} plants)"
        for each in known
    )


def _matrices(content: Mapping[str, Any]) -> list[Picture]:
    titles = {
        "single": "One effect",
        "left-out": "One effect that is no candidate",
    }
    confusion = content["confusion"]
    return [
        Picture(
            Markup(figures.confusion_picture(f"confusion-{kind}", kind, confusion)),
            title,
            "Matrix of counts: a row for each effect that is there, a column for each answer; an alias of it is paler.",
            scrolls=True,
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
