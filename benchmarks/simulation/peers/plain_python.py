"""The same laws in plain Python: the toolkit's own reference."""

from __future__ import annotations

from functools import partial

import numpy as np

from benchmarks.simulation.ours import model_of
from benchmarks.simulation.workload import PERIOD, Stem
from valvemodel.reference.motion import Stem as PlainStem
from valvemodel.reference.numbers import numbers_of

TITLE = "closed form in plain Python (ours)"
SETTINGS = ("exact",)


def run(stem: Stem, pressures: np.ndarray, setting: str) -> np.ndarray:
    """Return the positions just before each pressure acts. [m]"""
    moving = PlainStem(numbers_of(model_of(stem)), stem.rest(pressures[0]))
    positions = np.empty(len(pressures))
    for sample, pressure in enumerate(pressures.tolist()):
        positions[sample] = moving.position
        for _ in moving.hold(partial(held, pressure), 0.0, PERIOD):
            pass
    return positions


def held(pressure: float, _: float) -> float:
    """Return a pressure that stands still. [Pa]"""
    return pressure
