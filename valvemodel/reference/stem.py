"""Stem: the forces on it."""

from __future__ import annotations

from math import cos, exp, expm1, pi, sin
from types import SimpleNamespace

STOP_SPEED = 1e-6
"""A slower slip has ended where friction holds the stem: an overdamped one would only ever creep. [m/s]"""

FARTHEST = 10.0
"""No stem goes farther. [m]"""


def thrust(n: SimpleNamespace, position: float, pressure: float, time: float) -> float:
    """Return what drives the stem: pressure times area, less the spring's force, and the load. [N]"""
    area = n.diaphragm_area * (1.0 + n.area_slope * position + n.area_curvature * position**2)
    stiffening = 1.0 + n.spring_progression * position + n.spring_hardening * position**2
    spring = n.spring_preload + n.spring_rate * position * stiffening
    return area * pressure - spring + load(n, time)


def load(n: SimpleNamespace, time: float) -> float:
    """Return the load as the sum of its waves. [N]"""
    angle = 2.0 * pi * time / n.load_period
    force = n.load_sine * sin(angle) + n.load_cosine * cos(angle)
    for wave in range(2, int(n.load_waves) + 1):
        sine, cosine = getattr(n, f"load_sine_{wave}"), getattr(n, f"load_cosine_{wave}")
        force += sine * sin(wave * angle) + cosine * cos(wave * angle)
    return force


def coulomb_friction(n: SimpleNamespace, side: float, position: float, pressure: float, time: float) -> float:
    """Return the friction of a stem that moves fast to a side, without its viscous part. [N]"""
    friction = n.coulomb_friction * (1.0 + n.friction_asymmetry * side)
    friction *= max(1.0 - n.friction_drift_rate * n.friction_drift_time * expm1(-time / n.friction_drift_time), 0.0)
    distance = abs(position - n.tight_spot_position) / n.tight_spot_width
    friction *= 1.0 + n.tight_spot_excess * exp(-(distance**n.tight_spot_exponent))
    inflated = max(pressure, 0.0)
    seal = n.friction_area * inflated * (inflated / n.supply_pressure) ** (n.friction_pressure_order - 1.0)
    return max(friction + seal, 0.0)


def breakaway_ratio(n: SimpleNamespace) -> float:
    """Return the force at which a stem breaks away over its Coulomb friction."""
    return max(n.static_friction_ratio, n.stribeck_ratio)


def viscous_friction(n: SimpleNamespace, side: float) -> float:
    """Return the viscous friction of a stem that moves to a side. [N s/m]"""
    return n.viscous_friction * (1.0 + n.viscous_asymmetry * side)


def highest_position(n: SimpleNamespace) -> float:
    """Return the upper end of the travel. [m]"""
    return min(n.travel_max, n.upper_stop, FARTHEST)


def lowest_position(n: SimpleNamespace) -> float:
    """Return the lower end of the travel. [m]"""
    return max(n.travel_min, n.lower_stop, -FARTHEST)


def rebound(n: SimpleNamespace, velocity: float) -> float:
    """Return the velocity after the stem hits an end of its travel; a rebound below the stop speed rests. [m/s]"""
    after = -n.restitution * velocity
    return after if abs(after) >= STOP_SPEED else 0.0


def balanced_position(n: SimpleNamespace, pressure: float) -> float:
    """Return where nothing drives the stem at the start, in the middle of its stuck band (Newton's method). [m]"""
    if n.spring_rate == 0.0:
        return 0.0
    position, reach = 0.0, 1e-6
    for _ in range(100):
        net = thrust(n, position, pressure, 0.0)
        slope = (net - thrust(n, position + reach, pressure, 0.0)) / reach
        change = net / max(slope, 0.1 * n.spring_rate)
        position += change
        if abs(change) < 1e-15 or abs(position) > FARTHEST:
            break
    return position
