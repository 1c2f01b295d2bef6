"""Runs of the chain over whole inputs, compiled: one row of numbers after the other, sample by sample.

The chain runs forward only. Where the pressure stands still under a held current, a run goes through it stage by
stage: first all pressures, then the stem, whose state stays in the processor's registers from event to event.
"""

from __future__ import annotations

import math

import numpy as np

from valvemodel.chain import (
    CURRENT,
    advance_period,
    anchor_stem,
    maps_plainly,
    mode_of,
    slip_on,
    start_chain,
    whole_duration,
)
from valvemodel.compiled import compiled, inlined
from valvemodel.parameters import MOST_NOTED, one_by_one
from valvemodel.stages.drifts import has_drifts, hold_drifts, longest_period, may_hold_drifts, take_out_drifts
from valvemodel.stages.electromagnet import advance_flux, coil_gap, gap_of_current
from valvemodel.stages.kept_parts import begin_parts
from valvemodel.stages.linkage import drag_both, dragged
from valvemodel.stages.motion import remember_glide
from valvemodel.stages.nozzle import advance_nozzle, static_pressure
from valvemodel.stages.sensor import read_sensor, reads_plainly
from valvemodel.stages.stem import STUCK

NONE = np.zeros((0, 0))
"""For outputs that are left out."""

ONE = np.uint64(1)
"""Counts samples without a sign: indices that may be negative cost more than the rest of a stuck period."""

FREE = np.zeros(0)
"""For runs without anchors."""


@compiled
def is_forward(state):
    """Return whether the pressure stands still under a held current and the stem may glide through a period."""
    return state.plan_steady == 1.0 and state.plan_moving == 0.0 and state.plan_delayed == 0.0


@compiled
def hold_pressures(p, state, time, drive, pressures):
    """Fill in the pressure that each held current gives."""
    if maps_plainly(p):
        gap_offset, gap_gain = p.gap_offset, p.gap_gain
        supply_pressure, flow_ratio = p.supply_pressure, p.flow_ratio
        # Without a branch in it, this loop is compiled into vector instructions.
        for sample in range(time.shape[0] - 1):
            gap = coil_gap(max(drive[sample], 0.0), gap_offset, gap_gain)
            pressures[sample] = static_pressure(gap, supply_pressure, flow_ratio)
        return
    for sample in range(time.shape[0] - 1):
        effective = advance_flux(p, state, drive[sample])
        gap = gap_of_current(p, effective, time[sample])
        pressures[sample] = advance_nozzle(p, state, gap, effective)


@compiled
def glide_along(p, state, memory, time, pressures, tolerance, positions):
    """Move a steady stem along all samples and write down the linkage; what is no glide goes event by event."""
    area, preload, stiffness = p.diaphragm_area, p.spring_preload, p.spring_rate
    play, lowest, highest = p.backlash_half_width, state.plan_lowest, state.plan_highest
    stick_speed = p.stick_speed
    hold_low = -state.plan_falling_friction * state.plan_ratio
    hold_high = state.plan_rising_friction * state.plan_ratio
    position, velocity, linkage, side = state.position, state.velocity, state.linkage, state.mode
    is_worn = p.backlash_wear > 0.0
    positions[0] = linkage
    sample, last = np.uint64(0), np.uint64(time.shape[0] - 1)
    while sample < last:
        if side == STUCK:
            held = stiffness * position
            while sample < last and hold_low <= area * pressures[sample] - preload - held <= hold_high:
                sample += ONE
                positions[sample] = linkage
        else:
            duration = whole_duration(time[sample + ONE] - time[sample])
            remember_glide(p, state, memory, side, duration)
            yy, yv, yf = state.quiet_yy, state.quiet_yv, state.quiet_yf
            vy, vv, vf = state.quiet_vy, state.quiet_vv, state.quiet_vf
            friction = state.quiet_friction
            while side * velocity >= stick_speed and whole_duration(time[sample + ONE] - time[sample]) == duration:
                push = area * pressures[sample] - (preload + friction)
                end = (yy * position + yv * velocity) + yf * push
                speed = (vy * position + vv * velocity) + vf * push
                # Not `and`: one branch that is foreseen is cheaper than three.
                if not ((side * speed >= stick_speed) & (lowest <= end) & (end <= highest)):
                    break
                position, velocity = end, speed
                if is_worn:
                    drag_both(p, state, position)
                    linkage = state.linkage
                else:
                    linkage = dragged(linkage, position, play)
                sample += ONE
                positions[sample] = linkage
                if sample == last:
                    break
        if sample < last:
            state.position, state.velocity, state.linkage, state.mode = position, velocity, linkage, side
            duration = whole_duration(time[sample + ONE] - time[sample])
            slip_on(p, state, memory, pressures[sample], time[sample], duration, tolerance)
            position, velocity, linkage, side = state.position, state.velocity, state.linkage, state.mode
            sample += ONE
            positions[sample] = linkage
    state.position, state.velocity, state.linkage, state.mode = position, velocity, linkage, side


@compiled
def read_along(p, state, time, readings):
    """Turn positions of the linkage into readings."""
    linkage = state.linkage
    for sample in range(time.shape[0]):
        state.linkage = readings[sample]
        readings[sample] = read_sensor(p, state, time[sample])
    state.linkage = linkage


@compiled
def run_forward(p, state, memory, time, drive, tolerance, pressures, readings):
    """Run a chain stage by stage, under the pressures of the row before if its parts are taken."""
    if state.plan_current == 1.0:
        if memory.takes_parts == 0.0:
            hold_pressures(p, state, time, drive, pressures)
        glide_along(p, state, memory, time, pressures, tolerance, readings)
    else:
        glide_along(p, state, memory, time, drive, tolerance, readings)
    if not reads_plainly(p):
        read_along(p, state, time, readings)


@inlined
def is_anchored(p, state, anchor, before, mode_before):
    """Return whether a stem is put anew at a sample: at each anchor, or only where it has come to rest."""
    if math.isnan(anchor):
        return False
    return p.anchors_at_rest == 0.0 or (state.mode == STUCK and (mode_before != STUCK or state.position != before))


@inlined
def tempered_square(error, reach):
    """Return the square of an error that counts, far beyond a reach, by its logarithm alone."""
    if math.isinf(reach):
        return error * error
    return reach * reach * math.log1p((error / reach) ** 2)


@inlined
def square_at(goal, sample, reading):
    """Return what a reading adds to the sum of squared errors of a goal: measured positions, slack and reach."""
    measured, slack, reach, _ = goal
    if measured.shape[0] == 0 or math.isnan(measured[sample]):
        return 0.0
    return tempered_square(max(abs(reading - measured[sample]) - slack, 0.0), reach)


@compiled
def errors_along(readings, measured, places, noise, slack, reach, lost, errors, first):
    """Fill in measured less simulated readings as they count, whose squares `square_at` adds up. [noise]

    Parameters
    ----------
    readings : array, shape (n, m) [m]
    measured, places : arrays, shape (k,) [m]
        What was measured at some samples, and which those are.
    slack : float [m]
    reach : float [noise]
        As for `score_rows`.
    lost : float [noise]
        What counts in place of what is no number; NaN leaves it as it is.
    errors : array, shape (n, more)
        Filled from a column `first` on.
    """
    per_noise = 1.0 / noise
    for row in range(readings.shape[0]):
        for each in range(places.shape[0]):
            error = measured[each] - readings[row, places[each]]
            if slack > 0.0:
                error = math.copysign(max(abs(error) - slack, 0.0), error)
            error *= per_noise
            if not math.isinf(reach):
                error = math.copysign(math.sqrt(tempered_square(error, reach)), error)
            errors[row, first + each] = error if math.isfinite(error) or math.isnan(lost) else lost


@compiled
def run_by_periods(p, given, state, memory, time, drive, anchors, tolerance, readings, pressures, modes, goal):
    """Run a chain period by period, put anew at the anchors; `given` are its numbers with what drifts.

    Return the sum of squared errors of a goal; infinity, and no more readings, once it is more than the goal's most.
    """
    holds = has_drifts(given) and not has_drifts(p)
    before, mode_before = state.position, state.mode
    total, most = 0.0, goal[3]
    for sample in range(time.shape[0]):
        if anchors.shape[0] > 0 and is_anchored(p, state, anchors[sample], before, mode_before):
            anchor_stem(p, state, anchors[sample], time[sample])
        before, mode_before = state.position, state.mode
        readings[sample] = read_sensor(p, state, time[sample])
        total += square_at(goal, sample, readings[sample])
        if total > most:
            return math.inf
        if pressures.shape[0] > 0:
            pressures[sample] = state.pressure
            modes[sample] = mode_of(state)
        if sample + 1 < time.shape[0]:
            if holds:
                hold_drifts(p, state, given, 0.5 * (time[sample] + time[sample + 1]))
            advance_period(p, state, memory, drive[sample], time[sample], time[sample + 1] - time[sample], tolerance)
    return total


@compiled
def run_row(
    given, state, memory, time, drive, anchors, driven_by, tolerance, readings, pressures, modes, scratch, goal, alike
):
    """Run one row of numbers over a drive; return the sum of squared errors of a goal, as `run_by_periods` does.

    Parameters
    ----------
    scratch : array, shape (m,), array, shape (1,), dtype PARAMETERS, and float [s]
        For the pressures and numbers on the way, overwritten; the longest period.
    alike : tuple of two bool
        Whether the pressures of the row before are taken, and whether its own are kept for the next.
    """
    held, own, longest = scratch
    p, holds = given, may_hold_drifts(given, longest, tolerance)
    if holds:
        own[0] = given
        p = own[0]
        take_out_drifts(p)
        hold_drifts(p, state, given, time[0])
    start_chain(p, state, memory, drive[0], driven_by, time[0], tolerance)
    goes_forward = not (anchors.shape[0] > 0 or pressures.shape[0] > 0 or holds) and is_forward(state)
    takes, keeps = alike
    begin_parts(memory, keeps, takes, 1.0 + holds + 2.0 * goes_forward, tolerance)
    if not goes_forward:
        return run_by_periods(
            p, given, state, memory, time, drive, anchors, tolerance, readings, pressures, modes, goal
        )
    run_forward(p, state, memory, time, drive, tolerance, held, readings)
    total = 0.0
    for sample in range(time.shape[0]):
        total += square_at(goal, sample, readings[sample])
    return total


def run_chain(rows, states, memories, time, drive, anchors, driven_by, tolerance, readings, pressures, modes):
    """Run each row of numbers over the same drive, one by one, as `run_in_order` does."""
    run_in_order(
        rows, states, memories, time, drive, anchors, driven_by, tolerance, readings, pressures, modes,
        *one_by_one(len(rows)),
    )  # fmt: skip


@compiled
def run_in_order(
    rows, states, memories, time, drive, anchors, driven_by, tolerance, readings, pressures, modes, order, follows
):
    """Run rows of numbers over the same drive; row k of the outputs is the state just before the drive of period k.

    Parameters
    ----------
    rows : array, shape (n,), dtype PARAMETERS
    states : array, shape (n,), dtype STATE
        Overwritten.
    memories : array, shape (1,), dtype MEMORY
        Overwritten; one row after the other uses it.
    time : array, shape (m,) [s]
    drive : array, shape (m,) [A] or [Pa]
        Held from each sample to the next.
    anchors : array, shape (0,) or (m,) [m]
        Readings at which the stem is put anew; NaN where it runs free.
    driven_by : int
        CURRENT or PRESSURE.
    tolerance : float [m]
        What a run may be off in position, but for slips that hang by a hair.
    readings, pressures, modes : arrays, shape (n, m) [m], [Pa], -1 falling 0 stuck 1 rising
        Overwritten; pressures and modes may have shape (n, 0) and are then left out.
    order : array of int, shape (k,)
        The rows that are run, as they come.
    follows : array of bool, shape (k,)
        Whether a row's pressures are those of the row before it in that order: a coarse run lays them once.
    """
    scratch = np.empty(time.shape[0]), rows[:1].copy(), longest_period(time)
    nothing = np.empty(0), 0.0, math.inf, math.inf
    for turn in range(order.shape[0]):
        row, is_followed = order[turn], turn + 1 < order.shape[0] and follows[turn + 1]
        run_row(
            rows[row], states[row], memories[0], time, drive, anchors, driven_by, tolerance,
            readings[row], pressures[row], modes[row], scratch, nothing, (turn > 0 and follows[turn], is_followed),
        )  # fmt: skip


@compiled
def score_rows(
    rows, states, memories, time, drive, measured, slack, reach, anchors, driven_by, tolerance, readings, most, sums
):
    """Run each row of numbers and keep the sum of its squared errors alone.

    Parameters
    ----------
    rows : array, shape (n,), dtype PARAMETERS
    states : array, shape (1,), dtype STATE
        Overwritten by one row after the other, as are `memories` and `readings`.
    measured : array, shape (m,) [m]
        NaN where nothing was measured.
    slack : float [m]
        Error that does not count, of a reading that comes in coarse steps.
    reach : float [m]
        Error far beyond which a sample counts by the logarithm; infinite for plain squares.
    readings : array, shape (m,) [m]
    most : array, shape (n,) [m^2]
        Sum beyond which a row is worth nothing: its run need not go on.
    sums : array, shape (n,) [m^2]
        Overwritten; infinite where a run was not ended.
    """
    scratch, nothing = (np.empty(time.shape[0]), rows[:1].copy(), longest_period(time)), np.empty(0)
    for row in range(rows.shape[0]):
        sums[row] = run_row(
            rows[row], states[0], memories[0], time, drive, anchors, driven_by, tolerance,
            readings, nothing, nothing, scratch, (measured, slack, reach, most[row]), (False, False),
        )  # fmt: skip


@compiled
def note_sample(p, state, time, sample):
    """Write down what stands at an instant."""
    sample.reading = read_sensor(p, state, time)
    sample.pressure = state.pressure
    sample.position = state.position
    sample.velocity = state.velocity
    sample.mode = mode_of(state)


@compiled
def trace_chain(rows, states, memories, time, drive, anchors, tolerance, samples, instants, between, events):
    """Run one row of numbers and write down all samples, what stands at instants between them, and all events.

    Parameters
    ----------
    rows, memories : arrays, shape (1,)
    states : array, shape (2,)
        The second is for looking ahead. Overwritten.
    samples : array, shape (m,), dtype SAMPLE
    instants : array, shape (k,), increasing, within the times [s]
    between : array, shape (k,), dtype SAMPLE
    events : array, dtype EVENT
        As many as it holds are written down.

    Returns
    -------
    int
        How many events there were.
    """
    p, state, ahead, memory = rows[0], states[0], states[1], memories[0]
    start_chain(p, state, memory, drive[0], CURRENT, time[0], tolerance)
    before, mode_before = state.position, state.mode
    instant, found = 0, 0
    for sample in range(time.shape[0]):
        if anchors.shape[0] > 0 and is_anchored(p, state, anchors[sample], before, mode_before):
            anchor_stem(p, state, anchors[sample], time[sample])
        note_sample(p, state, time[sample], samples[sample])
        is_last = sample + 1 == time.shape[0]
        while instant < instants.shape[0] and (is_last or instants[instant] < time[sample + 1]):
            states[1] = states[0]
            entered, acting = memory.line_entered, memory.line_acting
            if instants[instant] > time[sample]:
                span = instants[instant] - time[sample]
                advance_period(p, ahead, memory, drive[sample], time[sample], span, tolerance)
            note_sample(p, ahead, instants[instant], between[instant])
            memory.line_entered, memory.line_acting = entered, acting
            instant += 1
        if is_last:
            break
        before, mode_before = state.position, state.mode
        memory.notes_events, memory.events_noted = 1.0, 0.0
        advance_period(p, state, memory, drive[sample], time[sample], time[sample + 1] - time[sample], tolerance)
        memory.notes_events = 0.0
        for index in range(min(int(memory.events_noted), MOST_NOTED)):
            if found < events.shape[0]:
                events[found] = memory.events[index]
            found += 1
    return found
