"""Designed inputs are admissible, tell more than plain ramps, and promise what repetitions show."""

from __future__ import annotations

import math

import numpy as np
import pytest

from identification.design import search
from identification.design.choice import chosen_parameters
from identification.design.inputs import NUMBERS_A_SEGMENT, SEGMENTS, Limits, pattern_current, standard_ramp
from identification.design.search import design, loss_of
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.valves import read_valve

FREE = Limits(4e-3, 20e-3, math.inf, 0.5, 40.0, 0.02)


def nominal() -> Model:
    valve = read_valve("calibrated")
    return Model(valve.name, valve.values)


@pytest.mark.parametrize("rate", [math.inf, 4e-3])
@pytest.mark.parametrize("dwell", [0.0, 2.0])
def test_patterns_keep_range_rate_and_dwell(rate: float, dwell: float) -> None:
    limits = Limits(5e-3, 18e-3, rate, dwell, 60.0, 0.02)
    generator = np.random.default_rng(4)
    for _ in range(40):
        current = pattern_current(limits, generator.uniform(0.0, 1.0, SEGMENTS * NUMBERS_A_SEGMENT))
        assert current.shape == limits.time.shape
        assert current.min() >= limits.low
        assert current.max() <= limits.high
        change = np.diff(current)
        # Currents are rounded to a tenth of a microampere.
        assert np.abs(change).max() <= rate * limits.period + 1.01e-7
        held = np.flatnonzero(np.abs(change) > 1e-9)
        turns = held[1:][np.sign(change[held[1:]]) != np.sign(change[held[:-1]])]
        before = held[:-1][np.sign(change[held[1:]]) != np.sign(change[held[:-1]])]
        assert np.all((turns - before - 1) * limits.period >= dwell - 2 * limits.period)


def test_standard_ramp_goes_through_the_range() -> None:
    current = standard_ramp(FREE)
    assert current.min() == pytest.approx(FREE.low)
    assert current.max() == pytest.approx(FREE.high)


def test_a_design_tells_more_than_ramps_and_keeps_its_promise(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "GENERATIONS", 8)
    said = []
    found = design(
        nominal(),
        ["viscous_friction", "spring_rate"],
        FREE,
        noise=1e-4,
        repetitions=30,
        progress=lambda what, share: said.append(share),
    )
    assert [each.name for each in found.expectations] == ["spring_rate", "viscous_friction"]
    for each in found.expectations:
        assert each.design < each.ramp
        assert each.observed == pytest.approx(each.design, rel=0.4), each.name
    assert said == sorted(said)
    content = found.as_json()
    assert content["parameters"]["spring_rate"]["std_design"] == found.expectations[0].design


def test_criteria_of_a_known_matrix() -> None:
    matrix = np.diag([4.0, 25.0, 100.0])
    assert loss_of(matrix, [0, 1], "D") == pytest.approx(math.log(0.25 * 0.04))
    assert loss_of(matrix, [0, 1], "A") == pytest.approx(math.log(0.25 + 0.04))
    with pytest.raises(InputError, match="known: A, D"):
        loss_of(matrix, [0, 1], "E")


def test_names_are_letters_or_full() -> None:
    names = chosen_parameters("k, coulomb_friction,f_v,c0", nominal())
    assert names == ["spring_rate", "coulomb_friction", "viscous_friction", "gap_offset"]
    sticky = nominal().with_effect("static_friction")
    assert chosen_parameters("F_s", sticky) == ["static_friction_ratio"]
    saturated = nominal().with_effect("magnetic_saturation", saturation_slope=0.8)
    assert chosen_parameters("saturation_slope", saturated) == ["saturation_slope"]
    with pytest.raises(InputError):
        chosen_parameters("saturation_reach", saturated)  # the law of two straight lines holds it


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("S_1", "current and position tell only"),
        ("F_s", "F_s = F_c"),
        ("k,spring_rate", "came twice"),
        ("spring_rat", "spring_rate"),
        (" , ", "at least one"),
    ],
)
def test_names_that_cannot_be_designed_for(text: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        chosen_parameters(text, nominal())


@pytest.mark.parametrize(
    "wrong",
    [{"low": 0.03}, {"rate": 0.0}, {"rate": 1e-4}, {"dwell": -1.0}, {"period": 1.0}, {"period": 0.0}],
)
def test_limits_that_no_current_keeps(wrong: dict[str, float]) -> None:
    given = {"low": 4e-3, "high": 20e-3, "rate": math.inf, "dwell": 0.5, "duration": 60.0, "period": 0.02}
    with pytest.raises(InputError):
        Limits(**{**given, **wrong})
