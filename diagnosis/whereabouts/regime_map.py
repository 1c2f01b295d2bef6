"""The map of a residual: how the stem moves, by where it is and by when."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from identification.experiment import Experiment
from identification.results.regimes import ends_of_travel, is_after_reversal, thirds_between

ROWS = (
    "rising, just after a reversal",
    "rising, later",
    "stuck",
    "falling, just after a reversal",
    "falling, later",
)

COLUMNS = ("low", "middle", "high", "early", "midway", "late")
"""Thirds of the travel, then thirds of the record."""


@dataclass(frozen=True, eq=False)
class RegimeMap:
    """A residual by regime; each of the two halves of the columns covers every sample once.

    Attributes
    ----------
    rms : array, shape (rows, columns) [m]
        NaN where there are no samples.
    share, time_share : arrays, shape (rows, columns)
        Of the squared residual, and of the samples.
    """

    rms: np.ndarray
    share: np.ndarray
    time_share: np.ndarray

    def as_json(self) -> dict[str, Any]:
        """Return the map as diagnosis.json has it, None where there are no samples."""
        return {
            "rows": list(ROWS),
            "columns": list(COLUMNS),
            "unit": "m",
            "rms": [[each if np.isfinite(each) else None for each in row] for row in self.rms.tolist()],
            "share": self.share.tolist(),
            "time_share": self.time_share.tolist(),
        }


def regime_map(
    experiments: Sequence[Experiment], residuals: Sequence[np.ndarray], modes: Sequence[np.ndarray]
) -> RegimeMap:
    """Lay residuals out by how the stem of the model moves, where it is and when.

    Parameters
    ----------
    experiments : sequence of Experiment
    residuals : sequence of arrays, each of shape (n,) [m]
        Measured less simulated position.
    modes : sequence of arrays, each of shape (n,)
        Of the simulation: 1 rising, 0 stuck, -1 falling.
    """
    shape = (len(ROWS), len(COLUMNS))
    squares, counts = np.zeros(shape), np.zeros(shape)
    for experiment, residual, mode in zip(experiments, residuals, modes, strict=True):
        known = np.isfinite(residual)
        row = rows_of(experiment.time, mode)[known]
        for column in columns_of(experiment):
            np.add.at(squares, (row, column[known]), residual[known] ** 2)
            np.add.at(counts, (row, column[known]), 1.0)
    half = len(COLUMNS) // 2
    with np.errstate(invalid="ignore"):
        rms = np.sqrt(squares / np.where(counts > 0.0, counts, np.nan))
    return RegimeMap(rms, squares / (squares[:, :half].sum() or 1.0), counts / (counts[:, :half].sum() or 1.0))


def rows_of(time: np.ndarray, mode: np.ndarray) -> np.ndarray:
    """Return the row of each sample, by direction and time since the last reversal, shape (n,)."""
    is_just_after = is_after_reversal(time, mode)
    return np.where(mode > 0, np.where(is_just_after, 0, 1), np.where(mode < 0, np.where(is_just_after, 3, 4), 2))


def columns_of(experiment: Experiment) -> tuple[np.ndarray, np.ndarray]:
    """Return the columns of each sample: its third of the travel, and its third of the record, each of shape (n,)."""
    low, high = ends_of_travel(experiment.position)
    by_place = np.searchsorted(thirds_between(low, high), np.nan_to_num(experiment.position, nan=low))
    return by_place, 3 + np.searchsorted(thirds_between(0.0, experiment.time[-1]), experiment.time)
