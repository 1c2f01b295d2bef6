"""The terminal's answer: the page's words, in 80 columns, with every place whole."""

from __future__ import annotations

import io
from typing import Any

import pytest
from report_samples import SAMPLES, cause, effect, none, two_effects
from rich.console import Console

from diagnosis.report import print_answer
from diagnosis.report.words import make_answer


def printed(diagnosis: dict[str, Any], *, width: int = 80, **places: str) -> str:
    file = io.StringIO()
    print_answer(diagnosis, Console(file=file, width=width), places)
    return file.getvalue()


def joined(text: str) -> str:
    return " ".join(text.split())


@pytest.mark.parametrize("name", SAMPLES)
def test_answer_fits_and_says_what_the_page_says(name: str) -> None:
    diagnosis, _ = SAMPLES[name]()
    text, answer = printed(diagnosis), make_answer(diagnosis)
    assert all(len(line) <= 80 and line == line.rstrip() for line in text.splitlines())
    assert "\x1b" not in text
    for sentence in (answer.headline, answer.explanation, answer.confidence, answer.next_step, *answer.where):
        assert sentence in joined(text)
    assert not {"None", "nan"} & set(text.replace(",", " ").split())


def test_places_are_never_broken() -> None:
    place = "/a/very/long/folder" * 8 + "/report.html"
    assert place in printed(effect()[0], report=place)


def test_text_is_not_read_as_markup() -> None:
    diagnosis = effect()[0] | {"warnings": ["record [bold]a[/bold] [/] \x1b[31mred"]}
    assert "record [bold]a[/bold] [/] \ufffd[31mred" in joined(printed(diagnosis))


@pytest.mark.parametrize(
    ("probability", "rivals", "headline"),
    [
        (0.97, [], "The model lacks coil lag."),
        (0.7, [], "The model most likely lacks coil lag."),
        (0.4, [], "The model lacks something; the best guess is coil lag."),
        (0.97, [["sensor_lag"]], "The model lacks coil lag or sensor lag."),
        (0.97, [[]], "The model may lack coil lag, but other base parameters explain this record as well."),
    ],
)
def test_headline_is_as_sure_as_the_probability(probability: float, rivals: list, headline: str) -> None:
    diagnosis = effect()[0]
    diagnosis["causes"] = [cause(["coil_lag"], probability, 1e-4, 0.9, indistinguishable_from=rivals)]
    assert make_answer(diagnosis).headline == headline


def test_alternatives_in_another_stage_are_said() -> None:
    diagnosis = effect()[0]
    diagnosis["causes"] = [
        cause(["spring_hardening"], 0.9, 1e-4, 0.9, indistinguishable_from=[["linkage_nonlinearity"]])
    ]
    assert "An effect that looks the same here would lie in the sensor." in make_answer(diagnosis).where


def test_none_without_alternatives_says_so() -> None:
    diagnosis = none()[0]
    diagnosis["causes"][0]["indistinguishable_from"] = []
    assert "No listed effect could hide" in make_answer(diagnosis).alternatives_sentence


def test_two_effects_lie_in_both_of_their_stages() -> None:
    answer = make_answer(two_effects()[0])
    assert answer.where[0].startswith("The effects lie in the stem (")
    assert "and the sensor (" in answer.where[0]
    assert "An effect that looks the same here would lie in the electromagnet or the nozzle." in answer.where
    assert [stage.name for stage in answer.stages if stage.is_found] == ["stem", "sensor"]
