"""Regimes: in which modes, places and times of a record a residual is large."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from identification.experiment import Experiment

AFTER_REVERSAL = 1.0
"""Seconds after the stem has started the other way that count as just after a reversal."""

LIKE_THE_BAND = 0.02
"""Share of the travel next to the highest and lowest reading that counts as near a stop."""


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
    """Return the regimes of a residual, the one with the largest error first.

    Parameters
    ----------
    experiments : sequence of Experiment
    residuals : sequence of arrays, each of shape (n,) [m]
        Measured less simulated position.
    modes : sequence of arrays, each of shape (n,)
        Of the simulation: 1 rising, 0 stuck, -1 falling.
    """
    parts: dict[tuple[str, str], list[np.ndarray]] = {}
    for experiment, residual, mode in zip(experiments, residuals, modes, strict=True):
        known = np.isfinite(residual)
        for key, mask in masks_of(experiment, mode).items():
            parts.setdefault(key, []).append(residual[mask & known])
    everything = np.concatenate([residual[np.isfinite(residual)] for residual in residuals])
    whole = float(np.sum(everything**2)) or 1.0
    found = []
    for (name, where), pieces in parts.items():
        error = np.concatenate(pieces)
        if len(error) >= max(10, 0.005 * len(everything)):
            square = float(np.sum(error**2))
            rms = float(np.sqrt(square / len(error)))
            found.append(Regime(name, where, rms, square / whole, len(error) / len(everything)))
    return sorted(found, key=lambda regime: -regime.rms)


def masks_of(experiment: Experiment, mode: np.ndarray) -> dict[tuple[str, str], np.ndarray]:
    """Return the samples of each regime, by its name and its words."""
    time, position = experiment.time, experiment.position
    low, high = np.nanquantile(position, [0.002, 0.998])
    thirds = low + (high - low) * np.array([1.0, 2.0]) / 3.0
    third_of_time = time[-1] / 3.0
    margin = LIKE_THE_BAND * (high - low)
    since = time_since_reversal(time, mode)
    return {
        ("rising", "while the stem rises"): mode > 0,
        ("falling", "while the stem falls"): mode < 0,
        ("stuck", "while the stem is stuck"): mode == 0,
        ("after_reversal", "in the first second after a reversal"): (since < AFTER_REVERSAL) & (mode != 0),
        ("low", f"in the lower third of the travel, below {thirds[0] * 1e3:.0f} mm"): position < thirds[0],
        ("middle", "in the middle third of the travel"): (position >= thirds[0]) & (position <= thirds[1]),
        ("high", f"in the upper third of the travel, above {thirds[1] * 1e3:.0f} mm"): position > thirds[1],
        ("near_stop", "at the ends of the travel"): (position < low + margin) | (position > high - margin),
        ("early", f"in the first third of the record, before {third_of_time:.0f} s"): time < third_of_time,
        ("late", f"in the last third of the record, after {2 * third_of_time:.0f} s"): time > 2.0 * third_of_time,
    }


def time_since_reversal(time: np.ndarray, mode: np.ndarray) -> np.ndarray:
    """Return the time since the stem last started the other way; infinite before the first reversal. [s]"""
    since = np.full(len(time), np.inf)
    moving = np.flatnonzero(mode != 0)
    reversals = moving[1:][np.diff(mode[moving]) != 0]
    if len(reversals):
        last = np.searchsorted(reversals, np.arange(len(time)), side="right") - 1
        after = last >= 0
        since[after] = time[after] - time[reversals[last[after]]]
    return since
