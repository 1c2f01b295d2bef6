"""The core's eddy currents, a second lag behind the coil's, against integrations that take them one after the other."""

import numpy as np
import pytest
from independent_chain import IndependentChain
from simulation_runs import base_model, ramps_and_steps, run, stepped_readings, with_effects

from identification.problem import FINE_TOLERANCE, SEARCH_TOLERANCE
from valvemodel.model import Model
from valvemodel.reference import simulate_slowly
from valvemodel.simulation import simulate
from valvemodel.trajectory import TOLERANCE

TIME, CURRENT = ramps_and_steps(seconds=3.0, seed=1)
PAIRS = [(0.1, 0.02), (0.02, 0.1), (0.06, 0.06), (0.06, 0.06 * (1.0 + 2e-4)), (0.0, 0.05)]
EFFECTS = [
    (), ("magnetic_saturation",), ("chamber_filling",), ("supply_droop",), ("static_friction",),
    ("gap_drift", "sensor_lag"),
]  # fmt: skip
LOOPS = {
    "Bouc and Wen": {"bouc_wen_gamma": 0.2},
    "Dahl": {},
    "plays": {"return_point_memory": 1.0},
}


def with_lags(coil: float, eddies: float, *keys: str) -> Model:
    return with_effects(base_model(), *keys).with_effect("coil_lag", coil_time_constant=coil, eddy_time_constant=eddies)


def apart(one: Model, other: Model) -> float:
    return float(np.abs(run(one, TIME, CURRENT) - run(other, TIME, CURRENT)).max())


BOUNDS = {TOLERANCE: 1e-9, FINE_TOLERANCE: 2e-6, SEARCH_TOLERANCE: 5e-5}
"""What a run is off at most, by its tolerance, where the pressure turns within a period. [m]"""


@pytest.mark.parametrize("keys", EFFECTS, ids=" ".join)
def test_eddy_currents_behind_the_coil_agree_with_an_independent_integration(keys):
    model = with_lags(0.1, 0.02, *keys)
    row = model.rows()[0]
    expected = IndependentChain({name: float(row[name]) for name in row.dtype.names}).run(TIME, CURRENT)
    for tolerance, bound in BOUNDS.items():
        assert np.abs(run(model, TIME, CURRENT, tolerance=tolerance) - expected).max() < bound, tolerance


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("keys", [(), ("presliding",)], ids=" ".join)
def test_lags_near_and_far_apart_agree_with_the_reference(pair, keys):
    model = with_lags(*pair, *keys)
    found = simulate(model, time=TIME, current=CURRENT).position
    assert np.abs(found - simulate_slowly(model, time=TIME, current=CURRENT).position).max() < 1e-9


@pytest.mark.parametrize("loop", LOOPS)
@pytest.mark.parametrize("pair", [(0.1, 0.02), (0.06, 0.06)])
def test_flux_that_turns_within_a_period_turns_the_loop_there(loop, pair):
    """Behind two lags the flux goes on for a while after the current has turned; each way has its own branch."""
    model = with_lags(*pair).with_effect("magnetic_hysteresis", hysteresis_half_width=4e-4, **LOOPS[loop])
    found = simulate(model, time=TIME, current=CURRENT).position
    assert np.abs(found - simulate_slowly(model, time=TIME, current=CURRENT).position).max() < 1e-9
    coarse = run(model, TIME, CURRENT, tolerance=SEARCH_TOLERANCE)
    assert np.abs(coarse - found).max() < BOUNDS[SEARCH_TOLERANCE]


def test_order_of_the_lags_does_not_matter():
    assert apart(with_lags(0.1, 0.02), with_lags(0.02, 0.1)) == 0.0
    assert apart(with_lags(0.0, 0.05), with_lags(0.05, 0.0)) == 0.0


def test_eddy_currents_fade_into_none():
    changes = [apart(with_lags(0.1, eddies), with_lags(0.1, 0.0)) for eddies in (1e-2, 1e-5, 1e-8)]
    assert changes[0] > 1e-4
    assert changes[1] < 2e-3 * changes[0]
    assert changes[2] < 2e-6 * changes[0]


@pytest.mark.parametrize("pair", PAIRS)
def test_stepping_equals_a_whole_run_to_the_last_bit(pair):
    model = with_lags(*pair, "stribeck", "magnetic_hysteresis")
    assert (stepped_readings(model, TIME, CURRENT) == simulate(model, time=TIME, current=CURRENT).position).all()
