"""The stem problem that all solve: pressures held over periods, stick, slip, breakaway and stop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

PERIOD = 0.01
"""Control period. [s]"""

LOWEST, HIGHEST = 40e3, 240e3
"""Range of the pressures. [Pa]"""

STOP_SPEED = 1e-6
"""Below this speed a slip has ended where friction holds the stem. [m/s]"""


@dataclass(frozen=True)
class Stem:
    """m v' = S P - k y - F_c sign(v) - f_v v while it slips; at rest it holds up to F_s."""

    damping: float
    mass: float = 1.36
    rate: float = 52500.0
    area: float = 0.0645
    coulomb: float = 1423.0
    static: float = 1708.0

    def net(self, position: float, pressure: float) -> float:
        """Return the force on the stem, all but friction. [N]"""
        return self.area * pressure - self.rate * position

    def is_stuck(self, position: float, velocity: float, pressure: float) -> bool:
        """Return whether friction holds the stem."""
        return abs(velocity) < STOP_SPEED and abs(self.net(position, pressure)) <= self.static

    def rest(self, pressure: float) -> float:
        """Return the middle of the stuck band. [m]"""
        return self.area * pressure / self.rate


STEMS = {"A": Stem(damping=612.9), "B": Stem(damping=1.59)}
"""A is overdamped, B rings at 31 Hz."""


def triangle(periods: int) -> np.ndarray:
    """Return pressures that rise and fall over the range within 20 s, shape (periods,). [Pa]"""
    phase = np.arange(periods) * PERIOD / 20.0 % 1.0
    return LOWEST + (HIGHEST - LOWEST) * (1.0 - np.abs(2.0 * phase - 1.0))


def steps(periods: int) -> np.ndarray:
    """Return pressures that jump anywhere in the range every half second, shape (periods,). [Pa]"""
    lasting = round(0.5 / PERIOD)
    levels = np.random.default_rng(1).uniform(LOWEST, HIGHEST, periods // lasting + 1)
    return np.repeat(levels, lasting)[:periods]


class PositionLoop:
    """A sampled PI that follows a set point of slow waves and steps."""

    GAIN, RATE = 4e5, 8e5
    """Proportional [Pa/m] and integral [Pa/(m s)]."""

    def __init__(self) -> None:
        self.integral = 140e3

    def pressure(self, sample: int, position: float) -> float:
        """Return the pressure for the period that begins. [Pa]"""
        error = set_point(sample) - position
        self.integral = min(max(self.integral + self.RATE * PERIOD * error, LOWEST), HIGHEST)
        return min(max(self.integral + self.GAIN * error, LOWEST), HIGHEST)


def set_point(sample: int) -> float:
    """Return a staircase of five levels with 4 s a level. [m]"""
    return (0.10, 0.19, 0.14, 0.24, 0.08)[int(sample * PERIOD / 4.0) % 5]
