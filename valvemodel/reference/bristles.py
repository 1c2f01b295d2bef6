"""Motion of a stem on elastic friction: Dahl's bristles, with F_s > F_c those of LuGre. It is never quite stuck."""

from __future__ import annotations

from collections.abc import Iterator
from math import copysign, exp
from types import SimpleNamespace

import numpy as np

from valvemodel.reference.air import Pressure
from valvemodel.reference.flow import flow
from valvemodel.reference.instant import first_instant
from valvemodel.reference.slip import Motion
from valvemodel.reference.stem import (
    breakaway_ratio,
    coulomb_friction,
    highest_position,
    lowest_position,
    thrust,
    viscous_friction,
)

FINEST = (1e-14, 1e-11, 1e-9)
"""Of position, velocity and bristles. [m], [m/s], [N]"""

LEAST = 1e-9
"""Bristles that carry nothing would have no slope. [N]"""

STATIC_DECAY = 1e-3
"""Speed over which breakaway friction that is not Stribeck's falls to Coulomb's. [m/s]"""


class BristleStem:
    """Position, velocity and the force of the bristles."""

    def __init__(self, numbers: SimpleNamespace, position: float, pressure: float) -> None:
        self.numbers = numbers
        self.lowest, self.highest = lowest_position(numbers), highest_position(numbers)
        self.position = min(max(position, self.lowest), self.highest)
        self.velocity = 0.0
        self.pressure: Pressure = lambda _: pressure
        self.time = 0.0
        limit = self.limit(0.0, self.position, 0.0)
        self.bristle = min(max(thrust(numbers, self.position, pressure, 0.0), -limit), limit)

    def hold(self, pressure: Pressure, time: float, duration: float) -> Iterator[tuple[Motion, float]]:
        """Hold a current; yield each stretch of motion to one side, and how long it takes."""
        self.pressure, self.time = pressure, time
        used = 0.0
        while used < duration:
            motion, lasted = self.move(used, duration - used)
            yield motion, lasted
            used = duration if lasted == duration - used else used + lasted

    def move(self, begin: float, left: float) -> tuple[Motion, float]:
        """Move until a turn, an end of the travel or the end of what is left; return the motion and its time."""
        if self.is_blocked(begin):
            position = self.position
            is_free = not self.is_blocked(begin + left)
            lasted = first_instant(lambda t: not self.is_blocked(begin + t), left) if is_free else left
            return lambda _: (position, 0.0), lasted
        side = copysign(1.0, self.velocity or self.net(begin, self.position, self.bristle))

        def slope(instant: float, state: np.ndarray) -> tuple[float, float, float]:
            position, velocity, bristle = state
            net = self.net(begin + instant, position, bristle) - viscous_friction(self.numbers, side) * velocity
            limit = self.limit(begin + instant, position, velocity)
            bending = (velocity - abs(velocity) * bristle / limit) / self.numbers.presliding_compliance
            return velocity, net / self.numbers.stem_mass, bending

        def has_ended(_: float, state: np.ndarray) -> bool:
            return side * state[1] < 0.0 or not self.lowest <= state[0] <= self.highest

        start = (self.position, self.velocity, self.bristle)
        motion, lasted, has_stopped = flow(slope, start, left, FINEST, has_ended)
        self.position, self.velocity, self.bristle = (float(each) for each in motion(lasted))
        if has_stopped:
            self.position, self.velocity = min(max(self.position, self.lowest), self.highest), 0.0
        return lambda instant: (float(motion(instant)[0]), float(motion(instant)[1])), lasted

    def net(self, instant: float, position: float, bristle: float) -> float:
        """Return the force on the stem but for its viscous friction. [N]"""
        return thrust(self.numbers, position, self.pressure(instant), self.time + instant) - bristle

    def is_blocked(self, instant: float) -> bool:
        """Return whether an end of the travel holds the stem."""
        net = self.net(instant, self.position, self.bristle)
        is_at_end = self.position >= self.highest if net > 0.0 else self.position <= self.lowest
        return self.velocity == 0.0 and is_at_end

    def limit(self, instant: float, position: float, velocity: float) -> float:
        """Return the friction that the bristles approach at a speed. [N]"""
        n, side = self.numbers, copysign(1.0, velocity) if velocity else 0.0
        friction = coulomb_friction(n, side, position, self.pressure(instant), self.time + instant)
        decay = n.stribeck_velocity if n.stribeck_ratio > 1.0 else STATIC_DECAY
        return max(friction * (1.0 + (breakaway_ratio(n) - 1.0) * exp(-abs(velocity) / decay)), LEAST)
