"""A PID around the slipping valve without Coulomb friction, in python-control: an outside judge, and a rival."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from valvemodel.control.scenario import Scenario
from valvemodel.model import Model
from valvemodel.valves import read_valve

START_CURRENT = 12e-3


def slipping_valve() -> Model:
    """Return the `linear` valve without Coulomb friction: mass, damper and spring behind a straight line."""
    valve = read_valve("linear")
    return Model(valve.name, valve.values).with_values(coulomb_friction=0.0)


def plant_of(model: Model, period: float) -> Any:
    """Return that valve from current to position as python-control's zero-order hold of it."""
    import control

    values = model.values
    gain = values["diaphragm_area"] * values["pressure_per_current"]
    denominator = [values["stem_mass"], values["viscous_friction"], values["spring_rate"]]
    return control.c2d(control.tf2ss(control.tf([gain], denominator)), period, method="zoh")


def pid_of(gains: Mapping[str, float], period: float) -> Any:
    """Return eq. (34) as a transfer function of z."""
    import control

    z = control.tf([1.0, 0.0], [1.0], period)
    return (
        gains["proportional_gain"]
        + gains["integral_gain"] * period * z / (z - 1.0)
        + gains["derivative_gain"] / period * (z - 1.0) / z
    )


def rest_of(model: Model) -> float:
    """Return the position of rest under the start current. [m]"""
    values = model.values
    pressure = values["pressure_at_zero_current"] + values["pressure_per_current"] * START_CURRENT
    return values["diaphragm_area"] * pressure / values["spring_rate"]


def transfer_loop(model: Model, gains: Mapping[str, float], scenario: Scenario) -> np.ndarray:
    """Return the positions of the closed loop from python-control's forced response. [m]

    (34) as such adds K_D e(0) at the first sample, as if the error before had been 0; a first set point at the rest
    position makes that vanish.
    """
    import control

    rest = rest_of(model)
    loop = control.feedback(control.tf2ss(pid_of(gains, scenario.period)), plant_of(model, scenario.period))
    currents = control.forced_response(loop, inputs=scenario.setpoint - rest).outputs
    return rest + control.forced_response(plant_of(model, scenario.period), inputs=currents).outputs


def nonlinear_loop(model: Model, gains: Mapping[str, float], scenario: Scenario) -> np.ndarray:
    """Return the same from a discrete NonlinearIOSystem with a limited current, as a user would build it. [m]"""
    import control

    plant, rest, period = plant_of(model, scenario.period), rest_of(model), scenario.period

    def current(x: np.ndarray, setpoint: float) -> tuple[float, float, float]:
        error = setpoint - float((plant.C @ x[:2])[0]) - rest
        total = x[2] + error
        output = (
            gains["proportional_gain"] * error
            + gains["integral_gain"] * period * total
            + gains["derivative_gain"] / period * (error - x[3])
        )
        return min(max(START_CURRENT + output, 4e-3), 20e-3) - START_CURRENT, total, error

    def update(t: float, x: np.ndarray, u: np.ndarray, params: Mapping[str, Any]) -> np.ndarray:
        output, total, error = current(x, u[0])
        return np.r_[plant.A @ x[:2] + plant.B[:, 0] * output, total, error]

    def read(t: float, x: np.ndarray, u: np.ndarray, params: Mapping[str, Any]) -> np.ndarray:
        return plant.C @ x[:2] + rest

    loop = control.nlsys(update, read, inputs=1, outputs=1, states=4, dt=period)
    answer = control.input_output_response(loop, scenario.time, scenario.setpoint, np.zeros(4))
    return answer.outputs
