"""Transmitter: the reading lags the linkage, once or twice in series."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined
from valvemodel.stages.bow import bow, bow_slope
from valvemodel.stages.lag import (
    READING_LAG,
    SHORTER_READING_LAG,
    follow_nodes,
    in_series,
    longer_and_shorter,
    remembered_lag,
)
from valvemodel.stages.linkage import dragged_place
from valvemodel.stages.nodes import slope_at

NEAR_POLE = 1e-6
"""Distance from the pole of `lag_of_slip` that is kept: the reading is off by this share of its lag."""


@inlined
def has_lag(p):
    """Return whether the reading lags the linkage."""
    return p.sensor_time_constant > 0.0 or p.sensor_second_time_constant > 0.0


@inlined
def time_constants(p):
    """Return the longer and the shorter time constant. [s]"""
    return longer_and_shorter(p.sensor_time_constant, p.sensor_second_time_constant)


@inlined
def follow_linkage(p, state, memory, was, part, duration):
    """Follow the linkage, of which the stem drags a part, through a step to where it is: each lag on its own."""
    if p.sensor_second_time_constant > 0.0:
        follow_twice(p, state, memory, was, part, duration)
        return
    time_constant = p.sensor_time_constant
    if state.lag_duration != duration:
        state.lag_duration, state.lag_decay = duration, math.exp(-duration / time_constant)
    state.lagged_reading = lag_behind(
        p, state, memory, READING_LAG, time_constant, was, part, state.lagged_reading, state.lag_decay
    )


@compiled
def follow_twice(p, state, memory, was, part, duration):
    """Follow the linkage with two lags, apart from the common case of one, which it would slow down."""
    longer, shorter = time_constants(p)
    if state.lag_duration != duration:
        state.lag_duration = duration
        state.lag_decay = math.exp(-duration / longer)
        state.shorter_lag_decay = math.exp(-duration / shorter) if shorter > 0.0 else 0.0
    state.lagged_reading = lag_behind(
        p, state, memory, READING_LAG, longer, was, part, state.lagged_reading, state.lag_decay
    )
    if shorter > 0.0:
        state.less_lagged_reading = lag_behind(
            p,
            state,
            memory,
            SHORTER_READING_LAG,
            shorter,
            was,
            part,
            state.less_lagged_reading,
            state.shorter_lag_decay,
        )


@inlined
def lag_behind(p, state, memory, which, time_constant, was, part, reading, decay):
    """Return a lagged reading at the end of a step through which the stem drags a part of the linkage. [m]"""
    start, end = bow(p, was), bow(p, state.linkage)
    behind = start - reading
    if part == 0.0:
        return end - behind * decay
    gain = part * (end - start) / (state.linkage - was)
    of_velocity, of_acceleration = lag_of_slip(time_constant, state.trace_damping, state.trace_stiffness)
    steady = state.trace_steady
    forced = of_velocity * (state.trace_velocity - steady) + of_acceleration * state.trace_acceleration
    following = of_velocity * (state.trace_next_velocity - steady) + of_acceleration * state.trace_next_acceleration
    forced, following = gain * (forced + time_constant * steady), gain * (following + time_constant * steady)
    if memory.trace_count > 0.0:
        following += lag_of_pulls(p, state, memory, which, time_constant, part, gain, of_acceleration)
    return end - following - (behind - forced) * decay


@compiled
def lag_of_pulls(p, state, memory, which, time_constant, part, gain, of_acceleration):
    """Return how far a lagged reading is further behind an integrated step: by its pulls, and by a bow. [m]"""
    count, side, spacing = int(memory.trace_count), memory.step_side, memory.step_spacing
    lag = remembered_lag(memory, which, 1.0 / time_constant, spacing, count)
    for node in range(count + 1):
        # The lag's own acceleration factor feeds on the slope of the pulls.
        source = -of_acceleration * gain * slope_at(count, memory.pull_powers, float(node)) / spacing
        linkage = dragged_place(p, state, side, part, memory.step_position + side * memory.ways[node])
        source += (part * bow_slope(p, linkage) - gain) * memory.speeds[node]
        memory.forces[node] = side * source
    follow_nodes(lag, 0.0, memory.forces, memory.powers, memory.values)
    return memory.values[count]


@compiled
def lag_of_slip(time_constant, damping, stiffness):
    """Return how far a lagged reading is behind a slip a' = -c a - k v: a sum of v and a with these two factors.

    Where the lag's time constant is one of the slip's own, the factors have a pole, which is stepped aside of.
    """
    shape = 1.0 - damping * time_constant + stiffness * time_constant * time_constant
    if abs(shape) < NEAR_POLE:
        shape = NEAR_POLE if shape >= 0.0 else -NEAR_POLE
    of_acceleration = -time_constant * time_constant / shape
    return time_constant * (1.0 - damping * time_constant) / shape, of_acceleration


@inlined
def lagged_reading(p, state):
    """Return what comes out of both lags in series. [m]"""
    if p.sensor_second_time_constant == 0.0:
        return state.lagged_reading
    longer, shorter = time_constants(p)
    return in_series(longer, shorter, state.lagged_reading, state.less_lagged_reading)


@compiled
def settle_reading(p, state):
    """Let the reading have followed the linkage to where it is."""
    state.lagged_reading = state.less_lagged_reading = bow(p, state.linkage)
