"""Branches of a model: where long slips under held currents end, rising and falling, run on the exact simulator."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from valvemodel.control.laws.settings import HIGHEST_CURRENT, LOWEST_CURRENT
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.simulation import simulate
from valvemodel.stepping import SteppedValve

CURRENTS = 161
"""Currents at which the branches are run: every 0.1 mA."""

SETTLING = 30.0
"""Time for which a current is held: ten of the longest time constants that an effect may have. [s]"""

MOVED = 1e-3
"""Share of the travel that counts as having moved."""

RAMP = 5e-6
"""Step of current by which a breakaway is sought. [A]"""


@dataclass(frozen=True)
class Branches:
    """The two branches of a valve, each strictly rising in both columns.

    Parameters
    ----------
    rising, falling : array, shape (n, 2) [A], [m]
        Current, and the reading where a long slip under it ends.
    slip_jump : float
        Shortest slip from rest. [m]
    """

    rising: np.ndarray
    falling: np.ndarray
    slip_jump: float

    @property
    def lowest(self) -> float:
        """The lowest position that a fall can end at. [m]"""
        return float(min(self.rising[0, 1], self.falling[0, 1]))

    @property
    def highest(self) -> float:
        """The highest position that a rise can end at. [m]"""
        return float(max(self.rising[-1, 1], self.falling[-1, 1]))

    @property
    def reach(self) -> tuple[float, float]:
        """Lowest and highest position that can be reached from both sides. [m]"""
        return (
            float(max(self.rising[0, 1], self.falling[0, 1])),
            float(min(self.rising[-1, 1], self.falling[-1, 1])),
        )

    def rising_current(self, position: np.ndarray | float) -> np.ndarray:
        """Return the current whose rise ends at a position; beyond the branch that of its end. [A]"""
        return np.interp(position, self.rising[:, 1], self.rising[:, 0])

    def falling_current(self, position: np.ndarray | float) -> np.ndarray:
        """Return the current whose fall ends at a position; beyond the branch that of its end. [A]"""
        return np.interp(position, self.falling[:, 1], self.falling[:, 0])

    def width(self, position: np.ndarray | float) -> np.ndarray:
        """Return the width of the loop in current at a position within reach. [A]"""
        return self.rising_current(position) - self.falling_current(position)


def branches_of(model: Model) -> Branches:
    """Run the branches of a model.

    Raises
    ------
    InputError
        If the valve hardly moves within 4..20 mA.
    """
    currents = np.linspace(LOWEST_CURRENT, HIGHEST_CURRENT, CURRENTS)
    rising = _branch(model, currents, LOWEST_CURRENT, 1.0)
    falling = _branch(model, currents, HIGHEST_CURRENT, -1.0)
    found = Branches(rising, falling, 0.0)
    if not found.reach[0] < found.reach[1]:
        raise InputError(
            "a valve to control reaches positions from both sides within 4..20 mA",
            f"{model.name}: friction holds it, or no current moves it",
            "check friction, spring and gap of the model",
        )
    return Branches(rising, falling, _slip_jump(model, found))


def _branch(model: Model, currents: np.ndarray, start: float, side: float) -> np.ndarray:
    """Return currents and readings of the slips from one end of the range that moved the stem one way."""
    rest = _reading_after(model, start, start)
    readings = np.array([_reading_after(model, start, current) for current in currents])
    has_moved = side * (readings - rest) > MOVED * model.values["rated_travel"]
    rows = np.column_stack((currents, readings))[has_moved]
    if len(rows) < 2:
        raise InputError(
            "a valve to control moves both ways within 4..20 mA",
            f"{model.name} does not move from {1e3 * start:g} mA on",
            "check friction, spring and gap of the model",
        )
    is_further = np.r_[True, rows[1:, 1] > np.maximum.accumulate(rows[:-1, 1])]
    return rows[is_further]


def _reading_after(model: Model, start: float, current: float) -> float:
    time = np.array([0.0, SETTLING, 2.0 * SETTLING])
    return float(simulate(model, time=time, current=np.array([start, current, current])).position[-1])


def _slip_jump(model: Model, found: Branches) -> float:
    """Return how far the stem slips at once when a slow rise frees it in the middle of its reach. [m]"""
    moved = MOVED * model.values["rated_travel"]
    current = float(found.rising_current(0.5 * sum(found.reach)))
    valve = SteppedValve(model, current=LOWEST_CURRENT)
    rest = valve.step(current, SETTLING)
    while valve.reading - rest < moved and current < HIGHEST_CURRENT:
        before = valve.reading
        current += RAMP
        valve.step(current, SETTLING)
    return max(valve.reading - before, 0.0) if valve.reading - before > moved else 0.0
