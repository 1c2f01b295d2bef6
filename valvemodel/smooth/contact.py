"""Stops that give way, smooth: a spring from a position on, its kink rounded.

A part's motion is laid in the coordinate in which the spring stays as stiff as it is off the stops, so that one that
meets a stop goes as far into it as the stop lets it.
"""

from __future__ import annotations

from typing import Any

import casadi as ca

from valvemodel.smooth.rounding import Expression, gate, ramp

LEAST_COMPLIANCE = 1e-12
"""A stop does not give way by less. [m/N]"""


def compliance_of(p: Any) -> Expression:
    """Return the yield of a stop over force, not quite 0. [m/N]"""
    return ca.fmax(p.stop_compliance, LEAST_COMPLIANCE)


def depths(p: Any, position: Expression) -> list[tuple[float, Expression]]:
    """Return for each stop its side, and how far the stem is beyond it. [m]"""
    return [
        *((1.0, position - getattr(p, name)) for name in p.upper_stops),
        *((-1.0, getattr(p, name) - position) for name in p.lower_stops),
    ]


def contact_force(p: Any, position: Expression) -> Expression:
    """Return the force of the stops, counted downwards. [N]"""
    if not p.yields:
        return 0.0
    compliance = compliance_of(p)
    width = p.smoothing_width * compliance
    return sum(side * rounded(depth, width) for side, depth in depths(p, position)) / compliance


def settle_contact(p: Any, x: Any, push: Expression, rising: Expression, falling: Expression) -> None:
    """Let a stem that presses on a stop go into it, or out of it, until friction holds it.

    Parameters
    ----------
    push : Expression
        The force on the stem without that of the stops, upwards. [N]
    rising, falling : Expression
        Friction of a stem that moves to either side. [N]
    """
    if not p.yields:
        return
    stiffness = 1.0 / compliance_of(p) + p.spring_rate
    width = p.smoothing_width * compliance_of(p)
    for side, depth in depths(p, x.position):
        at_stop = side * push + p.spring_rate * depth
        into, out = (rising, falling) if side > 0.0 else (falling, rising)
        shallowest, deepest = (at_stop - into) / stiffness, (at_stop + out) / stiffness
        settled = depth + ramp(shallowest - depth, width) - ramp(depth - deepest, width)
        presses = gate(depth, width)
        x.position += side * presses * (ramp(settled, width) - depth)
        x.velocity *= 1.0 - presses


def take_along(p: Any, x: Any, way: Expression) -> None:
    """Take the stem along a way that was found at the stiffness off the stops."""
    position = x.position
    if p.yields:
        excess = 1.0 / (compliance_of(p) * p.spring_rate)
        width = p.smoothing_width * compliance_of(p)
        stretched = [side * excess * rounded(depth, width) for side, depth in depths(p, position)]
        position += sum(stretched)
        for side, depth in depths(p, position + way):
            way -= side * (depth - pushed_back(depth, excess, width))
    x.position = position + way


def rounded(depth: Expression, width: Expression) -> Expression:
    """Return max(depth, 0), rounded so that what adds a multiple of it has an inverse in closed form."""
    return 0.5 * (depth + ca.sqrt(depth * depth + width * width))


def pushed_back(depth: Expression, excess: Expression, width: Expression) -> Expression:
    """Return the u whose u + excess rounded(u) is a depth: the lower root of a quadratic equation."""
    root = ca.sqrt(depth * depth + (1.0 + excess) * width * width)
    return (depth * (1.0 + 0.5 * excess) - 0.5 * excess * root) / (1.0 + excess)
