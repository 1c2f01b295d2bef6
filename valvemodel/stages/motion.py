"""Motion of the stem under a held pressure, event by event: breakaway, stop, reversal, end of the travel."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined
from valvemodel.stages.linearised import advance_linearised
from valvemodel.stages.linkage import TOUCHING, way_to_contact
from valvemodel.stages.load import has_load
from valvemodel.stages.nodes import REMEMBERED
from valvemodel.stages.part import PRESSURE_SHARE, is_coarse, pressure_at
from valvemodel.stages.presliding import bristle_stiffness, bristle_viscosity, elastic_friction, time_on_bristles
from valvemodel.stages.pressed import may_settle, settle_on_stop
from valvemodel.stages.response import forget_responses, remember_response
from valvemodel.stages.rest import break_away, breakaway_side, come_to_rest, meet_limit, sticks, time_stuck
from valvemodel.stages.series import advance_falling, advance_series
from valvemodel.stages.sliders import has_sliders, stiffness_of_sliders
from valvemodel.stages.slip import SHORT, STOP_SPEED, first_stop, slip_end, swing_out, time_of_way, transition
from valvemodel.stages.stem import (
    FALLING,
    RISING,
    STUCK,
    breakaway_ratio,
    fastest_drift,
    has_held_limit,
    highest_position,
    is_linear,
    lowest_position,
    reach_of_tight_spot,
    room_to,
    sliding_friction,
    tangent_stiffness,
    thrust,
    varies_in_time,
)
from valvemodel.stages.step import lay_motion
from valvemodel.stages.transmitter import has_lag
from valvemodel.stages.travel import MEETING, advance_travel

HOLD = 1e-12
"""Share of the breakaway force by which it must be exceeded: the tail of a creep would chatter about it by rounding."""

PAST_STICKING = 1e-12
"""Way between the stick speed and speed 0 that is too short to be looked at. [m]"""

STIFF = 5e3
"""Fastest decay of a speed that is followed in powers of time: they carry for a few of its time constants. [1/s]"""

RESOLVED = 0.25
"""Longest step over the period of a load, or over the time constant of a drift."""

RIGID = 0.01
"""Share of the tolerance below which the reach of the bristles is none: they are the dry friction of their limit."""

BENT = 0.01
"""Share of the tolerance within which bristles are bent as far as they go: what they lack moves the stem by less."""


@compiled
def plan_stem(p, state, memory, tolerance):
    """Write down once a run what does not change during it."""
    state.plan_elastic = p.presliding_compliance * p.coulomb_friction > RIGID * tolerance
    state.plan_linear = is_linear(p) and state.plan_elastic == 0.0
    state.plan_varies = varies_in_time(p)
    state.plan_limit_held = has_held_limit(p)
    stiffest = p.viscous_friction * (1.0 + abs(p.viscous_asymmetry)) + p.bristle_damping * 2.0**p.bristle_exponent
    is_stiff = stiffest > STIFF * p.stem_mass
    state.plan_series = (
        not is_stiff
        and state.plan_elastic == 1.0
        and state.plan_limit_held == 1.0
        and is_linear(p)
        and state.plan_varies == 0.0
        and not has_lag(p)
    )
    own_rate = p.viscous_friction / p.stem_mass + math.sqrt(p.spring_rate / p.stem_mass)
    state.plan_response = 1.0 / max(own_rate, 1e-3)
    state.plan_longest = longest_step(p)
    state.plan_plain = (
        state.plan_elastic == 0.0
        and state.plan_varies == 0.0
        and p.area_slope == 0.0
        and p.area_curvature == 0.0
        and p.spring_hardening == 0.0
        and p.spring_progression == 0.0
        and p.friction_area == 0.0
        and not has_lag(p)
    )
    state.plan_clear = p.tight_spot_excess == 0.0 and p.stop_compliance == 0.0
    state.plan_reach = reach_of_tight_spot(p, PRESSURE_SHARE * tolerance * p.spring_rate)
    state.plan_glides = state.plan_plain == 1.0 and p.stribeck_ratio == 1.0
    state.plan_falling = (
        not is_stiff
        and state.plan_plain == 1.0
        and state.plan_clear == 1.0
        and p.stribeck_ratio > 1.0
        and p.stribeck_shape == 1.0
        and p.stribeck_tail == 0.0
        and p.stick_speed == STOP_SPEED
    )
    state.plan_steady = state.plan_plain == 1.0 and state.plan_clear == 1.0 and state.plan_linear == 1.0
    state.plan_bowed = has_lag(p) and (p.linkage_bow != 0.0 or p.linkage_skew != 0.0)
    # The remaining closed forms need the events.
    state.plan_closed = state.plan_linear == 1.0 and state.plan_varies == 0.0 and state.plan_bowed == 0.0
    state.plan_highest, state.plan_lowest = highest_position(p), lowest_position(p)
    plan_friction(p, state)
    state.plan_ratio = breakaway_ratio(p) * (1.0 + HOLD)
    state.plan_drift = fastest_drift(p)
    state.plan_hard_stop = p.stick_speed * p.stick_speed / PAST_STICKING
    state.known_duration = state.quiet_duration = -1.0
    for place in range(REMEMBERED):
        memory.glides[place].duration = -1.0
    forget_responses(memory)
    state.trial_step = math.inf


@inlined
def plan_friction(p, state):
    """Write down the friction either way of a stem of plain forces, off any tight spot."""
    state.plan_rising_friction = sliding_friction(p, RISING, math.inf, 0.0, 0.0)
    state.plan_falling_friction = sliding_friction(p, FALLING, math.inf, 0.0, 0.0)
    choose_friction(state)


@inlined
def choose_friction(state):
    """Write down the friction of the glide that is known, which may have drifted since, with its sign."""
    state.quiet_friction = state.plan_rising_friction if state.quiet_side > 0.0 else -state.plan_falling_friction


@inlined
def is_clear(p, state, low, high):
    """Return whether neither a tight spot nor a stop that gives way acts between two positions."""
    if p.stop_compliance > 0.0 and not p.lower_stop <= low <= high <= p.upper_stop:
        return False
    beyond = state.plan_reach + p.tight_spot_position
    return p.tight_spot_excess == 0.0 or low >= beyond or high <= p.tight_spot_position - state.plan_reach


@inlined
def may_glide(p, state):
    """Return whether the forces on the stem are plain where it is."""
    return state.plan_plain == 1.0 and (state.plan_clear == 1.0 or is_clear(p, state, state.position, state.position))


@inlined
def stays_clear(p, state, position, velocity):
    """Return whether the way from a position was clear; else put the stem back to there, at its velocity there."""
    if state.plan_clear == 1.0 or is_clear(p, state, min(position, state.position), max(position, state.position)):
        return True
    state.position, state.velocity = position, velocity
    return False


@inlined
def glides(p, state, memory, pressure, duration):
    """Move a stem through a duration if its forces are plain and nothing happens in it; return whether that was so."""
    position, velocity = state.position, state.velocity
    has_glided = may_glide(p, state) and glide(p, state, memory, pressure, duration)
    return has_glided and stays_clear(p, state, position, velocity)


@inlined
def glides_through_part(p, state, memory):
    """Move a stem through a part of moving pressure as `glides` does through a duration."""
    position, velocity = state.position, state.velocity
    return may_glide(p, state) and glide_part(p, state, memory) and stays_clear(p, state, position, velocity)


@inlined
def glide(p, state, memory, pressure, duration):
    """Move a stem of plain forces through a duration if nothing happens in it, and return whether that was so.

    Nothing happens while the stem stays stuck, or slips at no less than the stop speed at both ends: a speed has at
    most one zero, or its zeros are half a swing apart and the duration is shorter.
    """
    side = state.mode
    if side == STUCK:
        net = p.diaphragm_area * pressure - p.spring_preload - p.spring_rate * state.position
        return -state.plan_falling_friction * state.plan_ratio <= net <= state.plan_rising_friction * state.plan_ratio
    if state.plan_glides == 0.0:
        return False
    remember_glide(p, state, memory, side, duration)
    # In a closed loop the pressure comes last; all else is summed before.
    push = p.diaphragm_area * pressure - (p.spring_preload + state.quiet_friction)
    position = (state.quiet_yy * state.position + state.quiet_yv * state.velocity) + state.quiet_yf * push
    velocity = (state.quiet_vy * state.position + state.quiet_vv * state.velocity) + state.quiet_vf * push
    is_quiet = (
        side * state.velocity >= p.stick_speed
        and side * velocity >= p.stick_speed
        and state.plan_lowest <= position <= state.plan_highest
    )
    if is_quiet:
        state.position = position
        state.velocity = velocity
    return is_quiet


@inlined
def remember_glide(p, state, memory, side, duration):
    """Write down what a glide over a duration to one side needs, where it is not the last one."""
    if state.quiet_duration != duration or state.quiet_side != side:
        recall_glide(p, state, memory, side, duration)


@compiled
def recall_glide(p, state, memory, side, duration):
    """Write down what a glide over a duration to one side needs, laid anew unless it was among the last few."""
    for place in range(REMEMBERED):
        glide = memory.glides[place]
        if glide.duration == duration and glide.side == side:
            state.quiet_duration, state.quiet_side = duration, side
            state.quiet_vv, state.quiet_vf, state.quiet_vy = glide.vv, glide.vf, glide.vy
            state.quiet_yv, state.quiet_yf, state.quiet_yy = glide.yv, glide.yf, glide.yy
            choose_friction(state)
            return
    foresee_glide(p, state, side, duration)
    glide = memory.glides[int(memory.glide_turn)]
    memory.glide_turn = (memory.glide_turn + 1.0) % REMEMBERED
    glide.duration, glide.side = duration, side
    glide.vv, glide.vf, glide.vy = state.quiet_vv, state.quiet_vf, state.quiet_vy
    glide.yv, glide.yf, glide.yy = state.quiet_yv, state.quiet_yf, state.quiet_yy


@compiled
def foresee_glide(p, state, side, duration):
    """Write down how velocity and position follow from themselves and the force over a duration of one slip."""
    mass = p.stem_mass
    damping = p.viscous_friction * (1.0 + p.viscous_asymmetry * side)
    vv, va, _, _, yv, ya = transition(mass, damping, p.spring_rate, duration)
    # The acceleration is the net force less the viscous friction, over the mass.
    state.quiet_vv, state.quiet_vf = vv - va * damping / mass, va / mass
    state.quiet_yv, state.quiet_yf = yv - ya * damping / mass, ya / mass
    # The spring is taken out of the net force, so that the two sums of a period are short.
    state.quiet_yy, state.quiet_vy = 1.0 - state.quiet_yf * p.spring_rate, -state.quiet_vf * p.spring_rate
    state.quiet_duration, state.quiet_side = duration, side
    plan_friction(p, state)
    discriminant = p.spring_rate / mass - (0.5 * damping / mass) ** 2
    if discriminant > 0.0 and math.sqrt(discriminant) * duration >= math.pi:
        # More than half a swing: no glide is quiet.
        state.quiet_vv = state.quiet_vf = math.nan


@compiled
def glide_part(p, state, memory):
    """Move a stem of plain forces through a part of moving pressure if nothing happens in it; return whether so.

    Between the nodes speed and pressure go beyond their values there by a part of their bends or of their range only.
    """
    count, side, speeds = int(memory.part_count), state.mode, memory.speeds
    hold = p.spring_rate * state.position + p.spring_preload
    if side == STUCK:
        lowest = highest = memory.pressures[0]
        for node in range(1, count + 1):
            lowest, highest = min(lowest, memory.pressures[node]), max(highest, memory.pressures[node])
        slack = 0.5 * (highest - lowest)
        can_rise = p.diaphragm_area * (highest + slack) - hold > state.plan_rising_friction * state.plan_ratio
        can_fall = p.diaphragm_area * (lowest - slack) - hold < -state.plan_falling_friction * state.plan_ratio
        return not (can_rise or can_fall)
    if state.plan_glides == 0.0:
        return False
    mass, speed = p.stem_mass, side * state.velocity
    damping = p.viscous_friction * (1.0 + p.viscous_asymmetry * side) / mass
    remember_response(memory, damping, p.spring_rate / mass, memory.part_spacing, count)
    friction = state.plan_rising_friction if side > 0.0 else state.plan_falling_friction
    net = side * (p.diaphragm_area * memory.part_powers[0] - hold) - friction
    memory.step_spacing, memory.step_speed, memory.step_start = memory.part_spacing, speed, net / mass - damping * speed
    for power in range(1, count + 1):
        memory.pull_powers[power] = side * p.diaphragm_area / mass * memory.part_powers[power]
    speeds[0] = speed
    lay_motion(memory, count)
    lowest, bend = min(speed, speeds[count]), 0.0
    for node in range(1, count):
        lowest = min(lowest, speeds[node])
        bend = max(bend, speeds[node - 1] - 2.0 * speeds[node] + speeds[node + 1])
    position = state.position + side * memory.ways[count]
    is_quiet = lowest - 0.5 * bend >= p.stick_speed and state.plan_lowest <= position <= state.plan_highest
    if is_quiet:
        state.position, state.velocity = position, side * speeds[count]
    return is_quiet


@inlined
def remember_swing(p, state, damping, stiffness):
    """Write down the rates of a linear slip where they differ from the last one's."""
    if state.known_damping != damping or state.known_stiffness != stiffness or state.known_duration < 0.0:
        alpha = 0.5 * damping / p.stem_mass
        square = stiffness / p.stem_mass - alpha * alpha
        beta = math.sqrt(max(square, 0.0))
        state.known_alpha, state.known_beta = alpha, beta
        state.known_half_swing = math.pi / beta if beta > 0.0 else math.inf
        state.known_damping, state.known_stiffness, state.known_duration = damping, stiffness, 0.0


@inlined
def keeps_going(state, speed, acceleration, duration):
    """Return whether it is known at once that a speed does not fall to 0 within a duration.

    A speed has at most one zero, or its zeros are half a swing apart.
    """
    return (
        state.known_duration == duration
        and duration < state.known_half_swing
        and state.known_vv * speed + state.known_va * acceleration >= STOP_SPEED
    )


@inlined
def remembered_transition(p, state, damping, stiffness, duration, is_odd):
    """Return `transition`, that of a duration which is not odd computed anew only where it is not the last one."""
    if is_odd:
        return transition(p.stem_mass, damping, stiffness, duration)
    if state.known_duration != duration:
        vv, va, av, aa, yv, ya = transition(p.stem_mass, damping, stiffness, duration)
        state.known_vv, state.known_va, state.known_av = vv, va, av
        state.known_aa, state.known_yv, state.known_ya = aa, yv, ya
        state.known_duration = duration
    return state.known_vv, state.known_va, state.known_av, state.known_aa, state.known_yv, state.known_ya


@compiled
def longest_step(p):
    """Return the longest step that cannot miss what forces that vary in time do within. [s]"""
    longest = math.inf
    if has_load(p):
        longest = RESOLVED * p.load_period / p.load_waves
    if p.friction_drift_rate != 0.0:
        longest = min(longest, RESOLVED * p.friction_drift_time)
    return longest


@compiled
def advance_stem(p, state, memory, time, duration, tolerance):
    """Move the stem until its next event or the end of a duration; return the time used. [s]

    A linear slip under held forces is one closed-form step; else a slip is integrated.
    """
    if may_settle(p, state, tolerance):
        settled = settle_on_stop(p, state, memory, time, duration, tolerance)
        if settled > 0.0:
            return settled
    if state.plan_elastic == 1.0:
        if is_coarse(tolerance):
            return advance_linearised(p, state, memory, time, duration, tolerance)
        if state.mode == STUCK:
            rest = time_on_bristles(p, state, memory, time, duration, tolerance)
            if state.mode == STUCK:
                return rest
        if state.plan_series == 1.0 and (memory.part_count == 0.0 or p.area_slope == 0.0):
            return advance_on_bristles(p, state, memory, time, duration, tolerance)
        return advance_travel(p, state, memory, time, duration, tolerance)
    pressure = pressure_at(memory, time)
    if memory.part_count == 0.0 and state.plan_closed == 1.0:
        return advance_held(p, state, pressure, duration)
    if state.mode == STUCK:
        side = breakaway_side(p, state, pressure, time)
        if side == STUCK:
            return time_stuck(p, state, memory, time, duration, tolerance)
        break_away(p, state, side)
    elif sticks(p, state, pressure, time):
        come_to_rest(state)
        return 0.0
    if state.plan_falling == 1.0:
        return advance_falling(p, state, memory, time, pressure, duration, tolerance)
    return advance_travel(p, state, memory, time, duration, tolerance)


@compiled
def advance_held(p, state, pressure, duration):
    """Move the stem under forces that are held until its next event or the end of a duration; return the time used."""
    breaks_away = state.mode == STUCK
    if breaks_away:
        side = breakaway_side(p, state, pressure, 0.0)
        if side == STUCK:
            return duration
        break_away(p, state, side)
    elif sticks(p, state, pressure, 0.0):
        come_to_rest(state)
        return 0.0
    return advance_slip(p, state, pressure, duration, breaks_away)


@compiled
def advance_on_bristles(p, state, memory, time, duration, tolerance):
    """Move a slip on bristles of a held limit until its next event or the end of a duration; return the time used. [s]

    Once they are bent as far as they go, it slips on dry friction.
    """
    side, position, pressure = state.mode, state.position, pressure_at(memory, time)
    limit = sliding_friction(p, side, position, pressure, 0.0)
    viscous = p.viscous_friction * (1.0 + p.viscous_asymmetry * side)
    if p.bristle_damping > 0.0:
        viscous += bristle_viscosity(p, bristle_stiffness(p, side * state.bristle, limit))
    net = side * (thrust(p, position, pressure, 0.0) - elastic_friction(p, state) - viscous * state.velocity)
    is_held = memory.part_count == 0.0
    if is_held and side * state.velocity * state.plan_response <= MEETING * tolerance and net <= 0.0:
        # The rest of a creep is below the tolerance.
        come_to_rest(state)
        return 0.0
    is_bent = (1.0 - p.slider_share) * (limit - side * state.bristle) <= BENT * tolerance * p.spring_rate
    if has_sliders(p):
        is_bent = is_bent and stiffness_of_sliders(p, state, side, limit) == 0.0
    if is_held and is_bent:
        state.bristle = side * limit
        return advance_slip(p, state, pressure, duration, False)
    return advance_series(p, state, memory, time, pressure, limit, duration, tolerance)


@compiled
def advance_slip(p, state, pressure, duration, breaks_away):
    """Move a linear slip under held forces to its next event or the end of a duration; return the time used. [s]"""
    side, position = state.mode, state.position
    speed = side * state.velocity
    mass = p.stem_mass
    coulomb = sliding_friction(p, side, position, pressure, 0.0)
    viscous = p.viscous_friction * (1.0 + p.viscous_asymmetry * side)
    stiffness = tangent_stiffness(p, side, position, pressure, 0.0)
    start = (side * thrust(p, position, pressure, 0.0) - coulomb - viscous * speed) / mass
    if breaks_away and start <= 0.0:
        # Rounding: friction holds it after all.
        come_to_rest(state)
        return duration
    remember_swing(p, state, viscous, stiffness)
    stop = math.inf
    if speed == 0.0 and start > 0.0:
        stop = state.known_half_swing
    elif not keeps_going(state, speed, start, duration):
        stop = first_stop(mass, viscous, stiffness, speed, start)
    step, has_stopped = min(stop, duration), stop <= duration
    if has_stopped and max(state.known_alpha, state.known_beta) * stop >= SHORT and state.known_beta > 0.0:
        way, next_acceleration = swing_out(state.known_alpha, state.known_beta, speed, start, stop)
        next_speed = 0.0
    else:
        vv, va, av, aa, yv, ya = remembered_transition(p, state, viscous, stiffness, step, has_stopped)
        way = yv * speed + ya * start
        next_speed, next_acceleration = vv * speed + va * start, av * speed + aa * start
    room = room_to(state, side)
    contact = way_to_contact(p, state, side) if has_lag(p) else math.inf
    if not way <= room and not TOUCHING < contact < room:
        return hit_limit(p, state, mass, viscous, stiffness, speed, start, room, step)
    is_slow = next_speed < p.stick_speed and (not has_stopped or next_acceleration > -state.plan_hard_stop)
    if is_slow and state.plan_elastic == 0.0 and next_acceleration < 0.0:
        breakaway = state.plan_ratio * coulomb
        if abs(coulomb + viscous * next_speed + mass * next_acceleration) <= breakaway:
            has_stopped = True
            # Well inside what holds it, or rounding would let it break away anew.
            excess = coulomb * (1.0 - breakaway_ratio(p) * (1.0 + 0.5 * HOLD))
            step = slip_end(mass, viscous, stiffness, speed, start, excess, p.stick_speed, step)
            vv, va, av, aa, yv, ya = transition(mass, viscous, stiffness, step)
            way = yv * speed + ya * start
            next_speed, next_acceleration = vv * speed + va * start, av * speed + aa * start
    if TOUCHING < contact < way:
        # The play closes: the transmitter follows only from here on.
        step = time_of_way(mass, viscous, stiffness, speed, start, contact, step, 0.0)
        vv, va, av, aa, yv, ya = transition(mass, viscous, stiffness, step)
        way, has_stopped = contact, False
        next_speed, next_acceleration = vv * speed + va * start, av * speed + aa * start
    leave_trace(state, mass, viscous, stiffness, speed, start, next_speed, next_acceleration)
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
def hit_limit(p, state, mass, damping, stiffness, speed, acceleration, room, step):
    """Move a slip to the end of the travel; return the time used. [s]"""
    step = time_of_way(mass, damping, stiffness, speed, acceleration, max(room, 0.0), step, 0.0)
    vv, va, av, aa, _, _ = transition(mass, damping, stiffness, step)
    next_speed, next_acceleration = vv * speed + va * acceleration, av * speed + aa * acceleration
    leave_trace(state, mass, damping, stiffness, speed, acceleration, next_speed, next_acceleration)
    meet_limit(p, state, next_speed)
    return step
