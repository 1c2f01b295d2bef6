"""A leak that chokes, against the balance of both flows solved by a library; later laws against plain Python."""

import numpy as np
import pytest
from scipy.optimize import brentq

from valvemodel.model import Model
from valvemodel.reference import simulate_slowly
from valvemodel.simulation import simulate
from valvemodel.valves import read_valve

TIME = np.linspace(0.0, 6.0, 301)
CURRENT = np.interp(TIME, [0.0, 3.0, 6.0], [4e-3, 20e-3, 6e-3])
OUTSIDE = 101325.0


def valve(**effects: dict[str, float]) -> Model:
    found = read_valve("calibrated")
    return Model(found.name, found.values, effects)


def flow(before: float, behind: float) -> float:
    """Return the flow from one absolute pressure to another through a hole of choked flow 1 at a pressure of 1."""
    above = max(behind / before - 0.528, 0.0) / (1.0 - 0.528)
    return before * np.sqrt(max(1.0 - above**2, 0.0))


def behind_hole(pressure: float, area: float) -> float:
    """Return the gauge pressure between a restriction and a hole, so many times as large. [Pa]"""
    before = pressure + OUTSIDE
    balance = lambda between: flow(before, between) - area * flow(between, OUTSIDE)  # noqa: E731
    return brentq(balance, OUTSIDE, before, xtol=1e-8, rtol=1e-14) - OUTSIDE if pressure > 0.0 else pressure


@pytest.mark.parametrize("area", [0.05, 0.5, 1.2])
def test_pressure_behind_a_choking_leak_balances_both_flows(area):
    leak = {"leak_ratio": 0.0, "turbulent_leak_ratio": area**2, "leak_chokes": 1.0}
    supplied = simulate(valve(), time=TIME, current=CURRENT).pressure
    found = simulate(valve(air_leak=leak), time=TIME, current=CURRENT).pressure
    expected = np.array([behind_hole(each, area) for each in supplied])
    assert expected.max() > 1.2 * OUTSIDE  # the larger pressures choke, the smaller do not
    assert expected.min() < 0.5 * OUTSIDE
    assert np.abs(found - expected).max() < 1e-3


def test_later_laws_agree_with_the_reference_beside_others():
    leak = {"leak_ratio": 0.1, "turbulent_leak_ratio": 0.3, "leak_chokes": 1.0}
    tanh = {"saturation_slope": 0.0, "saturation_knee": 4e-3, "saturation_reach": 8e-3, "saturation_law": 1.0}
    core = {"magnetic_saturation": tanh, "magnetic_hysteresis": {}, "coil_lag": {"coil_time_constant": 0.02}}
    model = valve(**core, air_leak=leak, choked_flow={}, chamber_filling={"chamber_filling_time": 0.05})
    few = slice(0, 40)
    found = simulate(model, time=TIME[few], current=CURRENT[few]).position
    assert np.abs(found - simulate_slowly(model, time=TIME[few], current=CURRENT[few]).position).max() < 5e-9


def test_a_choking_leak_without_a_hole_is_none():
    none = valve(air_leak={"leak_ratio": 0.0, "turbulent_leak_ratio": 0.0, "leak_chokes": 1.0})
    found, plain = (simulate(each, time=TIME, current=CURRENT).position for each in (none, valve()))
    assert np.array_equal(found, plain)
