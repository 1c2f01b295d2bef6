"""A valve that is stepped gives what a whole run gives."""

import numpy as np
import pytest
from simulation_runs import EFFECT_KEYS, base_model, ramps_and_steps, stepped_readings, with_effects

from valvemodel.errors import InputError
from valvemodel.simulation import simulate
from valvemodel.stepping import SteppedValve


@pytest.mark.parametrize("keys", [(), *((key,) for key in EFFECT_KEYS), ("transport_delay", "stribeck", "sensor_lag")])
def test_stepping_equals_a_whole_run_to_the_last_bit(keys):
    time, current = ramps_and_steps(seconds=6.0)
    model = with_effects(base_model(), *keys)
    assert (stepped_readings(model, time, current) == simulate(model, time=time, current=current).position).all()


def test_a_refused_step_leaves_the_valve_as_it_was():
    valve = SteppedValve(base_model(), current=12e-3)
    before = (valve.time, valve.reading, valve.position)
    for current, duration in ((-1e-3, 0.01), (np.nan, 0.01), (12e-3, 0.0), (12e-3, np.inf)):
        with pytest.raises(InputError):
            valve.step(current, duration)
    assert (valve.time, valve.reading, valve.position) == before
