"""Regimes of a record: its samples by the mode of the stem, the place along the travel and the time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from identification.experiment import Experiment

AFTER_REVERSAL = 1.0
"""Seconds after the stem has started the other way that count as just after a reversal."""

LIKE_THE_BAND = 0.02
"""Share of the travel next to the highest and lowest reading that counts as near a stop."""


def masks_of(experiment: Experiment, mode: np.ndarray) -> dict[str, np.ndarray]:
    """Return the samples of each regime by its name, each an array of bool, shape (n,)."""
    time, position = experiment.time, experiment.position
    low, high = _ends_of_travel(experiment)
    low_third, high_third = _thirds_of_travel(experiment)
    third_of_time = time[-1] / 3.0
    margin = LIKE_THE_BAND * (high - low)
    since = time_since_reversal(time, mode)
    return {
        "rising": mode > 0,
        "falling": mode < 0,
        "stuck": mode == 0,
        "after_reversal": (since < AFTER_REVERSAL) & (mode != 0),
        "low": position < low_third,
        "middle": (position >= low_third) & (position <= high_third),
        "high": position > high_third,
        "near_stop": (position < low + margin) | (position > high - margin),
        "early": time < third_of_time,
        "late": time > 2.0 * third_of_time,
    }


def words_of(experiments: Sequence[Experiment]) -> dict[str, str]:
    """Return where each regime is, in words by its name; a number that differs by experiment is told as a range."""
    low_thirds, high_thirds = 1e3 * np.array([_thirds_of_travel(each) for each in experiments]).T
    first_thirds, last_thirds = np.array([_thirds_of_time(each) for each in experiments]).T
    record = "the record" if len(experiments) == 1 else "each record"
    return {
        "rising": "while the stem rises",
        "falling": "while the stem falls",
        "stuck": "while the stem is stuck",
        "after_reversal": "in the first second after a reversal",
        "low": f"in the lower third of the travel, below {_span(low_thirds)} mm",
        "middle": "in the middle third of the travel",
        "high": f"in the upper third of the travel, above {_span(high_thirds)} mm",
        "near_stop": "at the ends of the travel",
        "early": f"in the first third of {record}, before {_span(first_thirds)} s",
        "late": f"in the last third of {record}, after {_span(last_thirds)} s",
    }


def _ends_of_travel(experiment: Experiment) -> np.ndarray:
    """Return lowest and highest reading but for the outermost, shape (2,). [m]"""
    return np.asarray(np.nanquantile(experiment.position, [0.002, 0.998]))


def _thirds_of_travel(experiment: Experiment) -> np.ndarray:
    """Return where the lower third of the travel ends and the upper one begins, shape (2,). [m]"""
    low, high = _ends_of_travel(experiment)
    return np.asarray(low + (high - low) * np.array([1.0, 2.0]) / 3.0)


def _thirds_of_time(experiment: Experiment) -> np.ndarray:
    """Return when the first third of a record ends and the last one begins, in its own time, shape (2,). [s]"""
    return np.asarray(experiment.start + experiment.time[-1] / 3.0 * np.array([1.0, 2.0]))


def _span(values: np.ndarray) -> str:
    """Return values in whole numbers: one where they are alike, else the lowest and the highest."""
    lowest, highest = f"{values.min():.0f}", f"{values.max():.0f}"
    return lowest if lowest == highest else f"{lowest} to {highest}"


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
