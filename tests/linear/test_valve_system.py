"""The exact valve in python-control's own simulation equals the simulator's."""

import control as ct
import numpy as np
import pytest

from valvemodel.linear import exact_system
from valvemodel.model import Model
from valvemodel.simulation import simulate
from valvemodel.stepping import SteppedValve
from valvemodel.valves import read_valve

PERIOD = 0.01


def valve(**effects) -> Model:
    found = read_valve("calibrated")
    return Model(found.name, found.values, effects)


@pytest.mark.parametrize(
    ("model", "bound"),
    [
        (valve(), 1e-13),
        (valve(static_friction={}, linkage_backlash={}), 1e-13),
        (valve(chamber_filling={}, stribeck={}, presliding={}), 1e-13),
        # Arrivals that differ by rounding are integrated to the tolerance.
        (valve(transport_delay={"transport_delay": 0.034}, chamber_filling={}, presliding={}), 1e-9),
    ],
    ids=["base", "stick and play", "chamber and bristles", "line before them"],
)
def test_input_output_response_is_the_simulation(model, bound):
    time = PERIOD * np.arange(400)
    current = 12e-3 + 4e-3 * np.sin(3.0 * time)
    system = exact_system(model, period=PERIOD, current=current[0])
    assert isinstance(system, ct.NonlinearIOSystem)
    response = ct.input_output_response(system, time, current, system.start)
    exact = simulate(model, time=time, current=current)
    assert np.abs(response.outputs[0] - exact.position).max() < bound
    assert np.abs(response.outputs[2] - exact.pressure).max() < 1e-7


def test_loop_closed_in_python_control_is_the_loop_stepped_by_hand():
    model, setpoint, gain = valve(static_friction={}), 0.15, 0.02
    plant = exact_system(model, period=PERIOD, current=12e-3)
    law = ct.nlsys(
        lambda time, states, inputs, parameters: states + 5.0 * PERIOD * gain * (setpoint - inputs),
        lambda time, states, inputs, parameters: states + gain * (setpoint - inputs),
        inputs=["reading"], outputs=["current"], states=1, dt=PERIOD, name="law",
    )  # fmt: skip
    loop = ct.interconnect([plant, law], inputs=None, outputs=["reading"], check_unused=False)
    time = PERIOD * np.arange(300)
    response = ct.input_output_response(loop, time, 0.0, [*plant.start, 12e-3])
    stepped, integral = SteppedValve(model, current=12e-3), 12e-3
    readings = []
    for _ in time:
        readings.append(stepped.reading)
        error = setpoint - stepped.reading
        current = integral + gain * error
        integral += 5.0 * PERIOD * gain * error
        stepped.step(current, PERIOD)
    assert np.ptp(readings) > 1e-3
    assert np.abs(np.ravel(response.outputs) - readings).max() < 1e-12
