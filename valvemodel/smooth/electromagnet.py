"""Electromagnet, smooth: current to gap; the same closed forms as the exact stage, over a whole part of a period."""

from __future__ import annotations

from collections.abc import Collection
from itertools import pairwise
from typing import Any

import casadi as ca

from valvemodel.equations.symbolic import coil_gap
from valvemodel.smooth.lags import SHORTEST_TIME, in_series, longer_and_shorter
from valvemodel.smooth.rounding import Expression, dead_zone, magnitude, passed
from valvemodel.stages.plays import LEAST_EVENNESS, PLAYS, SHARES

LEAST_CURRENT = 1e-9
"""Keeps the slope of the root, and the loop's quotients at half-width 0, finite. [A]"""

CORNER = 1e-2
"""The loop's corner is rounded by this share of the smoothing share: a wider one would forget slow changes."""

STRAIGHT = 1e-6
"""Least steepness of the curve behind the middle of the loop, for its quotients."""

PLAY_STATES = tuple(f"play_{index}" for index in range(PLAYS))


def states_of(effects: Collection[str], *, has_eddies: bool, remembers: bool) -> tuple[str, ...]:
    """Return the names of the states that the effects need; plays only where the hysteresis remembers by them."""
    lag = ("flux_current", "less_lagged_flux")[: 1 + has_eddies] if "coil_lag" in effects else ()
    plays = PLAY_STATES if remembers else ()
    return lag + (("hysteresis_input", "hysteresis", *plays) if "magnetic_hysteresis" in effects else ())


def rest_electromagnet(p: Any, x: Any, current: Expression) -> Expression:
    """Put the stage at rest under a current, where it starts in its loop; return what the flux stands for. [A]"""
    magnetising = effective = saturate(p, current) if "magnetic_saturation" in p.effects else current
    if "magnetic_hysteresis" in p.effects:
        x.hysteresis_input, x.hysteresis = magnetising, p.hysteresis_start
        effective = magnetising - p.hysteresis_half_width * p.hysteresis_start
    if "coil_lag" in p.effects:
        x.flux_current = effective if p.lags_behind_core else current
        if p.has_eddies:
            x.less_lagged_flux = x.flux_current
    for name, room in zip(PLAY_STATES, rooms_of_plays(p), strict=True) if p.remembers else ():
        setattr(x, name, magnetising - p.hysteresis_start * room)
    return effective


def advance_flux(p: Any, x: Any, current: Expression, duration: Expression) -> Expression:
    """Hold the current for a duration and return the mean current that the flux stands for. [A]"""
    if p.lags_behind_core:
        return lag(p, x, pass_core(p, x, current), duration)
    return pass_core(p, x, lag(p, x, current, duration))


def lag(p: Any, x: Any, current: Expression, duration: Expression) -> Expression:
    """Let the flux lag a held current for a duration and return its mean. [A]"""
    if "coil_lag" in p.effects:
        longer, shorter = longer_and_shorter(p.coil_time_constant, p.eddy_time_constant, has_both=p.has_eddies)
        x.flux_current, flux = lag_behind(x.flux_current, current, duration, longer)
        if p.has_eddies:
            x.less_lagged_flux, less_lagged = lag_behind(x.less_lagged_flux, current, duration, shorter)
            flux = in_series(longer, shorter, flux, less_lagged)
        current = flux
    return current


def pass_core(p: Any, x: Any, current: Expression) -> Expression:
    """Return what the core makes of a current. [A]"""
    if "magnetic_saturation" in p.effects:
        current = saturate(p, current)
    if "magnetic_hysteresis" in p.effects:
        current = magnetise(p, x, current)
    return current


def lag_behind(
    flux: Expression, current: Expression, duration: Expression, time_constant: Expression
) -> tuple[Expression, Expression]:
    """Return a flux that lags a held current, at the end of a duration and in the mean of it. [A]"""
    rate = duration / ca.fmax(time_constant, SHORTEST_TIME)
    departure = flux - current
    return current + departure * ca.exp(-rate), current + departure * passed(rate)


def saturate(p: Any, current: Expression) -> Expression:
    """Bend the current above the knee. [A]"""
    lost = lost_above_knee(p, current - p.saturation_knee) - lost_above_knee(p, -p.saturation_knee)
    return current - (1.0 - p.saturation_slope) * lost


def lost_above_knee(p: Any, above: Expression) -> Expression:
    """Return how much of the current the core would lose with no slope above its knee. [A]"""
    width = p.saturation_rounding
    ramp = 0.5 * (above + ca.sqrt(above * above + width * width))
    if p.saturates_as_tanh:
        reach = ca.fmax(p.saturation_reach, LEAST_CURRENT)
        return ramp - reach * ca.tanh(ramp / reach)
    return ramp * (ramp / (ramp + p.saturation_reach))


def magnetise(p: Any, x: Any, current: Expression) -> Expression:
    """Follow the hysteresis loop to a current and return the current that the flux stands for. [A]"""
    width = ca.fmax(p.hysteresis_half_width, LEAST_CURRENT)
    change = (current - x.hysteresis_input) / (2.0 * width * (1.0 - p.bouc_wen_gamma) * (1.0 + p.hysteresis_roundness))
    corner = CORNER * p.smoothing_share
    way, side = magnitude(change, corner), ca.tanh(change / corner)
    place, steepness = side * x.hysteresis, 1.0 - 2.0 * p.bouc_wen_gamma
    steepness = ca.if_else(ca.fabs(steepness) < STRAIGHT, STRAIGHT, steepness)
    back = ca.fmin(way, ca.log1p(steepness * ca.fmax(-place, 0.0)) / steepness)
    behind = ca.fmin(place, 0.0) * ca.exp(-steepness * back) - ca.expm1(-steepness * back) / steepness
    before = ca.fmax(place, 0.0)
    # Across the side's rounded corner the place stays what it was.
    x.hysteresis += side * (behind + before - place - (1.0 - before) * ca.expm1(back - way))
    x.hysteresis_input = current
    behind = p.hysteresis_half_width * x.hysteresis
    if p.remembers:
        behind += p.return_point_memory * (pull_plays(p, x, current) - behind)
    return current - behind


def pull_plays(p: Any, x: Any, current: Expression) -> Expression:
    """Let the plays follow a current and return how far the flux is behind it by them. [A]"""
    total = 0.0
    for name, room in zip(PLAY_STATES, rooms_of_plays(p), strict=True):
        play = getattr(x, name)
        play += dead_zone(current - play, room, room, scale_of_plays(p) * p.smoothing_share)
        setattr(x, name, play)
        total += current - play
    return total / (PLAYS * (1.0 + p.hysteresis_roundness))


def scale_of_plays(p: Any) -> Expression:
    """Return the mean room of the plays either way. [A]"""
    return ca.fmax(p.hysteresis_half_width, LEAST_CURRENT) * (1.0 + p.hysteresis_roundness)


def rooms_of_plays(p: Any) -> list[Expression]:
    """Return the mean rooms either way of equal shares of the plays, least first. [A]"""
    uneven = 1.0 - LEAST_EVENNESS - (1.0 - 2.0 * LEAST_EVENNESS) * p.play_evenness
    beyond = [(1.0 - share) - uneven * (1.0 - share) ** (1.0 / uneven) for share in SHARES]
    scale = scale_of_plays(p) * PLAYS / (beyond[0] - beyond[-1])
    return [scale * (least - most) for least, most in pairwise(beyond)]


def crept(time: Expression, time_constant: Expression, is_logarithmic: Expression) -> Expression:
    """Return how far a creep of unit rate at the start has come: to its time constant, or on as a logarithm. [s]"""
    share = time / time_constant
    return time_constant * ((is_logarithmic - 1.0) * ca.expm1(-share) + is_logarithmic * ca.log1p(share))


def gap_of_current(p: Any, current: Expression, time: Expression) -> Expression:
    """Return the gap at an effective current, drift included. [m]"""
    gap = coil_gap(ca.fmax(current, LEAST_CURRENT), p.gap_offset, p.gap_gain)
    if "gap_drift" in p.effects:
        gap += p.gap_drift_rate * crept(time, p.gap_drift_time, p.gap_drift_creep)
    return gap
