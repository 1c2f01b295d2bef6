"""Settled loops: currents in steps of half a milliampere, each held until the stem has come to rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from valvemodel.model import Model
from valvemodel.simulation import simulate

STEP = 0.5e-3
"""Of the current, as the paper's text has it. [A]"""

HOLD = 5.0
"""For which each current is held. [s]"""


@dataclass(frozen=True)
class SettledLoop:
    """Settled pairs in the order taken, and the part of the sweep that each ends.

    Attributes
    ----------
    current, pressure, position : arrays, shape (n,) [A], [Pa], [m]
    part : array of int, shape (n,)
        0 for the first sweep, 1 for the next, and so on.
    """

    current: np.ndarray
    pressure: np.ndarray
    position: np.ndarray
    part: np.ndarray

    def as_json(self) -> dict[str, object]:
        """Return the data with their units."""
        return {
            "current": {"value": self.current, "unit": "A"},
            "pressure": {"value": self.pressure, "unit": "Pa"},
            "position": {"value": self.position, "unit": "m"},
            "part": self.part,
        }


def settled_loop(model: Model, corners: Sequence[float], *, start_position: float = math.nan) -> SettledLoop:
    """Return where the stem settles while the current goes from corner to corner in steps.

    Parameters
    ----------
    model : Model
    corners : sequence of float
        Currents between which the direction stays. [A]
    start_position : float
        Reading at the first corner; by default at rest in the middle of the stuck band. [m]
    """
    currents, parts = [corners[0]], [0]
    for part, (start, end) in enumerate(pairwise(corners)):
        count = round(abs(end - start) / STEP)
        currents += list(start + (end - start) * np.arange(1, count + 1) / count)
        parts += [part] * count
    # A row shows the state before its current acts: the last current is held once more to be seen.
    held = np.array([*currents, currents[-1]])
    run = simulate(model, time=HOLD * np.arange(len(held)), current=held, start_position=start_position)
    return SettledLoop(held[:-1], run.pressure[1:], run.position[1:], np.array(parts))
