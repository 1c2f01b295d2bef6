"""Lags, smooth: time constants that may be none, and two lags in series."""

from __future__ import annotations

import casadi as ca

from valvemodel.smooth.rounding import Expression
from valvemodel.stages.lag import APART

SHORTEST_TIME = 1e-12
"""A time constant is not shorter, so that its neutral value 0 has a derivative. [s]"""


def longer_and_shorter(first: Expression, second: Expression, *, has_both: bool) -> tuple[Expression, Expression]:
    """Return the time constants of two lags in series, kept apart about their mean, or the first and none. [s]"""
    if not has_both:
        return first, 0.0
    mean = 0.5 * (first + second)
    half = 0.5 * ca.fmax(ca.fabs(first - second), APART * mean)
    return mean + half, mean - half


def in_series(longer: Expression, shorter: Expression, by_longer: Expression, by_shorter: Expression) -> Expression:
    """Return what comes out of both lags in series: by partial fractions, a sum of one and the other alone."""
    return by_longer + shorter / (longer - shorter) * (by_longer - by_shorter)
