"""A current that was measured with noise is smoothed where the stem does not answer the noise, and there alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.blindtest.plants import draw_plant
from diagnosis.blindtest.profiles import draw_profile
from diagnosis.blindtest.valve import integrate
from identification.driving.measured_current import as_set, error_of_current, may_be_noisy, said_of_current
from identification.driving.timing import experiments_of
from identification.experiment import Experiment
from identification.fit import Fit, fit_base
from identification.fitting import fit_records
from valvemodel.model import Model
from valvemodel.records import Record
from valvemodel.valves import read_valve

NOISE, STEP = 8e-6, 1.6e-5

PLANT = draw_plant(21, ())


@pytest.fixture(scope="module")
def given() -> Model:
    valve = read_valve("calibrated")
    return Model(valve.name, valve.values)


@pytest.fixture(scope="module")
def profile() -> tuple[np.ndarray, np.ndarray]:
    return draw_profile(8, duration=60.0)


def white(current: np.ndarray) -> np.ndarray:
    return NOISE * np.random.default_rng(3).standard_normal(len(current))


def record_of(time: np.ndarray, driven: np.ndarray, recorded: np.ndarray) -> Record:
    """Return the record of a plant that one current drives while the other is recorded."""
    position = integrate(PLANT.base, time, driven)["position"]
    position = position + PLANT.noise * np.random.default_rng(4).standard_normal(len(time))
    return Record.from_arrays(name="noisy", time=time, current=recorded, position=position)


def with_base(record: Record, given: Model) -> tuple[Experiment, Fit]:
    (experiment,), _ = experiments_of([record])
    return experiment, fit_base(given, [experiment])


def missed(experiment: Experiment, given: Model) -> float:
    """Return what a base fitted to an experiment misses of it. [m]"""
    return float(np.nanstd(experiment.position - fit_base(given, [experiment]).simulated_on(experiment).position[0]))


@pytest.fixture(scope="module")
def measured(profile) -> Record:
    time, current = profile
    return record_of(time, current, current + white(current))


def test_noise_that_the_stem_does_not_answer_is_taken_out(given, profile, measured):
    experiment, base = with_base(measured, given)
    (found,) = as_set([experiment], base)
    assert found.current_noise == pytest.approx(NOISE, rel=0.1)
    assert np.std(found.current - profile[1]) < 0.5 * NOISE
    assert missed(found, given) < 1.3 * PLANT.noise < 0.8 * missed(experiment, given)
    (said,) = said_of_current([found])
    assert "measured with noise of 0.008" in said


def test_noise_that_drove_the_valve_is_kept(given, profile):
    time, current = profile
    driven = current + white(current)
    experiment, base = with_base(record_of(time, driven, driven), given)
    assert may_be_noisy(experiment)
    assert as_set([experiment], base) == [experiment]


def test_a_current_as_it_was_set_is_not_asked(given, profile):
    time, current = profile
    experiment, base = with_base(record_of(time, current, current), given)
    assert not may_be_noisy(experiment)
    assert as_set([experiment], base) == [experiment]
    assert error_of_current(experiment, base) == (0.0, 0.0)
    assert said_of_current([experiment]) == []


def test_a_rounded_current_counts_as_one_with_noise_of_its_steps(given, profile):
    time, current = profile
    experiment, base = with_base(record_of(time, current, STEP * np.round(current / STEP)), given)
    (found,) = as_set([experiment], base)
    assert found.current_step == pytest.approx(STEP)
    assert np.std(found.current - current) < 0.9 * np.std(experiment.current - current)
    (said,) = said_of_current([found])
    assert "rounded to steps of 0.016 mA" in said


def test_a_staircase_of_set_currents_is_not_taken_for_a_rounded_one(given):
    time = 0.02 * np.arange(3000)
    levels = 1e-3 * np.array([4, 8, 12, 16, 20, 16, 12, 8, 4, 12])
    current = np.repeat(levels, 300)
    experiment, base = with_base(record_of(time, current, current), given)
    assert as_set([experiment], base) == [experiment]


def test_what_is_left_of_the_noise_is_known(given, profile, measured):
    experiment, base = with_base(measured, given)
    (found,) = as_set([experiment], base)
    near = fit_base(given, [found])
    exact = replace(found, current=profile[1])
    runs = [near.simulated_on(each).smooth[0] for each in (found, exact)]
    really = float(np.sqrt(np.mean((runs[0] - runs[1])[np.isfinite(found.position)] ** 2)))
    assert error_of_current(found, near)[0] == pytest.approx(really, rel=0.5)


def test_a_fit_says_so_and_is_near_the_valve(given, measured):
    outcome = fit_records([measured], given)
    assert any("measured with noise" in warning for warning in outcome.warnings)
    friction = next(each for each in outcome.parameters if each.name == "coulomb_friction")
    assert friction.value == pytest.approx(PLANT.base["coulomb_friction"], rel=0.1)


@pytest.mark.parametrize(("rate", "is_asked"), [(10.0, True), (1.0, False)])
def test_the_way_of_a_current_between_slow_rows_is_not_taken_for_noise(profile, rate, is_asked):
    time, current = profile
    every = round(50.0 / rate)
    rough = current + 1e-3 * np.random.default_rng(3).standard_normal(len(time))
    (experiment,), _ = experiments_of([record_of(time, rough, rough).at_rows(slice(None, None, every))])
    assert may_be_noisy(experiment) == is_asked
