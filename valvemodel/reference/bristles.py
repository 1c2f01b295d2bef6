"""Motion of a stem on elastic friction: Dahl's and LuGre's bristles and Iwan's sliders. It is never quite stuck."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import pairwise
from math import copysign, exp
from types import SimpleNamespace

from valvemodel.reference.air import Pressure
from valvemodel.reference.flow import Flow, State, flow
from valvemodel.reference.instant import first_instant
from valvemodel.reference.slip import Motion
from valvemodel.reference.stem import (
    Span,
    breakaway_ratio,
    contact_force,
    coulomb_friction,
    highest_position,
    is_blocked,
    lowest_position,
    stribeck_share,
    thrust,
    velocity_at_end,
    viscous_friction,
)

FINEST = (1e-14, 1e-11, 1e-9)
"""Of position, velocity and bristles. [m], [m/s], [N]"""

LEAST = 1e-9
"""Bristles that carry nothing would have no slope. [N]"""

SLOWEST = 1e-12
"""A stem at rest is asked what would hold it either way: none at 0. [m/s]"""

STATIC_DECAY = 1e-3
"""Speed over which breakaway friction that is not Stribeck's falls to Coulomb's. [m/s]"""


SLIDERS = 16
"""Sliders in parallel, elastic up to forces that are spread evenly from 0 to twice their mean."""


class BristleStem:
    """Position, velocity, the force of the bristles, and how far each slider is bent."""

    def __init__(self, numbers: SimpleNamespace, position: float, pressure: float) -> None:
        self.numbers = numbers
        self.position = min(max(position, lowest_position(numbers)), highest_position(numbers))
        self.velocity = 0.0
        self.pressure: Pressure = lambda _: pressure
        self.time = 0.0
        limit = sliding_limit(numbers, self.position, 0.0, pressure, 0.0)
        carried = thrust(numbers, self.position, pressure, 0.0) + contact_force(numbers, self.position)
        self.bristle = min(max(carried, -limit), limit)
        self.sliders = [yields * self.bristle * numbers.presliding_compliance for yields in slider_yields()]

    def hold(self, pressure: Pressure, time: float, duration: float) -> Iterator[tuple[Motion, float]]:
        """Hold a current; yield each stretch of motion to one side, and how long it takes."""
        self.pressure, self.time = pressure, time
        used = 0.0
        while used < duration:
            held = self.position
            found, lasted = self.move(used, duration - used)
            if found is None:
                yield partial(standing, held), lasted
            else:
                yield from one_way_parts(found, lasted)
            used = duration if lasted == duration - used else used + lasted

    def move(self, begin: float, left: float) -> tuple[Flow | None, float]:
        """Move until an end of the travel or the end of what is left; return the flow, if any, and its time.

        With sliders a flow ends at a reversal as well: to one side they are functions of the way and of the limit,
        which they follow at once (slower than the stem moves, or this is not their law).
        """
        if self.is_blocked(begin):
            is_free = not self.is_blocked(begin + left)
            return None, first_instant(lambda t: not self.is_blocked(begin + t), left) if is_free else left

        def slope(instant: float, state: State) -> State:
            time, pressure = self.time + begin + instant, self.pressure(begin + instant)
            position, velocity, bristle = state
            damping = viscous_friction(n, copysign(1.0, velocity))
            net = thrust(n, position, pressure, time) - damping * velocity
            limit = sliding_limit(n, position, velocity, pressure, time)
            room = 1.0 - copysign(1.0, velocity) * bristle / limit
            bending = velocity * copysign(abs(room) ** n.bristle_exponent, room) / n.presliding_compliance
            resisting = bristle + n.bristle_damping * n.presliding_compliance * (bending if room > 0.0 else 0.0)
            if n.slider_share > 0.0:
                behind = sliding_limit(n, position, -velocity, pressure, time)
                bends = self.bends(side, position - begun, limit, behind)
                sliders = side * sum(bends) / (SLIDERS * n.presliding_compliance)
                resisting += n.slider_share * (sliders - resisting)
            return [velocity, (net - resisting) / n.stem_mass, bending]

        def is_beyond(_: float, state: State) -> bool:
            has_turned = n.slider_share > 0.0 and side * state[1] < 0.0
            return has_turned or not span.lowest <= state[0] <= span.highest

        n, begun, side = self.numbers, self.position, self.side(begin)
        span = Span(n, begun, side)
        found, lasted, has_hit = flow(slope, [self.position, self.velocity, self.bristle], left, FINEST, is_beyond)
        self.position, self.velocity, self.bristle = found(lasted)
        limits = self.limits(side, begin + lasted)
        self.sliders = [side * bend for bend in self.bends(side, self.position - begun, *limits)]
        if has_hit and not span.lowest < self.position < span.highest:
            self.position = span.within(self.position)
            self.velocity = velocity_at_end(n, self.position, self.velocity)
        return found, lasted

    def bends(self, side: float, way: float, limit: float, behind: float) -> list[float]:
        """Return how far the sliders are bent along a motion to one side, after a way, under both limits. [m]"""
        compliance = self.numbers.presliding_compliance
        pairs = [(side * bend, yields * compliance) for bend, yields in zip(self.sliders, slider_yields(), strict=True)]
        return [min(max(bend, -reach * behind) + side * way, reach * limit) for bend, reach in pairs]

    def limits(self, side: float, instant: float) -> tuple[float, float]:
        """Return what holds the sliders along a motion to one side and against it, where the stem is. [N]"""
        n, speed, pressure, time = self.numbers, abs(self.velocity), self.pressure(instant), self.time + instant
        ways = (copysign(max(speed, SLOWEST), each) for each in (side, -side))
        ahead, behind = (sliding_limit(n, self.position, way, pressure, time) for way in ways)
        return ahead, behind

    def net(self, instant: float) -> float:
        """Return the force on the stem, were it at rest. [N]"""
        n = self.numbers
        sliders = sum(self.bends(1.0, 0.0, *self.limits(1.0, instant))) / (SLIDERS * n.presliding_compliance)
        elastic = self.bristle + n.slider_share * (sliders - self.bristle)
        return thrust(n, self.position, self.pressure(instant), self.time + instant) - elastic

    def side(self, instant: float) -> float:
        """Return the side to which the stem moves, or begins to move."""
        return copysign(1.0, self.velocity if self.velocity != 0.0 else self.net(instant))

    def is_blocked(self, instant: float) -> bool:
        """Return whether an end of the travel holds the stem."""
        return self.velocity == 0.0 and is_blocked(self.numbers, self.position, self.net(instant))


def slider_yields() -> list[float]:
    """Return the force at which each slider slides, over their mean."""
    return [(2.0 * number + 1.0) / SLIDERS for number in range(SLIDERS)]


def sliding_limit(n: SimpleNamespace, position: float, velocity: float, pressure: float, time: float) -> float:
    """Return the friction that the bristles approach at a velocity. [N]"""
    side = copysign(1.0, velocity) if velocity else 0.0
    friction = coulomb_friction(n, side, position, pressure, time)
    share = stribeck_share(n, velocity) if n.stribeck_ratio > 1.0 else exp(-abs(velocity) / STATIC_DECAY)
    return max(friction * (1.0 + (breakaway_ratio(n) - 1.0) * share), LEAST)


def one_way_parts(found: Flow, lasted: float) -> Iterator[tuple[Motion, float]]:
    """Yield the parts of a flow between the instants at which the velocity changes its sign."""
    begin, looks = 0.0, [instant for instant in found.ends if instant < lasted] + [lasted]
    cuts = []
    for low, high in pairwise([0.0, *looks]):
        side = found(low)[1]
        if side * found(high)[1] < 0.0:
            cuts.append(low + first_instant(lambda t: side * found(low + t)[1] <= 0.0, high - low))  # noqa: B023
    for end in [*cuts, lasted]:
        if end > begin:
            yield partial(later, found, begin), end - begin
        begin = end


def later(found: Flow, begin: float, instant: float) -> State:
    """Return a flow an instant after one of its parts began."""
    return found(begin + instant)


def standing(position: float, _: float) -> State:
    """Return the motion of a stem that stands still."""
    return [position, 0.0]
