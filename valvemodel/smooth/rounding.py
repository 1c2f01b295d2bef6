"""Kinks rounded over a stated width: twice differentiable, and untouched beyond the width."""

from __future__ import annotations

from typing import Any

import casadi as ca

Expression = Any
"""A CasADi SX or MX, or a number."""


def ramp(x: Expression, width: Expression) -> Expression:
    """Return max(x, 0) with its kink rounded within a width on either side.

    A softplus of the same width would reach further: a stuck stem would creep under it for ever.
    """
    z = ca.fmin(ca.fmax(x / width, -1.0), 1.0)
    return width * (z + 1.0) ** 3 * (3.0 - z) / 16.0 + ca.fmax(x - width, 0.0)


def gate(x: Expression, width: Expression) -> Expression:
    """Return 0 below, 1 above zero, with the jump spread over a width on either side: the slope of `ramp`."""
    z = ca.fmin(ca.fmax(x / width, -1.0), 1.0)
    return (z + 1.0) ** 2 * (2.0 - z) / 4.0


def dead_zone(x: Expression, above: Expression, below: Expression, width: Expression) -> Expression:
    """Return by how much x is above a limit or, negative, below the negative of another."""
    return ramp(x - above, width) - ramp(-x - below, width)


def magnitude(x: Expression, width: Expression) -> Expression:
    """Return the absolute value of x, 0 at 0."""
    return ca.sqrt(x * x + width * width) - width


def passed(rate_by_time: Expression) -> Expression:
    """Return the mean of exp(-x t) over t in 0..1, smooth at x = 0."""
    is_small = ca.fabs(rate_by_time) < 1e-3
    x = ca.if_else(is_small, 1.0, rate_by_time)
    series = 1.0 - rate_by_time / 2.0 * (1.0 - rate_by_time / 3.0 * (1.0 - rate_by_time / 4.0))
    return ca.if_else(is_small, series, -ca.expm1(-x) / x)
