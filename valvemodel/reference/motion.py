"""Motion of a stem under a held pressure, from event to event: breakaway, stop, reversal, end of the travel."""

from __future__ import annotations

from collections.abc import Iterator
from math import copysign, inf
from types import SimpleNamespace
from typing import TYPE_CHECKING

from valvemodel.reference.air import Pressure
from valvemodel.reference.instant import first_instant
from valvemodel.reference.slip import Motion, first_stop, slip
from valvemodel.reference.stem import (
    STOP_SPEED,
    Span,
    breakaway_ratio,
    coulomb_friction,
    highest_position,
    is_blocked,
    lowest_position,
    thrust,
    velocity_at_end,
    viscous_friction,
)

if TYPE_CHECKING:
    from valvemodel.reference.curved import CurvedStem

PAST_STICKING = 1e-12
"""Way between the stick speed and speed 0 that is too short to be looked at. [m]"""

HELD = 1.0 + 1e-12
"""Friction holds this share of its breakaway force, lest rounding decide."""


def hard_stop(n: SimpleNamespace) -> float:
    """Return how hard a slip slows down that stops at speed 0, hardly further than where it may stick. [m/s^2]"""
    speed: float = n.stick_speed
    return speed * speed / PAST_STICKING


def end_slip(stem: Stem | CurvedStem) -> None:
    """Stop a slip where the stem is, or throw it back at an end of the travel; at a stop that gives way it goes on."""
    position = stem.span.within(stem.position)
    velocity = velocity_at_end(stem.numbers, position, stem.velocity) if position != stem.position else 0.0
    stem.come_to_rest(position)
    if velocity != 0.0:
        stem.velocity, stem.side = velocity, copysign(1.0, velocity)


class Stem:
    """Position, velocity and side of a stem: 1 slipping up, -1 slipping down, 0 stuck."""

    def __init__(self, numbers: SimpleNamespace, position: float) -> None:
        self.numbers = numbers
        self.position = min(max(position, lowest_position(numbers)), highest_position(numbers))
        self.span = Span(numbers, self.position, 0.0)
        self.velocity = 0.0
        self.side = 0.0

    def hold(self, pressure: Pressure, _: float, duration: float) -> Iterator[tuple[Motion, float]]:
        """Hold a pressure for a duration; yield each stretch of motion to one side, and how long it takes."""
        left, held = duration, pressure(0.0)
        while left > 0.0:
            motion, used = self.move(held, left)
            yield motion, used
            left -= used

    def move(self, pressure: float, left: float) -> tuple[Motion, float]:
        """Move until the next event or the end of what is left; return the motion and how long it takes."""
        if self.sticks(pressure):
            self.come_to_rest(self.position)
            position = self.position
            return lambda _: (position, 0.0), left
        n, position, velocity = self.numbers, self.position, self.velocity
        if self.side == 0.0:
            self.side = 1.0 if thrust(n, position, pressure, 0.0) > 0.0 else -1.0
        side = self.side
        self.span = Span(n, position, side)
        friction = coulomb_friction(n, side, position, pressure, 0.0)
        body = {
            "mass": n.stem_mass,
            "damping": viscous_friction(n, side),
            "stiffness": n.spring_rate - n.diaphragm_area * n.area_slope * pressure,
        }
        force = n.diaphragm_area * pressure - n.spring_preload - side * friction
        if self.span.stop != inf:
            body["stiffness"] += 1.0 / n.stop_compliance
            force += self.span.stop / n.stop_compliance
        motion = slip(**body, force=force, position=position, velocity=velocity)
        acceleration = self.acceleration(position, velocity, pressure)
        stop = first_stop(**body, speed=side * velocity, acceleration=side * acceleration)
        used = min(stop, left)
        if self.has_ended(pressure, *motion(used)):
            stop = used = first_instant(lambda t: self.has_ended(pressure, *motion(t)), used)
        self.position, self.velocity = motion(used)
        if stop <= left:
            end_slip(self)
        return motion, used

    def sticks(self, pressure: float) -> bool:
        """Return whether a slip has ended: it is held, and creeps or slows down below the stick speed."""
        speed = abs(self.velocity)
        if speed >= self.numbers.stick_speed or not self.is_held(self.position, pressure):
            return False
        return speed < STOP_SPEED or self.side * self.acceleration(self.position, self.velocity, pressure) < 0.0

    def acceleration(self, position: float, velocity: float, pressure: float) -> float:
        """Return the acceleration of a slip, eq. (6). [m/s^2]"""
        n, side = self.numbers, self.side
        friction = side * coulomb_friction(n, side, position, pressure, 0.0) + viscous_friction(n, side) * velocity
        return (thrust(n, position, pressure, 0.0) - friction) / n.stem_mass

    def is_held(self, position: float, pressure: float) -> bool:
        """Return whether friction, or an end of the travel, holds a stem that is at rest at a position."""
        net = thrust(self.numbers, position, pressure, 0.0)
        side = 1.0 if net > 0.0 else -1.0
        friction = coulomb_friction(self.numbers, side, position, pressure, 0.0)
        return is_blocked(self.numbers, position, side) or abs(net) <= HELD * breakaway_ratio(self.numbers) * friction

    def has_ended(self, pressure: float, position: float, velocity: float) -> bool:
        """Return whether a slip is beyond the travel, or has slowed down to a creep where friction holds the stem."""
        is_beyond = self.span.is_beyond(position, self.side)
        is_slow = self.side * velocity < self.numbers.stick_speed
        slowing = self.side * self.acceleration(position, velocity, pressure)
        is_creep = is_slow and -hard_stop(self.numbers) < slowing < 0.0
        return is_beyond or (is_creep and self.is_held(position, pressure))

    def come_to_rest(self, position: float) -> None:
        """End a slip at a position."""
        self.position, self.velocity, self.side = position, 0.0, 0.0
