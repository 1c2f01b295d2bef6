"""Admissible currents: a pattern of ramps, steps and dwells between levels, repeated as long as the test lasts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from valvemodel.errors import InputError

SEGMENTS = 8
"""Moves to a level in one pattern."""

NUMBERS_A_SEGMENT = 3
"""Level, rate and dwell, each from 0 to 1."""

SLOWEST_STROKE = 40.0
"""The slowest ramp takes so long through the range. [s]"""

LONGEST_DWELL = 6.0
"""Beyond the shortest one. [s]"""

STANDARD_STROKE = 15.0
"""What a design is compared with: ramps up and down through the range, so long each. [s]"""

FEWEST_SAMPLES = 200

DIGITS = 7
"""A current is written to a tenth of a microampere, finer than any source sets it."""


@dataclass(frozen=True)
class Limits:
    """What a current may do.

    Parameters
    ----------
    low, high : float
        Range. [A]
    rate : float
        Fastest change; infinite where steps are allowed. [A/s]
    dwell : float
        Shortest stay at a level. [s]
    duration : float
        Of the whole test. [s]
    period : float
        Of the samples. [s]

    Raises
    ------
    InputError
        If no such current can be made.
    """

    low: float
    high: float
    rate: float
    dwell: float
    duration: float
    period: float

    def __post_init__(self) -> None:
        if not 0.0 <= self.low < self.high:
            arrived = f"got {1e3 * self.low:g} and {1e3 * self.high:g} mA"
            raise InputError("the range is two currents from 0 on, the lower first", arrived, "change --range")
        if not self.rate > 0.0:
            raise InputError("the fastest change is positive", f"got {1e3 * self.rate:g} mA/s", "change --rate")
        if self.dwell < 0.0:
            raise InputError("the shortest dwell is not negative", f"got {self.dwell:g} s", "change --dwell")
        if not self.period > 0.0 or not self.duration >= FEWEST_SAMPLES * self.period:
            raise InputError(
                f"a test has at least {FEWEST_SAMPLES} samples",
                f"got {self.duration:g} s every {self.period:g} s",
                "raise --duration or lower --period",
            )
        if (self.high - self.low) / self.rate > 0.25 * self.duration:
            raise InputError(
                "a test has time for two strokes there and back",
                f"one stroke takes {(self.high - self.low) / self.rate:g} s of {self.duration:g} s",
                "raise --duration or --rate",
            )

    @property
    def time(self) -> np.ndarray:
        """Sample times, shape (n,). [s]"""
        return self.period * np.arange(round(self.duration / self.period) + 1)


def pattern_current(limits: Limits, numbers: np.ndarray) -> np.ndarray:
    """Return the current of a pattern at the sample times.

    Parameters
    ----------
    limits : Limits
    numbers : array, shape (SEGMENTS * 3,)
        Level, rate and dwell of each move, from 0 to 1.

    Returns
    -------
    array, shape (n,) [A]
    """
    shares = np.asarray(numbers, float).reshape(SEGMENTS, NUMBERS_A_SEGMENT)
    span = limits.high - limits.low
    levels = limits.low + span * shares[:, 0]
    slowest = min(span / SLOWEST_STROKE, limits.rate)
    fastest = min(limits.rate, span / limits.period)
    rates = slowest * (fastest / slowest) ** shares[:, 1]
    dwells = limits.dwell + limits.period + LONGEST_DWELL * shares[:, 2] ** 2
    moves = np.maximum(np.abs(levels - np.roll(levels, 1)) / rates, limits.period)
    # A pattern begins after the dwell at its last level, so that it can follow itself.
    ends = np.cumsum(np.column_stack([moves, dwells]).ravel())
    times = np.concatenate([[0.0], ends])
    values = np.concatenate([[levels[-1]], np.repeat(levels, 2)])
    repeats = math.ceil(limits.duration / ends[-1])
    times = np.concatenate([times[:-1] + number * ends[-1] for number in range(repeats)] + [[repeats * ends[-1]]])
    values = np.concatenate([values[:-1]] * repeats + [values[-1:]])
    return np.round(np.interp(limits.time, times, values), DIGITS)


def standard_ramp(limits: Limits) -> np.ndarray:
    """Return ramps up and down through the range, shape (n,). [A]"""
    stroke = max(min(STANDARD_STROKE, 0.5 * limits.duration), (limits.high - limits.low) / limits.rate)
    share = 1.0 - np.abs((limits.time / stroke) % 2.0 - 1.0)
    return np.round(limits.low + (limits.high - limits.low) * share, DIGITS)
