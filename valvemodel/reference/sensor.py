"""Sensor: from the stem's position to the reading."""

from __future__ import annotations

from math import ceil, exp, expm1, floor, sqrt
from types import SimpleNamespace

import numpy as np

from valvemodel.reference.instant import first_instant
from valvemodel.reference.slip import Motion

NODES = [(float(node), float(weight)) for node, weight in zip(*np.polynomial.legendre.leggauss(12), strict=True)]
"""Gauss-Legendre nodes and weights on -1..1."""

PANEL = 1e-3
"""Longest panel of the quadrature: far below the time constants of stem and transmitter. [s]"""


class Sensor:
    """Linkage and transmitter."""

    def __init__(self, numbers: SimpleNamespace, position: float) -> None:
        self.numbers = numbers
        self.linkage = position
        self.filtered = self.lagged = bowed(numbers, position)
        # Two lags in series may stand in either order.
        self.shorter, self.longer = sorted((numbers.sensor_time_constant, numbers.sensor_second_time_constant))

    def follow(self, motion: Motion, duration: float) -> None:
        """Follow a stem that moves to one side for a duration."""
        before = self.linkage

        def linkage(instant: float) -> float:
            """Play: the stem takes the linkage along once it touches."""
            position = motion(instant)[0]
            play = self.numbers.backlash_half_width
            return min(max(before, position - play), position + play)

        self.linkage = linkage(duration)
        if self.longer == 0.0:
            return
        touch = duration
        if self.linkage != before:
            touch = first_instant(lambda t: linkage(t) != before, duration)
        self.approach(lambda _: before, 0.0, touch)
        panels = ceil((duration - touch) / PANEL)
        for panel in range(panels):
            width = (duration - touch) / panels
            self.approach(linkage, touch + panel * width, width)

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


def answer_of_both(longer: float, shorter: float, time: float) -> float:
    """Return how two lags in series answer an impulse; equal ones too, and one alone. [1/s]"""
    if shorter == 0.0:
        return exp(-time / longer) / longer
    rate = 1.0 / shorter - 1.0 / longer
    share = -expm1(-rate * time) / rate if rate > 0.0 else time
    return exp(-time / longer) * share / longer / shorter


def zero_drift(n: SimpleNamespace, time: float) -> float:
    """Return how far the zero has crept: d T (1 - exp(-t/T)). [m]"""
    return -n.sensor_drift_rate * n.sensor_drift_time * expm1(-time / n.sensor_drift_time)


def bowed(n: SimpleNamespace, position: float) -> float:
    """Return what a bowed and skewed linkage indicates. [m]"""
    share = position / n.rated_travel
    skew = 0.5 * sqrt(27.0) * n.linkage_skew * (1.0 - 2.0 * share)
    return position + 4.0 * share * (1.0 - share) * (n.linkage_bow + skew)


def straightened(n: SimpleNamespace, reading: float) -> float:
    """Return the position at which a bowed linkage gives a reading, by iteration. [m]"""
    position = reading
    for _ in range(60):
        position += reading - bowed(n, position)
    return position
