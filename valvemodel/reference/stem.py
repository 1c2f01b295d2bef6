"""Stem: the forces on it."""

from __future__ import annotations

from math import cos, exp, expm1, inf, pi, sin
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
    return area * pressure - spring - contact_force(n, position) + load(n, time)


def contact_force(n: SimpleNamespace, position: float) -> float:
    """Return the force by which a stop that gives way pushes the stem back, counted downwards. [N]"""
    if n.stop_compliance == 0.0:
        return 0.0
    depth: float = max(position - n.upper_stop, 0.0) - max(n.lower_stop - position, 0.0)
    return depth / n.stop_compliance


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
    distance = abs(position - n.tight_spot_position) / n.tight_spot_width
    friction *= 1.0 + n.tight_spot_excess * ending(n.tight_spot_closure, distance**n.tight_spot_exponent)
    inflated = max(pressure, 0.0)
    seal = n.friction_area * inflated * (inflated / n.supply_pressure) ** (n.friction_pressure_order - 1.0)
    growth = max(1.0 - n.friction_drift_rate * n.friction_drift_time * expm1(-time / n.friction_drift_time), 0.0)
    return growth * max(friction + seal, 0.0)


def ending(closure: float, power: float) -> float:
    """Return the share of a tight spot's excess friction that is left at a power of the distance from its middle."""
    if closure == 0.0:
        return exp(-power)
    return max(1.0 - closure * power, 0.0) ** (1.0 / closure)


def breakaway_ratio(n: SimpleNamespace) -> float:
    """Return the force at which a stem breaks away over its Coulomb friction."""
    return max(n.static_friction_ratio, n.stribeck_ratio)


def stribeck_share(n: SimpleNamespace, velocity: float) -> float:
    """Return the share of the drop from breakaway to Coulomb friction that is left at a velocity."""
    relative = (abs(velocity) / n.stribeck_velocity) ** n.stribeck_shape
    return (1.0 - n.stribeck_tail) * exp(-relative) + n.stribeck_tail / (1.0 + relative)


def viscous_friction(n: SimpleNamespace, side: float) -> float:
    """Return the viscous friction of a stem that moves to a side. [N s/m]"""
    return n.viscous_friction * (1.0 + n.viscous_asymmetry * side)


def highest_position(n: SimpleNamespace) -> float:
    """Return the upper end of the travel. [m]"""
    return min(n.travel_max, FARTHEST, *([n.upper_stop] if n.stop_compliance == 0.0 else []))


def lowest_position(n: SimpleNamespace) -> float:
    """Return the lower end of the travel. [m]"""
    return max(n.travel_min, -FARTHEST, *([n.lower_stop] if n.stop_compliance == 0.0 else []))


class Span:
    """The positions between which the stem's forces follow one law: off the stops that give way, or against one."""

    def __init__(self, n: SimpleNamespace, position: float, side: float) -> None:
        self.lowest, self.highest = lowest_position(n), highest_position(n)
        self.stop = inf
        if n.stop_compliance > 0.0:
            if position > n.upper_stop or (position == n.upper_stop and side > 0.0):
                self.lowest = self.stop = n.upper_stop
            elif position < n.lower_stop or (position == n.lower_stop and side < 0.0):
                self.highest = self.stop = n.lower_stop
            else:
                self.lowest, self.highest = max(self.lowest, n.lower_stop), min(self.highest, n.upper_stop)

    def is_beyond(self, position: float, side: float) -> bool:
        """Return whether a motion to a side has left the span."""
        return position > self.highest if side > 0.0 else position < self.lowest

    def within(self, position: float) -> float:
        """Return a position, or the end of the span that is nearest to it. [m]"""
        return min(max(position, self.lowest), self.highest)


def held_by_stops(n: SimpleNamespace, position: float, pressure: float) -> float:
    """Return a position, no deeper in a stop that gives way than where friction holds a resting stem. [m]"""
    span = Span(n, position, 0.0)
    if span.stop == inf:
        return position
    side = 1.0 if position > span.stop else -1.0
    holding = breakaway_ratio(n) * coulomb_friction(n, -side, span.stop, pressure, 0.0)
    force = max(side * thrust(n, span.stop, pressure, 0.0) + holding, 0.0)
    return span.stop + side * min(side * (position - span.stop), force / (n.spring_rate + 1.0 / n.stop_compliance))


def is_blocked(n: SimpleNamespace, position: float, side: float) -> bool:
    """Return whether an end of the travel bars the way to a side."""
    return position >= highest_position(n) if side > 0.0 else position <= lowest_position(n)


def rebound(n: SimpleNamespace, velocity: float) -> float:
    """Return the velocity after the stem hits an end of its travel; a rebound below the stop speed rests. [m/s]"""
    after = -n.restitution * velocity
    return after if abs(after) >= STOP_SPEED else 0.0


def velocity_at_end(n: SimpleNamespace, position: float, velocity: float) -> float:
    """Return the velocity of a stem that has come to the end of a span: where a stop gives way, it goes on. [m/s]"""
    return rebound(n, velocity) if is_blocked(n, position, velocity) else velocity


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
