"""A slip under a held force in closed form: where it goes, when it stops, when it has ended.

A slip to one side is m a' = -c a - k v, with the speed v >= 0 and the acceleration a counted along its side.
"""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined

STOP_SPEED = 1e-6
"""Below this speed a slip has ended where the net force is within the breakaway force. [m/s]"""

BEYOND = 1.05
"""Longest step over the time to the stop of the linear part, the stiffest: two zeros of the speed are farther apart."""

SHORT = 0.25
"""Below this product of a rate and a duration the power series is summed: the closed forms would cancel."""

NEAR_CRITICAL = 0.03
"""Below this product of beta and duration the hyperbolic or circular functions are summed as a series."""

NEARLY = 0.01
"""Share of a level from which its logarithm leads to it; far below, a straight line does."""

CREEPING = 1e-8
"""Last step to the end of a creep, over its bracket: what it leaves is the square of it."""

ROUNDS = 80
"""Most iterations of a bracketed root; bisection alone needs 60."""


@compiled
def transition(mass, damping, stiffness, duration):
    """Return the exact map of (v, a) over a duration of m a' = -c a - k v, any sign of c and k.

    Six numbers: v from v and a, a from v and a, the way from v and a.
    """
    alpha = 0.5 * damping / mass
    omega_squared = stiffness / mass
    discriminant = alpha * alpha - omega_squared
    beta = math.sqrt(abs(discriminant))
    x = beta * duration
    if max(abs(alpha) * duration, x) < SHORT:
        return short_transition(alpha, omega_squared, duration)
    if discriminant > 0.0 and x >= NEAR_CRITICAL:
        return overdamped_transition(alpha, beta, omega_squared, duration)
    decay = math.exp(-alpha * duration)
    if x >= NEAR_CRITICAL:
        cosine = decay * math.cos(x)
        sine = decay * math.sin(x) / beta
    else:
        square = x * x if discriminant > 0.0 else -x * x
        cosine = decay * (1.0 + square / 2.0 * (1.0 + square / 12.0 * (1.0 + square / 30.0)))
        sine = decay * duration * (1.0 + square / 6.0 * (1.0 + square / 20.0 * (1.0 + square / 42.0)))
    way = (1.0 - cosine - alpha * sine) / omega_squared
    return (
        cosine + alpha * sine, sine, -omega_squared * sine, cosine - alpha * sine, sine + 2.0 * alpha * way, way,
    )  # fmt: skip


@compiled
def overdamped_transition(alpha, beta, omega_squared, duration):
    """Return `transition` from its two decay rates, the small one taken from their product. Holds for k = 0."""
    if alpha >= 0.0:
        fast = alpha + beta
        slow = omega_squared / fast
    else:
        slow = alpha - beta
        fast = omega_squared / slow
    slow_loss, fast_loss = loss(slow * duration), loss(fast * duration)
    slow_way = duration if slow == 0.0 else -slow_loss / slow
    fast_way = duration if fast == 0.0 else -fast_loss / fast
    width = 0.5 / beta
    sine = width * (slow_loss - fast_loss)
    way = width * (slow_way - fast_way)
    from_acceleration = width * (fast * (1.0 + fast_loss) - slow * (1.0 + slow_loss))
    from_speed = width * (fast * (1.0 + slow_loss) - slow * (1.0 + fast_loss))
    return from_speed, sine, -omega_squared * sine, from_acceleration, sine + 2.0 * alpha * way, way


@inlined
def loss(x):
    """Return exp(-x) - 1; for large x without `expm1`, which is three times as slow."""
    return math.expm1(-x) if abs(x) < SHORT else math.exp(-x) - 1.0


@compiled
def short_transition(alpha, omega_squared, duration):
    """Return `transition` as a power series in the duration."""
    before, term = 0.0, 1.0
    aa, va, ya = 1.0, duration, 0.5 * duration * duration
    for n in range(1, 30):
        # term is the n-th derivative of a at 0 times duration^n / n!
        following = -duration * (2.0 * alpha * term + omega_squared * before * duration / max(n - 1, 1)) / n
        before, term = term, following
        aa += term
        va += term * duration / (n + 1.0)
        ya += term * duration * duration / ((n + 1.0) * (n + 2.0))
        if abs(term) < 1e-18 and abs(before) < 1e-15:
            break
    return 1.0 - omega_squared * ya, va, -omega_squared * va, aa, va + 2.0 * alpha * ya, ya


@compiled
def first_stop(mass, damping, stiffness, speed, acceleration):
    """Return when a speed that is not negative first falls to 0, or infinity. [s]"""
    if speed < 0.0 or (speed == 0.0 and acceleration <= 0.0):
        return 0.0
    alpha = 0.5 * damping / mass
    discriminant = alpha * alpha - stiffness / mass
    if discriminant < 0.0:
        beta = math.sqrt(-discriminant)
        if speed == 0.0:
            return math.pi / beta
        return math.atan2(beta * speed, -(alpha * speed + acceleration)) / beta
    if speed == 0.0:
        return math.inf
    beta = math.sqrt(discriminant)
    falling = -((alpha + beta) * speed + acceleration)
    if falling <= 0.0:
        return math.inf
    if beta == 0.0:
        return speed / falling
    return math.log1p(2.0 * beta * speed / falling) / (2.0 * beta)


@inlined
def swing_out(alpha, beta, speed, acceleration, stop):
    """Return the way of a ringing slip to its stop, and the acceleration there; sine and cosine are known there."""
    sine, cosine = beta * speed, alpha * speed + acceleration
    at_stop = -math.exp(-alpha * stop) * math.sqrt(sine * sine + cosine * cosine)
    return (acceleration + 2.0 * alpha * speed - at_stop) / (alpha * alpha + beta * beta), at_stop


@compiled
def slip_end(mass, damping, stiffness, speed, acceleration, excess, stop_speed, high):
    """Return when a slip has ended by the stop-speed rule, known to have ended by the end of a bracket. [s]

    The later of two instants: the speed falls below the stop speed, and the net force below the breakaway force,
    which is `excess` (Coulomb less breakaway, not positive) plus viscous friction plus inertia.
    """
    jerk = -(damping * acceleration + stiffness * speed) / mass
    peak = first_stop(mass, damping, stiffness, acceleration, jerk) if acceleration > 0.0 else 0.0
    low = min(peak, high)
    slow = falling_instant(mass, damping, stiffness, speed, acceleration, 1.0, 0.0, stop_speed, low, high)
    return falling_instant(mass, damping, stiffness, speed, acceleration, damping, mass, -excess, slow, high)


@compiled
def falling_instant(mass, damping, stiffness, speed, acceleration, of_speed, of_acceleration, level, low, high):
    """Return when of_speed v + of_acceleration a falls to a level inside a bracket. [s]

    Bracketed Newton iteration on the logarithm of the closed form, which a creep makes a straight line, from the upper
    end on; the lower end where it is already below.
    """
    v, a = speed, acceleration
    if low > 0.0:
        v, a = motion_after(mass, damping, stiffness, speed, acceleration, low)
    if of_speed * v + of_acceleration * a <= level:
        return low
    instant, bound = high, high
    for _ in range(ROUNDS):
        v, a = motion_after(mass, damping, stiffness, speed, acceleration, instant)
        value = of_speed * v + of_acceleration * a
        if value > level:
            low = instant
        else:
            high = instant
        slope = of_speed * a - of_acceleration * (damping * a + stiffness * v) / mass
        excess = value * math.log(value / level) if value > NEARLY * level > 0.0 else value - level
        following = instant - excess / slope if slope < 0.0 else 0.5 * (low + high)
        if not low <= following <= high:
            following = 0.5 * (low + high)
        # The step after this one would gain as many digits again.
        is_met = abs(following - instant) <= CREEPING * bound or high - low <= CREEPING**2 * bound
        instant = following
        if is_met:
            break
    return instant


@inlined
def motion_after(mass, damping, stiffness, speed, acceleration, duration):
    """Return speed and acceleration of a slip after a duration."""
    vv, va, av, aa, _, _ = transition(mass, damping, stiffness, duration)
    return vv * speed + va * acceleration, av * speed + aa * acceleration


@compiled
def time_of_way(mass, damping, stiffness, speed, acceleration, distance, high, steady):
    """Return when a slip has gone a distance that it goes within a bracket; bracketed Newton iteration. [s]

    The speed is counted from a steady one, 0 but where the force on the slip is a ramp.
    """
    low, bound = 0.0, high
    instant = following = 0.5 * high
    for _ in range(ROUNDS):
        vv, va, _, _, yv, ya = transition(mass, damping, stiffness, instant)
        missing = distance - (steady * instant + yv * speed + ya * acceleration)
        if missing > 0.0:
            low = instant
        else:
            high = instant
        v = steady + vv * speed + va * acceleration
        following = instant + missing / v if v > 0.0 else 0.5 * (low + high)
        if not low < following < high:
            following = 0.5 * (low + high)
        if abs(following - instant) <= 1e-15 * bound or high - low <= 1e-15 * bound:
            break
        instant = following
    return following
