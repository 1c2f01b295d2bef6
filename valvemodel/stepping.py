"""A valve that is stepped, period by period: what a controller acts on."""

from __future__ import annotations

import math

import numpy as np

from valvemodel import chain
from valvemodel.compiled import compiled
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.parameters import MEMORY, STATE
from valvemodel.stages.sensor import read_sensor
from valvemodel.trajectory import TOLERANCE


@compiled
def _start(rows, states, memories, current, time, tolerance):
    """Put a valve at rest and return its reading. [m]"""
    chain.start_chain(rows[0], states[0], memories[0], current, chain.CURRENT, time, tolerance)
    return read_sensor(rows[0], states[0], time)


@compiled
def _advance(rows, states, memories, current, time, following, tolerance):
    """Hold a current from an instant to the following one and return the reading there. [m]"""
    chain.advance_period(rows[0], states[0], memories[0], current, time, following - time, tolerance)
    return read_sensor(rows[0], states[0], following)


class SteppedValve:
    """A valve whose state is kept between calls, so that what drives it may depend on what it reads.

    Stepped along a record's times it gives the readings of `simulate` to the last bit.

    Parameters
    ----------
    model : Model
    current : float
        Under which it is at rest at the start. [A]
    start_position : float
        Reading at the start; by default at rest in the middle of the stuck band. [m]
    tolerance : float
        As in `simulate`. [m]

    Attributes
    ----------
    time : float
        Since the start. [s]
    reading : float
        What the sensor reads now; all that a controller may see. [m]

    Examples
    --------
    >>> valve = SteppedValve(model, current=12e-3)
    >>> for _ in range(100):
    ...     valve.step(12e-3 + 0.05 * (0.15 - valve.reading), 0.01)
    """

    def __init__(
        self,
        model: Model,
        *,
        current: float,
        start_position: float = math.nan,
        tolerance: float = TOLERANCE,
    ) -> None:
        self.time = 0.0
        self._tolerance = tolerance
        self._rows = model.rows(start_position=start_position)
        self._preload = float(self._rows["spring_preload"][0])
        self._states = np.zeros(1, STATE)
        self._memories = np.zeros(1, MEMORY)
        self.reading: float = _start(self._rows, self._states, self._memories, _checked(current), 0.0, tolerance)

    def step(self, current: float, duration: float) -> float:
        """Hold a current [A] for a duration [s] and return the reading at its end. [m]

        Raises
        ------
        InputError
            If the current is negative or not finite, or the duration not positive; the valve stays as it is.
        """
        following = self.time + duration
        if not following > self.time or not math.isfinite(following):
            raise InputError("a step takes time", f"got a duration of {duration} s", "give a positive one")
        self.reading = _advance(
            self._rows, self._states, self._memories, _checked(current), self.time, following, self._tolerance
        )
        self.time = following
        return self.reading

    @property
    def load(self) -> float:
        """Force on the stem beyond the model's own, positive against a rise; may be set between steps. [N]"""
        return float(self._rows["spring_preload"][0]) - self._preload

    @load.setter
    def load(self, force: float) -> None:
        self._rows["spring_preload"][0] = self._preload + force

    @property
    def position(self) -> float:
        """The stem's true position. [m]"""
        return float(self._states["position"][0])

    @property
    def velocity(self) -> float:
        """The stem's speed, positive when rising. [m/s]"""
        return float(self._states["velocity"][0])

    @property
    def pressure(self) -> float:
        """The pressure at the actuator. [Pa]"""
        return float(self._states["pressure"][0])

    @property
    def mode(self) -> float:
        """1 rising, 0 stuck, -1 falling."""
        return float(chain.mode_of(self._states[0]))


def _checked(current: float) -> float:
    if not (math.isfinite(current) and current >= 0.0):
        raise InputError("a current is a number from 0 A on", f"got {current} A", "correct it")
    return float(current)
