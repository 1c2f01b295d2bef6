"""The chain run through time: held currents in, readings out, compiled."""

from __future__ import annotations

import math

from valvemodel.compiled import apart, compiled, inlined
from valvemodel.parameters import MEMORY, MOST_NOTED, PARAMETERS, STATE
from valvemodel.stages.bow import unbow
from valvemodel.stages.electromagnet import advance_flux, gap_of_current, has_coil_lag, rest_electromagnet
from valvemodel.stages.kept_parts import next_part
from valvemodel.stages.lag import forget_lags
from valvemodel.stages.line import ROUNDING, enter_line, leave_line, next_arrival, rest_line
from valvemodel.stages.linkage import drag_linkage, shift_linkage
from valvemodel.stages.motion import advance_held, advance_stem, glides, glides_through_part, plan_stem
from valvemodel.stages.nozzle import advance_nozzle, has_leak, is_amplified, rest_nozzle
from valvemodel.stages.part import hold_pressure, is_coarse, is_of_a_search, rest_parts
from valvemodel.stages.rest import come_to_rest
from valvemodel.stages.sensor import follow_stem, rest_sensor, sensor_drift
from valvemodel.stages.slip import STOP_SPEED
from valvemodel.stages.stem import STUCK, breakaway_ratio, held_by_stops, lay_span, put_stem, rest_stem
from valvemodel.stages.transmitter import settle_reading
from valvemodel.stages.travel import SHORTEST_STEP

RECORDS = (PARAMETERS, STATE, MEMORY)

CURRENT, PRESSURE = 0, 1
"""What drives a run: the current through all stages, or the pressure at the stem alone."""

TICKS = 1.26e12
"""In a second; decimals, thirds, sevenths and ninths of it are whole numbers of ticks. [1/s]"""

CHATTER = 64
"""Shortest steps in a row after which a stem that sticks and breaks away in turn is held for a moment."""

MOST_STEPS, STEPS_PER_SECOND = 2000, 2e4
"""Steps of the stem in one hold, and more for each second of it, after which it is followed more coarsely."""

MOST_STEPS_OF_A_SEARCH, STEPS_PER_SECOND_OF_A_SEARCH = 60, 2e3
"""Steps there: numbers that make a stem chatter a thousand times in a hold are none of a valve."""

JUMP_SHARE = 0.04
"""Share of its errors that is left to a stem that jumps off a ramp: they shift the instant, and the jump is as fast."""

FEW = 4
"""Events of one period that a steady stem meets without being followed further; most have one or two."""

COARSEST = 1.0
"""A tolerance beyond all travel. [m]"""


@compiled
def has_pressure_dynamics(p):
    """Return whether the pressure moves while the current is held."""
    return (
        p.gap_drift_rate != 0.0
        or has_coil_lag(p)
        or p.chamber_filling_time > 0.0
        or is_amplified(p)
        or p.droop_gain > 0.0
        or p.droop_consumption > 0.0
    )


@compiled
def maps_plainly(p):
    """Return whether eqs. (16) and (31) alone give the pressure of a held current."""
    return (
        p.saturation_slope == 1.0
        and p.hysteresis_half_width == 0.0
        and p.pressure_per_current == 0.0
        and p.compressible_share == 0.0
        and not has_leak(p)
        and not has_pressure_dynamics(p)
    )


@compiled
def plan_run(p, state, memory, driven_by, tolerance):
    """Write down once a run what does not change during it."""
    plan_stem(p, state, memory, tolerance)
    forget_lags(memory)
    state.lag_duration = -1.0
    state.plan_moving = driven_by == CURRENT and has_pressure_dynamics(p)
    state.plan_current = driven_by == CURRENT
    state.plan_delayed = p.transport_delay > 0.0 and driven_by == CURRENT
    has_ramp = state.plan_elastic == 0.0 and (state.plan_moving == 1.0 or state.plan_varies == 1.0)
    # A search takes a jump that begins a moment early or late.
    state.plan_share = JUMP_SHARE if has_ramp and breakaway_ratio(p) > 1.0 and not is_coarse(tolerance) else 1.0


@apart(RECORDS, 4)
def start_chain(p, state, memory, drive, driven_by, time, tolerance):
    """Plan a run and put all stages at rest under the first drive; the stem where the start reading says, if any."""
    plan_run(p, state, memory, driven_by, tolerance)
    if driven_by == CURRENT:
        effective = rest_electromagnet(p, state, drive)
        rest_nozzle(p, state, gap_of_current(p, effective, time), effective)
    else:
        state.pressure = drive
    rest_parts(state, drive)
    state.rest_drive = drive if p.gap_drift_rate == 0.0 else math.nan
    if math.isnan(p.start_position):
        rest_stem(p, state, state.pressure, time)
    else:
        put_stem(p, state, unbow(p, p.start_position - sensor_drift(p, time)), state.pressure, time)
    rest_line(memory, drive)
    rest_sensor(p, state)
    if p.backlash_start != 0.0:
        state.position -= p.backlash_start * p.backlash_half_width
    lay_span(p, state, STUCK)


@compiled
def note_event(memory, time, position, speed_before, mode_before, mode_after):
    """Write down an event; where the table is full, only count it."""
    index = int(memory.events_noted)
    memory.events_noted += 1.0
    if index < MOST_NOTED:
        event = memory.events[index]
        event.time, event.position, event.speed_before = time, position, speed_before
        event.mode_before, event.mode_after = mode_before, mode_after


@compiled
def note_events(state, memory, time, step, before, mode_before, highest_before):
    """Write down the changes of mode in one step of the stem, which may break away and stop again.

    Where it comes to a stop that gives way, or leaves it, the span of its forces changes and its mode does not.
    """
    moved = state.position - before
    if mode_before == STUCK and (state.mode != STUCK or moved != 0.0):
        side = state.mode if state.mode != STUCK else math.copysign(1.0, moved)
        note_event(memory, time, before, 0.0, STUCK, side)
        mode_before = side
    if state.mode != mode_before:
        speed = abs(state.trace_next_velocity)
        note_event(memory, time + step, state.position, speed, mode_before, state.mode)
    elif state.span_highest != highest_before and state.position in (state.span_lowest, state.span_highest):
        note_event(memory, time + step, state.position, abs(state.velocity), state.mode, state.mode)


@apart(RECORDS, 4)
def move_by_events(p, state, memory, time, used, duration, tolerance):
    """Move stem and sensor through what is left of a duration of the part, from event to event.

    What is too stiff to be followed in a bounded number of steps is followed at ten times the tolerance, and so on.
    """
    in_a_row, pause, steps, most = 0, SHORTEST_STEP, 0, MOST_STEPS + STEPS_PER_SECOND * duration
    if is_of_a_search(tolerance):
        most = MOST_STEPS_OF_A_SEARCH + STEPS_PER_SECOND_OF_A_SEARCH * duration
    while used < duration and tolerance <= COARSEST:
        steps += 1
        if steps > most:
            tolerance, steps = 10.0 * tolerance, 0
        before, mode_before, highest_before = state.position, state.mode, state.span_highest
        memory.trace_count = state.trace_steady = state.trace_velocity = state.trace_acceleration = 0.0
        state.trace_next_velocity = state.trace_next_acceleration = 0.0
        step = advance_stem(p, state, memory, time + used, duration - used, tolerance)
        follow_stem(p, state, memory, before, state.position, step)
        if memory.notes_events == 1.0:
            note_events(state, memory, time + used, step, before, mode_before, highest_before)
        in_a_row = in_a_row + 1 if step <= SHORTEST_STEP else 0
        if in_a_row == CHATTER:
            # It would go on so for ever: it rests a moment, and then for twice as long.
            come_to_rest(state)
            step, in_a_row, pause = min(pause, duration - used), 0, 2.0 * pause
        used += step


@inlined
def slip_on(p, state, memory, pressure, time, duration, tolerance):
    """Move stem and sensor through a duration under a held pressure in which something happens."""
    used = 0.0
    if state.plan_steady == 1.0 and memory.notes_events == 0.0:
        for _ in range(FEW):
            used += advance_held(p, state, pressure, duration - used)
            drag_linkage(p, state)
            if used >= duration:
                return
    hold_pressure(memory, pressure)
    move_by_events(p, state, memory, time, used, duration, tolerance)


@inlined
def move_stem(p, state, memory, pressure, time, duration, tolerance):
    """Move stem and sensor through a duration under a held pressure, event by event."""
    if glides(p, state, memory, pressure, duration):
        drag_linkage(p, state)
    else:
        slip_on(p, state, memory, pressure, time, duration, tolerance)


@inlined
def hold_drive(p, state, memory, drive, time, duration, tolerance):
    """Hold a current at the electromagnet and the pressure that it gives at the stem; or hold a pressure."""
    pressure = drive
    if state.plan_current == 1.0:
        effective = advance_flux(p, state, drive)
        gap = gap_of_current(p, effective, time)
        pressure = advance_nozzle(p, state, gap, effective)
    else:
        state.pressure = drive
    move_stem(p, state, memory, pressure, time, duration, tolerance)


@apart(RECORDS, 4)
def hold_in_parts(p, state, memory, drive, time, duration, tolerance):
    """Hold a current part by part while the pressure moves, and at once where it has come to rest."""
    used = 0.0
    while used < duration:
        left, now = duration - used, time + used
        if state.rest_drive == drive:
            move_stem(p, state, memory, state.pressure, now, left, tolerance)
            return
        length = next_part(p, state, memory, drive, now, left, tolerance)
        if glides_through_part(p, state, memory):
            drag_linkage(p, state)
        else:
            move_by_events(p, state, memory, now, 0.0, length, tolerance)
        used = duration if left - length <= ROUNDING else used + length


@inlined
def hold_current(p, state, memory, drive, time, duration, tolerance):
    """Hold a current or a pressure for a duration, whether what it gives moves or not."""
    if state.plan_moving == 1.0:
        hold_in_parts(p, state, memory, drive, time, duration, tolerance)
    else:
        hold_drive(p, state, memory, drive, time, duration, tolerance)


@inlined
def whole_duration(span):
    """Return a duration in whole ticks: those that differ by rounding alone share their closed forms. [s]"""
    return math.floor(span * TICKS + 0.5) / TICKS


@apart(RECORDS, 4)
def hold_delayed(p, state, memory, drive, time, duration, tolerance):
    """Let a current enter the line and hold what comes out of it: its switches fall inside the periods."""
    enter_line(memory, time, drive)
    instant, end = time, time + duration
    while True:
        arrived = leave_line(memory, p.transport_delay, instant)
        following = next_arrival(memory, p.transport_delay, end)
        span = following - instant
        # An exact run is not shifted by a part of a tick.
        span = whole_duration(span) if is_coarse(tolerance) else span
        hold_current(p, state, memory, arrived, instant, span, tolerance)
        if following == end:
            return
        instant = following


@inlined
def advance_period(p, state, memory, drive, time, span, tolerance):
    """Hold a drive from an instant for a span of time."""
    duration = whole_duration(span)
    if state.plan_delayed == 1.0:
        hold_delayed(p, state, memory, drive, time, duration, tolerance)
    else:
        hold_current(p, state, memory, drive, time, duration, tolerance)


@compiled
def anchor_stem(p, state, reading, time):
    """Shift stem and linkage to a reading that they are off by more than the tolerance; motion and friction stay.

    A shift as small as the noise of the reading would decide, at the brink of breakaway, whether the stem slips.
    """
    shift = unbow(p, reading - sensor_drift(p, time)) - state.linkage
    if abs(shift) <= p.anchor_tolerance:
        return
    if p.stop_compliance > 0.0:
        shift = held_by_stops(p, state.position + shift, state.pressure, time) - state.position
    state.position += shift
    lay_span(p, state, state.mode)
    shift_linkage(state, shift)
    settle_reading(p, state)


@compiled
def mode_of(state):
    """Return the mode as a user sees it: a creep below the stop speed counts as stuck."""
    return STUCK if abs(state.velocity) < STOP_SPEED else math.copysign(1.0, state.velocity)
