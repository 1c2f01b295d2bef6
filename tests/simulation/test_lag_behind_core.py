"""A flux that lags behind the core, where saturation and loop are of the current: closed form, plain Python, smooth."""

import numpy as np
import pytest
from simulation_runs import base_model, flux_current, off_the_exact_run, with_values

from valvemodel.model import Model
from valvemodel.reference import simulate_slowly
from valvemodel.simulation import simulate

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
    return with_values(base_model(), **effects)


@pytest.mark.parametrize("core", [{}, {"magnetic_saturation": KNEE}, {"magnetic_hysteresis": LOOPS["plays"]}])
def test_the_flux_follows_what_the_core_makes_of_the_current(core):
    """Held for a period each, what the core makes of it is followed by a first-order lag."""
    aims, found = flux_current(CURRENT, **core), flux_current(CURRENT, **core, coil_lag=LAG)
    share = np.exp(-0.02 / LAG["coil_time_constant"])
    expected, flux = [], aims[0]
    for aim in aims:
        flux = aim + (flux - aim) * share
        expected.append(flux)
    assert np.abs(found - expected).max() < 1e-10
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
    off = off_the_exact_run(model, TIME, CURRENT)
    assert off[1] < 1e-5
    assert off[1] <= off[0]
