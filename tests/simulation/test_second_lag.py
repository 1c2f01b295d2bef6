"""Two lags in series behind the stem, against integrations that take them one after the other."""

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
PAIRS = [(0.1, 0.03), (0.03, 0.1), (0.06, 0.06), (0.06, 0.06 * (1.0 + 2e-4)), (0.0, 0.05)]
EFFECTS = [
    (), ("linkage_backlash",), ("linkage_nonlinearity",), ("chamber_filling",), ("spring_hardening",), ("presliding",),
    ("static_friction", "linkage_backlash", "linkage_nonlinearity"),
]  # fmt: skip


def with_lags(first: float, second: float, *keys: str, **values: float) -> Model:
    numbers = {"sensor_time_constant": first, "sensor_second_time_constant": second}
    return with_effects(base_model(**values), *keys).with_effect("sensor_lag", **numbers)


def apart(one: Model, other: Model) -> float:
    return float(np.abs(run(one, TIME, CURRENT) - run(other, TIME, CURRENT)).max())


BOUNDS = {TOLERANCE: 1e-9, FINE_TOLERANCE: 5e-7, SEARCH_TOLERANCE: 5e-5}
"""What a run is off at most, by its tolerance. [m]"""


@pytest.mark.parametrize("keys", EFFECTS, ids=" ".join)
def test_two_lags_agree_with_an_independent_integration(keys):
    model = with_lags(0.1, 0.03, *keys)
    row = model.rows()[0]
    expected = IndependentChain({name: float(row[name]) for name in row.dtype.names}).run(TIME, CURRENT)
    for tolerance, bound in BOUNDS.items():
        assert np.abs(run(model, TIME, CURRENT, tolerance=tolerance) - expected).max() < bound, tolerance


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("damping", [612.9, 1.59])
def test_lags_near_and_far_apart_agree_with_the_independent_integration(pair, damping):
    model = with_lags(*pair, viscous_friction=damping)
    row = model.rows()[0]
    expected = IndependentChain({name: float(row[name]) for name in row.dtype.names}).run(TIME, CURRENT)
    assert np.abs(run(model, TIME, CURRENT) - expected).max() < 1e-9


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("keys", [(), ("linkage_backlash", "linkage_nonlinearity")], ids=" ".join)
def test_lags_agree_with_the_reference(pair, keys):
    model = with_lags(*pair, *keys)
    found = simulate(model, time=TIME, current=CURRENT).position
    assert np.abs(found - simulate_slowly(model, time=TIME, current=CURRENT).position).max() < 1e-9


def test_order_of_the_lags_does_not_matter():
    assert apart(with_lags(0.1, 0.03), with_lags(0.03, 0.1)) == 0.0
    assert apart(with_lags(0.0, 0.05), with_lags(0.05, 0.0)) == 0.0


def test_second_lag_fades_into_none():
    changes = [apart(with_lags(0.1, second), with_lags(0.1, 0.0)) for second in (1e-2, 1e-5, 1e-8)]
    assert changes[0] > 1e-4
    assert changes[1] < 2e-3 * changes[0]
    assert changes[2] < 2e-6 * changes[0]


@pytest.mark.parametrize("pair", PAIRS)
def test_stepping_behind_two_lags_equals_a_whole_run_to_the_last_bit(pair):
    model = with_lags(*pair, "stribeck", "linkage_backlash")
    assert (stepped_readings(model, TIME, CURRENT) == simulate(model, time=TIME, current=CURRENT).position).all()


def test_stem_that_is_put_anew_is_read_without_delay():
    model = with_lags(0.1, 0.03, "linkage_nonlinearity")
    anchors, readings = np.full(len(TIME), np.nan), np.empty((1, len(TIME)))
    anchors[60], anchors[100] = 0.05, 0.12
    runs.run_chain(
        model.rows(), np.zeros(1, STATE), np.zeros(1, MEMORY), TIME, CURRENT,
        anchors, runs.CURRENT, TOLERANCE, readings, runs.NONE, runs.NONE,
    )  # fmt: skip
    assert readings[0, [60, 100]] == pytest.approx([0.05, 0.12], abs=1e-14)
    assert np.abs(readings[0, 59] - 0.05) > 1e-3
