"""Regimes: in which modes, places and times of a record a residual is large."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from identification.experiment import Experiment
from identification.results.regimes import masks_of, words_of


@dataclass(frozen=True)
class Regime:
    """One part of a record: where in words, the error there, its share of the squared error and of the time."""

    name: str
    where: str
    rms: float
    share: float
    time_share: float


def regimes_of(
    experiments: Sequence[Experiment], residuals: Sequence[np.ndarray], modes: Sequence[np.ndarray]
) -> list[Regime]:
    """Return the regimes of a residual, each once for all experiments, the one with the largest error first.

    Parameters
    ----------
    experiments : sequence of Experiment
    residuals : sequence of arrays, each of shape (n,) [m]
        Measured less simulated position.
    modes : sequence of arrays, each of shape (n,)
        Of the simulation: 1 rising, 0 stuck, -1 falling.
    """
    parts: dict[str, list[np.ndarray]] = {}
    for experiment, residual, mode in zip(experiments, residuals, modes, strict=True):
        known = np.isfinite(residual)
        for name, mask in masks_of(experiment, mode).items():
            parts.setdefault(name, []).append(residual[mask & known])
    everything = np.concatenate([residual[np.isfinite(residual)] for residual in residuals])
    whole = float(np.sum(everything**2)) or 1.0
    words, found = words_of(experiments), []
    for name, pieces in parts.items():
        error = np.concatenate(pieces)
        if len(error) >= max(10, 0.005 * len(everything)):
            square = float(np.sum(error**2))
            rms = float(np.sqrt(square / len(error)))
            found.append(Regime(name, words[name], rms, square / whole, len(error) / len(everything)))
    return sorted(found, key=lambda regime: -regime.rms)
