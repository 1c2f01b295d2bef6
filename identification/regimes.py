"""Regimes of a record: its samples by the mode of the stem, the place along the travel and the time."""

from __future__ import annotations

import numpy as np

from identification.experiment import Experiment

AFTER_REVERSAL = 1.0
"""Seconds after the stem has started the other way that count as just after a reversal."""

LIKE_THE_BAND = 0.02
"""Share of the travel next to the highest and lowest reading that counts as near a stop."""


def masks_of(experiment: Experiment, mode: np.ndarray) -> dict[tuple[str, str], np.ndarray]:
    """Return the samples of each regime, by its name and its words."""
    time, position = experiment.time, experiment.position
    low, high = np.nanquantile(position, [0.002, 0.998])
    thirds = low + (high - low) * np.array([1.0, 2.0]) / 3.0
    third_of_time = time[-1] / 3.0
    first_third, second_third = experiment.start + third_of_time, experiment.start + 2.0 * third_of_time
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
        ("early", f"in the first third of the record, before {first_third:.0f} s"): time < third_of_time,
        ("late", f"in the last third of the record, after {second_third:.0f} s"): time > 2.0 * third_of_time,
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
