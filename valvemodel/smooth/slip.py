"""A slip under a held force in closed form, differentiable in its parameters on both sides of critical damping."""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca

from valvemodel.smooth.rounding import Expression, passed

NEAR_CRITICAL = 1e-2
"""Below this square of beta and duration the hyperbolic or circular functions are summed as a series."""

SHORT = 1e-6
"""Below this square of both rates and duration the way is summed as a series: it would cancel."""

LEAST_RATE = 1e-9
"""Keeps roots and quotients of the branch that is not taken finite. [1/s], [1/s^2]"""

NEVER = 1e9
"""A slip that does not stop stops then. [s]"""


class Transition(NamedTuple):
    """Velocity and way after a duration: by velocity, and by net force at the start."""

    velocity_by_velocity: Expression
    velocity_by_force: Expression
    way_by_velocity: Expression
    way_by_force: Expression


def transition(mass: Expression, damping: Expression, stiffness: Expression, duration: Expression) -> Transition:
    """Return the exact map of m v' = F - c v - k w, w' = v from w = 0, for c >= 0, k >= 0.

    References
    ----------
    Paper eq. (6) in slip; the same closed form as `valvemodel.stages.slip.transition`.
    """
    alpha = 0.5 * damping / mass
    discriminant = alpha * alpha - stiffness / mass
    square = discriminant * duration * duration
    is_near, is_over = ca.fabs(square) < NEAR_CRITICAL, discriminant > 0.0

    beta = ca.sqrt(ca.if_else(is_over, discriminant, 1.0))
    fast = alpha + beta
    slow = stiffness / mass / ca.fmax(fast, LEAST_RATE)
    slow_left, fast_left = ca.exp(-slow * duration), ca.exp(-fast * duration)
    over_cosine, over_sine = 0.5 * (slow_left + fast_left), 0.5 * (slow_left - fast_left) / beta
    over_way = 0.5 * duration * (passed(slow * duration) - passed(fast * duration)) / (beta * mass)

    decay = ca.exp(-alpha * duration)
    swing = ca.sqrt(ca.if_else(is_over, 1.0, ca.fmax(-discriminant, LEAST_RATE)))
    under_cosine, under_sine = decay * ca.cos(swing * duration), decay * ca.sin(swing * duration) / swing

    near_square = ca.if_else(is_near, square, 0.0)
    near_cosine = decay * (1.0 + near_square / 2.0 * (1.0 + near_square / 12.0 * (1.0 + near_square / 30.0)))
    near_sine = decay * duration * (1.0 + near_square / 6.0 * (1.0 + near_square / 20.0 * (1.0 + near_square / 42.0)))

    cosine = ca.if_else(is_near, near_cosine, ca.if_else(is_over, over_cosine, under_cosine))
    sine = ca.if_else(is_near, near_sine, ca.if_else(is_over, over_sine, under_sine))
    omega_squared = stiffness / mass
    is_short = (omega_squared + alpha * alpha) * duration * duration < SHORT
    curvature = (4.0 * alpha * alpha - omega_squared) * duration * duration / 12.0
    near_way = ca.if_else(
        is_short,
        duration * duration / (2.0 * mass) * (1.0 - 2.0 * alpha * duration / 3.0 + curvature),
        (1.0 - cosine - alpha * sine) / ca.fmax(stiffness, LEAST_RATE),
    )
    way = ca.if_else(ca.logic_and(is_over, ca.logic_not(is_near)), over_way, near_way)
    return Transition(cosine - alpha * sine, sine / mass, sine, way)


def stop_time(
    mass: Expression, damping: Expression, stiffness: Expression, speed: Expression, net: Expression
) -> Expression:
    """Return when a speed that is not negative falls to 0 under a net force along it, or a very long time. [s]"""
    alpha = 0.5 * damping / mass
    acceleration = (net - damping * speed) / mass
    discriminant = alpha * alpha - stiffness / mass
    is_over = discriminant > 0.0
    beta = ca.sqrt(ca.if_else(is_over, ca.fmax(discriminant, LEAST_RATE), 1.0))
    falling = -((alpha + beta) * speed + acceleration)
    falls = falling > 0.0
    over = ca.log1p(2.0 * beta * speed / ca.if_else(falls, falling, 1.0)) / (2.0 * beta)
    swing = ca.sqrt(ca.if_else(is_over, 1.0, ca.fmax(-discriminant, LEAST_RATE)))
    is_at_rest = ca.logic_and(speed == 0.0, acceleration <= 0.0)
    under = ca.atan2(
        ca.if_else(is_at_rest, 0.0, swing * speed), ca.if_else(is_at_rest, 1.0, -alpha * speed - acceleration)
    )
    return ca.if_else(is_over, ca.if_else(falls, over, NEVER), under / swing)
