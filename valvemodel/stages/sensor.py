"""Sensor: stem position to reading, with the effects of linkage and transmitter."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined
from valvemodel.declarations import Effect, Parameter, choice_of_law
from valvemodel.stages.bow import bow
from valvemodel.stages.creep import creep_parameters, crept
from valvemodel.stages.linkage import drag_linkage, part_dragged, rest_linkage
from valvemodel.stages.transmitter import follow_linkage, has_lag, lagged_reading, settle_reading

EFFECTS = (
    Effect(
        key="linkage_backlash",
        stage="sensor",
        title="linkage backlash",
        meaning="play between stem and transmitter, which a worn joint takes up in two stages",
        equation=r"z = (z_- + z_+)/2,\quad z_\pm = \min(\max(z_\pm, y - b_\pm), y + b_\pm),\quad "
        r"b_\pm = b\,(1 \pm w)",
        source="play operator, Krasnosel'skii and Pokrovskii (1989); two side by side, the operator of Prandtl and "
        "Ishlinskii, Brokate and Sprekels (1996)",
        parameters=(
            Parameter("backlash_half_width", "m", "b: half the play", 0.0, 0.03, 0.0, (1e-3, 4e-3)),
            Parameter(
                "backlash_start",
                "1",
                "where in the play the linkage starts",
                -1.0,
                1.0,
                0.0,
                (0.0,),
                is_later=True,
                is_start=True,
            ),
            Parameter(
                "backlash_wear",
                "1",
                "w: part of b by which one stage is tighter, the other looser",
                0.0,
                1.0,
                0.0,
                (0.0, 0.4),
                is_later=True,
            ),
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
        equation=r"r = z + d\,T\,(1 - e^{-t/T})\quad\text{or}\quad r = z + d\,T\,\ln(1 + t/T)",
        source="a transmitter that warms up, first order; logarithmic creep: Phillips, Phil. Mag. 9 (1905)",
        parameters=(
            Parameter("sensor_drift_rate", "m/s", "creep of the zero at the start", -3e-3, 3e-3, 0.0, (1e-5, -1e-5)),
            *creep_parameters("sensor_drift"),
        ),
        aliases=("gap_drift", "load_force"),
        acts_in_time=True,
        told_apart_by="a measured pressure, or a mechanical stop that is visited early and late",
    ),
    Effect(
        key="sensor_lag",
        stage="sensor",
        title="sensor lag",
        meaning="the transmitter is slow, and so may be a filter that damps its reading",
        equation=r"T\,\dot q = z - q,\quad T_2\,\dot r = q - r",
        source="first-order transmitter, damping filter of first order in series",
        parameters=(
            Parameter("sensor_time_constant", "s", "T: time constant", 0.0, 3.0, 0.0, (0.1, 0.5), is_lag=True),
            Parameter(
                "sensor_second_time_constant",
                "s",
                "T_2: second lag in series, of a damping filter",
                0.0,
                3.0,
                0.0,
                (0.0, 0.1),
                is_later=True,
            ),
        ),
        aliases=("coil_lag", "chamber_filling", "transport_delay"),
        acts_in_time=True,
        told_apart_by="a measured pressure, or a faster sampling of one reversal: a slow reading rounds the corner",
    ),
    Effect(
        key="linkage_nonlinearity",
        stage="sensor",
        title="linkage nonlinearity",
        meaning="the rotary linkage reads a bow, and a skew, over the travel",
        equation=(
            r"r = z + 4\xi(1 - \xi)\,(h + \sqrt{27}/2\,s\,(1 - 2\xi)),\ \xi = z/L\quad\text{or}\quad "
            r"r = L\,(\theta(\xi) - \theta(0))/(\theta(1) - \theta(0)),\ \tan\theta\text{ or }\sin\theta = a\,(\xi - c)"
        ),
        source=(
            "lever geometry to third order, or whole: an arm whose slot (s < 0: tangent) or rod (s > 0: sine) follows "
            "the stem, a and c such that h and s are its third order"
        ),
        parameters=(
            Parameter("linkage_bow", "m", "h: bow in the middle of the travel", -0.15, 0.15, 0.0, (3e-3, -3e-3)),
            Parameter(
                "linkage_skew",
                "m",
                "s: swing between the halves of the travel",
                -0.06,
                0.02,
                0.0,
                (1e-3, -1e-3),
                typical=0.0,
            ),
            choice_of_law(
                "linkage_arm",
                "0: to third order; 1: a whole arm, turned in a slot where the skew is negative, else by a rod",
            ),
        ),
        aliases=("spring_hardening", "area_variation", "magnetic_saturation"),
        told_apart_by="a straight scale on the stem, or a measured pressure with a known spring",
    ),
)


@compiled
def follow_stem(p, state, memory, before, after, duration):
    """Follow a stem that moves one way from one position to another within a duration.

    The lag is exact behind a straight linkage; what a bow adds is a polynomial through the nodes of the step.
    """
    was = state.linkage
    drag_linkage(p, state)
    if has_lag(p) and duration > 0.0:
        part = part_dragged(p, abs(state.linkage - was), abs(after - before))
        follow_linkage(p, state, memory, was, part, duration)


@compiled
def sensor_drift(p, time):
    """Return how far the zero has crept. [m]"""
    if p.sensor_drift_rate == 0.0:
        return 0.0
    return p.sensor_drift_rate * crept(time, p.sensor_drift_time, p.sensor_drift_creep)


@compiled
def reads_plainly(p):
    """Return whether the reading is the position of the linkage."""
    return (
        not has_lag(p)
        and p.linkage_bow == 0.0
        and p.linkage_skew == 0.0
        and p.sensor_drift_rate == 0.0
        and p.resolution == 0.0
    )


@inlined
def read_sensor(p, state, time):
    """Return the reading at an instant. [m]"""
    reading = lagged_reading(p, state) if has_lag(p) else bow(p, state.linkage)
    reading += sensor_drift(p, time)
    if p.resolution > 0.0:
        steps = math.floor((reading - p.resolution_offset) / p.resolution + 0.5)
        reading = p.resolution_offset + p.resolution * steps
    return reading


@compiled
def rest_sensor(p, state):
    """Put the sensor at rest on the stem, in the middle of its play."""
    rest_linkage(p, state, state.position)
    settle_reading(p, state)
