"""Two lags in series, of the reading or of the flux, against integrations that take them one after the other."""

import numpy as np
import pytest
from independent_chain import IndependentChain
from simulation_runs import base_model, ramps_and_steps, run, stepped_readings, with_effects

from identification.problem import FINE_TOLERANCE, SEARCH_TOLERANCE
from valvemodel import runs
from valvemodel.model import Model
from valvemodel.parameters import MEMORY, STATE
from valvemodel.reference import simulate_slowly
from valvemodel.simulation import simulate
from valvemodel.trajectory import TOLERANCE

TIME, CURRENT = ramps_and_steps(seconds=3.0, seed=1)
NAMES = {
    "sensor_lag": ("sensor_time_constant", "sensor_second_time_constant"),
    "coil_lag": ("coil_time_constant", "eddy_time_constant"),
}
LAGS = {"sensor_lag": (0.1, 0.03), "coil_lag": (0.1, 0.02)}
PAIRS = [
    (key, pair)
    for key, lags in LAGS.items()
    for pair in (lags, lags[::-1], (0.06, 0.06), (0.06, 0.06 * (1.0 + 2e-4)), (0.0, 0.05))
]
BESIDE = {
    "sensor_lag": [
        (), ("linkage_backlash",), ("linkage_nonlinearity",), ("chamber_filling",), ("spring_hardening",),
        ("presliding",), ("static_friction", "linkage_backlash", "linkage_nonlinearity"),
    ],
    "coil_lag": [
        (), ("magnetic_saturation",), ("chamber_filling",), ("supply_droop",), ("static_friction",),
        ("gap_drift", "sensor_lag"),
    ],
}  # fmt: skip
LOOPS = {"Bouc and Wen": {"bouc_wen_gamma": 0.2}, "Dahl": {}, "plays": {"return_point_memory": 1.0}}


def with_lags(key: str, pair: tuple[float, float], *keys: str, **values: float) -> Model:
    return with_effects(base_model(**values), *keys).with_effect(key, **dict(zip(NAMES[key], pair, strict=True)))


def apart(key: str, one: tuple[float, float], other: tuple[float, float]) -> float:
    return float(np.abs(run(with_lags(key, one), TIME, CURRENT) - run(with_lags(key, other), TIME, CURRENT)).max())


BOUNDS = {TOLERANCE: 1e-9, FINE_TOLERANCE: 5e-7, SEARCH_TOLERANCE: 5e-5}
"""What a run is off at most, by its tolerance. [m]"""

TURNING = {**BOUNDS, FINE_TOLERANCE: 2e-6}
"""The same behind the lags of a coil: there the pressure turns within a period. [m]"""


@pytest.mark.parametrize(("key", "keys"), [(key, keys) for key in BESIDE for keys in BESIDE[key]])
def test_two_lags_agree_with_an_independent_integration(key, keys):
    model = with_lags(key, LAGS[key], *keys)
    expected = IndependentChain.of(model).run(TIME, CURRENT)
    for tolerance, bound in (TURNING if key == "coil_lag" else BOUNDS).items():
        assert np.abs(run(model, TIME, CURRENT, tolerance=tolerance) - expected).max() < bound, tolerance


@pytest.mark.parametrize("pair", [pair for key, pair in PAIRS if key == "sensor_lag"])
@pytest.mark.parametrize("damping", [612.9, 1.59])
def test_lags_near_and_far_apart_agree_with_the_independent_integration(pair, damping):
    model = with_lags("sensor_lag", pair, viscous_friction=damping)
    expected = IndependentChain.of(model).run(TIME, CURRENT)
    assert np.abs(run(model, TIME, CURRENT) - expected).max() < 1e-9


@pytest.mark.parametrize(("key", "pair"), PAIRS)
@pytest.mark.parametrize("is_plain", [True, False])
def test_lags_agree_with_the_reference(key, pair, is_plain):
    beside = {"sensor_lag": ("linkage_backlash", "linkage_nonlinearity"), "coil_lag": ("presliding",)}[key]
    model = with_lags(key, pair, *(() if is_plain else beside))
    found = simulate(model, time=TIME, current=CURRENT).position
    assert np.abs(found - simulate_slowly(model, time=TIME, current=CURRENT).position).max() < 1e-9


@pytest.mark.parametrize("loop", LOOPS)
@pytest.mark.parametrize("pair", [(0.1, 0.02), (0.06, 0.06)])
def test_flux_that_turns_within_a_period_turns_the_loop_there(loop, pair):
    """Behind two lags the flux goes on for a while after the current has turned; each way has its own branch."""
    model = with_lags("coil_lag", pair)
    model = model.with_effect("magnetic_hysteresis", hysteresis_half_width=4e-4, **LOOPS[loop])
    found = simulate(model, time=TIME, current=CURRENT).position
    assert np.abs(found - simulate_slowly(model, time=TIME, current=CURRENT).position).max() < 1e-9
    coarse = run(model, TIME, CURRENT, tolerance=SEARCH_TOLERANCE)
    assert np.abs(coarse - found).max() < TURNING[SEARCH_TOLERANCE]


@pytest.mark.parametrize("key", LAGS)
def test_order_of_the_lags_does_not_matter(key):
    assert apart(key, LAGS[key], LAGS[key][::-1]) == 0.0
    assert apart(key, (0.0, 0.05), (0.05, 0.0)) == 0.0


@pytest.mark.parametrize("key", LAGS)
def test_second_lag_fades_into_none(key):
    changes = [apart(key, (0.1, second), (0.1, 0.0)) for second in (1e-2, 1e-5, 1e-8)]
    assert changes[0] > 1e-4
    assert changes[1] < 2e-3 * changes[0]
    assert changes[2] < 2e-6 * changes[0]


@pytest.mark.parametrize(("key", "pair"), PAIRS)
def test_stepping_behind_two_lags_equals_a_whole_run_to_the_last_bit(key, pair):
    beside = {"sensor_lag": "linkage_backlash", "coil_lag": "magnetic_hysteresis"}[key]
    model = with_lags(key, pair, "stribeck", beside)
    assert (stepped_readings(model, TIME, CURRENT) == simulate(model, time=TIME, current=CURRENT).position).all()


def test_stem_that_is_put_anew_is_read_without_delay():
    model = with_lags("sensor_lag", (0.1, 0.03), "linkage_nonlinearity")
    anchors, readings = np.full(len(TIME), np.nan), np.empty((1, len(TIME)))
    anchors[60], anchors[100] = 0.05, 0.12
    runs.run_chain(
        model.rows(), np.zeros(1, STATE), np.zeros(1, MEMORY), TIME, CURRENT,
        anchors, runs.CURRENT, TOLERANCE, readings, runs.NONE, runs.NONE,
    )  # fmt: skip
    assert readings[0, [60, 100]] == pytest.approx([0.05, 0.12], abs=1e-14)
    assert np.abs(readings[0, 59] - 0.05) > 1e-3
