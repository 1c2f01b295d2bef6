"""Sensor: from the stem's position to the reading."""

from __future__ import annotations

from itertools import pairwise
from math import asin, atan, ceil, exp, floor, sqrt
from types import SimpleNamespace

import numpy as np

from valvemodel.reference.electromagnet import crept
from valvemodel.reference.instant import first_instant
from valvemodel.reference.lags import answer_of_both
from valvemodel.reference.slip import Motion

NODES = [(float(node), float(weight)) for node, weight in zip(*np.polynomial.legendre.leggauss(12), strict=True)]
"""Gauss-Legendre nodes and weights on -1..1."""

PANEL = 1e-3
"""Longest panel of the quadrature: far below the time constants of stem and transmitter. [s]"""


class Sensor:
    """Linkage and transmitter."""

    def __init__(self, numbers: SimpleNamespace, position: float) -> None:
        self.numbers = numbers
        # A worn joint has two plays side by side; the linkage goes half the way of each.
        self.half_widths = [numbers.backlash_half_width * (1.0 + sign * numbers.backlash_wear) for sign in (-1.0, 1.0)]
        spread = numbers.backlash_start * numbers.backlash_half_width * numbers.backlash_wear
        self.parts = [position - spread, position + spread]
        self.filtered = self.lagged = bowed(numbers, position)
        # Two lags in series may stand in either order.
        self.shorter, self.longer = sorted((numbers.sensor_time_constant, numbers.sensor_second_time_constant))

    @property
    def linkage(self) -> float:
        """Where the linkage is. [m]"""
        return 0.5 * sum(self.parts)

    def follow(self, motion: Motion, duration: float) -> None:
        """Follow a stem that moves to one side for a duration."""
        before = self.parts

        def part(number: int, instant: float) -> float:
            """Play: the stem takes the part along once it touches."""
            position, play = motion(instant)[0], self.half_widths[number]
            return min(max(before[number], position - play), position + play)

        def linkage(instant: float) -> float:
            return 0.5 * (part(0, instant) + part(1, instant))

        def touch(number: int) -> float:
            return first_instant(lambda instant: part(number, instant) != before[number], duration)

        self.parts = [part(number, duration) for number in (0, 1)]
        if self.longer == 0.0:
            return
        touched = [touch(number) for number in (0, 1) if self.parts[number] != before[number]]
        kinks = sorted({*touched, duration})
        self.approach(lambda _: 0.5 * sum(before), 0.0, kinks[0])
        for start, end in pairwise(kinks):
            panels = ceil((end - start) / PANEL)
            for panel in range(panels):
                width = (end - start) / panels
                self.approach(linkage, start + panel * width, width)

    def approach(self, linkage, start: float, duration: float) -> None:
        """Lags: T q' = z - q, T2 r' = q - r; their solution as integrals over the linkage's positions z."""
        end = bowed(self.numbers, linkage(start + duration))
        # q - z and r - z die out; only what z lacks of its end is summed, so that a linkage at rest is exact.
        once, twice = 0.0, 0.0
        for node, weight in NODES:
            share = 0.5 * (1.0 + node)
            lack = 0.5 * weight * duration * (bowed(self.numbers, linkage(start + share * duration)) - end)
            left = (1.0 - share) * duration
            once += lack * exp(-left / self.longer) / self.longer
            twice += lack * answer_of_both(self.longer, self.shorter, left)
        began = (self.lagged - end) * self.longer * answer_of_both(self.longer, self.shorter, duration)
        dying = (self.filtered - end) * exp(-duration / self.shorter) if self.shorter > 0.0 else 0.0
        self.lagged = end + (self.lagged - end) * exp(-duration / self.longer) + once
        self.filtered = end + dying + began + twice

    def reading(self, time: float) -> float:
        """Return what the sensor reads at a time since the start: drift added, rounded to its grid. [m]"""
        n = self.numbers
        reading = self.filtered if self.longer > 0.0 else bowed(n, self.linkage)
        reading += zero_drift(n, time)
        if n.resolution == 0.0:
            return reading
        return n.resolution_offset + n.resolution * floor((reading - n.resolution_offset) / n.resolution + 0.5)


def zero_drift(n: SimpleNamespace, time: float) -> float:
    """Return how far the zero has crept. [m]"""
    return n.sensor_drift_rate * crept(time, n.sensor_drift_time, n.sensor_drift_creep)


def bowed(n: SimpleNamespace, position: float) -> float:
    """Return what a bowed and skewed linkage indicates. [m]"""
    share = position / n.rated_travel
    if n.linkage_arm and n.linkage_skew != 0.0:
        low, here, high = (turned(n, each) for each in (0.0, share, 1.0))
        return n.rated_travel * (here - low) / (high - low)
    skew = 0.5 * sqrt(27.0) * n.linkage_skew * (1.0 - 2.0 * share)
    return position + 4.0 * share * (1.0 - share) * (n.linkage_bow + skew)


def turned(n: SimpleNamespace, share: float) -> float:
    """Return the angle of an arm at a share of the travel, in a slot where the skew is negative, else on a rod."""
    skew = 0.5 * sqrt(27.0) * n.linkage_skew
    lever = sqrt((24.0 if skew < 0.0 else 48.0) * abs(skew) / n.rated_travel)
    way = lever * (share - 0.5 - n.linkage_bow / (6.0 * skew))
    if skew < 0.0:
        return atan(way)
    # Near its dead point the arm goes on as steeply as there.
    inside = min(max(way, -0.98), 0.98)
    return asin(inside) + (way - inside) / sqrt(1.0 - inside**2)


def straightened(n: SimpleNamespace, reading: float) -> float:
    """Return the position at which a bowed linkage gives a reading, by iteration. [m]"""
    position = reading
    for _ in range(400):
        position += 0.2 * (reading - bowed(n, position))
    return position
