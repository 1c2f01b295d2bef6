"""Motion of a stem whose friction is elastic before it slides: Dahl's bristles, with F_s > F_c those of LuGre."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled
from valvemodel.stages.slip import (
    CAUTION,
    GROWTH,
    SHORTEST_STEP,
    SHRINKAGE,
    first_stop,
    step_factor,
    time_of_way,
    transition,
)
from valvemodel.stages.stem import FALLING, RISING, STUCK, limiting_friction, tangent_stiffness, thrust

NEGLIGIBLE_SWING = 7e-8
"""A stuck stem whose next elastic swing is shorter than this goes to its balance, at a tolerance of 1 N. [m]"""

SETTLED = 3.0
"""Time constants of a creep to its balance after which it is taken to be there."""


@compiled
def advance_presliding(p, state, pressure, time, duration, tolerance):
    """Move a stem on bristles until its next reversal or the end of a duration; return the time used. [s]

    Along a way in one direction the friction is a function of the position alone (Dahl), so that the step is the
    linearised one of `advance_slip` with the stiffness of the bristles added.
    """
    middle = time + 0.5 * duration
    position, bristle = state.position, state.bristle
    contact = 1.0 / p.presliding_compliance
    mass = p.stem_mass
    net = thrust(p, position, pressure, middle) - bristle
    if state.mode == STUCK:
        side = RISING if net > 0.0 else FALLING
        room = state.plan_highest - position if side > 0.0 else position - state.plan_lowest
        if net == 0.0 or room <= 0.0:
            return duration
        state.mode = side
        state.velocity = 0.0
        state.trial_step = 0.0
    side = state.mode
    speed = side * state.velocity
    room = state.plan_highest - position if side > 0.0 else position - state.plan_lowest
    limit = limiting_friction(p, side, position, pressure, middle, speed)
    viscous = p.viscous_friction * (1.0 + p.viscous_asymmetry * side)
    slope = max(contact * (1.0 - side * bristle / limit), 0.0)
    stiffness = tangent_stiffness(p, side, position, pressure, middle) + slope
    start = (side * net - viscous * speed) / mass
    if speed == 0.0:
        swing = side * net
        is_quick = SETTLED * viscous <= stiffness * duration
        if is_quick and swing <= NEGLIGIBLE_SWING * math.sqrt(tolerance) * stiffness:
            settle(p, state, min(swing / stiffness, room), limit)
            return duration
    stop = first_stop(mass, viscous, stiffness, speed, start)
    trial = state.trial_step if state.trial_step > 0.0 else duration
    step = min(trial, duration)
    while True:
        has_stopped = stop <= step
        if has_stopped:
            step = stop
        vv, va, av, aa, yv, ya = transition(mass, viscous, stiffness, step)
        next_speed = 0.0 if has_stopped else vv * speed + va * start
        next_acceleration = av * speed + aa * start
        way = yv * speed + ya * start
        end = position + side * way
        following = bristle_after(p, side, end, way, pressure, middle, next_speed, bristle)
        left_over = side * (thrust(p, end, pressure, middle) - following) - viscous * next_speed
        left_over -= mass * next_acceleration
        factor = step_factor(left_over, tolerance)
        if factor >= CAUTION or step <= SHORTEST_STEP:
            break
        step *= max(factor, SHRINKAGE)
    state.trial_step = max(trial if step < trial and factor >= 1.0 else step * min(factor, GROWTH), SHORTEST_STEP)
    way = max(way + ya * left_over / (6.0 * mass), 0.0)
    if not way <= room:
        step = time_of_way(mass, viscous, stiffness, speed, start, max(room, 0.0), step)
        way, has_stopped = room, True
    elif not has_stopped:
        next_speed = max(next_speed + va * left_over / (3.0 * mass), 0.0)
        has_stopped = next_speed == 0.0
    end = position + side * way
    state.bristle = bristle_after(p, side, end, way, pressure, middle, next_speed, bristle)
    state.position = end
    state.velocity = side * next_speed
    state.trace_damping, state.trace_stiffness = viscous / mass, stiffness / mass
    state.trace_velocity, state.trace_acceleration = side * speed, side * start
    state.trace_next_velocity, state.trace_next_acceleration = side * next_speed, side * next_acceleration
    if has_stopped:
        state.velocity = 0.0
        state.mode = STUCK
        state.trial_step = 0.0
    return step


@compiled
def bristle_after(p, side, end, way, pressure, time, speed, bristle):
    """Return the force of the bristles after a way to one side, exact along it (Dahl). [N]"""
    limit = limiting_friction(p, side, end, pressure, time, speed)
    return side * limit + (bristle - side * limit) * math.exp(-abs(way) / (limit * p.presliding_compliance))


@compiled
def settle(p, state, way, limit):
    """Take a stuck stem over a short elastic way to its balance."""
    side = state.mode
    state.position += side * way
    state.bristle = side * limit + (state.bristle - side * limit) * math.exp(-way / (limit * p.presliding_compliance))
    state.velocity = 0.0
    state.mode = STUCK
