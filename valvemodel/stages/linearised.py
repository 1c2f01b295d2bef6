"""Coarse motion of a stem on bristles: linearised steps, the force that one leaves over bounded."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined
from valvemodel.stages.load import load_if_any
from valvemodel.stages.part import pressure_at
from valvemodel.stages.presliding import (
    bristle_after,
    bristle_stiffness,
    bristle_viscosity,
    elastic_friction,
    elastic_friction_at,
    elastic_stiffness,
    friction_after,
    let_slide,
    limit_behind,
    pull_bristles,
)
from valvemodel.stages.rest import are_forces_held, break_away, come_to_rest, is_blocked, meet_limit
from valvemodel.stages.slip import BEYOND, falling_instant, first_stop, time_of_way, transition
from valvemodel.stages.stem import (
    FALLING,
    RISING,
    STUCK,
    inner_thrust,
    limiting_friction,
    room_to,
    tangent_stiffness,
    thrust,
)

LEFT_OVER = 2e5
"""Force that one step may leave over, for a metre of the tolerance. [N/m]"""

NEGLIGIBLE_SWING = 1e-2
"""A stuck stem whose next elastic swing is a smaller share of the tolerance goes to its balance."""

SETTLED = 3.0
"""Time constants of a creep to its balance after which it is taken to be there."""

PAST_REVERSAL = 1.01
"""Share of the time to a reversal of the force, by a straight line, after which it has reversed."""

GROWTH, SHRINKAGE, CAUTION = 6.0, 0.1, 0.8
"""A step grows and shrinks by no more than these factors, and aims at this share of what is allowed."""

SOFT = 1e-3
"""Share of the spring's stiffness below which nothing holds a slip."""

SHORTEST_STEP = 1e-8
"""A step is not made shorter than this: it is far below any time constant of a valve. [s]"""


@compiled
def advance_linearised(p, state, memory, time, duration, tolerance):
    """Move a stem on bristles until its next reversal or the end of a duration; return the time used. [s]

    Along a way in one direction the friction is a function of the position alone (Dahl); its stiffness at the start is
    added to the spring's. What pressure and load add along a step is a ramp.
    """
    duration = min(duration, state.plan_longest)
    moves = not are_forces_held(state, memory)
    mass, position = p.stem_mass, state.position
    loaded, pressure = load_if_any(p, time), pressure_at(memory, time)
    driving = inner_thrust(p, position, pressure) + loaded
    let_slide(p, state, pressure, time)
    net = at_end = driving - elastic_friction(p, state)
    if state.mode == STUCK:
        if moves:
            last, last_pressure = time + duration, pressure_at(memory, time + duration)
            at_end = thrust(p, position, last_pressure, last) - elastic_friction_at(p, state, last_pressure, last)
        if settles(p, state, memory, time, duration, net, at_end, tolerance):
            return duration
        side = RISING if net > 0.0 or (net == 0.0 and at_end > 0.0) else FALLING
        if net == 0.0 == at_end or is_blocked(state, position, side):
            return time_to_reversal(net, at_end, duration)
        break_away(p, state, side)
        state.trial_step = math.inf
    side, allowed = state.mode, LEFT_OVER * tolerance
    speed, room = side * state.velocity, room_to(state, side)
    _, sliding, viscous, stiffness = resistance(p, state, memory, side, time, speed)
    start, stop = (side * net - viscous * speed) / mass, math.inf
    trial, steady, bow, loaded_then = state.trial_step, 0.0, 0.0, loaded
    step = min(trial, duration)
    if not moves:
        stop = first_stop(mass, viscous, stiffness, speed, start)
    elif stiffness > 0.0:
        speed, start, step = calmed(p, state, memory, time, step, driving, speed, start, viscous, stiffness, tolerance)
        if step == 0.0:
            rests = state.velocity == 0.0
            come_to_rest(state)
            return time_to_reversal(net, at_end, duration) if rests else 0.0
    while True:
        has_stopped = stop <= step
        step = min(step, stop)
        if moves:
            loaded_then = load_if_any(p, time + step)
            after = inner_thrust(p, position, pressure_at(memory, time + step)) + loaded_then
            steady = ramp_speed(p, side * (after - driving) / step, stiffness)
            bow = side * p.diaphragm_area * bow_of_pressure(memory, time, step)
        vv, va, av, aa, yv, ya = transition(mass, viscous, stiffness, step)
        if moves and steady + vv * (speed - steady) + va * start <= 0.0:
            step, has_stopped = stop_on_ramp(mass, viscous, stiffness, speed, start, steady, step), True
            loaded_then = load_if_any(p, time + step)
            vv, va, av, aa, yv, ya = transition(mass, viscous, stiffness, step)
        next_speed = 0.0 if has_stopped else steady + vv * (speed - steady) + va * start
        next_acceleration, way = av * (speed - steady) + aa * start, steady * step + yv * (speed - steady) + ya * start
        end, then = position + side * way, time + step
        pressure = pressure_at(memory, then)
        limit = limiting_friction(p, side, end, pressure, then, next_speed)
        behind = limit_behind(p, state, side, end, pressure, then, next_speed)
        bristle = bristle_after(p, state, side, way, limit)
        left_over = side * (inner_thrust(p, end, pressure) + loaded_then)
        left_over -= friction_after(p, state, side, way, limit, behind, bristle)
        next_viscous = sliding
        if p.bristle_damping > 0.0:
            next_viscous += bristle_viscosity(p, bristle_stiffness(p, bristle, limit))
        left_over -= next_viscous * next_speed + mass * next_acceleration
        factor = step_factor(max(abs(left_over), abs(bow)), allowed)
        if factor >= CAUTION or step <= SHORTEST_STEP:
            break
        step *= max(factor, SHRINKAGE)
    state.trial_step = max(trial if step < trial and factor >= 1.0 else step * min(factor, GROWTH), SHORTEST_STEP)
    # What is left over grows with the square of the time; what the forces bow by is a parabola.
    corrected = max(way + ya * (left_over / 6.0 + bow / 1.5) / mass, 0.0)
    # A lag sees the correction as a little speed all along the step.
    little, traced_speed = (corrected - way) / step if step > 0.0 else 0.0, next_speed
    has_hit = not corrected <= room
    if has_hit:
        step = time_of_way(mass, viscous, stiffness, speed - steady, start, max(room, 0.0), step, steady)
        vv, va, _, _, _, _ = transition(mass, viscous, stiffness, step)
        corrected, little = room, 0.0
        traced_speed = next_speed = max(steady + vv * (speed - steady) + va * start, 0.0)
    elif not has_stopped:
        next_speed = max(next_speed + va * left_over / (3.0 * mass), 0.0)
        has_stopped = next_speed == 0.0
    shift(p, state, corrected, limit, behind)
    state.velocity = side * next_speed
    state.trace_damping, state.trace_stiffness = viscous / mass, stiffness / mass
    state.trace_steady = side * (steady + little)
    state.trace_velocity, state.trace_acceleration = side * (speed + little), side * start
    state.trace_next_velocity = side * (traced_speed + little)
    state.trace_next_acceleration = side * next_acceleration
    if has_hit:
        meet_limit(p, state, next_speed)
    elif has_stopped:
        come_to_rest(state)
    return step


@inlined
def bow_of_pressure(memory, time, step):
    """Return how far the pressure in the middle of a step is off the straight line between its ends. [Pa]

    A load bows by little: no step is longer than a part of its shortest wave's period.
    """
    if memory.part_count == 0.0:
        return 0.0
    ends = pressure_at(memory, time) + pressure_at(memory, time + step)
    return pressure_at(memory, time + 0.5 * step) - 0.5 * ends


@compiled
def resistance(p, state, memory, side, time, speed):
    """Return what resists a stem on bristles that goes to a side. [N], [N s/m], [N s/m], [N/m]

    Limit of the bristles, viscous friction without and with theirs, stiffness.
    """
    position, pressure = state.position, pressure_at(memory, time)
    limit = limiting_friction(p, side, position, pressure, time, speed)
    viscous = sliding = p.viscous_friction * (1.0 + p.viscous_asymmetry * side)
    bending = bristle_stiffness(p, side * state.bristle, limit)
    stiffness = tangent_stiffness(p, side, position, pressure, time)
    stiffness += elastic_stiffness(p, state, side, limit, bending)
    if p.bristle_damping > 0.0:
        fading = bristle_viscosity(p, bending)
        viscous += fading
        stiffness -= fading * speed / (limit * p.presliding_compliance)
    return limit, sliding, viscous, stiffness


@compiled
def settles(p, state, memory, time, duration, net, at_end, tolerance):
    """Take a stem that rests on bristles to its balance at the end of a duration, if that is negligibly near.

    Returns whether it is: the forces on it, now and then, swing it by much less than the tolerance.
    """
    side = RISING if at_end > 0.0 else FALLING
    if at_end == 0.0 or is_blocked(state, state.position, side):
        return False
    limit, _, viscous, stiffness = resistance(p, state, memory, side, time, 0.0)
    way, negligible = abs(at_end) / stiffness, NEGLIGIBLE_SWING * tolerance
    if SETTLED * viscous > stiffness * duration or max(abs(net), abs(at_end)) > stiffness * negligible:
        return False
    bristle = bristle_after(p, state, side, way, limit)
    behind = limit_behind(p, state, side, state.position, pressure_at(memory, time), time, 0.0)
    taken = friction_after(p, state, side, way, limit, behind, bristle) - side * elastic_friction(p, state)
    if abs(at_end) - taken > bristle_stiffness(p, bristle, limit) * negligible or way > room_to(state, side):
        # It is on its way to break away.
        return False
    break_away(p, state, side)
    shift(p, state, way, limit, behind)
    come_to_rest(state)
    return True


@inlined
def time_to_reversal(net, at_end, duration):
    """Return when the force on a stem has just changed sides, at most a duration. [s]"""
    if net * at_end >= 0.0:
        return duration
    return min(duration, PAST_REVERSAL * duration * net / (net - at_end) + SHORTEST_STEP)


@inlined
def ramp_speed(p, growth, stiffness):
    """Return the speed at which a slip follows a force that grows, by so much a second, once its swings are over."""
    # Where hardly anything holds it, what the force grows by is left over by the step.
    return growth / stiffness if stiffness > SOFT * p.spring_rate else 0.0


@compiled
def calmed(p, state, memory, time, step, driving, speed, start, viscous, stiffness, tolerance):
    """Return speed, acceleration and first step of a slip on a ramp, without swings about it that are negligible.

    A step of 0 says that the stem comes to rest at once. A swing that counts is followed half by half.
    """
    # Without the ramp it would stop here.
    stop = BEYOND * first_stop(p.stem_mass, viscous, stiffness, speed, start if speed > 0.0 else 1.0)
    if stop >= step:
        return speed, start, step
    after = thrust(p, state.position, pressure_at(memory, time + step), time + step)
    steady = ramp_speed(p, state.mode * (after - driving) / step, stiffness)
    swing = math.sqrt(p.stem_mass / stiffness)
    if (abs(speed - steady) + abs(start) * swing) * swing > NEGLIGIBLE_SWING * tolerance:
        return speed, start, stop
    return max(steady, 0.0), 0.0, step if steady > 0.0 else 0.0


@compiled
def stop_on_ramp(mass, damping, stiffness, speed, start, steady, high):
    """Return when a slip on a ramp first stops, known to have stopped by the end of a bracket. [s]"""
    low = 0.0
    if speed == 0.0:
        low = 0.5 * high
        while low > SHORTEST_STEP:
            vv, va, _, _, _, _ = transition(mass, damping, stiffness, low)
            if steady - vv * steady + va * start > 0.0:
                break
            low *= 0.5
    return falling_instant(mass, damping, stiffness, speed - steady, start, 1.0, 0.0, -steady, low, high)


@compiled
def shift(p, state, way, limit, behind):
    """Take stem and bristles along a way to the side of the motion."""
    state.position += state.mode * way
    pull_bristles(p, state, state.mode, way, limit, behind)


@compiled
def step_factor(left_over, allowed):
    """Return by what factor a step should change, whose left-over force grows with its square."""
    if not abs(left_over) < math.inf:
        return 0.0
    return CAUTION * math.sqrt(allowed / (abs(left_over) + 1e-9 * allowed))
