"""Linearisations against central differences of the exact simulator, closed forms and python-control."""

import control as ct
import numpy as np
import pytest
from linear_slips import slip_response

from valvemodel.linear import linearise
from valvemodel.linear.state_space import TREATMENTS
from valvemodel.model import Model
from valvemodel.stages import EFFECTS
from valvemodel.valves import read_valve

SPEED, CHANGE = 1e-5, 1e-9
"""Slow and small: the way of 0.1 um hardly bends anything. [m/s], [A]"""

TIME = np.linspace(0.0, 5e-3, 6)
QUICK = {
    "coil_lag": {"coil_time_constant": 4e-3},
    "chamber_filling": {"chamber_filling_time": 8e-3},
    "asymmetric_filling": {"fill_time": 4e-3, "vent_time": 7e-3},
    "supply_droop": {"droop_gain": 0.2, "droop_recovery_time": 0.05},
    "sensor_lag": {"sensor_time_constant": 4e-3},
    "presliding": {"presliding_compliance": 1e-8},
    "stribeck": {"stribeck_ratio": 1.1, "stribeck_velocity": 0.3},
}
"""Quick enough to show in that time."""


def valve(name: str = "calibrated", **effects: dict[str, float]) -> Model:
    found = read_valve(name)
    return Model(found.name, found.values, effects)


LINEAR = [effect.key for effect in EFFECTS if TREATMENTS[effect.key].is_linear and effect.key != "transport_delay"]
CASES = {key: valve(**{key: QUICK.get(key, {})}) for key in LINEAR} | {
    "calibrated": valve(),
    "linear": valve("linear"),
    "ringing": valve().with_values(viscous_friction=1.59),
    "sag from the nozzle's air": valve(supply_droop={"droop_consumption": 0.3, "droop_recovery_time": 0.05}),
    "choked and leaking": valve(choked_flow={}, air_leak={"leak_ratio": 0.2}),
    "many": valve(
        **{key: QUICK.get(key, {}) for key in ("coil_lag", "chamber_filling", "sensor_lag", "spring_hardening",
        "area_variation", "magnetic_saturation", "linkage_nonlinearity", "position_dependent_friction")}
    ),
}  # fmt: skip


@pytest.mark.parametrize("mode", ["rising", "falling"])
@pytest.mark.parametrize("name", CASES)
def test_slip_answers_as_the_exact_simulator_differs(name, mode):
    model = CASES[name]
    found = linearise(model, current=11e-3, mode=mode, speed=SPEED)
    expected = slip_response(model, found.point, TIME, CHANGE)
    answer = ct.forced_response(found.system, TIME, np.full(len(TIME), CHANGE)).outputs
    for signal, values in zip(found.system.output_labels, answer, strict=True):
        difference = np.abs(values - expected[signal])[1:].max()
        assert difference < 1e-6 * np.abs(expected[signal]).max(), signal
