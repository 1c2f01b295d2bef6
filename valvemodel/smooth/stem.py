"""Stem, smooth: the exact step of a stem under a held pressure, its dead zone rounded.

A part of a period is a slip to its stop and, from there, a stay or a breakaway; each is one closed form in which the
friction is the force that would stop the stem at the end, held to the Coulomb friction by the rounded dead zone.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any

import casadi as ca

from valvemodel.equations.symbolic import driving_force
from valvemodel.smooth.contact import contact_force, settle_contact, take_along
from valvemodel.smooth.presliding import (
    SLIDER_STATES,
    advance_presliding,
    bend_sliders,
    elastic_friction,
    let_slide,
)
from valvemodel.smooth.rounding import Expression, dead_zone, gate, ramp
from valvemodel.smooth.slip import stop_time, transition
from valvemodel.stages.slip import STOP_SPEED

SHORTEST_SHARE = 1e-6
"""Neither slip nor stay is shorter than this share of a part, so that both have a derivative."""

SPEED_PER_WIDTH = 1e-5
"""The speed at which a slip has ended is rounded over this, times the smoothing width. [m/s/N]"""


VARIES_FRICTION = {"friction_drift", "position_dependent_friction", "pressure_dependent_friction"}
"""Effects by which friction falls so that it holds what it held no more."""

LEAST_SQUARE = 1e-12
"""What keeps the relative distance from a tight spot off 0, in square."""

LEAST_LEFT = 1e-12
"""What keeps the way to the end of a tight spot off 0, as a share."""

SMALL_SHARE = 1e-3
"""Below this share of the way to where a tight spot ends, a series stands in for the logarithm."""


def states_of(effects: Collection[str], *, slides: bool) -> tuple[str, ...]:
    """Return the names of the states that the effects need; sliders are left out where they carry nothing."""
    if "presliding" not in effects:
        return "position", "velocity"
    return ("position", "velocity", "bristle", *(SLIDER_STATES if slides else ()))


def put_stem(p: Any, x: Any, position: Expression, time: Expression) -> None:
    """Put the stem at rest at a position; bristles carry the thrust off the stops as far as they can."""
    x.position, x.velocity = position, 0.0
    if "presliding" in p.effects:
        limit = sliding_friction(p, 0.0, position, x.pressure, time)
        x.bristle = ca.fmin(ca.fmax(thrust_off_stops(p, position, x.pressure, time), -limit), limit)
        if p.slides:
            bend_sliders(p, x, x.bristle)
    stop_at_limits(p, x)


def advance_stem(p: Any, x: Any, pressure: Expression, time: Expression, duration: Expression) -> None:
    """Hold the pressure and move the stem through a part of a period; forces that vary are held at a time."""
    if "presliding" in p.effects:
        if p.slides and p.effects & VARIES_FRICTION:
            rising, falling = (sliding_friction(p, side, x.position, pressure, time) for side in (1.0, -1.0))
            let_slide(p, x, rising, falling)
        net = thrust(p, x.position, pressure, time)
        side = ca.sign(net - elastic_friction(p, x))
        limit = sliding_friction(p, side, x.position, pressure, time)
        motion = transition(p.stem_mass, damping(p, side), stiffness(p, side, x.position, pressure, time), duration)
        advance_presliding(p, x, net, limit, motion, duration)
    else:
        if p.contacts:
            push = thrust_off_stops(p, x.position, pressure, time)
            rising, falling = (sliding_friction(p, side, x.position, pressure, time) for side in (1.0, -1.0))
            settle_contact(p, x, push, rising, falling)
        slips = time_in_slip(p, x, pressure, time, duration)
        move(p, x, pressure, time, slips, ca.sign(x.velocity), breaks_away=False)
        resting_side = ca.sign(thrust(p, x.position, pressure, time))
        move(p, x, pressure, time, duration - slips, resting_side, breaks_away=True)
    stop_at_limits(p, x)


def time_in_slip(p: Any, x: Any, pressure: Expression, time: Expression, duration: Expression) -> Expression:
    """Return for how long the stem goes on slipping before it stops. [s]"""
    side, speed = ca.sign(x.velocity), ca.fabs(x.velocity)
    net = side * thrust(p, x.position, pressure, time) - friction(p, x, side, speed, pressure, time)
    slope = stiffness(p, side, x.position, pressure, time)
    slips = ca.fmin(stop_time(p.stem_mass, damping(p, side), slope, speed, net), duration)
    if "static_friction" in p.effects:
        stop_speed = p.stick_speed + SPEED_PER_WIDTH * p.smoothing_width
        jump = (p.static_friction_ratio - 1.0) * p.coulomb_friction
        # A creep counts as a stay only where a stay is held by more than a slip.
        matters = jump / (jump + p.smoothing_width)
        slips *= 1.0 - matters * (1.0 - gate(speed - stop_speed, stop_speed))
    return ca.fmin(ca.fmax(slips, SHORTEST_SHARE * duration), (1.0 - SHORTEST_SHARE) * duration)


def move(
    p: Any, x: Any, pressure: Expression, time: Expression, duration: Expression, side: Expression, *, breaks_away: bool
) -> None:
    """Move the stem through a duration in which it does not reverse."""
    slope = stiffness(p, side, x.position, pressure, time)
    motion = transition(p.stem_mass, damping(p, side), slope, duration)
    net = thrust(p, x.position, pressure, time)
    stopping = motion.velocity_by_velocity * x.velocity / motion.velocity_by_force + net
    rising, falling = (sliding_friction(p, each, x.position, pressure, time) for each in (1.0, -1.0))
    excess = dead_zone(stopping, rising, falling, p.smoothing_width)
    if "stribeck" in p.effects:
        factor = weakened(p, motion.velocity_by_force * excess)
        excess = dead_zone(stopping, rising * factor, falling * factor, p.smoothing_width)
    if breaks_away and "static_friction" in p.effects:
        ratio = p.static_friction_ratio
        armed = dead_zone(stopping, ratio * rising, ratio * falling, p.smoothing_width)
        # Full once beyond the breakaway force by the width; the same as `excess` where F_s is F_c.
        jump = (ratio - 1.0) * 0.5 * (rising + falling)
        opened = ca.fabs(armed) * (1.0 + jump / p.smoothing_width)
        excess = ca.sign(excess) * ca.fmin(ca.fabs(excess), opened)
    way = motion.way_by_velocity * x.velocity + motion.way_by_force * (net - stopping + excess)
    take_along(p, x, way)
    x.velocity = motion.velocity_by_force * excess


def friction(p: Any, x: Any, side: Expression, speed: Expression, pressure: Expression, time: Expression) -> Expression:
    """Return the friction of a stem that slips to a side at a speed, all but its viscous part. [N]"""
    level = sliding_friction(p, side, x.position, pressure, time)
    return level * weakened(p, speed) if "stribeck" in p.effects else level


def weakened(p: Any, velocity: Expression) -> Expression:
    """Return the friction at a velocity over Coulomb's."""
    relative = (ca.sqrt(velocity * velocity + STOP_SPEED * STOP_SPEED) / p.stribeck_velocity) ** p.stribeck_shape
    share = (1.0 - p.stribeck_tail) * ca.exp(-relative) + p.stribeck_tail / (1.0 + relative)
    return 1.0 + (p.stribeck_ratio - 1.0) * share


def thrust(p: Any, position: Expression, pressure: Expression, time: Expression) -> Expression:
    """Return the force that drives the stem, all but friction. [N]"""
    return thrust_off_stops(p, position, pressure, time) - contact_force(p, position)


def thrust_off_stops(p: Any, position: Expression, pressure: Expression, time: Expression) -> Expression:
    """Return that force without the one of stops that give way. [N]"""
    force = driving_force(pressure, position, p.diaphragm_area, p.spring_rate, p.spring_preload)
    if "area_variation" in p.effects:
        force += p.diaphragm_area * pressure * position * (p.area_slope + p.area_curvature * position)
    if "spring_hardening" in p.effects:
        force -= p.spring_rate * (p.spring_progression + p.spring_hardening * position) * position**2
    if "load_force" in p.effects:
        angle = 2.0 * math.pi * time / p.load_period
        force += p.load_sine * ca.sin(angle) + p.load_cosine * ca.cos(angle)
        for wave in range(2, p.waves + 1):
            sine, cosine = getattr(p, f"load_sine_{wave}"), getattr(p, f"load_cosine_{wave}")
            force += sine * ca.sin(wave * angle) + cosine * ca.cos(wave * angle)
    return force


def stiffness(p: Any, side: Expression, position: Expression, pressure: Expression, time: Expression) -> Expression:
    """Return by how much the net force falls with the position. [N/m]"""
    slope = p.spring_rate
    if "spring_hardening" in p.effects:
        slope += p.spring_rate * (2.0 * p.spring_progression + 3.0 * p.spring_hardening * position) * position
    if "area_variation" in p.effects:
        slope -= p.diaphragm_area * pressure * (p.area_slope + 2.0 * p.area_curvature * position)
    if "position_dependent_friction" in p.effects:
        distance = (position - p.tight_spot_position) / p.tight_spot_width
        bump = tight_spot_bump(p, distance)
        level = sliding_friction(p, side, position, pressure, time)
        steepness = p.tight_spot_exponent * distance * squared(distance) ** (0.5 * p.tight_spot_exponent - 1.0)
        steepness /= 1.0 - closeness(p, tight_spot_power(p, distance))
        slope = ca.fmax(slope - steepness / p.tight_spot_width * side * level * bump / (1.0 + bump), 0.0)
    return slope


def tight_spot_bump(p: Any, distance: Expression) -> Expression:
    """Return the excess friction at a distance from the middle of a tight spot, in half-widths."""
    power = tight_spot_power(p, distance)
    share = closeness(p, power)
    is_small = ca.fabs(share) < SMALL_SHARE
    away = ca.if_else(is_small, 0.5, share)
    longer = ca.if_else(
        is_small, 1.0 + share * (1.0 / 2.0 + share * (1.0 / 3.0 + share / 4.0)), -ca.log1p(-away) / away
    )
    return p.tight_spot_excess * ca.exp(-power * longer)


def tight_spot_power(p: Any, distance: Expression) -> Expression:
    """Return the power of a distance from the middle of a tight spot, in half-widths, with which its excess falls."""
    return squared(distance) ** (0.5 * p.tight_spot_exponent)


def closeness(p: Any, power: Expression) -> Expression:
    """Return that power over the one at which a tight spot ends, kept below 1; below 0 where it has tails."""
    return ca.fmin(p.tight_spot_closure * power, 1.0 - LEAST_LEFT)


def squared(distance: Expression) -> Expression:
    """Return the square of a distance, kept from 0, where a power of it has no slope in its exponent."""
    return distance * distance + LEAST_SQUARE


def damping(p: Any, side: Expression) -> Expression:
    """Return the viscous friction to a side. [N s/m]"""
    if "asymmetric_viscous_friction" not in p.effects:
        return p.viscous_friction
    return p.viscous_friction * (1.0 + p.viscous_asymmetry * side)


def sliding_friction(
    p: Any, side: Expression, position: Expression, pressure: Expression, time: Expression
) -> Expression:
    """Return the Coulomb friction of a stem that moves to a side. [N]"""
    level = p.coulomb_friction
    if "asymmetric_friction" in p.effects:
        level *= 1.0 + p.friction_asymmetry * side
    if "position_dependent_friction" in p.effects:
        distance = (position - p.tight_spot_position) / p.tight_spot_width
        level *= 1.0 + tight_spot_bump(p, distance)
    if "pressure_dependent_friction" in p.effects:
        positive = ca.fmax(pressure, 1e-9 * p.supply_pressure)
        share = (positive / p.supply_pressure) ** (p.friction_pressure_order - 1.0)
        level = ca.fmax(level + p.friction_area * positive * share, 0.0)
    if "friction_drift" in p.effects:
        grown = -p.friction_drift_rate * p.friction_drift_time * ca.expm1(-time / p.friction_drift_time)
        level *= ca.fmax(1.0 + grown, 0.0)
    return level


def stop_at_limits(p: Any, x: Any) -> None:
    """Hold the stem within its travel, the stops rounded over the length that the spring gives to the width."""
    for name in p.highest:
        room = getattr(p, name) - x.position
        x.position = getattr(p, name) - ramp(room, p.smoothing_length)
        x.velocity *= gate(room, p.smoothing_length)
    for name in p.lowest:
        room = x.position - getattr(p, name)
        x.position = getattr(p, name) + ramp(room, p.smoothing_length)
        x.velocity *= gate(room, p.smoothing_length)
