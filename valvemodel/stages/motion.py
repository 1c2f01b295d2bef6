"""Motion of the stem under a held pressure, event by event: breakaway, stop, reversal, end of the travel."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined
from valvemodel.stages.presliding import advance_presliding
from valvemodel.stages.slip import (
    CAUTION,
    GROWTH,
    SHORTEST_STEP,
    SHRINKAGE,
    STOP_SPEED,
    first_stop,
    slip_end,
    step_factor,
    time_of_way,
    transition,
)
from valvemodel.stages.stem import (
    FALLING,
    RISING,
    STUCK,
    breakaway_ratio,
    highest_position,
    is_linear,
    lowest_position,
    sliding_friction,
    stribeck_excess,
    stribeck_slope,
    tangent_stiffness,
    thrust,
    varies_in_time,
)

SPOT_SHARE = 0.25
"""Longest way of a linearised step near a tight spot over the spot's width, so that none is stepped over."""

SPOT_REACH = 4.0
"""Distance from a tight spot, over its width, beyond which its excess is below 2e-7 of its height."""

HOLD = 1e-12
"""Share of the breakaway force by which it must be exceeded: the tail of a creep would chatter about it by rounding."""

TOUCHING = 1e-12
"""Play within this of being taken up is taken up. [m]"""

HARD_STOP = 1.0
"""A deceleration that leaves less than 1e-12 m between the stop speed and 0. [m/s^2]"""

UNSTABLE = 3.0
"""Longest linearised step over the time in which an unstable speed grows by a factor of e."""

DRIFT_HOLD = 0.02
"""Longest hold while gap or friction drift, which have time constants of 20 s and more. [s]"""

LOAD_SAMPLES = 8.0
"""Fewest parts of a load's period into which a held pressure is cut, so that no breakaway is missed."""


@compiled
def plan_stem(p, state):
    """Write down once a run what does not change during it."""
    state.plan_linear = is_linear(p)
    state.plan_steady = (
        state.plan_linear == 1.0
        and not varies_in_time(p)
        and p.area_slope == 0.0
        and p.area_curvature == 0.0
        and p.friction_area == 0.0
        and p.sensor_time_constant == 0.0
    )
    state.plan_highest, state.plan_lowest = highest_position(p), lowest_position(p)
    state.plan_rising_friction = sliding_friction(p, RISING, 0.0, 0.0, 0.0)
    state.plan_falling_friction = sliding_friction(p, FALLING, 0.0, 0.0, 0.0)
    state.plan_ratio = breakaway_ratio(p) * (1.0 + HOLD)
    state.known_duration = state.quiet_duration = -1.0
    state.trial_step = 0.0


@inlined
def glide(p, state, pressure, duration):
    """Move a steady stem through a duration if nothing happens in it, and return whether that was so.

    Nothing happens while the stem stays stuck, or slips at no less than the stop speed at both ends: a speed has at
    most one zero, or its zeros are half a swing apart and the duration is shorter.
    """
    side, push = state.mode, p.diaphragm_area * pressure - p.spring_preload
    if side == STUCK:
        net = push - p.spring_rate * state.position
        return -state.plan_falling_friction * state.plan_ratio <= net <= state.plan_rising_friction * state.plan_ratio
    if state.quiet_duration != duration or state.quiet_side != side:
        remember_glide(p, state, side, duration)
    push -= state.quiet_friction
    position = state.quiet_yf * push + state.quiet_yv * state.velocity + state.quiet_yy * state.position
    velocity = state.quiet_vf * push + state.quiet_vy * state.position + state.quiet_vv * state.velocity
    is_quiet = (
        side * state.velocity >= STOP_SPEED
        and side * velocity >= STOP_SPEED
        and state.plan_lowest <= position <= state.plan_highest
    )
    if is_quiet:
        state.position = position
        state.velocity = velocity
    return is_quiet


@compiled
def remember_glide(p, state, side, duration):
    """Write down how velocity and position follow from themselves and the force over a duration of one slip."""
    mass = p.stem_mass
    damping = p.viscous_friction * (1.0 + p.viscous_asymmetry * side)
    vv, va, _, _, yv, ya = transition(mass, damping, p.spring_rate, duration)
    # The acceleration is the net force less the viscous friction, over the mass.
    state.quiet_vv, state.quiet_vf = vv - va * damping / mass, va / mass
    state.quiet_yv, state.quiet_yf = yv - ya * damping / mass, ya / mass
    # The spring is taken out of the net force, so that the two sums of a period are short.
    state.quiet_yy, state.quiet_vy = 1.0 - state.quiet_yf * p.spring_rate, -state.quiet_vf * p.spring_rate
    state.quiet_friction = state.plan_rising_friction if side > 0.0 else -state.plan_falling_friction
    state.quiet_duration, state.quiet_side = duration, side
    discriminant = p.spring_rate / mass - (0.5 * damping / mass) ** 2
    if discriminant > 0.0 and math.sqrt(discriminant) * duration >= math.pi:
        # More than half a swing: no glide is quiet.
        state.quiet_vv = state.quiet_vf = math.nan


@compiled
def remembered_transition(p, state, damping, stiffness, duration):
    """Return `transition`, computed anew only where its arguments differ from the last ones."""
    if state.known_duration != duration or state.known_damping != damping or state.known_stiffness != stiffness:
        vv, va, av, aa, yv, ya = transition(p.stem_mass, damping, stiffness, duration)
        state.known_vv, state.known_va, state.known_av = vv, va, av
        state.known_aa, state.known_yv, state.known_ya = aa, yv, ya
        state.known_duration, state.known_damping, state.known_stiffness = duration, damping, stiffness
    return state.known_vv, state.known_va, state.known_av, state.known_aa, state.known_yv, state.known_ya


@compiled
def breakaway_side(p, state, pressure, time):
    """Return the side to which a resting stem breaks away, STUCK where friction or an end of the travel holds it."""
    position = state.position
    net = thrust(p, position, pressure, time)
    side = RISING if net > 0.0 else FALLING
    if abs(net) <= state.plan_ratio * sliding_friction(p, side, position, pressure, time):
        return STUCK
    is_blocked = position >= state.plan_highest if side > 0.0 else position <= state.plan_lowest
    return STUCK if is_blocked else side


@compiled
def time_stuck(p, state, pressure, time, duration):
    """Return how long a stem that holds at an instant goes on holding, at most a duration. [s]"""
    if not varies_in_time(p) or breakaway_side(p, state, pressure, time + duration) == STUCK:
        return duration
    low, high = 0.0, duration
    while high - low > 1e-12 + 1e-15 * time:
        middle = 0.5 * (low + high)
        if breakaway_side(p, state, pressure, time + middle) == STUCK:
            low = middle
        else:
            high = middle
    return high


@compiled
def advance_stem(p, state, pressure, time, duration, tolerance):
    """Hold the pressure and move the stem until its next event or the end of a duration; return the time used. [s]

    Forces that vary in time are held at their value in the middle of a slip, exact to second order; `longest_hold`
    bounds the duration for it. A linear slip is one closed-form step. Else the forces are linearised at the start
    of a step, whose length keeps the force left over at its end below the tolerance. [N]
    """
    if p.presliding_compliance > 0.0:
        return advance_presliding(p, state, pressure, time, duration, tolerance)
    breaks_away = state.mode == STUCK
    if breaks_away:
        side = breakaway_side(p, state, pressure, time)
        if side == STUCK:
            return time_stuck(p, state, pressure, time, duration)
        state.velocity = 0.0
        state.mode = side
        state.trial_step = 0.0
    elif abs(state.velocity) < STOP_SPEED and breakaway_side(p, state, pressure, time) == STUCK:
        come_to_rest(state)
        return 0.0
    return advance_slip(p, state, pressure, time, duration, tolerance, breaks_away)


@compiled
def come_to_rest(state):
    """End a slip where the stem is."""
    state.velocity = 0.0
    state.mode = STUCK


@compiled
def advance_slip(p, state, pressure, time, duration, tolerance, breaks_away):
    """Move a slipping stem by one step, to its stop or the end of the duration at most; return the time used. [s]"""
    middle = time + 0.5 * duration
    side, position = state.mode, state.position
    speed = side * state.velocity
    mass = p.stem_mass
    coulomb = sliding_friction(p, side, position, pressure, middle)
    viscous = p.viscous_friction * (1.0 + p.viscous_asymmetry * side)
    stiffness = tangent_stiffness(p, side, position, pressure, middle)
    friction, damping = coulomb, viscous
    if p.stribeck_ratio > 1.0:
        excess = stribeck_excess(p, coulomb, speed)
        friction += excess
        damping -= stribeck_slope(p, excess, speed)
    start = (side * thrust(p, position, pressure, middle) - friction - viscous * speed) / mass
    if breaks_away and start <= 0.0:
        # Rounding, or a load that falls back within the duration: friction holds it after all.
        come_to_rest(state)
        return duration
    if state.plan_linear == 0.0:
        return advance_curved_slip(
            p, state, pressure, middle, duration, tolerance, speed, start, viscous, damping, stiffness
        )
    stop = first_stop(mass, damping, stiffness, speed, start)
    step = min(stop, duration)
    vv, va, av, aa, yv, ya = remembered_transition(p, state, damping, stiffness, step)
    way = yv * speed + ya * start
    room = state.plan_highest - position if side > 0.0 else position - state.plan_lowest
    next_speed, next_acceleration = vv * speed + va * start, av * speed + aa * start
    has_stopped = stop <= duration
    if not way <= room:
        return hit_limit(state, mass, damping, stiffness, speed, start, room, step)
    is_slow = next_speed < STOP_SPEED and (not has_stopped or next_acceleration > -HARD_STOP)
    if is_slow and next_acceleration < 0.0:
        breakaway = state.plan_ratio * coulomb
        if abs(coulomb + viscous * next_speed + mass * next_acceleration) <= breakaway:
            has_stopped = True
            # Well inside what holds it, or rounding would let it break away anew.
            excess = coulomb * (1.0 - breakaway_ratio(p) * (1.0 + 0.5 * HOLD))
            step = slip_end(mass, damping, stiffness, speed, start, excess, step)
            vv, va, av, aa, yv, ya = transition(mass, damping, stiffness, step)
            way = yv * speed + ya * start
            next_speed, next_acceleration = vv * speed + va * start, av * speed + aa * start
    if p.sensor_time_constant > 0.0:
        contact = way_to_contact(p, state, side)
        if TOUCHING < contact < way:
            # The play closes: the transmitter follows only from here on.
            step = time_of_way(mass, damping, stiffness, speed, start, contact, step)
            vv, va, av, aa, yv, ya = transition(mass, damping, stiffness, step)
            way, has_stopped = contact, False
            next_speed, next_acceleration = vv * speed + va * start, av * speed + aa * start
    leave_trace(state, mass, damping, stiffness, speed, start, next_speed, next_acceleration)
    state.position = position + side * way
    state.velocity = side * max(next_speed, 0.0)
    if has_stopped:
        come_to_rest(state)
    return step


@compiled
def leave_trace(state, mass, damping, stiffness, speed, acceleration, next_speed, next_acceleration):
    """Leave to the sensor what it needs to follow a slip exactly."""
    state.trace_damping, state.trace_stiffness = damping / mass, stiffness / mass
    state.trace_velocity, state.trace_acceleration = state.mode * speed, state.mode * acceleration
    state.trace_next_velocity = state.mode * next_speed
    state.trace_next_acceleration = state.mode * next_acceleration


@compiled
def way_to_contact(p, state, side):
    """Return how far the stem still goes before its play is taken up. [m]"""
    return side * (state.linkage - state.position) + p.backlash_half_width


@compiled
def hit_limit(state, mass, damping, stiffness, speed, acceleration, room, step):
    """Move a slip to the end of the travel, where it stops dead; return the time used. [s]"""
    step = time_of_way(mass, damping, stiffness, speed, acceleration, max(room, 0.0), step)
    vv, va, av, aa, _, _ = transition(mass, damping, stiffness, step)
    next_speed, next_acceleration = vv * speed + va * acceleration, av * speed + aa * acceleration
    leave_trace(state, mass, damping, stiffness, speed, acceleration, next_speed, next_acceleration)
    state.position = state.plan_highest if state.mode > 0.0 else state.plan_lowest
    come_to_rest(state)
    return step


@compiled
def advance_curved_slip(p, state, pressure, time, duration, tolerance, speed, start, viscous, damping, stiffness):
    """Move a slip under curved forces by one linearised step of controlled error; return the time used. [s]

    The force left over grows with the square of time: its first effect on speed and way is added, so that the error
    is of the fourth order. The next step aims at the tolerance.
    """
    mass, side, position = p.stem_mass, state.mode, state.position
    trial = state.trial_step if state.trial_step > 0.0 else duration
    if damping < 0.0:
        trial = min(trial, -UNSTABLE * mass / damping)
    step = min(trial, duration)
    stop = first_stop(mass, damping, stiffness, speed, start)
    while True:
        has_stopped = stop <= step
        if has_stopped:
            step = stop
        vv, va, av, aa, yv, ya = transition(mass, damping, stiffness, step)
        next_speed = 0.0 if has_stopped else vv * speed + va * start
        next_acceleration = av * speed + aa * start
        way = yv * speed + ya * start
        left_over = slip_left_over(p, side, position, way, next_speed, next_acceleration, pressure, time, viscous)
        factor = step_factor(left_over, tolerance)
        if p.tight_spot_excess != 0.0 and way > SPOT_SHARE * p.tight_spot_width:
            distance = side * (p.tight_spot_position - position)
            reach = SPOT_REACH * p.tight_spot_width
            if -reach < distance < way + reach:
                factor = min(factor, CAUTION * SPOT_SHARE * p.tight_spot_width / way)
        if factor >= CAUTION or step <= SHORTEST_STEP:
            break
        step *= max(factor, SHRINKAGE)
    state.trial_step = max(trial if step < trial and factor >= 1.0 else step * min(factor, GROWTH), SHORTEST_STEP)
    room = state.plan_highest - position if side > 0.0 else position - state.plan_lowest
    way += ya * left_over / (6.0 * mass)
    if not way <= room:
        return hit_limit(state, mass, damping, stiffness, speed, start, room, step)
    if not has_stopped:
        next_speed = max(next_speed + va * left_over / (3.0 * mass), 0.0)
    leave_trace(state, mass, damping, stiffness, speed, start, next_speed, next_acceleration)
    state.position = position + side * max(way, 0.0)
    state.velocity = side * next_speed
    is_slow = next_speed < STOP_SPEED and next_acceleration < 0.0
    if is_slow and breakaway_side(p, state, pressure, time) == STUCK:
        has_stopped = True
    if has_stopped or next_speed == 0.0:
        come_to_rest(state)
        state.trial_step = 0.0
    return step


@compiled
def slip_left_over(p, side, position, way, speed, acceleration, pressure, time, viscous):
    """Return the net force at the end of a linearised slip step less the one that the step assumed. [N]"""
    end = position + side * way
    friction = sliding_friction(p, side, end, pressure, time)
    if p.stribeck_ratio > 1.0:
        friction += stribeck_excess(p, friction, speed)
    net = side * thrust(p, end, pressure, time) - friction - viscous * speed
    return net - p.stem_mass * acceleration


@compiled
def longest_hold(p, substep):
    """Return how long forces that vary in time may be held at their middle. [s]"""
    longest = math.inf
    if p.load_sine != 0.0 or p.load_cosine != 0.0:
        longest = min(substep, p.load_period / LOAD_SAMPLES)
    if p.friction_drift_rate != 0.0:
        longest = min(longest, DRIFT_HOLD)
    return longest
