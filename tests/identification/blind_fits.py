"""Fits to blind plants that the identification's tests share."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from diagnosis.blindtest.plants import Plant, draw_plant, measure, write_record
from identification.extension import extend
from identification.fit import Fit, fit_base
from identification.holdout import hold_out
from identification.timing import experiments_of
from valvemodel.model import Model
from valvemodel.records import read_record
from valvemodel.valves import read_valve


def fits_to_plant(
    seed: int, key: str, folder: Path, *, profile: int | None = None, nuisance: bool = False
) -> tuple[Plant, Fit, Fit]:
    """Return a plant with an effect, and the fits to its record without the effect and with it."""
    plant, base = base_of_plant(seed, (key,), folder, profile=profile, nuisance=nuisance)
    return plant, base, extend(base, key)


def base_of_plant(
    seed: int, keys: Sequence[str], folder: Path, *, profile: int | None = None, nuisance: bool = False
) -> tuple[Plant, Fit]:
    """Return a plant with some effects, and the base valve fitted to its record."""
    plant = draw_plant(seed, keys, nuisance=nuisance)
    return plant, base_of_record(measure(plant, seed + 7 if profile is None else profile), folder)


def base_of_record(measurement: dict[str, np.ndarray], folder: Path) -> Fit:
    """Return the base valve fitted to what was measured."""
    path = folder / "record.csv"
    write_record(path, measurement)
    experiments, _ = experiments_of([read_record(path)])
    holdout = hold_out(experiments)
    valve = read_valve("calibrated")
    return fit_base(Model(valve.name, valve.values), holdout.experiments, holdout.fitted)
