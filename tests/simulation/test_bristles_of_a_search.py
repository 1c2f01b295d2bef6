"""A search's runs of a stem on bristles keep to the exact ones, also where pressure or load move."""

import numpy as np
import pytest
from independent_chain import IndependentChain
from simulation_runs import base_model, ramps_and_steps, run

from identification.problem import SEARCH_TOLERANCE
from valvemodel.model import Model

TIME, CURRENT = ramps_and_steps(seconds=20.0, seed=7)

MOVING = {
    "filling": {"chamber_filling": {"chamber_filling_time": 0.15}},
    "unequal filling": {"asymmetric_filling": {"fill_time": 0.2, "vent_time": 0.1}},
    "coil": {"coil_lag": {"coil_time_constant": 0.3}},
    "filling and spring": {
        "chamber_filling": {"chamber_filling_time": 0.15},
        "spring_hardening": {"spring_hardening": 0.5},
    },
    "filling and area": {"chamber_filling": {"chamber_filling_time": 0.15}, "area_variation": {"area_slope": 0.2}},
    "filling and tight spot": {
        "chamber_filling": {"chamber_filling_time": 0.15},
        "position_dependent_friction": {"tight_spot_excess": 0.3},
    },
    "filling and stop": {"chamber_filling": {"chamber_filling_time": 0.15}, "end_stop": {"upper_stop": 0.15}},
    "filling and lag": {"chamber_filling": {"chamber_filling_time": 0.15}, "sensor_lag": {"sensor_time_constant": 0.3}},
    "filling and two lags": {
        "chamber_filling": {"chamber_filling_time": 0.15},
        "sensor_lag": {"sensor_time_constant": 0.3, "sensor_second_time_constant": 0.1},
    },
}


HELD = {
    "held": {},
    "load": {"load_force": {"load_sine": 1500.0, "load_cosine": 0.0, "load_period": 12.0}},
    "slow load": {"load_force": {"load_sine": 20.0, "load_cosine": 0.0, "load_period": 30.0}},
}
"""The current's steps jolt the stem: its swings are remembered, and count for more."""

OFF = {"filling and tight spot": 4.0, "held": 5.0, "load": 7.0, "slow load": 5.0}
"""Root mean square error over the tolerance, at most, where it is not far below it."""


def on_bristles(name: str, reach: float) -> Model:
    model = base_model()
    model = model.with_effect("presliding", presliding_compliance=reach / model.values["coulomb_friction"])
    for key, values in {**MOVING, **HELD}[name].items():
        model = model.with_effect(key, **values)
    return model


@pytest.mark.parametrize("reach", [2e-6, 2e-5, 2e-4, 2e-3])
@pytest.mark.parametrize("name", [*MOVING, *HELD])
def test_coarse_run_on_bristles_is_near_the_exact_one(name, reach):
    model = on_bristles(name, reach)
    off = run(model, TIME, CURRENT, tolerance=SEARCH_TOLERANCE) - run(model, TIME, CURRENT)
    assert np.sqrt(np.mean(off**2)) < OFF.get(name, 0.3) * SEARCH_TOLERANCE


@pytest.mark.parametrize("name", ["held", "filling", "filling and stop", "load", "filling and lag"])
def test_coarse_runs_on_bristles_come_nearer_as_their_tolerance_falls(name):
    model = on_bristles(name, 2e-4)
    exact = run(model, TIME, CURRENT)
    off = [np.abs(run(model, TIME, CURRENT, tolerance=tolerance) - exact).max() for tolerance in (1e-5, 1e-6, 1e-7)]
    assert off[2] < 0.3 * off[0]
    assert off[2] < 1e-6


def test_stem_pressed_on_a_stop_springs_back_when_the_force_turns():
    """Bristles that the stem bent on its way push it back at once, not from the next part of the period on."""
    model = on_bristles("filling and stop", 2e-4)
    time = np.arange(150) / 50.0
    current = np.interp(time, (0.0, 1.5, 3.0), (12e-3, 17e-3, 12e-3))
    independent = IndependentChain.of(model).run(time, current)
    exact = run(model, time, current)
    assert (exact == model.rows()[0]["upper_stop"]).sum() > 20
    assert np.abs(exact - independent).max() < 1e-8
