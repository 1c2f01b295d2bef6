"""Staircase: how often the measured stem rests on its way, while the model's stem keeps moving."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from identification.experiment import Experiment

STRIDES = (3, 5, 10, 20)
"""Samples over which a movement is looked at; the stride that shows most counts."""

SEEN = 6.0
"""Movement of the model's stem over a stride from which the measured one's can be judged. [noise]"""

RESTS, MOVES = 0.25, 0.6
"""Share of the model's movement below which the measured stem rests, and above which it moves."""


def stops_on_the_way(experiment: Experiment, simulated: np.ndarray) -> int:
    """Count the rests between two movements of the same direction in which the model knows no rest.

    Stick-slip on a slow ramp and a coarse reading show so; a wrong gain, a lag, or a stop at the end do not.

    Parameters
    ----------
    experiment : Experiment
    simulated : array, shape (n,) [m]
        Position of a model.
    """
    return max(_stops(experiment.position, simulated, SEEN * experiment.noise, stride) for stride in STRIDES)


def _stops(measured: np.ndarray, simulated: np.ndarray, least: float, stride: int) -> int:
    if len(measured) <= stride:
        return 0
    movement, expected = (each[stride:] - each[:-stride] for each in (measured, simulated))
    way = np.where(np.abs(expected) > least, np.sign(expected), 0.0)
    count = 0
    for first, last in pairwise([0, *(np.flatnonzero(np.diff(way)) + 1), len(way)]):
        if way[first] == 0.0:
            continue
        share = movement[first:last] / expected[first:last]
        clear = share[(share < RESTS) | (share > MOVES)] > MOVES
        changes = np.diff(clear.astype(int))
        began = np.flatnonzero(clear)[:1]
        count += int((changes[began[0] :] > 0).sum()) if len(began) else 0
    return count
