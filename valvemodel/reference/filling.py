"""Filling: the supply sags, the chamber fills and the amplifier follows, as differential equations."""

from __future__ import annotations

from math import sqrt
from types import SimpleNamespace
from typing import TYPE_CHECKING

from valvemodel.reference.flow import State, flow
from valvemodel.reference.nozzle import ATMOSPHERE

if TYPE_CHECKING:
    from valvemodel.reference.air import Air

FINEST = (1e-8, 1e-8, 1e-8)
"""Of sag, chamber and amplifier. [Pa]"""

NEAR = 1e-5
"""Between the instants from which the tendency of the pressure is taken. [s]"""

JUMP = 1e-9
"""Share of the supply that is a jump."""

LEAST_ROOT = 1e-3
"""Orifices are not more than a thousand times quicker than first order."""


def flows(n: SimpleNamespace) -> bool:
    """Return whether air has to flow before a pressure is there."""
    return n.droop_gain > 0.0 or n.droop_consumption > 0.0 or n.chamber_filling_time > 0.0 or fills_unequally(n)


def fills_unequally(n: SimpleNamespace) -> bool:
    """Return whether filling and venting take their own times."""
    return max(filling_times(n)) > 0.0 or n.filling_slowness != 0.0


def filling_times(n: SimpleNamespace) -> tuple[float, float]:
    """Return the time constants of filling and of venting, each with that of a line that smears. [s]"""
    smear = n.line_dispersion * n.transport_delay
    return n.fill_time + smear, n.vent_time + smear


class Stretch:
    """Part of a hold in which the supplied pressure goes one way.

    A rise draws the supply down, d' = g P' + (d_settled - d)/T, so that d - g P is what flows smoothly; while the
    pressure falls, g is 0.
    """

    def __init__(self, air: Air, begin: float, end: float) -> None:
        self.air, self.numbers, self.begin = air, air.numbers, begin
        self.is_rising = self.tends_up(begin, air.sag, air.supplied)
        self.gain = self.numbers.droop_gain if self.is_rising else 0.0
        start = [air.sag - self.gain * air.supplied, air.chamber, air.filled]
        self.flow, lasted, _ = flow(self.slope, start, end - begin, FINEST, self.has_turned)
        self.end = begin + lasted

    def tends_up(self, instant: float, sag: float, supplied: float) -> bool:
        """Return whether the supplied pressure jumps up, or would rise but for what that draws."""
        n, share = self.numbers, self.air.share(instant)
        jump = (n.supply_pressure - sag) * share - supplied
        if abs(jump) > JUMP * n.supply_pressure:
            return jump > 0.0
        trend = (self.air.share(instant + NEAR) - share) / NEAR
        recovery = (sag - sag_to_settle(n, share)) / n.droop_recovery_time
        return (n.supply_pressure - sag) * trend + share * recovery > 0.0

    def has_turned(self, instant: float, state: State) -> bool:
        """Return whether the supplied pressure has begun to go the other way."""
        if self.numbers.droop_gain == 0.0:
            return False
        supplied = self.supplied(instant, state)
        return self.tends_up(self.begin + instant, state[0] + self.gain * supplied, supplied) != self.is_rising

    def supplied(self, instant: float, state: State) -> float:
        """Return the share of the sagging supply. [Pa]"""
        share = self.air.share(self.begin + instant)
        return (self.numbers.supply_pressure - state[0]) * share / (1.0 + self.gain * share)

    def slope(self, instant: float, state: State) -> State:
        """Return the rates of sag (but for what a rise draws), chamber and amplifier. [Pa/s]"""
        n, supplied = self.numbers, self.supplied(instant, state)
        sag = state[0] + self.gain * supplied
        settled = sag_to_settle(n, self.air.share(self.begin + instant))
        target = state[1] if n.chamber_filling_time > 0.0 else supplied
        return [
            (settled - sag) / n.droop_recovery_time,
            chamber_slope(n, state[1], supplied, self.air.gap(self.begin + instant)),
            filled_slope(n, state[2], target),
        ]

    def state_after(self, instant: float) -> tuple[float, float, float, float]:
        """Return supplied pressure, sag, chamber and amplifier an instant after the hold began. [Pa]"""
        state = self.flow(instant - self.begin)
        supplied = self.supplied(instant - self.begin, state)
        return supplied, state[0] + self.gain * supplied, state[1], state[2]

    def pressure(self, instant: float) -> float:
        """Return the pressure behind the last stage that there is. [Pa]"""
        supplied, _, chamber, filled = self.state_after(instant)
        if fills_unequally(self.numbers):
            return filled
        return chamber if self.numbers.chamber_filling_time > 0.0 else supplied


def stretches_of(air: Air, duration: float) -> list[Stretch]:
    """Return the stretches of a hold, one after the other."""
    stretches = [Stretch(air, 0.0, duration)]
    while (end := stretches[-1].end) < duration:
        air.supplied, air.sag, air.chamber, air.filled = stretches[-1].state_after(end)
        stretches.append(Stretch(air, end, duration))
    return stretches


def sag_to_settle(n: SimpleNamespace, share: float) -> float:
    """Return the sag that the flow through the orifice keeps up. [Pa]"""
    return n.droop_consumption * n.supply_pressure * sqrt(max(1.0 - share, 0.0))


def chamber_slope(n: SimpleNamespace, pressure: float, resting: float, opening: float) -> float:
    """Return how fast the chamber fills: eq. (15), its flows less those at rest. [Pa/s]"""
    if n.chamber_filling_time == 0.0:
        return 0.0
    bounded = min(max(pressure, 0.0), n.supply_pressure)
    filling_time = n.chamber_filling_time * (1.0 + n.filling_growth * bounded / n.supply_pressure)
    stiffness = 1.0 + n.filling_of_gas * bounded / ATMOSPHERE
    excess = inflow(n, bounded, opening) - inflow(n, resting, opening)
    return stiffness * n.supply_pressure * excess / filling_time


def inflow(n: SimpleNamespace, pressure: float, opening: float) -> float:
    """Return what flows into the chamber over what the orifice lets into an empty one, eq. (15); or laminar."""
    share = pressure / n.supply_pressure
    turbulent = sqrt(1.0 - share) - opening * sqrt(n.flow_ratio * share)
    return turbulent - n.laminar_filling * (turbulent + share)


def filled_slope(n: SimpleNamespace, pressure: float, target: float) -> float:
    """Return how fast the amplifier follows: at its own pace up and down, rate-limited one way. [Pa/s]"""
    if not fills_unequally(n):
        return 0.0
    fill_time, vent_time = filling_times(n)
    rate = quickness(n, pressure, target) * (target - pressure) / (fill_time if target > pressure else vent_time)
    if n.filling_slowness > 0.0:
        return max(rate, -1.0 / n.filling_slowness)
    return min(rate, -1.0 / n.filling_slowness) if n.filling_slowness < 0.0 else rate


def quickness(n: SimpleNamespace, pressure: float, target: float) -> float:
    """Return by how much orifices are quicker than first order: the flow of eq. (15), 0 at the target, over the lead.

    sqrt(1 - p) - sqrt(1/q - 1) sqrt(p) = (q - p) / (q sqrt(1 - p) + sqrt(q p (1 - q))), in shares of the supply.
    """
    share, resting = (min(max(each / n.supply_pressure, 0.0), 1.0) for each in (pressure, target))
    root = resting * sqrt(1.0 - share) + sqrt(resting * share * (1.0 - resting))
    stiffness = 1.0 + n.orifices_of_gas * share * n.supply_pressure / ATMOSPHERE
    return 1.0 + n.orifice_share * (stiffness / max(root, LEAST_ROOT) - 1.0)
