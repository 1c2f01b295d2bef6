"""CasADi: an integrator with a zero-crossing event over each period, mapped over the run."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from benchmarks.simulation.workload import PERIOD, STOP_SPEED, Stem

TITLE = "CasADi integrator with events"
SETTINGS = (("erk", 1e-4), ("cvodes", 1e-6), ("erk", 1e-6), ("cvodes", 1e-8), ("erk", 1e-8))


def run(stem: Stem, pressures: np.ndarray, setting: tuple[str, float]) -> np.ndarray:
    """Return the positions just before each pressure acts. [m]"""
    state, pressure = ca.MX.sym("state", 3), ca.MX.sym("pressure")
    start = ca.vertcat(stem.rest(float(pressures[0])), 0.0, 0.0)
    before = ca.Function("before", [state, pressure], [switched(stem, state, pressure)])
    slip = integrator(stem, *setting)
    switched_state = before(state, pressure)
    after = ca.if_else(switched_state[2] == 0.0, switched_state, slip(x0=switched_state, p=pressure)["xf"], True)
    period = ca.Function("period", [state, pressure], [after])
    states = np.array(period.mapaccum(len(pressures) - 1)(start, pressures[None, :-1]))
    return np.concatenate([[float(start[0])], states[0]])


def switched(stem: Stem, state: Any, pressure: Any) -> Any:
    """Return position, velocity and side of a stem at which a pressure begins to act."""
    y, v, side = state[0], state[1], state[2]
    net = stem.area * pressure - stem.rate * y
    is_slow = ca.fabs(v) < STOP_SPEED
    is_stuck = ca.logic_and(is_slow, ca.fabs(net) <= stem.static)
    side = ca.if_else(is_stuck, 0.0, ca.if_else(side == 0.0, ca.sign(net), side))
    return ca.vertcat(y, ca.if_else(is_stuck, 0.0, v), side)


def integrator(stem: Stem, plugin: str, tolerance: float) -> ca.Function:
    """Return the slip over a period with its stops, the side a state that the event changes."""
    state, pressure = ca.SX.sym("state", 3), ca.SX.sym("pressure")
    y, v, side = state[0], state[1], state[2]
    force = stem.area * pressure - side * stem.coulomb
    acceleration = (force - stem.rate * y - stem.damping * v) / stem.mass
    slope = ca.vertcat(v, acceleration, 0.0)
    slips = ca.if_else(side == 0.0, 0.0, 1.0)
    stopped = switched(stem, ca.vertcat(y, 0.0, 0.0), pressure)
    transition = ca.Function(
        "transition",
        {"index": ca.SX.sym("index"), "x": state, "p": pressure, "post_x": stopped},
        ca.event_in(),
        ca.event_out(),
    )
    dae: dict[str, Any] = {"x": state, "p": pressure, "ode": slips * slope, "zero": side * v}
    options: dict[str, Any] = {"transition": transition, "reltol": tolerance, "abstol": 1e-3 * tolerance}
    return ca.integrator("slip", plugin, dae, 0.0, PERIOD, options)
