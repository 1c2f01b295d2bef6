"""The chain run through time: held currents in, readings out, compiled."""

from __future__ import annotations

import math

import numpy as np

from valvemodel.compiled import compiled
from valvemodel.stages.electromagnet import advance_flux, gap_of_current, rest_electromagnet
from valvemodel.stages.nozzle import advance_nozzle, rest_nozzle
from valvemodel.stages.sensor import bow, follow_stem, read_sensor, rest_sensor, sensor_drift, unbow
from valvemodel.stages.stem import (
    STOP_SPEED, STUCK, advance_stem, put_stem, rest_stem,
)  # fmt: skip

CURRENT, PRESSURE = 0, 1
"""What drives a run: the current through all stages, or the pressure at the stem alone."""

ROUNDING = 1e-12
"""Periods that differ by less are equal but for the rounding of their times. [s]"""

MOST_EVENTS = 100_000
"""Events within one period beyond which a stem is taken to be at rest; a guard, never reached by sound parameters."""


@compiled
def has_pressure_dynamics(p):
    """Return whether the pressure moves while the current is held."""
    return (
        p.coil_time_constant > 0.0
        or p.chamber_filling_time > 0.0
        or p.fill_time > 0.0
        or p.vent_time > 0.0
        or p.filling_slowness > 0.0
        or p.droop_gain > 0.0
    )


@compiled
def start_chain(p, state, drive, driven_by, time):
    """Put all stages at rest under the first drive; the stem where the start reading says, if any."""
    if driven_by == CURRENT:
        rest_electromagnet(p, state, drive)
        gap = gap_of_current(p, state.hysteresis_input, time)
        rest_nozzle(p, state, gap, state.hysteresis_input)
    else:
        state.pressure = drive
    if math.isnan(p.start_position):
        rest_stem(p, state, state.pressure, time)
        put_stem(p, state, state.position, state.pressure, time)
    else:
        put_stem(p, state, unbow(p, p.start_position - sensor_drift(p, time)), state.pressure, time)
    rest_sensor(p, state)


@compiled
def move_stem(p, state, pressure, time, duration, tolerance):
    """Move stem and sensor through a duration under a held pressure, event by event."""
    used = 0.0
    for _ in range(MOST_EVENTS):
        left = duration - used
        if left <= 0.0:
            return
        before = state.position
        step = advance_stem(p, state, pressure, time + used, left, tolerance)
        follow_stem(p, state, before, state.position, step)
        used += step
    state.velocity = 0.0
    state.mode = STUCK


@compiled
def hold_current(p, state, current, time, duration, substep, tolerance):
    """Hold a current at the electromagnet for a duration, in parts while the pressure moves."""
    parts = 1
    if has_pressure_dynamics(p):
        parts = min(max(int(math.ceil(duration / substep - 1e-9)), 1), 200)
    part = duration / parts
    for index in range(parts):
        instant = time + index * part
        effective = advance_flux(p, state, current, part)
        gap = gap_of_current(p, effective, instant + 0.5 * part)
        pressure = advance_nozzle(p, state, gap, effective, part)
        move_stem(p, state, pressure, instant, part, tolerance)


@compiled
def hold_period(p, state, time, drive, period, driven_by, substep, tolerance):
    """Move the chain from one sample to the next.

    A transport delay shifts the breakpoints of the current: they fall inside the periods.
    """
    start, end = time[period], time[period + 1]
    if abs(end - start - state.period) > ROUNDING:
        state.period = end - start
    if driven_by == PRESSURE:
        state.pressure = drive[period]
        move_stem(p, state, drive[period], start, state.period, tolerance)
        return
    delay = p.transport_delay
    if delay == 0.0:
        hold_current(p, state, drive[period], start, state.period, substep, tolerance)
        return
    index = period
    while index >= 0 and time[index] + delay > start + 1e-12:
        index -= 1
    instant = start
    while instant < end - 1e-12:
        following = min(time[index + 1] + delay, end) if index < period else end
        hold_current(p, state, drive[max(index, 0)], instant, following - instant, substep, tolerance)
        instant = following
        index += 1


@compiled
def anchor_stem(p, state, reading, time):
    """Shift stem and linkage to a reading; motion, play and friction stay as they are."""
    shift = unbow(p, reading - sensor_drift(p, time)) - state.linkage
    state.position += shift
    state.linkage += shift
    state.lagged_reading = bow(p, state.linkage)


@compiled
def mode_of(state):
    """Return the mode as a user sees it: a creep below the stop speed counts as stuck."""
    return STUCK if abs(state.velocity) < STOP_SPEED else math.copysign(1.0, state.velocity)


@compiled
def run_chain(rows, states, time, drive, anchors, driven_by, substep, tolerance, readings, pressures, modes):
    """Run each row of numbers over the same drive; row k of the outputs is the state just before the drive of period k.

    Parameters
    ----------
    rows : array, shape (n,), dtype PARAMETERS
    states : array, shape (n,), dtype STATE
        Overwritten.
    time : array, shape (m,) [s]
    drive : array, shape (m,) [A] or [Pa]
        Held from each sample to the next.
    anchors : array, shape (0,) or (m,) [m]
        Readings at which the stem is put anew; NaN where it runs free.
    driven_by : int
        CURRENT or PRESSURE.
    substep : float [s]
        Longest part of a period while the pressure moves.
    tolerance : float [N]
        Force left over by one linearised slip step.
    readings, pressures, modes : arrays, shape (n, m) [m], [Pa], -1 falling 0 stuck 1 rising
        Overwritten; pressures and modes may have shape (0, 0) and are then left out.
    """
    for row in range(rows.shape[0]):
        p, state = rows[row], states[row]
        start_chain(p, state, drive[0], driven_by, time[0])
        for sample in range(time.shape[0]):
            if anchors.shape[0] > 0 and not math.isnan(anchors[sample]):
                anchor_stem(p, state, anchors[sample], time[sample])
            readings[row, sample] = read_sensor(p, state, time[sample])
            if pressures.shape[0] > 0:
                pressures[row, sample] = state.pressure
                modes[row, sample] = mode_of(state)
            if sample + 1 < time.shape[0]:
                hold_period(p, state, time, drive, sample, driven_by, substep, tolerance)


NONE = np.zeros((0, 0))
FREE = np.zeros(0)
