"""The terminal's answer: the page's words, in 80 columns, with every place whole."""

from __future__ import annotations

import io
from typing import Any

import pytest
from report_samples import SAMPLES, cause, effect, none, two_effects, unknown
from rich.console import Console

from diagnosis.report import print_answer
from diagnosis.report.words import make_answer
from valvemodel.effects import effect_of_key


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


def test_what_tells_rivals_apart_is_said_once_and_of_what_differs() -> None:
    answer = make_answer(two_effects()[0])
    assert answer.alternatives_sentence == "This record cannot tell sensor lag from coil lag or transport delay."
    assert [each.title for each in answer.alternatives] == ["coil lag", "transport delay"]
    assert all(len(each.told_apart_by) == 1 for each in answer.alternatives)


def test_nearest_candidate_of_an_unknown_cause_has_no_alternatives() -> None:
    diagnosis = unknown()[0]
    diagnosis["causes"][0]["indistinguishable_from"] = [["choked_flow"]]
    assert make_answer(diagnosis).alternatives == ()


@pytest.mark.parametrize(
    ("separation", "words"),
    [
        ({"now": 0.1, "profile": 2.0, "pressure_now": 9.0}, "record the current profile in next.csv: refitted"),
        ({"now": 0.1, "profile": 0.2, "pressure_now": 9.0}, "measure the pressure: under the same input"),
        (
            {"now": 0.1, "profile": 0.2, "pressure_now": 0.3, "profile_and_pressure": 0.8},
            "record the current profile in next.csv and measure the pressure",
        ),
        ({"now": 0.1, "profile": 0.2, "pressure_now": 0.3}, "nor does a measured pressure: refitted, they would"),
        ({"now": 0.1, "profile": 0.2}, "apart: refitted, they would differ by 0.2 times the noise at most"),
        ({"now": 7.0, "profile": 5.1}, "no current profile within the limits tells more than the record that is there"),
    ],
)
def test_next_step_asks_for_what_tells_rivals_apart(separation: dict[str, float], words: str) -> None:
    diagnosis = effect()[0]
    rivals = [["static_friction"], ["stribeck"]]
    diagnosis["next_experiment"] = {"file": "next.csv", "rivals": rivals, "is_open": True, "separation": separation}
    answer = make_answer(diagnosis)
    assert words in answer.designed
    assert answer.next_step == f"{answer.designed} Until then use the found model (model.json) with care."


def test_a_gap_that_grows_is_not_closed() -> None:
    diagnosis = effect()[0]
    diagnosis["causes"][2] |= {"gap_closed": -0.34, "gap_closed_interval": [-0.4, -0.001]}
    row = make_answer(diagnosis).causes[3]
    assert (row.closed, row.closed_interval) == ("nothing", "-40 to 0 %")


def test_only_effects_worth_saying_are_told_about() -> None:
    diagnosis = effect()[0]
    assert [told.key for told, _ in make_answer(diagnosis).told] == ["static_friction", "stribeck"]


def test_none_without_alternatives_says_so() -> None:
    diagnosis = none()[0]
    diagnosis["causes"][0]["indistinguishable_from"] = []
    assert "No listed effect could hide" in make_answer(diagnosis).alternatives_sentence


def test_none_is_said_of_the_readings_that_are_left_alone() -> None:
    """What shows itself only right after the current moves is not in the others."""
    diagnosis = none()[0]
    diagnosis["gap"] |= {"sampling_error": 0.0, "left_out": 0.5}
    answer = make_answer(diagnosis)
    assert answer.headline.startswith("The record says too little of the current")
    assert "50 % of the readings are left out" in answer.explanation
    assert answer.next_step.startswith("Log the current")
    diagnosis["gap"]["left_out"] = 0.1
    assert make_answer(diagnosis).headline.startswith("The model lacks nothing")


@pytest.mark.parametrize(
    ("probability", "sampling_error", "headline", "next_step"),
    [
        (0.95, 0.0, "The model lacks nothing: refitted, it explains this record.", "Use the refitted model"),
        (0.7, 0.0, "The model most likely lacks nothing: refitted, it explains this record.", "Use the refitted model"),
        (0.4, 0.0, "The record does not decide whether the model lacks anything.", "A second record of the valve"),
        (
            0.95,
            1.4e-4,
            "The record says too little of the current to show whether the model lacks anything.",
            "Log the current",
        ),
    ],
)
def test_none_is_said_as_surely_as_the_record_shows_it(
    probability: float, sampling_error: float, headline: str, next_step: str
) -> None:
    diagnosis = none()[0]
    diagnosis["causes"][0] |= {"probability": probability, "indistinguishable_from": []}
    diagnosis["gap"]["sampling_error"] = sampling_error
    answer = make_answer(diagnosis)
    assert answer.headline == headline
    assert answer.next_step.startswith(next_step)
    is_open = headline.startswith("The record")
    assert (answer.tag == "Cannot tell") == is_open
    assert ("comes down to the noise" in answer.explanation) != is_open
    assert ("could hide" in answer.alternatives_sentence) == (sampling_error == 0.0)
    assert ("beside what goes unseen" in answer.confidence) == (sampling_error > 0.0)


def test_two_effects_lie_in_both_of_their_stages() -> None:
    answer = make_answer(two_effects()[0])
    assert answer.where[0].startswith("The effects lie in the stem (")
    assert "and the sensor (" in answer.where[0]
    assert "An effect that looks the same here would lie in the electromagnet or the nozzle." in answer.where
    assert [stage.name for stage in answer.stages if stage.is_found] == ["stem", "sensor"]


@pytest.mark.parametrize(("waves", "is_of_this_record"), [(1.0, False), (20.0, True)])
def test_a_load_that_varied_at_will_is_said_to_be_that_of_this_record(waves: float, is_of_this_record: bool) -> None:
    diagnosis = effect()[0]
    sizes = {name: {"value": 40.0, "unit": "N", "std": 2.0} for name in ("load_sine", "load_sine_2", "load_cosine_20")}
    load = {"load_waves": {"value": waves, "unit": "1", "std": None}, **sizes}
    diagnosis["causes"] = [cause(["load_force"], 0.9, 1.58e-4, 0.99, parameters={"load_force": load})]
    answer = make_answer(diagnosis)
    assert ("that of this record alone" in answer.next_step) == is_of_this_record
    assert ("confirms it" in answer.next_step) != is_of_this_record
    text = printed(diagnosis)
    assert "load_sine = 40" in text
    assert "load_sine_2" not in text


def test_the_law_that_an_effect_follows_is_said_to_be_chosen_where_it_is_another_than_the_first() -> None:
    diagnosis = effect()[0]
    chosen, first = ({"value": value, "unit": "1", "std": None} for value in (1.0, 0.0))
    filling = {"filling_of_gas": chosen, "laminar_filling": first}
    diagnosis["causes"] = [cause(["chamber_filling"], 0.9, 1.58e-4, 0.99, parameters={"chamber_filling": filling})]
    text = printed(diagnosis)
    assert "filling_of_gas = 1 (chosen)" in text
    assert "laminar_filling" not in text


@pytest.mark.parametrize(
    ("key", "values", "said"),
    [
        ("end_stop", {"upper_stop": 0.2, "stop_compliance": 0.0}, "stop_compliance = 0 µm/N (chosen)"),
        ("end_stop", {"upper_stop": 0.2, "stop_compliance": 2e-7}, "stop_compliance = 0.2000 ± 0.0020 µm/N"),
        ("quantisation", {"resolution": 5e-4}, "resolution = 0.500 mm (read off the record)"),
    ],
)
def test_a_number_that_no_fit_moved_is_said_with_its_unit_and_where_it_comes_from(key, values, said) -> None:
    diagnosis = effect()[0]
    units = {each.name: each.unit for each in effect_of_key(key).parameters}
    found = {name: {"value": value, "unit": units[name], "std": 0.01 * value} for name, value in values.items()}
    diagnosis["causes"] = [cause([key], 0.9, 1.58e-4, 0.99, parameters={key: found})]
    assert said in printed(diagnosis)


def test_a_parameter_is_said_with_what_it_means_without_its_letter() -> None:
    diagnosis = effect()[0]
    slowness = {"filling_slowness": {"value": 2e-6, "unit": "s/Pa", "std": 1e-8}}
    diagnosis["causes"] = [cause(["asymmetric_filling"], 0.9, 1e-4, 0.99, parameters={"asymmetric_filling": slowness})]
    assert "(inverse of a rate limit, of venting where positive" in joined(printed(diagnosis))


@pytest.mark.parametrize("yardstick", ["free run", "re-anchored on the measured position every 2 s"])
def test_a_gap_of_re_anchored_runs_is_said_to_be_one(yardstick: str) -> None:
    diagnosis = effect()[0]
    diagnosis["gap"] = diagnosis["gap"] | {"yardstick": yardstick}
    assert (f", each model {yardstick}." in joined(printed(diagnosis))) == (yardstick != "free run")
