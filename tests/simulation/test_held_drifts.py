"""A coarse run takes slow drifts in steps, within its tolerance of an independent integration, and a fast one not."""

import numpy as np
import pytest
from independent_chain import IndependentChain
from simulation_runs import base_model, ramps_and_steps, run, with_effects

from identification.problem import SEARCH_TOLERANCE
from valvemodel import runs
from valvemodel.equations import numeric
from valvemodel.model import Model
from valvemodel.parameters import MEMORY, STATE
from valvemodel.stages.drifts import STEEPEST, longest_period, may_hold_drifts
from valvemodel.trajectory import TOLERANCE

TIME, CURRENT = ramps_and_steps(seconds=12.0, seed=3)
PERIOD = longest_period(TIME)
SLOW = {
    "gap_drift": {"gap_drift_rate": -2e-8, "gap_drift_time": 40.0},
    "load_force": {"load_sine": 120.0, "load_cosine": -60.0, "load_period": 17.0},
    "friction_drift": {"friction_drift_rate": 8e-3, "friction_drift_time": 30.0},
}


def drifting(key: str, *others: str, **values: float) -> Model:
    return with_effects(base_model(), *others).with_effect(key, **{**SLOW[key], **values})


@pytest.mark.parametrize("key", SLOW)
def test_a_coarse_run_is_within_its_tolerance_of_an_independent_integration(key):
    model = drifting(key)
    assert may_hold_drifts(model.rows()[0], PERIOD, SEARCH_TOLERANCE)
    coarse = run(model, TIME, CURRENT, tolerance=SEARCH_TOLERANCE)
    independent = IndependentChain.of(model).run(TIME, CURRENT)
    assert np.abs(coarse - independent).max() < SEARCH_TOLERANCE
    without = run(model.without_effect(key), TIME, CURRENT)
    assert np.abs(coarse - without).max() > 50.0 * SEARCH_TOLERANCE


@pytest.mark.parametrize("key", SLOW)
@pytest.mark.parametrize("other", ["static_friction", "chamber_filling", "coil_lag", "transport_delay", "sensor_lag"])
def test_a_coarse_run_beside_another_effect_is_within_its_tolerance_of_a_fine_one(key, other):
    model = drifting(key, other)
    coarse, fine = (run(model, TIME, CURRENT, tolerance=tolerance) for tolerance in (SEARCH_TOLERANCE, TOLERANCE))
    assert np.sqrt(np.mean((coarse - fine) ** 2)) < SEARCH_TOLERANCE


def test_a_coarse_run_lets_the_friction_of_a_seal_drift_too():
    model = drifting("friction_drift").with_effect("pressure_dependent_friction", friction_area=5e-3)
    assert may_hold_drifts(model.rows()[0], PERIOD, SEARCH_TOLERANCE)
    coarse = run(model, TIME, CURRENT, tolerance=SEARCH_TOLERANCE)
    independent = IndependentChain.of(model).run(TIME, CURRENT)
    assert np.abs(coarse - independent).max() < SEARCH_TOLERANCE


@pytest.mark.parametrize("key", SLOW)
def test_what_drifts_fast_or_is_sampled_slowly_is_followed_exactly(key):
    row = drifting(key).rows()[0]
    assert not may_hold_drifts(row, PERIOD, TOLERANCE)
    assert not may_hold_drifts(row, 100.0 * PERIOD, SEARCH_TOLERANCE)
    assert not may_hold_drifts(base_model().rows()[0], PERIOD, SEARCH_TOLERANCE)
    fast = drifting("load_force", load_period=0.8)
    assert not may_hold_drifts(fast.rows()[0], PERIOD, SEARCH_TOLERANCE)
    coarse, fine = (run(fast, TIME, CURRENT, tolerance=tolerance) for tolerance in (SEARCH_TOLERANCE, TOLERANCE))
    assert np.abs(coarse - fine).max() < SEARCH_TOLERANCE


@pytest.mark.parametrize("key", SLOW)
def test_a_run_leaves_its_numbers_as_they_were(key):
    rows = drifting(key).rows(2)
    before = rows.copy()
    runs.run_chain(
        rows, np.zeros(2, STATE), np.zeros(1, MEMORY), TIME, CURRENT, runs.FREE, 0, SEARCH_TOLERANCE,
        np.empty((2, len(TIME))), np.empty((2, 0)), np.empty((2, 0)),
    )  # fmt: skip
    names = [name for name in rows.dtype.names if not np.isnan(before[name][0])]
    assert all((rows[name] == before[name]).all() for name in names)


def test_the_pressure_falls_steepest_as_stated():
    values = base_model().numbers
    supply, ratio = values["supply_pressure"], values["flow_ratio"]
    gaps = np.linspace(0.0, 3.0 / np.sqrt(ratio), 20_001)
    steepest = np.abs(numeric.pressure_by_gap(gaps, supply, ratio)).max()
    assert steepest == pytest.approx(STEEPEST * supply * np.sqrt(ratio), rel=1e-6)
