"""A stem pressed on a stop that gives way, as a search follows it: where friction lets the force push it, at once.

The stop swings far faster than the pressure moves; followed swing by swing it would take most of the time of a run.
"""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined
from valvemodel.stages.part import is_of_a_search, pressure_at
from valvemodel.stages.rest import come_to_rest, meet_breakaway
from valvemodel.stages.stem import FALLING, RISING, STUCK, lay_span, sliding_friction, tangent_stiffness, thrust


@inlined
def is_pressed(p, state):
    """Return whether the stem presses on a stop that gives way, or is about to."""
    return p.stop_compliance > 0.0 and (state.span_lowest == p.upper_stop or state.span_highest == p.lower_stop)


@inlined
def may_settle(p, state, tolerance):
    """Return whether a search may let the stem follow the force at once: on a stop, on dry friction alone, and slow."""
    if not (is_of_a_search(tolerance) and state.plan_elastic == 0.0 and is_pressed(p, state)):
        return False
    is_dry = p.stribeck_ratio == 1.0 and p.static_friction_ratio == 1.0
    return is_dry and abs(state.velocity) * swing_of_stop(p) <= tolerance


@inlined
def swing_of_stop(p):
    """Return how long a stem takes to settle on its stop: by its mass and by viscous friction. [s]"""
    return math.sqrt(p.stem_mass * p.stop_compliance) + p.viscous_friction * p.stop_compliance


@compiled
def settle_on_stop(p, state, memory, time, duration, tolerance):
    """Move the stem on its stop until it leaves it or to the end of a duration; return the time used. [s]

    0 where it is off its balance by more than the tolerance, or the force moves so fast that it would be: nothing is
    moved then.
    """
    before = state.position
    side, stop = RISING, p.upper_stop
    if state.span_highest == p.lower_stop:
        side, stop = FALLING, p.lower_stop
    if abs(settled_place(p, state, memory, side, time) - before) > tolerance:
        return 0.0
    used, position = duration, settled_place(p, state, memory, side, time + duration)
    if side * position <= side * stop:
        state.position = position = stop
        used = meet_breakaway(p, state, memory, time, 0.0, duration, -side)
    velocity = (position - before) / used
    if abs(velocity) * swing_of_stop(p) > tolerance or not state.plan_lowest <= position <= state.plan_highest:
        state.position = before
        return 0.0
    state.position = position
    state.trace_steady = state.trace_velocity = state.trace_next_velocity = velocity
    come_to_rest(state)
    if position == stop:
        lay_span(p, state, STUCK)
    return used


@inlined
def settled_place(p, state, memory, side, instant):
    """Return where the force of an instant leaves the stem on its stop: where it is, or as far as friction lets it."""
    position, pressure = state.position, pressure_at(memory, instant)
    net = thrust(p, position, pressure, instant)
    way = RISING if net > 0.0 else FALLING
    excess = abs(net) - sliding_friction(p, way, position, pressure, instant)
    if excess <= 0.0:
        return position
    return position + way * excess / tangent_stiffness(p, side, position, pressure, instant)
