"""Air: the pressure at the actuator through a held current, where it stands still and where it moves."""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt
from types import SimpleNamespace

import numpy as np

from valvemodel.errors import InputError
from valvemodel.reference.electromagnet import Electromagnet, gap
from valvemodel.reference.flow import flow
from valvemodel.reference.nozzle import behind_leak, resting_pressure

Pressure = Callable[[float], float]
"""At the actuator, after a duration of the hold. [Pa]"""

FINEST = (1e-8, 1e-8, 1e-8)
"""Of sag, chamber and amplifier. [Pa]"""

NEAR = 1e-5
"""Instants between which the tendency of the pressure is taken. [s]"""


def moves(n: SimpleNamespace) -> bool:
    """Return whether the pressure moves under a held current."""
    return n.gap_drift_rate != 0.0 or n.coil_time_constant > 0.0 or flows(n)


def flows(n: SimpleNamespace) -> bool:
    """Return whether air has to flow before a pressure is there."""
    return n.droop_gain > 0.0 or n.droop_consumption > 0.0 or n.chamber_filling_time > 0.0 or fills_unequally(n)


def fills_unequally(n: SimpleNamespace) -> bool:
    """Return whether filling and venting take their own times."""
    return n.fill_time > 0.0 or n.vent_time > 0.0 or n.filling_slowness != 0.0


class Air:
    """The air behind an electromagnet; its state is the supply's sag, and the pressures of chamber and amplifier."""

    def __init__(self, numbers: SimpleNamespace, electromagnet: Electromagnet) -> None:
        self.numbers, self.electromagnet = numbers, electromagnet
        if fills_unequally(numbers) and not (numbers.fill_time > 0.0 and numbers.vent_time > 0.0):
            arrived = f"they are {numbers.fill_time:g} and {numbers.vent_time:g} s"
            raise InputError("the reference needs a positive fill_time and vent_time", arrived, "raise them")
        self.share = self.resting(0.0, 0.0) / numbers.supply_pressure
        self.sag = self.sag_to_settle(self.share)
        self.chamber = self.filled = (numbers.supply_pressure - self.sag) * self.share
        self.pressure = behind_leak(numbers, self.filled)

    def resting(self, time: float, instant: float) -> float:
        """Return the pressure at rest under the full supply, an instant after a time at which the current began. [Pa]"""
        current = self.electromagnet.current_after(instant)
        return resting_pressure(self.numbers, gap(self.numbers, current, time + instant), current)

    def hold(self, time: float, duration: float) -> Pressure:
        """Return the pressure through the current that the electromagnet holds from a time for a duration."""
        n = self.numbers
        if not moves(n):
            self.pressure = behind_leak(n, self.resting(time, 0.0))
            return lambda _: self.pressure
        if not flows(n):
            return lambda instant: behind_leak(n, self.resting(time, instant))
        return self.flow(time, duration)

    def flow(self, time: float, duration: float) -> Pressure:
        """Let the air flow, from each rise of the supplied pressure to its fall and back."""
        n, stretches, used = self.numbers, [], 0.0
        supplied = (n.supply_pressure - self.sag) * self.share
        while used < duration:
            is_rising = self.is_rising(time, used, supplied)
            gain = n.droop_gain if is_rising else 0.0
            # While the pressure rises it draws the supply down: d - g P changes without it.
            start = (self.sag - gain * supplied, self.chamber, self.filled)
            began = used

            def pressures(instant: float, state: np.ndarray, gain=gain, began=began) -> tuple[float, float]:
                share = self.resting(time, began + instant) / n.supply_pressure
                supplied = (n.supply_pressure - state[0]) * share / (1.0 + gain * share)
                return share, supplied

            def slope(instant: float, state: np.ndarray, gain=gain, began=began) -> tuple[float, float, float]:
                share, supplied = pressures(instant, state)
                sag = state[0] + gain * supplied
                opening = gap(n, self.electromagnet.current_after(began + instant), time + began + instant)
                chamber = self.chamber_slope(state[1], supplied, opening)
                target = state[1] if n.chamber_filling_time > 0.0 else supplied
                return (
                    (self.sag_to_settle(share) - sag) / n.droop_recovery_time,
                    chamber,
                    self.filled_slope(state[2], target),
                )

            def has_turned(instant: float, state: np.ndarray, began=began, is_rising=is_rising, gain=gain) -> bool:
                if n.droop_gain == 0.0:
                    return False
                self.sag = state[0] + gain * pressures(instant, state)[1]
                return self.tendency(time, began + instant) * (1.0 if is_rising else -1.0) < 0.0

            found, lasted, _ = flow(slope, start, duration - used, FINEST, has_turned)
            state = found(lasted)
            self.share, supplied = pressures(lasted, state)
            self.sag, self.chamber, self.filled = state[0] + gain * supplied, state[1], state[2]
            used += lasted
            stretches.append((used, began, found, pressures))

        def pressure(instant: float) -> float:
            _, began, found, pressures = next((each for each in stretches if instant <= each[0]), stretches[-1])
            state = found(instant - began)
            last = pressures(instant - began, state)[1]
            last = state[1] if n.chamber_filling_time > 0.0 else last
            return behind_leak(n, state[2] if fills_unequally(n) else last)

        return pressure

    def is_rising(self, time: float, instant: float, supplied: float) -> bool:
        """Return whether the supplied pressure rises: it jumps up, or its tendency is up."""
        share = self.resting(time, instant) / self.numbers.supply_pressure
        jump = (self.numbers.supply_pressure - self.sag) * share - supplied
        if abs(jump) > 1e-9 * self.numbers.supply_pressure:
            return jump > 0.0
        return self.tendency(time, instant) > 0.0

    def tendency(self, time: float, instant: float) -> float:
        """Return the rate of the supplied pressure but for what its own rise draws. [Pa/s]"""
        n = self.numbers
        before, after = (self.resting(time, instant + near) / n.supply_pressure for near in (0.0, NEAR))
        recovery = (self.sag - self.sag_to_settle(before)) / n.droop_recovery_time
        return (n.supply_pressure - self.sag) * (after - before) / NEAR + before * recovery

    def sag_to_settle(self, share: float) -> float:
        """Return the sag that the flow through the orifice keeps up. [Pa]"""
        return self.numbers.droop_consumption * self.numbers.supply_pressure * sqrt(max(1.0 - share, 0.0))

    def chamber_slope(self, pressure: float, resting: float, opening: float) -> float:
        """Return how fast the chamber fills: eq. (15), its flows less those at rest. [Pa/s]"""
        n = self.numbers
        if n.chamber_filling_time == 0.0:
            return 0.0
        bounded = min(max(pressure, 0.0), n.supply_pressure)
        filling_time = n.chamber_filling_time * (1.0 + n.filling_growth * bounded / n.supply_pressure)
        flows = inflow(n, bounded, opening) - inflow(n, resting, opening)
        return n.supply_pressure * flows / filling_time

    def filled_slope(self, pressure: float, target: float) -> float:
        """Return how fast the amplifier follows: first order, at its own pace up and down, rate-limited one way. [Pa/s]"""
        n = self.numbers
        if not fills_unequally(n):
            return 0.0
        rate = (target - pressure) / (n.fill_time if target > pressure else n.vent_time)
        if n.filling_slowness > 0.0:
            return max(rate, -1.0 / n.filling_slowness)
        if n.filling_slowness < 0.0:
            return min(rate, -1.0 / n.filling_slowness)
        return rate


def inflow(n: SimpleNamespace, pressure: float, opening: float) -> float:
    """Return what flows into the chamber over what the orifice lets into an empty one, eq. (15)."""
    share = pressure / n.supply_pressure
    return sqrt(1.0 - share) - opening * sqrt(n.flow_ratio * share)
