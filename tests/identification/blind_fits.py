"""Fits to blind plants that the identification's tests share."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from diagnosis.blindtest.plants import Plant, draw_plant, measure, write_record
from identification.driving.timing import experiments_of
from identification.extending.extension import extend
from identification.fit import Fit, fit_base
from identification.holdout import hold_out
from valvemodel.model import Model
from valvemodel.records import read_record
from valvemodel.valves import read_valve


@cache
def fits_to_plant(seed: int, key: str, *, profile: int | None = None, nuisance: bool = False) -> tuple[Plant, Fit, Fit]:
    """Return a plant with an effect, and the fits to its record without the effect and with it, made once for each."""
    plant, base = base_of_plant(seed, (key,), profile=profile, nuisance=nuisance)
    return plant, base, extend(base, key)


@cache
def base_of_plant(
    seed: int, keys: tuple[str, ...], *, profile: int | None = None, nuisance: bool = False
) -> tuple[Plant, Fit]:
    """Return a plant with some effects, and the base valve fitted to its record, made once for each."""
    plant = draw_plant(seed, keys, nuisance=nuisance)
    return plant, base_of_record(measure(plant, seed + 7 if profile is None else profile))


def base_of_record(measurement: dict[str, np.ndarray]) -> Fit:
    """Return the base valve fitted to what was measured and written to a file."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "record.csv"
        write_record(path, measurement)
        experiments, _ = experiments_of([read_record(path)])
    holdout = hold_out(experiments)
    valve = read_valve("calibrated")
    return fit_base(Model(valve.name, valve.values), holdout.experiments, holdout.fitted)
