"""What changes in a loop while the stem sticks or slips, compiled."""

from __future__ import annotations

import math

import numpy as np

from valvemodel.compiled import compiled
from valvemodel.stages.electromagnet import gap_of_current, saturate
from valvemodel.stages.nozzle import behind_leak, resting_pressure_of_chain
from valvemodel.stages.stem import breakaway_ratio, sliding_friction, stribeck_excess, thrust

INTEGRAL, POSITION, VELOCITY, OUTPUT = 0, 1, 2, 3
"""Order of a loop's states: of the controller [A], the stem and the process."""

SETTING = np.dtype(
    [(name, "f8") for name in ("setpoint", "reference", "proportional", "integral", "lag", "dead_time", "hold")]
)
"""Type of the numbers of controller and process; the hold is half a period.

[m], [A], [A/m], [A/(m s)], [s], [s], [s]
"""


@compiled
def static_pressure_at(p, current):
    """Return the actuator pressure at rest under a current. [Pa]"""
    effective = saturate(p, max(current, 0.0))
    return behind_leak(p, resting_pressure_of_chain(p, gap_of_current(p, effective, 0.0), effective))


@compiled
def position_before(s, states, time, past):
    """Return the position that acts now through line and sampling, from the past (time, position, velocity). [m]"""
    if s.dead_time == 0.0:
        return states[POSITION] - s.hold * states[VELOCITY]
    instant = time - s.dead_time - s.hold
    if instant >= past[-1, 0]:
        return past[-1, 1]
    if instant <= past[0, 0]:
        return past[0, 1]
    after = np.searchsorted(past[:, 0], instant, side="right")
    span = past[after, 0] - past[after - 1, 0]
    x = (instant - past[after - 1, 0]) / span
    # Hermite's cubic through positions and velocities.
    y0, y1, v0, v1 = past[after - 1, 1], past[after, 1], past[after - 1, 2] * span, past[after, 2] * span
    return y0 + x * (v0 + x * (3.0 * (y1 - y0) - 2.0 * v0 - v1 + x * (2.0 * (y0 - y1) + v0 + v1)))


@compiled
def shown(s, states, time, past):
    """Return the controlled variable without its sampling. [m]"""
    if s.lag > 0.0:
        return states[OUTPUT]
    return states[POSITION] if s.dead_time == 0.0 else position_before(s, states, time, past)


@compiled
def controlled(s, states, time, past):
    """Return the controlled variable as the controller has it: of the process, or the position itself. [m]"""
    return states[OUTPUT] if s.lag > 0.0 else position_before(s, states, time, past)


@compiled
def pressure_of(p, s, states, time, past):
    """Return the pressure that the controller asks for. [Pa]"""
    error = s.setpoint - controlled(s, states, time, past)
    return static_pressure_at(p, s.reference + s.proportional * error + states[INTEGRAL])


@compiled
def rates(p, s, side, states, time, past):
    """Return the rates of all states while the stem moves to a side, or sticks where that is 0."""
    following = np.zeros_like(states)
    following[INTEGRAL] = s.integral * (s.setpoint - controlled(s, states, time, past))
    if s.lag > 0.0:
        following[OUTPUT] = (position_before(s, states, time, past) - states[OUTPUT]) / s.lag
    if side == 0.0:
        return following
    position, velocity = states[POSITION], states[VELOCITY]
    pressure = pressure_of(p, s, states, time, past)
    friction = sliding_friction(p, side, position, pressure, 0.0)
    if p.stribeck_ratio > 1.0:
        friction += stribeck_excess(p, friction, velocity)
    viscous = p.viscous_friction * (1.0 + p.viscous_asymmetry * side)
    net = thrust(p, position, pressure, 0.0) - side * friction - viscous * velocity
    following[POSITION] = velocity
    following[VELOCITY] = net / p.stem_mass
    return following


@compiled
def excess_force(p, side, position, pressure):
    """Return by how much the driving force to a side exceeds what holds a stem at rest. [N]"""
    holding = breakaway_ratio(p) * sliding_friction(p, side, position, pressure, 0.0)
    return side * thrust(p, position, pressure, 0.0) - holding


@compiled
def excess(p, s, side, states, time, past):
    """Return that excess under the pressure of the loop; infinitely little where there is none. [N]"""
    force = excess_force(p, side, states[POSITION], pressure_of(p, s, states, time, past))
    return force if math.isfinite(force) else -math.inf
