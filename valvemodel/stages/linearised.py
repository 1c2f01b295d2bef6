"""Coarse motion of a stem on bristles: linearised steps, the force that one leaves over bounded."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled
from valvemodel.stages.part import pressure_at
from valvemodel.stages.presliding import (
    bristle_after,
    bristle_stiffness,
    bristle_viscosity,
    elastic_friction,
    elastic_stiffness,
    friction_after,
    pull_bristles,
)
from valvemodel.stages.rest import break_away, come_to_rest, is_blocked, meet_limit
from valvemodel.stages.slip import first_stop, time_of_way, transition
from valvemodel.stages.stem import FALLING, RISING, STUCK, limiting_friction, room_to, tangent_stiffness, thrust

LEFT_OVER = 2e5
"""Force that one step may leave over, for a metre of the tolerance. [N/m]"""

NEGLIGIBLE_SWING = 1e-2
"""A stuck stem whose next elastic swing is a smaller share of the tolerance goes to its balance."""

SETTLED = 3.0
"""Time constants of a creep to its balance after which it is taken to be there."""

GROWTH, SHRINKAGE, CAUTION = 6.0, 0.1, 0.8
"""A step grows and shrinks by no more than these factors, and aims at this share of what is allowed."""

SHORTEST_STEP = 1e-8
"""A step is not made shorter than this: it is far below any time constant of a valve. [s]"""


@compiled
def advance_linearised(p, state, memory, time, duration, tolerance):
    """Move a stem on bristles until its next reversal or the end of a duration; return the time used. [s]

    Pressure and load are held at their values in the middle. Along a way in one direction the friction is a function
    of the position alone (Dahl); its stiffness at the start is added to the spring's.
    """
    duration = min(duration, state.plan_longest)
    middle, mass, position = time + 0.5 * duration, p.stem_mass, state.position
    pressure = pressure_at(memory, middle)
    net = thrust(p, position, pressure, middle) - elastic_friction(p, state)
    if state.mode == STUCK:
        side = RISING if net > 0.0 else FALLING
        if net == 0.0 or is_blocked(state, state.position, side):
            return duration
        break_away(p, state, side)
        state.trial_step = math.inf
    side, allowed = state.mode, LEFT_OVER * tolerance
    speed, room = side * state.velocity, room_to(state, side)
    limit = limiting_friction(p, side, position, pressure, middle, speed)
    viscous = p.viscous_friction * (1.0 + p.viscous_asymmetry * side)
    bending = bristle_stiffness(p, side * state.bristle, limit)
    stiffness = tangent_stiffness(p, side, position, pressure, middle)
    stiffness += elastic_stiffness(p, state, side, limit, bending)
    sliding = viscous
    if p.bristle_damping > 0.0:
        fading = bristle_viscosity(p, bending)
        viscous += fading
        stiffness -= fading * speed / (limit * p.presliding_compliance)
    start = (side * net - viscous * speed) / mass
    if (
        speed == 0.0
        and SETTLED * viscous <= stiffness * duration
        and side * net <= stiffness * NEGLIGIBLE_SWING * tolerance
    ):
        balance = side * net / stiffness
        shift(p, state, min(balance, room), limit)
        come_to_rest(state)
        return duration if balance <= room else 0.0
    stop, trial = first_stop(mass, viscous, stiffness, speed, start), state.trial_step
    step = min(trial, duration)
    while True:
        has_stopped = stop <= step
        step = min(step, stop)
        vv, va, av, aa, yv, ya = transition(mass, viscous, stiffness, step)
        next_speed = 0.0 if has_stopped else vv * speed + va * start
        next_acceleration, way = av * speed + aa * start, yv * speed + ya * start
        end = position + side * way
        limit = limiting_friction(p, side, end, pressure, middle, next_speed)
        bristle = bristle_after(p, state, side, way, limit)
        left_over = side * thrust(p, end, pressure, middle) - friction_after(p, state, side, way, limit, bristle)
        next_viscous = sliding
        if p.bristle_damping > 0.0:
            next_viscous += bristle_viscosity(p, bristle_stiffness(p, bristle, limit))
        left_over -= next_viscous * next_speed + mass * next_acceleration
        factor = step_factor(left_over, allowed)
        if factor >= CAUTION or step <= SHORTEST_STEP:
            break
        step *= max(factor, SHRINKAGE)
    state.trial_step = max(trial if step < trial and factor >= 1.0 else step * min(factor, GROWTH), SHORTEST_STEP)
    way = max(way + ya * left_over / (6.0 * mass), 0.0)
    has_hit = not way <= room
    if has_hit:
        step = time_of_way(mass, viscous, stiffness, speed, start, max(room, 0.0), step)
        vv, va, _, _, _, _ = transition(mass, viscous, stiffness, step)
        way, next_speed = room, max(vv * speed + va * start, 0.0)
    elif not has_stopped:
        next_speed = max(next_speed + va * left_over / (3.0 * mass), 0.0)
        has_stopped = next_speed == 0.0
    shift(p, state, way, limit)
    state.velocity = side * next_speed
    state.trace_damping, state.trace_stiffness = viscous / mass, stiffness / mass
    state.trace_velocity, state.trace_acceleration = side * speed, side * start
    state.trace_next_velocity, state.trace_next_acceleration = side * next_speed, side * next_acceleration
    if has_hit:
        meet_limit(p, state, next_speed)
    elif has_stopped:
        come_to_rest(state)
    return step


@compiled
def shift(p, state, way, limit):
    """Take stem and bristles along a way to the side of the motion."""
    state.position += state.mode * way
    pull_bristles(p, state, state.mode, way, limit)


@compiled
def step_factor(left_over, allowed):
    """Return by what factor a step should change, whose left-over force grows with its square."""
    if not abs(left_over) < math.inf:
        return 0.0
    return CAUTION * math.sqrt(allowed / (abs(left_over) + 1e-9 * allowed))
