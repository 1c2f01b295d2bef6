"""Sensor: stem position to reading, with the effects of linkage and transmitter."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined
from valvemodel.declarations import Effect, Parameter
from valvemodel.stages.lag import follow_nodes, remember_lag
from valvemodel.stages.nodes import fit_powers, left_out, slope_at

EFFECTS = (
    Effect(
        key="linkage_backlash",
        stage="sensor",
        title="linkage backlash",
        meaning="play between stem and transmitter",
        equation=r"z = \min(\max(z, y - b), y + b)",
        source="play operator, Krasnosel'skii and Pokrovskii (1989)",
        parameters=(
            Parameter("backlash_half_width", "m", "b: half the play", 0.0, 0.03, 0.0, (1e-3, 4e-3)),
            Parameter("backlash_start", "1", "where in the play the linkage starts", -1.0, 1.0, 0.0, (0.0,)),
        ),
        aliases=("none", "magnetic_hysteresis"),
        told_apart_by="a second position sensor at the stem, or the pressure at which the stem itself starts",
    ),
    Effect(
        key="quantisation",
        stage="sensor",
        title="quantisation",
        meaning="the reading comes in coarse steps",
        equation=r"r = o + q\,\mathrm{round}((z - o)/q)",
        source="ideal rounding to a grid with an offset",
        parameters=(
            Parameter(
                "resolution",
                "m",
                "one step of the reading",
                0.0,
                0.02,
                0.0,
                ("reading_step",),
                is_fitted=False,
                typical=1e-3,
            ),
            Parameter(
                "resolution_offset",
                "m",
                "a reading on the grid",
                -0.02,
                0.02,
                0.0,
                ("reading_phase",),
                is_fitted=False,
                typical=0.0,
            ),
        ),
        stops_again=True,
        told_apart_by="the readings themselves: they take few values",
    ),
    Effect(
        key="sensor_drift",
        stage="sensor",
        title="sensor drift",
        meaning="the zero of the transmitter creeps",
        equation=r"r = z + d\,T\,(1 - e^{-t/T})",
        source="zero drift of a transmitter that warms up, first order",
        parameters=(
            Parameter("sensor_drift_rate", "m/s", "creep of the zero at the start", -3e-3, 3e-3, 0.0, (1e-5, -1e-5)),
            Parameter(
                "sensor_drift_time",
                "s",
                "time constant of the warming",
                25.0,
                3000.0,
                300.0,
                (300.0, 40.0),
                "log",
            ),
        ),
        aliases=("gap_drift", "load_force"),
        acts_in_time=True,
        told_apart_by="a measured pressure, or a mechanical stop that is visited early and late",
    ),
    Effect(
        key="sensor_lag",
        stage="sensor",
        title="sensor lag",
        meaning="the transmitter is slow",
        equation=r"T\,\dot r = z - r",
        source="first-order transmitter or filter",
        parameters=(Parameter("sensor_time_constant", "s", "time constant", 0.0, 3.0, 0.0, (0.1, 0.5)),),
        aliases=("coil_lag", "chamber_filling", "transport_delay"),
        acts_in_time=True,
        told_apart_by="a measured pressure, or a faster sampling of one reversal: a slow reading rounds the corner",
    ),
    Effect(
        key="linkage_nonlinearity",
        stage="sensor",
        title="linkage nonlinearity",
        meaning="the rotary linkage reads a bow, and a skew, over the travel",
        equation=r"r = z + 4\xi(1 - \xi)\,(h + \sqrt{27}/2\,s\,(1 - 2\xi)),\quad \xi = z/L",
        source="lever geometry to third order",
        parameters=(
            Parameter("linkage_bow", "m", "h: bow in the middle of the travel", -0.05, 0.05, 0.0, (3e-3, -3e-3)),
            Parameter(
                "linkage_skew",
                "m",
                "s: swing between the halves of the travel",
                -0.02,
                0.02,
                0.0,
                (1e-3,),
                typical=0.0,
            ),
        ),
        aliases=("spring_hardening", "area_variation", "magnetic_saturation"),
        told_apart_by="a straight scale on the stem, or a measured pressure with a known spring",
    ),
)


SKEW = 0.5 * math.sqrt(27.0)
"""Scales the skew so that its largest swing is the parameter (4 x (1 - x) (1 - 2 x) peaks at 4/sqrt(108))."""


STRAIGHT = 0.01
"""Share of the tolerance by which a linkage may bend along a step and still be straight."""

NEAR_POLE = 1e-6
"""Distance from the pole of `lag_of_slip` that is kept: the reading is off by this share of its lag."""


@inlined
def bow(p, position):
    """Return the indicated for a true position; the identity for a straight linkage. [m]"""
    if p.linkage_bow == 0.0 and p.linkage_skew == 0.0:
        return position
    share = position / p.rated_travel
    return position + 4.0 * share * (1.0 - share) * (p.linkage_bow + SKEW * p.linkage_skew * (1.0 - 2.0 * share))


@compiled
def unbow(p, reading):
    """Return the position that a bowed linkage indicates so, by iteration from the reading. [m]"""
    if p.linkage_bow == 0.0 and p.linkage_skew == 0.0:
        return reading
    position = reading
    for _ in range(60):
        change = reading - bow(p, position)
        position += change
        if abs(change) < 1e-15:
            break
    return position


@inlined
def follow_steadily(p, state):
    """Follow a stem that has moved one way, without a lag."""
    position = state.position
    if p.backlash_half_width == 0.0:
        state.linkage = position
    else:
        state.linkage = min(max(state.linkage, position - p.backlash_half_width), position + p.backlash_half_width)


@compiled
def follow_stem(p, state, memory, before, after, duration):
    """Follow a stem that moves one way from one position to another within a duration.

    The lag is exact behind a straight linkage; what a bow adds is a polynomial through the nodes of the step.
    """
    was = state.linkage
    follow_steadily(p, state)
    if p.sensor_time_constant == 0.0 or duration <= 0.0:
        return
    start, end = bow(p, was), bow(p, state.linkage)
    if state.lag_duration != duration:
        state.lag_duration = duration
        state.lag_decay = math.exp(-duration / p.sensor_time_constant)
    behind = start - state.lagged_reading
    if state.linkage == was:
        state.lagged_reading = end - behind * state.lag_decay
        return
    gain = (end - start) / (state.linkage - was)
    of_velocity, of_acceleration = lag_of_slip(p.sensor_time_constant, state.trace_damping, state.trace_stiffness)
    forced = gain * (of_velocity * state.trace_velocity + of_acceleration * state.trace_acceleration)
    following = gain * (of_velocity * state.trace_next_velocity + of_acceleration * state.trace_next_acceleration)
    if memory.trace_count > 0.0:
        following += lag_of_pulls(p, memory, gain, of_acceleration)
    state.lagged_reading = end - following - (behind - forced) * state.lag_decay


@compiled
def lag_of_pulls(p, memory, gain, of_acceleration):
    """Return how far a lagged reading is further behind an integrated step: by its pulls, and by a bow. [m]"""
    count, side, spacing = int(memory.trace_count), memory.step_side, memory.step_spacing
    lag = memory.lags[4]
    remember_lag(lag, 1.0 / p.sensor_time_constant, spacing, count)
    for node in range(count + 1):
        # The lag's own acceleration factor feeds on the slope of the pulls.
        source = -of_acceleration * gain * slope_at(count, memory.pull_powers, float(node)) / spacing
        position = memory.step_position + side * memory.ways[node]
        source += (bow_slope(p, position) - gain) * memory.speeds[node]
        memory.forces[node] = side * source
    follow_nodes(lag, 0.0, memory.forces, memory.powers, memory.values)
    return memory.values[count]


@compiled
def bow_left_out(p, memory, count, tolerance):
    """Return by how much a lagged reading is off where a bow is a polynomial through the nodes of a step. [m]"""
    way = memory.ways[count]
    curvature = 8.0 * (abs(p.linkage_bow) + 6.0 * SKEW * abs(p.linkage_skew)) / (p.rated_travel * p.rated_travel)
    most = curvature * way * way
    if most <= STRAIGHT * tolerance:
        return most
    side = memory.step_side
    gain = bow_slope(p, memory.step_position + 0.5 * side * way)
    for node in range(count + 1):
        slope = bow_slope(p, memory.step_position + side * memory.ways[node])
        memory.forces[node] = (slope - gain) * memory.speeds[node]
    fit_powers(count, memory.forces, memory.powers)
    return left_out(count, memory.powers) * memory.step_spacing * count


@inlined
def bow_slope(p, position):
    """Return how the indicated position changes with the true one."""
    share = position / p.rated_travel
    slope = 4.0 * (1.0 - 2.0 * share) * (p.linkage_bow + SKEW * p.linkage_skew * (1.0 - 2.0 * share))
    slope -= 8.0 * share * (1.0 - share) * SKEW * p.linkage_skew
    return 1.0 + slope / p.rated_travel


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


@compiled
def sensor_drift(p, time):
    """Return how far the zero has crept. [m]"""
    if p.sensor_drift_rate == 0.0:
        return 0.0
    return -p.sensor_drift_rate * p.sensor_drift_time * math.expm1(-time / p.sensor_drift_time)


@compiled
def reads_plainly(p):
    """Return whether the reading is the position of the linkage."""
    return (
        p.sensor_time_constant == 0.0
        and p.linkage_bow == 0.0
        and p.linkage_skew == 0.0
        and p.sensor_drift_rate == 0.0
        and p.resolution == 0.0
    )


@inlined
def read_sensor(p, state, time):
    """Return the reading at an instant. [m]"""
    reading = state.lagged_reading if p.sensor_time_constant > 0.0 else bow(p, state.linkage)
    reading += sensor_drift(p, time)
    if p.resolution > 0.0:
        steps = math.floor((reading - p.resolution_offset) / p.resolution + 0.5)
        reading = p.resolution_offset + p.resolution * steps
    return reading


@compiled
def rest_sensor(p, state):
    """Put the sensor at rest on the stem, in the middle of its play."""
    state.linkage = state.position
    state.lagged_reading = bow(p, state.linkage)
