"""Air: the pressure at the actuator through a held current, where it stands still and where it moves."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace

from valvemodel.errors import InputError
from valvemodel.reference.electromagnet import Electromagnet, gap
from valvemodel.reference.filling import Stretch, filling_times, fills_unequally, flows, sag_to_settle, stretches_of
from valvemodel.reference.nozzle import behind_leak, resting_pressure

Pressure = Callable[[float], float]
"""At the actuator, after a duration of the hold. [Pa]"""


def moves(n: SimpleNamespace) -> bool:
    """Return whether the pressure moves under a held current."""
    return n.gap_drift_rate != 0.0 or n.coil_time_constant > 0.0 or n.eddy_time_constant > 0.0 or flows(n)


class Air:
    """The air behind an electromagnet; its state is the supply's sag, and the pressures of chamber and amplifier."""

    def __init__(self, numbers: SimpleNamespace, electromagnet: Electromagnet) -> None:
        self.numbers, self.electromagnet = numbers, electromagnet
        if fills_unequally(numbers) and not min(filling_times(numbers)) > 0.0:
            arrived = f"they are {numbers.fill_time:g} and {numbers.vent_time:g} s"
            raise InputError("the reference needs a positive fill_time and vent_time", arrived, "raise them")
        self.time = 0.0
        share = self.share(0.0)
        self.sag = sag_to_settle(numbers, share)
        self.supplied = self.chamber = self.filled = (numbers.supply_pressure - self.sag) * share
        self.pressure = behind_leak(numbers, self.filled)

    def gap(self, instant: float) -> float:
        """Return the gap an instant after the hold began. [m]"""
        return gap(self.numbers, self.electromagnet.current_after(instant), self.time + instant)

    def share(self, instant: float) -> float:
        """Return the pressure at rest over that of the supply, an instant after the hold began."""
        current = self.electromagnet.current_after(instant)
        opening = gap(self.numbers, current, self.time + instant)
        return resting_pressure(self.numbers, opening, current) / self.numbers.supply_pressure

    def hold(self, time: float, duration: float) -> Pressure:
        """Return the pressure through the current that the electromagnet holds from a time for a duration."""
        n, self.time = self.numbers, time
        if flows(n):
            return self.flow(duration)
        if moves(n):
            return lambda instant: behind_leak(n, n.supply_pressure * self.share(instant))
        still = behind_leak(n, n.supply_pressure * self.share(0.0))
        return lambda _: still

    def flow(self, duration: float) -> Pressure:
        """Let the air flow and return the pressure through it."""
        stretches = stretches_of(self, duration)
        last = stretches[-1]
        self.supplied, self.sag, self.chamber, self.filled = last.state_after(duration)

        def pressure(instant: float) -> float:
            stretch: Stretch = next((each for each in stretches if instant <= each.end), last)
            return behind_leak(self.numbers, stretch.pressure(instant))

        return pressure
