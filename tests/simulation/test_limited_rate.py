"""A pressure whose rate is limited far too little to be felt: the run is that without a limit, in its time."""

import numpy as np
import pytest
from simulation_runs import base_model, ramps_and_steps, run, with_effects

from identification.problem import SEARCH_TOLERANCE
from valvemodel.stages.nodes import fall_between, fit_powers
from valvemodel.trajectory import TOLERANCE

TIME, CURRENT = ramps_and_steps(seconds=10.0, seed=3)
SLOWNESS = 10.0 ** -np.array([22.0, 18.0, 15.0, 13.0, 12.0, 11.0, 10.0, 9.0])
BOUNDS = {TOLERANCE: 1e-9, SEARCH_TOLERANCE: 2e-6}
"""What a run is off at most beside what the limit does, by its tolerance. [m]"""


def readings(fill_time: float, vent_time: float, slowness: float, tolerance: float) -> np.ndarray:
    numbers = {"fill_time": fill_time, "vent_time": vent_time, "filling_slowness": slowness}
    model = with_effects(base_model(), "sensor_lag").with_effect("asymmetric_filling", **numbers)
    return run(model, TIME, CURRENT, tolerance=tolerance)


@pytest.mark.parametrize("tolerance", BOUNDS)
@pytest.mark.parametrize(("fill_time", "vent_time"), [(0.0, 0.004), (0.004, 0.0), (0.0, 0.0), (0.03, 0.0)])
@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_what_a_limit_does_is_in_proportion_to_it(fill_time, vent_time, way, tolerance):
    free = readings(fill_time, vent_time, 0.0, tolerance)
    felt = (readings(fill_time, vent_time, way * 1e-9, tolerance) - free) / 1e-9
    for slowness in SLOWNESS:
        off = readings(fill_time, vent_time, way * slowness, tolerance) - free
        # What is felt of a limit is not quite in proportion: within a hundredth up to 1e-9 s/Pa.
        expected = np.abs(felt).max() * slowness
        assert np.abs(off - felt * slowness).max() < BOUNDS[tolerance] + 0.02 * expected, slowness


@pytest.mark.parametrize("fall", [1e-15, 3e-7, 0.2, 0.5, 0.999999])
@pytest.mark.parametrize("bend", [0.0, 0.3, -0.3])
def test_a_fall_is_found_where_it_is(fall, bend):
    # (fall - x) (1 + bend x): from before the fall alone, from beyond it alone, and from both.
    nodes = np.arange(4.0)
    powers = np.empty(4)
    fit_powers(3, (fall - nodes) * (1.0 + bend * nodes), powers)
    found = fall_between(3, powers, 0.0, 1.0)
    assert found == pytest.approx(fall, rel=1e-9, abs=1e-14)
