"""The valve: the four stages one after the other, under currents that are held."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from itertools import pairwise
from math import copysign, isnan, nan

import numpy as np

from valvemodel.model import Model
from valvemodel.reference.electromagnet import Electromagnet, gap
from valvemodel.reference.motion import STOP_SPEED, Stem
from valvemodel.reference.nozzle import behind_leak, resting_pressure
from valvemodel.reference.numbers import numbers_of
from valvemodel.reference.sensor import Sensor, straightened, zero_drift
from valvemodel.reference.stem import balanced_position
from valvemodel.simulation import Trajectory

ROUNDING = 1e-12
"""Instants and durations that differ by less are equal but for rounding. [s]"""


class Valve:
    """A valve at rest under a current, and then under what currents it is given."""

    def __init__(self, model: Model, current: float, start_reading: float) -> None:
        self.numbers = n = numbers_of(model)
        self.electromagnet = Electromagnet(n, current)
        self.pressure = self.pressure_now(0.0)
        position = balanced_position(n, self.pressure)
        if not isnan(start_reading):
            position = straightened(n, start_reading - zero_drift(n, 0.0))
        self.stem = Stem(n, position)
        self.sensor = Sensor(n, self.stem.position)
        # The linkage may start anywhere in its play.
        self.stem.position -= n.backlash_start * n.backlash_half_width

    def pressure_now(self, time: float) -> float:
        """Return the pressure at the actuator. [Pa]"""
        current = self.electromagnet.current_after(0.0)
        opening = gap(self.numbers, current, time)
        return behind_leak(self.numbers, resting_pressure(self.numbers, opening, current))

    def hold(self, current: float, time: float, duration: float) -> None:
        """Hold a current at the coil from a time for a duration."""
        self.electromagnet.hold(current)
        self.pressure = self.pressure_now(time)
        for motion, used in self.stem.hold(self.pressure, duration):
            self.sensor.follow(motion, used)
        self.electromagnet.advance(duration)

    @property
    def mode(self) -> float:
        """1 rising, 0 stuck, -1 falling."""
        velocity = self.stem.velocity
        return 0.0 if abs(velocity) < STOP_SPEED else copysign(1.0, velocity)


def simulate_slowly(model: Model, *, time: np.ndarray, current: np.ndarray, start_position: float = nan) -> Trajectory:
    """Simulate a valve in plain Python, to see what `simulate` does and to check it; a thousand times slower.

    Parameters
    ----------
    model : Model
    time : array, shape (n,), increasing [s]
    current : array, shape (n,) [A]
        Held from each row to the next.
    start_position : float
        Reading at the start; by default at rest in the middle of the stuck band. [m]

    Returns
    -------
    Trajectory

    References
    ----------
    Paper eqs. (1)-(6), (16), (31), (33); each effect's source is in its declaration.
    """
    clock = [float(instant - time[0]) for instant in time]
    drive = [float(each) for each in current]
    valve = Valve(model, drive[0], start_position)
    rows = [(valve.pressure, valve.sensor.reading(0.0), valve.mode)]
    arrival = [instant + valve.numbers.transport_delay for instant in clock]
    duration = nan
    for start, end in pairwise(clock):
        # Durations that differ by rounding alone are one.
        if not abs(end - start - duration) <= ROUNDING:
            duration = end - start
        for held, begin, lasting in out_of_the_line(arrival, drive, start, start + duration):
            valve.hold(held, begin, lasting)
        rows.append((valve.pressure, valve.sensor.reading(end), valve.mode))
    pressure, position, mode = (np.array(column) for column in zip(*rows, strict=True))
    return Trajectory(
        time=np.asarray(time, float),
        current=np.asarray(current, float),
        pressure=pressure,
        position=position,
        mode=mode,
    )


def out_of_the_line(
    arrival: list[float], drive: list[float], start: float, end: float
) -> Iterator[tuple[float, float, float]]:
    """Yield the currents that the line lets out between two instants: which, from when, for how long."""
    first = bisect_right(arrival, start + ROUNDING)
    last = bisect_left(arrival, end - ROUNDING)
    drives = [drive[max(first - 1, 0)], *drive[first:last]]
    switches = [start, *arrival[first:last], end]
    for held, begin, finish in zip(drives, switches, switches[1:], strict=False):
        yield held, begin, finish - begin
