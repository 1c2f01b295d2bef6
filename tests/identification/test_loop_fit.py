"""Fits of settled loops: what they determine, what not, and how the current went."""

from __future__ import annotations

import numpy as np
import pytest

from identification.determined.bootstrap import bootstrap
from identification.determined.neighbourhood import neighbourhood_of
from identification.experiment import experiment_of
from identification.fit import fit_base
from identification.fitting import fit_records
from identification.results.outcome import Outcome
from valvemodel.errors import InputError
from valvemodel.loops import settle_loop, shape_of_loop
from valvemodel.model import Model
from valvemodel.records import Record
from valvemodel.valves import read_valve

UP, DOWN = np.arange(4.0, 18.01, 0.5), np.arange(17.5, 3.99, -0.5)
CURRENT = np.concatenate([UP, DOWN]) * 1e-3
"""57 settled currents, 0.5 mA apart, as in the paper's Fig. 7. [A]"""


def calibrated(**changes: float) -> Model:
    valve = read_valve("calibrated")
    return Model(valve.name, valve.values).with_values(**changes)


def fitted(truth: Model, *, noise: float, seed: int = 1, is_ramped: bool = False, effects: tuple = ()) -> Outcome:
    position = settle_loop(truth, current=CURRENT, is_ramped=is_ramped)
    position += noise * np.ptp(position) * np.random.default_rng(seed).standard_normal(len(position))
    record = Record.from_arrays("loop", current=CURRENT, position=position)
    return fit_records([record], calibrated(), effects=effects, is_ramped=is_ramped)


def test_width_slope_and_height_of_a_noisy_loop() -> None:
    truth = calibrated(spring_rate=60000.0, coulomb_friction=1700.0)
    outcome = fitted(truth, noise=0.005)
    loop = outcome.as_json()["loop"]
    assert loop["driven"] == "stepped"
    shape = shape_of_loop(truth, position=loop["position"]["value"], highest_current=0.027)
    for name, unit in (("width", "A"), ("slope", "m/A"), ("height", "m")):
        assert loop[name]["unit"] == unit
        assert loop[name]["value"] == pytest.approx(getattr(shape, name), rel=0.01)
        assert 0.0 < loop[name]["std"] < 0.01 * getattr(shape, name)


def test_a_stop_is_found_in_a_loop_as_a_dead_one() -> None:
    """How a stem goes into a stop that gives way is no closed form: a loop is settled without."""
    outcome = fitted(calibrated().with_effect("end_stop", upper_stop=0.19), noise=0.002, effects=("end_stop",))
    found = outcome.as_json()
    assert outcome.model.effects["end_stop"]["upper_stop"] == pytest.approx(0.19, abs=1e-3)
    assert outcome.model.effects["end_stop"]["stop_compliance"] == 0.0
    assert found["loop"]["width"]["std"] > 0.0
    assert all(each.name != "stop_compliance" for each in outcome.parameters)


def test_what_an_overdamped_loop_does_not_determine_is_said() -> None:
    outcome = fitted(calibrated(), noise=0.002)
    assert {"stem_mass", "viscous_friction"} <= set(outcome.open)
    assert any("holds no time" in warning for warning in outcome.warnings)


def test_damping_below_the_critical_is_partly_determined_by_a_stepped_loop() -> None:
    truth = calibrated(viscous_friction=130.0)
    outcome = fitted(truth, noise=0.0005)
    found = {each.name: each for each in outcome.parameters}
    ratio = {
        name: values["viscous_friction"] / np.sqrt(values["spring_rate"] * values["stem_mass"])
        for name, values in (
            ("truth", truth.values),
            ("found", {name: each.value for name, each in found.items()}),
        )
    }
    assert ratio["found"] == pytest.approx(ratio["truth"], rel=0.1)


def test_static_friction_of_a_ramped_loop() -> None:
    truth = calibrated().with_effect("static_friction", static_friction_ratio=1.3)
    outcome = fitted(truth, noise=0.002, is_ramped=True, effects=("static_friction",))
    assert outcome.as_json()["loop"]["driven"] == "ramped"
    assert outcome.loop is not None
    found = next(each for each in outcome.parameters if each.name == "coulomb_friction")
    spring = next(each for each in outcome.parameters if each.name == "spring_rate")
    # The breakaway force itself is left open by a loop of ramps, and takes a part of the width: which part hangs on
    # rounding. For ratios of 1.2, 1.3 and 1.4 the friction is off by less than 0.1, 3.2 and 6.5 %.
    assert found.value / spring.value == pytest.approx(1423.0 / 52500.0, rel=0.05)


def test_a_bootstrap_of_a_ramped_loop_that_is_fitted_exactly_finds_no_spread() -> None:
    truth = calibrated(viscous_friction=130.0)
    position = settle_loop(truth, current=CURRENT, is_ramped=True)
    loop = experiment_of(Record.from_arrays("loop", current=CURRENT, position=position), is_ramped=True)
    drawn = bootstrap(neighbourhood_of(fit_base(truth, [loop])), 3)
    for name in ("spring_rate", "coulomb_friction"):
        std, low, high = drawn[name]
        assert std < 1e-6 * truth.values[name]
        assert low == pytest.approx(truth.values[name]) == high


def test_only_loops_are_ramped() -> None:
    time = np.arange(100) * 0.5
    current = 0.012 + 0.006 * np.sin(0.3 * time)
    record = Record.from_arrays("timed", time=time, current=current, position=current)
    with pytest.raises(InputError, match="only a settled loop is stepped or ramped"):
        fit_records([record], calibrated(), is_ramped=True)
    loop = Record.from_arrays("loop", current=CURRENT, position=settle_loop(calibrated(), current=CURRENT))
    with pytest.raises(InputError, match="a ramped loop is fitted with no effects but"):
        fit_records([loop], calibrated(), effects=["linkage_backlash"], is_ramped=True)
