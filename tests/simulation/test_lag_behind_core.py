"""A flux that lags behind the core, where saturation and loop are of the current: closed form, plain Python, smooth."""

import numpy as np
import pytest

from valvemodel.model import Model
from valvemodel.reference import simulate_slowly
from valvemodel.simulation import simulate
from valvemodel.smooth.chain import SmoothChain, parts_for, run_smooth
from valvemodel.valves import read_valve

TIME = np.linspace(0.0, 6.0, 301)
CURRENT = np.interp(TIME, [0.0, 2.0, 2.02, 4.0, 4.02, 6.0], [8e-3, 14e-3, 17e-3, 15e-3, 9e-3, 12e-3])
LAG = {"coil_time_constant": 0.15, "lag_behind_core": 1.0}
EDDIES = {"coil_time_constant": 0.02, "eddy_time_constant": 0.15, "lag_behind_core": 1.0}
KNEE = {"saturation_slope": 0.4, "saturation_knee": 11e-3}
LOOPS = {
    "plays": {"hysteresis_half_width": 3e-4, "return_point_memory": 1.0},
    "bouc_wen": {"hysteresis_half_width": 3e-4, "bouc_wen_gamma": 0.3, "return_point_memory": 0.0},
}


def valve(**effects: dict[str, float]) -> Model:
    found = read_valve("calibrated")
    model = Model(found.name, found.values)
    for key, values in effects.items():
        model = model.with_effect(key, **values)
    return model


def gaps(model: Model) -> np.ndarray:
    """Return the gaps that give the pressures of a run, eq. (16). [m]"""
    share = simulate(model, time=TIME, current=CURRENT).pressure / model.values["supply_pressure"]
    return np.sqrt((1.0 / share - 1.0) / model.values["flow_ratio"])


def currents(model: Model) -> np.ndarray:
    """Return the currents that the flux stands for, eq. (31). [A]"""
    return ((model.values["gap_offset"] - gaps(model)) / model.values["gap_gain"]) ** 2


@pytest.mark.parametrize("core", [{}, {"magnetic_saturation": KNEE}, {"magnetic_hysteresis": LOOPS["plays"]}])
def test_the_flux_follows_what_the_core_makes_of_the_current(core):
    """Held for a period each, what the core makes of it is followed by a first-order lag."""
    aims, found = currents(valve(**core)), currents(valve(**core, coil_lag=LAG))
    share = np.exp(-(TIME[1] - TIME[0]) / LAG["coil_time_constant"])
    expected, flux = [], aims[0]
    for aim in aims:
        # A run gives the pressure at the end of the period, in which the current is held.
        expected.append(flux)
        flux = aim + (flux - aim) * share
    best = min(np.abs(found - np.roll(expected, -late))[1:-2].max() for late in (0, 1))
    assert best < 1e-10
    assert np.abs(found - aims).max() > 1e-3


def test_without_a_core_that_bends_the_order_changes_nothing():
    for lag in (LAG, EDDIES):
        before, behind = (valve(coil_lag={**lag, "lag_behind_core": order}) for order in (0.0, 1.0))
        found, plain = (simulate(each, time=TIME, current=CURRENT).position for each in (behind, before))
        assert np.array_equal(found, plain)


@pytest.mark.parametrize("loop", LOOPS)
@pytest.mark.parametrize("lag", [LAG, EDDIES], ids=["one lag", "two lags"])
def test_the_order_in_plain_python(lag, loop):
    model = valve(magnetic_saturation=KNEE, magnetic_hysteresis=LOOPS[loop], coil_lag=lag)
    few = slice(190, 225)
    found = simulate(model, time=TIME[few], current=CURRENT[few]).position
    assert np.abs(found - simulate_slowly(model, time=TIME[few], current=CURRENT[few]).position).max() < 5e-9
    first = model.with_effect("coil_lag", **{**lag, "lag_behind_core": 0.0})
    before = simulate(first, time=TIME[few], current=CURRENT[few])
    assert np.abs(found - before.position).max() > 1e-4


@pytest.mark.parametrize("loop", LOOPS)
def test_the_smooth_order_converges_to_the_exact_one(loop):
    model = valve(magnetic_saturation=KNEE, magnetic_hysteresis=LOOPS[loop], coil_lag=EDDIES)
    exact = simulate(model, time=TIME, current=CURRENT, start_position=0.02).position
    chain = SmoothChain(model, parts=parts_for(model, 0.01))
    off = [
        np.std(run_smooth(chain, time=TIME, current=CURRENT, start_position=0.02, width=width) - exact)
        for width in (30.0, 0.01)
    ]
    assert off[1] < 1e-5
    assert off[1] <= off[0]
