"""Stops that give way, smooth: a spring from a position on, its kink rounded.

A part's motion is laid in the coordinate in which the spring stays as stiff as it is off the stops, so that one that
meets a stop goes as far into it as the stop lets it.
"""

from __future__ import annotations

from typing import Any

import casadi as ca

from valvemodel.smooth.rounding import Expression, gate, ramp

CONTACTS = ((1.0, "upper_stop"), (-1.0, "lower_stop"))
"""The side of each stop, and the parameter that says where it is."""

LEAST_COMPLIANCE = 1e-12
"""A stop does not give way by less. [m/N]"""


def compliance_of(p: Any) -> Expression:
    """Return the yield of a stop over force, not quite 0. [m/N]"""
    return ca.fmax(p.stop_compliance, LEAST_COMPLIANCE)


def contact_width(p: Any) -> Expression:
    """Return the depth over which a contact is rounded: that to which the smoothing width presses. [m]"""
    return p.smoothing_width * compliance_of(p)


def depths(p: Any, position: Expression) -> list[tuple[float, Expression]]:
    """Return for each stop that gives way its side, and how far the stem is beyond it. [m]"""
    return [(side, side * (position - getattr(p, name))) for side, name in p.contacts]


def contact_force(p: Any, position: Expression) -> Expression:
    """Return the force of the stops that give way, counted downwards. [N]"""
    return sum(side * rounded(depth, contact_width(p)) / compliance_of(p) for side, depth in depths(p, position))


def settle_contact(p: Any, x: Any, push: Expression, rising: Expression, falling: Expression) -> None:
    """Let a stem that presses on a stop go into it, or out of it, until friction holds it.

    Parameters
    ----------
    push : Expression
        The force on the stem without that of the stops, upwards. [N]
    rising, falling : Expression
        Friction of a stem that moves to either side. [N]
    """
    for side, depth in depths(p, x.position):
        stiffness, width = 1.0 / compliance_of(p) + p.spring_rate, contact_width(p)
        at_stop = side * push + p.spring_rate * depth
        into, out = (rising, falling) if side > 0.0 else (falling, rising)
        shallowest, deepest = (at_stop - into) / stiffness, (at_stop + out) / stiffness
        settled = depth + ramp(shallowest - depth, width) - ramp(depth - deepest, width)
        presses = gate(depth, width)
        x.position += side * presses * (ramp(settled, width) - depth)
        x.velocity *= 1.0 - presses


def take_along(p: Any, x: Any, way: Expression) -> None:
    """Take the stem along a way that was found at the stiffness off the stops."""
    begun = depths(p, x.position)
    x.position += way
    for side, depth in begun:
        x.position += side * excess_of(p) * rounded(depth, contact_width(p))
    for side, depth in depths(p, x.position):
        x.position -= side * (depth - pushed_back(depth, excess_of(p), contact_width(p)))


def excess_of(p: Any) -> Expression:
    """Return the stiffness of a stop over the spring's."""
    return 1.0 / (compliance_of(p) * p.spring_rate)


def rounded(depth: Expression, width: Expression) -> Expression:
    """Return max(depth, 0), rounded so that what adds a multiple of it has an inverse in closed form."""
    return 0.5 * (depth + ca.sqrt(depth * depth + width * width))


def pushed_back(depth: Expression, excess: Expression, width: Expression) -> Expression:
    """Return the u whose u + excess rounded(u) is a depth: the lower root of a quadratic equation."""
    root = ca.sqrt(depth * depth + (1.0 + excess) * width * width)
    return (depth * (1.0 + 0.5 * excess) - 0.5 * excess * root) / (1.0 + excess)
