"""The valve: the four stages one after the other, under currents that are held."""

from __future__ import annotations

from math import copysign, isnan
from types import SimpleNamespace

from valvemodel.reference.air import Air
from valvemodel.reference.bristles import BristleStem
from valvemodel.reference.curved import CurvedStem, curves, varies
from valvemodel.reference.electromagnet import Electromagnet
from valvemodel.reference.motion import Stem
from valvemodel.reference.sensor import Sensor, straightened, zero_drift
from valvemodel.reference.stem import STOP_SPEED, balanced_position, held_by_stops


class Valve:
    """A valve at rest under a current, and then under what currents it is given."""

    def __init__(self, numbers: SimpleNamespace, current: float, start_reading: float) -> None:
        self.numbers = numbers
        self.electromagnet = Electromagnet(numbers, current)
        self.air = Air(numbers, self.electromagnet)
        self.pressure = self.air.pressure
        position = balanced_position(numbers, self.pressure)
        if not isnan(start_reading):
            position = straightened(numbers, start_reading - zero_drift(numbers, 0.0))
            position = held_by_stops(numbers, position, self.pressure)
        self.stem = stem_of(numbers, position, self.pressure)
        self.sensor = Sensor(numbers, self.stem.position)
        # The linkage may start anywhere in its play.
        self.stem.position -= numbers.backlash_start * numbers.backlash_half_width

    def hold(self, current: float, time: float, duration: float) -> None:
        """Hold a current at the coil from a time for a duration."""
        self.electromagnet.hold(current)
        pressure = self.air.hold(time, duration)
        for motion, lasted in self.stem.hold(pressure, time, duration):
            self.sensor.follow(motion, lasted)
        self.pressure = pressure(duration)
        self.electromagnet.advance(duration)

    @property
    def mode(self) -> float:
        """1 rising, 0 stuck, -1 falling."""
        velocity = self.stem.velocity
        return 0.0 if abs(velocity) < STOP_SPEED else copysign(1.0, velocity)


def stem_of(numbers: SimpleNamespace, position: float, pressure: float) -> Stem | CurvedStem | BristleStem:
    """Return a stem at rest: in closed form where its slips are linear, else integrated."""
    if numbers.presliding_compliance > 0.0:
        return BristleStem(numbers, position, pressure)
    if curves(numbers) or varies(numbers):
        return CurvedStem(numbers, position)
    return Stem(numbers, position)
