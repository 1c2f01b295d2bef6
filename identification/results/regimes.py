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
    low, high = ends_of_travel(position)
    thirds, thirds_of_time = thirds_between(low, high), thirds_between(0.0, time[-1])
    margin = LIKE_THE_BAND * (high - low)
    return {
        "rising": mode > 0,
        "falling": mode < 0,
        "stuck": mode == 0,
        "after_reversal": is_after_reversal(time, mode) & (mode != 0),
        "low": position < thirds[0],
        "middle": (position >= thirds[0]) & (position <= thirds[1]),
        "high": position > thirds[1],
        "near_stop": (position < low + margin) | (position > high - margin),
        "early": time < thirds_of_time[0],
        "late": time > thirds_of_time[1],
    }


def words_of(experiments: Sequence[Experiment]) -> dict[str, str]:
    """Return where each regime is, in words by its name; a number that differs by experiment is told as a range."""
    low_thirds, high_thirds = 1e3 * np.array([thirds_between(*ends_of_travel(each.position)) for each in experiments]).T
    first_thirds, last_thirds = np.array([each.start + thirds_between(0.0, each.time[-1]) for each in experiments]).T
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


def ends_of_travel(position: np.ndarray) -> tuple[float, float]:
    """Return the lowest and the highest reading, but for two in a thousand at either end. [m]"""
    low, high = np.nanquantile(position, [0.002, 0.998])
    return low, high


def thirds_between(low: float, high: float) -> np.ndarray:
    """Return the two places that part a range into thirds, shape (2,)."""
    return low + (high - low) * np.array([1.0, 2.0]) / 3.0


def is_after_reversal(time: np.ndarray, mode: np.ndarray) -> np.ndarray:
    """Return at which samples the stem has just started the other way, shape (n,)."""
    return time_since_reversal(time, mode) < AFTER_REVERSAL


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
