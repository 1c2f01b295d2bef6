"""Motion of a stem under forces that curve or change in time, integrated from event to event."""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil
from types import SimpleNamespace

from valvemodel.reference.air import Pressure, moves
from valvemodel.reference.flow import State, flow
from valvemodel.reference.instant import first_instant
from valvemodel.reference.motion import HELD, end_slip, hard_stop
from valvemodel.reference.slip import Motion
from valvemodel.reference.stem import (
    STOP_SPEED,
    Span,
    breakaway_ratio,
    coulomb_friction,
    highest_position,
    is_blocked,
    lowest_position,
    stribeck_share,
    thrust,
    viscous_friction,
)

FINEST = (1e-14, 1e-11)
"""Of position and velocity. [m], [m/s]"""

LOOK = 1e-3
"""Longest time between two looks at a stem that holds. [s]"""


def curves(n: SimpleNamespace) -> bool:
    """Return whether a slip under a held pressure is no linear equation with constant forces."""
    has_straight_spring = n.spring_hardening == 0.0 and n.spring_progression == 0.0
    return not has_straight_spring or n.area_curvature != 0.0 or n.tight_spot_excess != 0.0 or n.stribeck_ratio > 1.0


def varies(n: SimpleNamespace) -> bool:
    """Return whether the forces on a stem change while it stands still."""
    return moves(n) or n.load_sine != 0.0 or n.load_cosine != 0.0 or n.load_waves > 1.0 or n.friction_drift_rate != 0.0


class CurvedStem:
    """Position, velocity and side of a stem: 1 slipping up, -1 slipping down, 0 stuck."""

    def __init__(self, numbers: SimpleNamespace, position: float) -> None:
        self.numbers = numbers
        self.position = min(max(position, lowest_position(numbers)), highest_position(numbers))
        self.span = Span(numbers, self.position, 0.0)
        self.velocity = 0.0
        self.side = 0.0
        self.pressure: Pressure = lambda _: 0.0
        self.time = 0.0

    def hold(self, pressure: Pressure, time: float, duration: float) -> Iterator[tuple[Motion, float]]:
        """Hold a current; yield each stretch of motion to one side, and how long it takes."""
        self.pressure, self.time = pressure, time
        used = 0.0
        while used < duration:
            motion, lasted = self.move(used, duration - used)
            yield motion, lasted
            used = duration if lasted == duration - used else used + lasted

    def move(self, begin: float, left: float) -> tuple[Motion, float]:
        """Move until the next event or the end of what is left; return the motion and how long it takes."""
        if self.sticks(begin):
            self.come_to_rest(self.position)
            position = self.position
            return lambda _: (position, 0.0), self.time_held(begin, left)
        if self.side == 0.0:
            self.side = 1.0 if self.thrust(begin, self.position) > 0.0 else -1.0
        self.span = Span(self.numbers, self.position, self.side)

        def slope(instant: float, state: State) -> State:
            return [state[1], self.acceleration(begin + instant, state[0], state[1])]

        def has_ended(instant: float, state: State) -> bool:
            return self.has_ended(begin + instant, state[0], state[1])

        motion, lasted, has_stopped = flow(slope, [self.position, self.velocity], left, FINEST, has_ended)
        self.position, self.velocity = motion(lasted)
        if has_stopped:
            end_slip(self)
        return motion, lasted

    def sticks(self, instant: float) -> bool:
        """Return whether a slip has ended: it is held, and creeps or slows down below the stick speed."""
        speed = abs(self.velocity)
        if speed >= self.numbers.stick_speed or not self.is_held(instant, self.position):
            return False
        return speed < STOP_SPEED or self.side * self.acceleration(instant, self.position, self.velocity) < 0.0

    def acceleration(self, instant: float, position: float, velocity: float) -> float:
        """Return the acceleration of a slip, eq. (6), friction falling with the speed (Stribeck). [m/s^2]"""
        n, side, time, pressure = self.numbers, self.side, self.time + instant, self.pressure(instant)
        friction = coulomb_friction(n, side, position, pressure, time) * (
            1.0 + (n.stribeck_ratio - 1.0) * stribeck_share(n, velocity)
        )
        resisting = side * friction + viscous_friction(n, side) * velocity
        return (thrust(n, position, pressure, time) - resisting) / n.stem_mass

    def thrust(self, instant: float, position: float) -> float:
        """Return what drives the stem. [N]"""
        return thrust(self.numbers, position, self.pressure(instant), self.time + instant)

    def is_held(self, instant: float, position: float) -> bool:
        """Return whether friction, or an end of the travel, holds a stem that is at rest at a position."""
        n, time, pressure = self.numbers, self.time + instant, self.pressure(instant)
        net = thrust(n, position, pressure, time)
        side = 1.0 if net > 0.0 else -1.0
        friction = coulomb_friction(n, side, position, pressure, time)
        return is_blocked(n, position, side) or abs(net) <= HELD * breakaway_ratio(n) * friction

    def time_held(self, begin: float, left: float) -> float:
        """Return how long a stem that holds goes on holding, at most what is left. [s]"""
        if not varies(self.numbers):
            return left
        looks = ceil(left / LOOK)
        for look in range(looks):
            low, high = left * look / looks, left * (look + 1) / looks
            if not self.is_held(begin + high, self.position):
                return low + first_instant(lambda t: not self.is_held(begin + low + t, self.position), high - low)  # noqa: B023
        return left

    def has_ended(self, instant: float, position: float, velocity: float) -> bool:
        """Return whether a slip has stopped, is beyond the travel, or creeps where friction holds the stem."""
        speed = self.side * velocity
        if speed < 0.0 or self.span.is_beyond(position, self.side):
            return True
        slowing = self.side * self.acceleration(instant, position, velocity)
        is_creep = speed < self.numbers.stick_speed and -hard_stop(self.numbers) < slowing < 0.0
        return is_creep and self.is_held(instant, position)

    def come_to_rest(self, position: float) -> None:
        """End a slip at a position."""
        self.position, self.velocity, self.side = position, 0.0, 0.0
