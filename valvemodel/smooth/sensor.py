"""Sensor, smooth: stem position to reading. A quantised reading has no smooth form: it is read unrounded."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import casadi as ca

from valvemodel.smooth.electromagnet import crept
from valvemodel.smooth.lags import SHORTEST_TIME, in_series, longer_and_shorter
from valvemodel.smooth.rounding import Expression, dead_zone, passed
from valvemodel.stages.bow import BY_ROD, BY_SLOT, DEAD_POINT, SKEW

BOW_STEPS = 4
"""Newton's steps from a reading to the position that a bowed linkage indicates so."""


def states_of(effects: Collection[str], *, filters: bool, wears: bool) -> tuple[str, ...]:
    """Return the names of the states that the effects need; one more where the reading is filtered, or a joint worn."""
    play = (("tight_linkage", "loose_linkage") if wears else ("linkage",)) if "linkage_backlash" in effects else ()
    lags = ("lagged_reading", "less_lagged_reading")[: 1 + filters] if "sensor_lag" in effects else ()
    return play + lags


def bow(p: Any, position: Expression) -> Expression:
    """Return the indicated for a true position; the identity for a straight linkage. [m]"""
    if "linkage_nonlinearity" not in p.effects:
        return position
    share = position / p.rated_travel
    if p.turns:
        low, here, high = (arm_angle(p, each) for each in (0.0, share, 1.0))
        return p.rated_travel * (here - low) / (high - low)
    return position + 4.0 * share * (1.0 - share) * (p.linkage_bow + SKEW * p.linkage_skew * (1.0 - 2.0 * share))


def bow_slope(p: Any, position: Expression) -> Expression:
    """Return how the indicated position changes with the true one."""
    share = position / p.rated_travel
    if p.turns:
        low, high = (arm_angle(p, each) for each in (0.0, 1.0))
        way = arm_way(p, share)
        inside = ca.fmin(ca.fmax(way, -DEAD_POINT), DEAD_POINT)
        slope = ca.if_else(p.linkage_skew < 0.0, 1.0 / (1.0 + way * way), 1.0 / ca.sqrt(1.0 - inside * inside))
        return lever(p) * slope / (high - low)
    bowed = (1.0 - 2.0 * share) * (p.linkage_bow + SKEW * p.linkage_skew * (1.0 - 2.0 * share))
    return 1.0 + 4.0 / p.rated_travel * (bowed - 2.0 * SKEW * p.linkage_skew * share * (1.0 - share))


def lever(p: Any) -> Expression:
    """Return the way of an arm through the whole travel over its length."""
    return ca.sqrt(ca.if_else(p.linkage_skew < 0.0, -BY_SLOT, BY_ROD) * p.linkage_skew / p.rated_travel)


def arm_way(p: Any, share: Expression) -> Expression:
    """Return the way over its length of an arm at a share of the travel, from where it stands square to the stem."""
    return lever(p) * (share - 0.5 - p.linkage_bow / (6.0 * SKEW * p.linkage_skew))


def arm_angle(p: Any, share: Expression) -> Expression:
    """Return the angle of an arm at a share of the travel, in a slot where the skew is negative, else on a rod."""
    way = arm_way(p, share)
    inside = ca.fmin(ca.fmax(way, -DEAD_POINT), DEAD_POINT)
    on_rod = ca.asin(inside) + (way - inside) / ca.sqrt(1.0 - inside * inside)
    return ca.if_else(p.linkage_skew < 0.0, ca.atan(way), on_rod)


def unbow(p: Any, reading: Expression) -> Expression:
    """Return the position that a bowed linkage indicates so. [m]"""
    if "linkage_nonlinearity" not in p.effects:
        return reading
    position = reading
    for _ in range(BOW_STEPS):
        position += (reading - bow(p, position)) / bow_slope(p, position)
    return position


def rest_sensor(p: Any, x: Any) -> None:
    """Put the sensor at rest on the stem, and the stem where in the play it starts."""
    if "sensor_lag" in p.effects:
        x.lagged_reading = bow(p, x.position)
    if p.filters:
        x.less_lagged_reading = x.lagged_reading
    if "linkage_backlash" in p.effects:
        for name, half_width in plays(p).items():
            setattr(x, name, x.position + p.backlash_start * (half_width - p.backlash_half_width))
        x.position -= p.backlash_start * p.backlash_half_width


def follow_stem(p: Any, x: Any, before: Expression, duration: Expression) -> None:
    """Follow the stem to where it is now, from the indicated position before; a lag takes the way as even."""
    if "linkage_backlash" in p.effects:
        for name, half_width in plays(p).items():
            linkage = getattr(x, name)
            pulled = dead_zone(x.position - linkage, half_width, half_width, p.smoothing_length)
            setattr(x, name, linkage + pulled)
    if "sensor_lag" in p.effects:
        after = bow(p, indicated(p, x))
        longer, shorter = time_constants(p)
        x.lagged_reading = lag_behind(x.lagged_reading, before, after, duration, longer)
        if p.filters:
            x.less_lagged_reading = lag_behind(x.less_lagged_reading, before, after, duration, shorter)


def plays(p: Any) -> dict[str, Expression]:
    """Return half the play between the stem and each part of the linkage, by the name of its state. [m]"""
    if not p.wears:
        return {"linkage": p.backlash_half_width}
    return {
        "tight_linkage": p.backlash_half_width * (1.0 - p.backlash_wear),
        "loose_linkage": p.backlash_half_width * (1.0 + p.backlash_wear),
    }


def lag_behind(
    reading: Expression, before: Expression, after: Expression, duration: Expression, time_constant: Expression
) -> Expression:
    """Return a lagged reading at the end of an even way. [m]"""
    rate = duration / ca.fmax(time_constant, SHORTEST_TIME)
    return after - (after - before) * passed(rate) - (before - reading) * ca.exp(-rate)


def time_constants(p: Any) -> tuple[Expression, Expression]:
    """Return the longer and the shorter time constant. [s]"""
    return longer_and_shorter(p.sensor_time_constant, p.sensor_second_time_constant, has_both=p.filters)


def indicated(p: Any, x: Any) -> Expression:
    """Return the position of the linkage: half way between the parts of a worn joint. [m]"""
    if "linkage_backlash" not in p.effects:
        return x.position
    return 0.5 * (x.tight_linkage + x.loose_linkage) if p.wears else x.linkage


def read_sensor(p: Any, x: Any, time: Expression) -> Expression:
    """Return the reading. [m]"""
    reading = lagged_reading(p, x) if "sensor_lag" in p.effects else bow(p, indicated(p, x))
    return reading + sensor_drift(p, time)


def lagged_reading(p: Any, x: Any) -> Expression:
    """Return what comes out of both lags in series. [m]"""
    if not p.filters:
        return x.lagged_reading
    longer, shorter = time_constants(p)
    return in_series(longer, shorter, x.lagged_reading, x.less_lagged_reading)


def sensor_drift(p: Any, time: Expression) -> Expression:
    """Return how far the zero has crept. [m]"""
    if "sensor_drift" not in p.effects:
        return 0.0
    return p.sensor_drift_rate * crept(time, p.sensor_drift_time, p.sensor_drift_creep)
