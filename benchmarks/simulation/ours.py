"""The toolkit as the benchmark runs it; what its accuracies are is said here alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.simulation.workload import PERIOD, Stem
from identification.problem import SEARCH_TOLERANCE
from valvemodel import chain, runs
from valvemodel.model import Model
from valvemodel.parameters import MEMORY, STATE
from valvemodel.trajectory import TOLERANCE


@dataclass(frozen=True)
class Accuracy:
    """How finely what has no closed form is integrated."""

    tolerance: float


DEFAULT = Accuracy(TOLERANCE)
SEARCH = Accuracy(SEARCH_TOLERANCE)
FINER = Accuracy(1e-2 * TOLERANCE)
"""Much finer than the default, to see what that one leaves over."""


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


class Run:
    """A model over held drives, with room for its output, so that only the simulation is timed."""

    def __init__(self, model: Model, drive: np.ndarray, *, driven_by: int, accuracy: Accuracy = DEFAULT) -> None:
        self.rows, self.drive, self.driven_by, self.accuracy = model.rows(), drive, driven_by, accuracy
        self.time = PERIOD * np.arange(len(drive))
        self.states, self.memories = np.zeros(1, STATE), np.zeros(1, MEMORY)
        self.readings = np.empty((1, len(drive)))

    def __call__(self) -> np.ndarray:
        """Return the readings just before each drive acts, shape (n,). [m]"""
        runs.run_chain(
            self.rows, self.states, self.memories, self.time, self.drive, runs.FREE, self.driven_by,
            self.accuracy.tolerance, self.readings, runs.NONE, runs.NONE,
        )  # fmt: skip
        return self.readings[0]


def stem_run(stem: Stem, pressures: np.ndarray) -> Run:
    """Return the stem problem ready to be run."""
    return Run(model_of(stem), pressures, driven_by=chain.PRESSURE)


def chain_run(model: Model, currents: np.ndarray, accuracy: Accuracy = DEFAULT) -> Run:
    """Return a whole chain under currents ready to be run."""
    return Run(model, currents, driven_by=chain.CURRENT, accuracy=accuracy)
