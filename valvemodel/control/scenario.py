"""A scenario: what a closed loop is asked to do and what disturbs it, period by period."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from valvemodel.errors import InputError

LEAST_PERIODS = 10
"""Shorter steps cannot be measured."""

SHORTEST_PERIOD, LONGEST_PERIOD = 1e-4, 10.0
"""Of a controller. [s]"""


@dataclass(frozen=True)
class Scenario:
    """Set points, loads, noise and resolution of a run.

    Parameters
    ----------
    period : float
        Of the controller. [s]
    setpoint : array, shape (n,) [m]
    load : array, shape (n,) [N]
        Force on the stem beyond the model's own, positive against a rise.
    noise : array, shape (n,) [m]
        Added to what the sensor gives.
    resolution : float
        Step in which the controller receives the noisy reading; 0 for none. [m]
    """

    period: float
    setpoint: np.ndarray
    load: np.ndarray
    noise: np.ndarray
    resolution: float = 0.0

    def __post_init__(self) -> None:
        check_conditions(period=self.period, resolution=self.resolution)
        rows = (self.setpoint, self.load, self.noise)
        if len({row.shape for row in rows}) != 1 or self.setpoint.ndim != 1 or len(self.setpoint) < 2:
            raise InputError(
                "set point, load and noise have a value for each period, two at least",
                f"got shapes {', '.join(str(row.shape) for row in rows)}",
                "make them equally long",
            )
        if not all(np.isfinite(row).all() for row in rows):
            raise InputError("set point, load and noise are finite", "got a value that is not", "correct it")

    @property
    def time(self) -> np.ndarray:
        """Instants at which the controller acts, shape (n,), as they add up in the loop. [s]"""
        return np.concatenate(([0.0], np.cumsum(np.full(len(self.setpoint) - 1, self.period))))

    @property
    def steps(self) -> list[slice]:
        """The parts of constant set point."""
        edges = np.flatnonzero(np.diff(self.setpoint)) + 1
        starts = [0, *edges.tolist()]
        return [slice(start, stop) for start, stop in zip(starts, [*starts[1:], len(self.setpoint)], strict=True)]


def held_levels(
    levels: Sequence[float],
    *,
    duration: float,
    period: float,
    noise: float = 0.0,
    resolution: float = 0.0,
    load: float = 0.0,
    seed: int = 0,
) -> Scenario:
    """Return a scenario that holds one set point after the other.

    Parameters
    ----------
    levels : sequence of float [m]
    duration : float
        For which each is held. [s]
    period : float [s]
    noise : float
        Standard deviation of white Gaussian noise. [m]
    resolution : float [m]
    load : float
        That acts in the second half of each level. [N]
    seed : int
        Of the noise.
    """
    check_conditions(period=period, noise=noise, resolution=resolution)
    if not duration >= LEAST_PERIODS * period or not np.isfinite(duration):
        raise InputError(
            f"a set point is held for {LEAST_PERIODS} periods at least",
            f"got {duration:g} s at a period of {period:g} s",
            "give a longer duration or a shorter period",
        )
    each = round(duration / period)
    setpoint = np.repeat(np.asarray(levels, float), each)
    loads = np.tile(np.where(np.arange(each) < each // 2, 0.0, load), len(levels))
    drawn = np.random.default_rng(seed).normal(size=len(setpoint))
    return Scenario(period, setpoint, loads, noise * drawn, resolution)


def check_conditions(*, period: float, noise: float = 0.0, resolution: float = 0.0) -> None:
    """Refuse a period, a noise or a resolution that no controller has.

    Raises
    ------
    InputError
        If the period is outside `SHORTEST_PERIOD`..`LONGEST_PERIOD` or a length is negative or not finite.
    """
    if not SHORTEST_PERIOD <= period <= LONGEST_PERIOD:
        raise InputError(
            f"a controller period lies in {1e3 * SHORTEST_PERIOD:g} ms..{LONGEST_PERIOD:g} s",
            f"got {period:g} s",
            'write it like "10 ms"',
        )
    for name, length in (("noise", noise), ("resolution", resolution)):
        if not (length >= 0.0 and np.isfinite(length)):
            raise InputError(f"the {name} of a reading is not negative", f"got {length:g} m", "give 0 mm for none")
