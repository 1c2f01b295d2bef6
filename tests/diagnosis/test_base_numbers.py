"""The report tells what the fit made of the valve's own numbers, and which of them matters most."""

import json
from dataclasses import asdict

import numpy as np
import pytest

from diagnosis.base_numbers import base_numbers
from diagnosis.blindtest.plants import draw_plant, measure
from diagnosis.report.base_numbers import number_rows, refit_sentence
from identification.determined.uncertainty import estimates
from identification.experiment import experiment_of
from identification.fit import fit_base, simulate_model
from valvemodel.records import Record


@pytest.fixture(scope="module")
def told(given):
    """A valve with a spring 12 % stiffer than given, and else as given."""
    plant_current = measure(draw_plant(5, ()), 1005, duration=60.0)["current"]
    time = 0.02 * np.arange(len(plant_current))
    blank = experiment_of(Record.from_arrays(name="stiff", time=time, current=plant_current, position=0.0 * time))
    stiff = given.with_values(spring_rate=1.12 * given.values["spring_rate"])
    clean = simulate_model(stiff, blank, start_position=float("nan")).position[0]
    noisy = clean + 1e-4 * np.random.default_rng(1).standard_normal(len(time))
    experiment = experiment_of(Record.from_arrays(name="stiff", time=time, current=plant_current, position=noisy))
    base = fit_base(given, [experiment])
    return given, [experiment], base, base_numbers(given, base, base, estimates(base), [experiment])


def test_number_that_differs_matters_most_and_the_others_are_as_given(told):
    given, experiments, _, numbers = told
    by_name = {each.name: each for each in numbers}
    stiff = by_name["spring_rate"]
    assert stiff.given == given.values["spring_rate"]
    assert stiff.found == pytest.approx(1.12 * stiff.given, abs=4.0 * stiff.std)
    assert stiff.refitted == stiff.found
    # A spring and the area under the pressure share one scale: putting the spring back costs what it closed.
    noise = experiments[0].noise
    assert stiff.gap_as_given > 20.0 * noise
    assert numbers == sorted(numbers, key=lambda each: -each.gap_as_given)
    assert by_name["coulomb_friction"].found == pytest.approx(given.values["coulomb_friction"], rel=0.15)


def test_numbers_are_told_in_words(told):
    numbers = told[3]
    content = {"base": {"numbers": [asdict(each) for each in numbers]}, "gap": {"as_given": 8e-3, "refitted": 1e-3}}
    json.dumps(content, allow_nan=False)
    rows = number_rows(content)
    assert [row.name for row in rows] == [each.name for each in numbers]
    assert next(row for row in rows if row.name == "spring_rate").given == "52500 N/m"
    assert "matters most" in refit_sentence(content)
    assert refit_sentence({**content, "gap": {"as_given": 1.2e-3, "refitted": 1e-3}}) == ""
    assert refit_sentence({"gap": {"as_given": 1.0, "refitted": 0.1}}) == ""
    assert number_rows({}) == ()


def test_letters_of_the_paper_are_left_out_of_the_sentence():
    number = {"name": "gap_offset", "unit": "m", "given": 126e-6, "refitted": 119e-6, "found": 119e-6, "std": None}
    content = {"base": {"numbers": [number | {"gap_as_given": 0.03}]}, "gap": {"as_given": 0.02, "refitted": 1e-3}}
    assert "the gap of the flapper at no current matters most" in refit_sentence(content)
    assert number_rows(content)[0].found == "not determined"
