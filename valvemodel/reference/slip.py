"""A slip under a constant force in closed form: m y'' + c y' + k y = F."""

from __future__ import annotations

import cmath
from collections.abc import Callable, Sequence
from math import atan2, exp, expm1, inf, pi, sqrt

Motion = Callable[[float], Sequence[float]]
"""Position [m], velocity [m/s] and what else moves, after a duration [s]."""


def slip(*, mass: float, damping: float, stiffness: float, force: float, position: float, velocity: float) -> Motion:
    """Return the motion from a position and a velocity.

    About its equilibrium the stem moves as exp(-alpha t) times cosh and sinh of beta t, beta^2 = alpha^2 - omega^2;
    where it rings beta is imaginary, and they are cos and sin.
    """
    if stiffness == 0.0:
        return springless_slip(mass, damping, force, position, velocity)
    alpha, omega_squared = 0.5 * damping / mass, stiffness / mass
    beta = cmath.sqrt(alpha**2 - omega_squared)
    equilibrium = force / stiffness
    away = position - equilibrium

    def motion(duration: float) -> tuple[float, float]:
        decay = exp(-alpha * duration)
        cosh = decay * cmath.cosh(beta * duration).real
        sinh = decay * (cmath.sinh(beta * duration) / beta).real if beta else decay * duration
        return (
            equilibrium + away * cosh + (velocity + alpha * away) * sinh,
            velocity * cosh - (omega_squared * away + alpha * velocity) * sinh,
        )

    return motion


def springless_slip(mass: float, damping: float, force: float, position: float, velocity: float) -> Motion:
    """Return the motion without a spring: towards the speed F/c, or at the acceleration F/m without damping."""
    if damping == 0.0:
        rate = force / mass
        return lambda t: (position + velocity * t + 0.5 * rate * t**2, velocity + rate * t)
    final, decay_time = force / damping, mass / damping
    excess = velocity - final
    return lambda t: (
        position + final * t - excess * decay_time * expm1(-t / decay_time),
        final + excess * exp(-t / decay_time),
    )


def first_stop(*, mass: float, damping: float, stiffness: float, speed: float, acceleration: float) -> float:
    """Return when a speed of at least 0 falls to 0, infinity where it does not. [s]

    tan(beta t) = beta v / -(alpha v + a) where the stem rings; tanh where it does not.
    """
    alpha = 0.5 * damping / mass
    beta_squared = alpha**2 - stiffness / mass
    falling = -(alpha * speed + acceleration)
    if beta_squared < 0.0:
        beta = sqrt(-beta_squared)
        return (atan2(beta * speed, falling) if speed > 0.0 else pi) / beta
    beta = sqrt(beta_squared)
    if speed == 0.0 or falling <= beta * speed:
        return inf
    return cmath.atanh(beta * speed / falling).real / beta if beta else speed / falling
