"""Simulate a model over held currents; one door to the compiled chain."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from valvemodel import chain, runs
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.parameters import MEMORY, STATE

SUBSTEP = 1e-3
"""Longest part of a period while the pressure moves under a held current. [s]"""

TOLERANCE = 1e-2
"""Force left over by one linearised slip step. [N]"""

MODE_NAMES = {-1.0: "falling", 0.0: "stuck", 1.0: "rising"}


@dataclass(frozen=True)
class Trajectory:
    """What a simulation gives, a row for each input row: the state just before the current of that row acts.

    Attributes
    ----------
    time : array, shape (n,) [s]
    current : array, shape (n,) [A]
    pressure : array, shape (n,) [Pa]
    position : array, shape (n,) [m]
        The sensor's reading.
    mode : array, shape (n,)
        1 rising, 0 stuck, -1 falling.
    """

    time: np.ndarray
    current: np.ndarray
    pressure: np.ndarray
    position: np.ndarray
    mode: np.ndarray

    @property
    def mode_names(self) -> list[str]:
        """The mode of each row in words."""
        return [MODE_NAMES[mode] for mode in self.mode.tolist()]


def simulate(
    model: Model,
    *,
    time: np.ndarray,
    current: np.ndarray,
    start_position: float = math.nan,
    substep: float = SUBSTEP,
    tolerance: float = TOLERANCE,
) -> Trajectory:
    """Simulate a valve under currents that are held from each row to the next.

    The base model is exact: stick and slip by mode, stops and breakaways in closed form, no step size. Effects that
    move the pressure within a period are integrated in parts; nonlinear slips in steps of controlled error.

    Parameters
    ----------
    model : Model
    time : array, shape (n,), increasing [s]
    current : array, shape (n,) [A]
    start_position : float
        Reading at the start; by default at rest in the middle of the stuck band. [m]
    substep : float
        Longest part of a period while the pressure moves. [s]
    tolerance : float
        Force left over by one linearised slip step. [N]

    Returns
    -------
    Trajectory

    Raises
    ------
    InputError
        If shapes differ, time does not increase or a current is negative or not finite.

    References
    ----------
    Paper eqs. (1)-(6), (16), (31), (33); mode rule of the stop speed.
    """
    time = np.ascontiguousarray(time, float)
    current = np.ascontiguousarray(current, float)
    _check_input(time, current)
    rows = model.rows(start_position=start_position)
    states = np.zeros(1, STATE)
    position, pressure, mode = (np.empty((1, len(time))) for _ in range(3))
    runs.run_chain(
        rows, states, np.zeros(1, MEMORY), time - time[0], current, runs.FREE, chain.CURRENT, substep, tolerance,
        position, pressure, mode,
    )  # fmt: skip
    return Trajectory(time, current, pressure[0], position[0], mode[0])


def _check_input(time: np.ndarray, current: np.ndarray) -> None:
    if time.ndim != 1 or time.shape != current.shape or len(time) == 0:
        raise InputError(
            "time and current are two rows of equal length",
            f"got shapes {time.shape} and {current.shape}",
            "cut one",
        )
    if not np.all(np.diff(time) > 0.0):
        row = int(np.argmin(np.diff(time)))
        raise InputError(
            "time must increase",
            f"row {row + 1} has {time[row + 1]} s after {time[row]} s",
            "sort or drop the row",
        )
    bad = ~np.isfinite(current) | (current < 0.0)
    if bad.any():
        row = int(np.argmax(bad))
        raise InputError("a current is a number from 0 A on", f"row {row} has {current[row]} A", "correct it")
