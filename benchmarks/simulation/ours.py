"""The toolkit on the stem problem."""

from __future__ import annotations

import numpy as np

from benchmarks.simulation.workload import PERIOD, Stem
from valvemodel import chain, runs
from valvemodel.model import Model
from valvemodel.parameters import MEMORY, STATE

TITLE = "valvemodel, one thread"
SUBSTEP, TOLERANCE = 1e-3, 1e-2


def model_of(stem: Stem) -> Model:
    """Return the stem problem as a model."""
    values = {
        "stem_mass": stem.mass,
        "spring_rate": stem.rate,
        "diaphragm_area": stem.area,
        "coulomb_friction": stem.coulomb,
        "viscous_friction": stem.damping,
    }
    return Model("stem problem", values, {"static_friction": {"static_friction_ratio": stem.static / stem.coulomb}})


def run(stem: Stem, pressures: np.ndarray) -> np.ndarray:
    """Return the positions just before each pressure acts. [m]"""
    time = PERIOD * np.arange(len(pressures))
    positions = np.empty((1, len(pressures)))
    runs.run_chain(
        model_of(stem).rows(), np.zeros(1, STATE), np.zeros(1, MEMORY), time, pressures, runs.FREE,
        chain.PRESSURE, SUBSTEP, TOLERANCE, positions, runs.NONE, runs.NONE,
    )  # fmt: skip
    return positions[0]
