"""Effects without a closed form against an adaptive integrator of high order that shares no code with the simulator."""

import numpy as np
import pytest
from independent_chain import IndependentChain
from simulation_runs import base_model, ramps_and_steps, run, with_effects

from identification.problem import FINE_TOLERANCE, SEARCH_TOLERANCE
from valvemodel.trajectory import TOLERANCE

INTEGRATED = (
    "coil_lag", "gap_drift", "chamber_filling", "asymmetric_filling", "supply_droop", "stribeck",
    "position_dependent_friction", "presliding", "spring_hardening", "load_force", "friction_drift",
)  # fmt: skip

BOUNDS = {TOLERANCE: 1e-9, FINE_TOLERANCE: 1e-7, SEARCH_TOLERANCE: 5e-5}
"""What a run is off at most, by its tolerance. [m]"""

PAIRS = (
    ("area_variation", "load_force"), ("friction_drift", "load_force"), ("chamber_filling", "spring_hardening"),
    ("coil_lag", "position_dependent_friction"), ("supply_droop", "friction_drift"), ("gap_drift", "stribeck"),
    ("magnetic_hysteresis", "coil_lag"), ("asymmetric_filling", "sensor_lag"),
    ("coil_lag", "stribeck"), ("chamber_filling", "stribeck"),
    ("sensor_lag", "linkage_nonlinearity"), ("sensor_lag", "linkage_nonlinearity", "linkage_backlash"),
    ("sensor_lag", "chamber_filling", "linkage_backlash"), ("sensor_lag", "spring_hardening", "linkage_backlash"),
    ("magnetic_hysteresis", "chamber_filling", "stribeck", "linkage_backlash"),
)  # fmt: skip


@pytest.mark.parametrize("keys", [*((key,) for key in INTEGRATED), *PAIRS], ids=" ".join)
def test_run_is_within_its_tolerance(keys):
    model = with_effects(base_model(), *keys)
    time, current = ramps_and_steps(seconds=3.0, seed=1)
    expected = IndependentChain.of(model).run(time, current)
    for tolerance, bound in BOUNDS.items():
        assert np.abs(run(model, time, current, tolerance=tolerance) - expected).max() < bound, tolerance


def test_bouc_and_wen_behind_a_coil_that_lags_is_within_its_tolerance():
    law = {"hysteresis_half_width": 4e-4, "hysteresis_roundness": 0.2, "bouc_wen_gamma": 0.4}
    model = with_effects(base_model(), "coil_lag").with_effect("magnetic_hysteresis", **law)
    time, current = ramps_and_steps(seconds=3.0, seed=1)
    expected = IndependentChain.of(model).run(time, current)
    for tolerance, bound in BOUNDS.items():
        assert np.abs(run(model, time, current, tolerance=tolerance) - expected).max() < bound, tolerance


@pytest.mark.parametrize("shape", [1.0, 2.0])
@pytest.mark.parametrize("keys", [(), ("coil_lag",), ("sensor_lag",), ("friction_drift",)], ids=" ".join)
def test_friction_that_falls_with_a_tail_is_within_its_tolerance(keys, shape):
    law = {"stribeck_ratio": 1.4, "stribeck_velocity": 8e-3, "stribeck_shape": shape, "stribeck_tail": 1.0}
    model = with_effects(base_model(), *keys).with_effect("stribeck", **law)
    time, current = ramps_and_steps(seconds=3.0, seed=1)
    expected = IndependentChain.of(model).run(time, current)
    for tolerance, bound in BOUNDS.items():
        # What a step is off grows while the friction falls.
        allowed = bound if tolerance == TOLERANCE else 3.0 * bound
        assert np.abs(run(model, time, current, tolerance=tolerance) - expected).max() < allowed, tolerance


def test_progressive_spring_is_within_its_tolerance():
    model = base_model().with_effect("spring_hardening", spring_hardening=2.0, spring_progression=1.0)
    time, current = ramps_and_steps(seconds=3.0, seed=1)
    expected = IndependentChain.of(model).run(time, current)
    assert np.abs(run(model, time, current) - expected).max() < BOUNDS[TOLERANCE]


@pytest.mark.parametrize("times", [(2e-3, 0.08, 4e-3), (8e-3, 2e-3, 6e-3), (2e-3, 0.08, 0.01), (2e-3, 1e-3, 0.05)])
def test_unequal_filling_behind_a_coil_that_lags_is_within_its_tolerance(times):
    coil, fill, vent = times
    model = base_model().with_effect("coil_lag", coil_time_constant=coil)
    model = model.with_effect("asymmetric_filling", fill_time=fill, vent_time=vent, filling_slowness=0.0)
    time, current = ramps_and_steps(seconds=3.0, seed=1)
    expected = IndependentChain.of(model).run(time, current)
    # Where the direction turns, the integration that judges is itself up to two tenths of a micrometre off.
    for tolerance, bound in {FINE_TOLERANCE: 3e-7, SEARCH_TOLERANCE: 1e-5}.items():
        assert np.abs(run(model, time, current, tolerance=tolerance) - expected).max() < bound, tolerance
