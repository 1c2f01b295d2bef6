"""Noise of a signal, estimated from the signal itself."""

from __future__ import annotations

import math

import numpy as np

KEPT_SHARE = 0.6
"""Share of the smallest differences that is trusted to be noise; the rest may be motion."""

KEPT_VARIANCE = 0.21530
"""Mean square of the smaller 60 % of a standard normal variable: 1 - 2 q phi(q)/0.6 with q = 0.84162."""

FLICKERING, OFF = 1.0 / math.sqrt(math.pi), math.sqrt(2.0 / math.pi)
"""Shares of readings in steps that stand alone between two alike, and that are off by a step, over noise by step: of
places that lie anywhere between two steps, and noise that is small beside them."""

ROUNDED, OFF_STEP, FEWEST_GAPS = 1e-12, 1e-2, 3
"""Share of the range that a step is more than, part of a step by which rounded values are off it at most, and how many
distances between neighbouring values tell it."""


def noise_level(signal: np.ndarray) -> float:
    """Estimate the standard deviation of white noise on a signal that mostly moves slowly.

    Third differences take out offset, slope and curvature; the smaller part of them ignores the jumps. A signal that
    shows no noise between its steps has at least a twentieth of a step, and no less than what makes it flicker between
    two of them; one that takes too many values for that, of another simulation, no less than what rounding them makes.

    Parameters
    ----------
    signal : array, shape (n,)
        NaN where nothing was measured.

    Returns
    -------
    float
        In the unit of the signal.
    """
    signal = signal[np.isfinite(signal)]
    if len(signal) < 8:
        return float(np.std(signal)) if len(signal) else 0.0
    squares = np.sort(np.diff(signal, n=3) ** 2)
    kept = squares[: max(int(KEPT_SHARE * len(squares)), 1)]
    level = float(np.sqrt(np.mean(kept) / (KEPT_VARIANCE * 20.0)))
    step, share = flickering(signal)
    rounding = 0.0 if step > 0.0 else display_step(signal) / math.sqrt(12.0)
    return max(level, 0.05 * step, step * share / FLICKERING, rounding, 1e-9)


def flicker_level(signal: np.ndarray) -> float:
    """Return what noise before a coarse converter leaves of its readings, root mean square, in the signal's unit.

    A reading that is off is off by a whole step.

    Parameters
    ----------
    signal : array, shape (n,)
        NaN where nothing was measured.
    """
    step, share = flickering(signal[np.isfinite(signal)])
    return step * math.sqrt(OFF / FLICKERING * share)


def flickering(signal: np.ndarray) -> tuple[float, float]:
    """Return the step of the grid that a signal's values lie on, and the share of them that stand alone on a step.

    That is on another one than both neighbours, where these are on one; both are 0 where there is no grid.
    """
    step, offset = reading_grid(signal)
    if step == 0.0:
        return 0.0, 0.0
    # By steps, not by values: a finer display shows several on one.
    steps = np.round((signal - offset) / step)
    before, here, after = steps[:-2], steps[1:-1], steps[2:]
    return step, float(np.mean((before == after) & (here != before)))


def reading_step(signal: np.ndarray) -> float:
    """Return the step of the grid that a signal's values lie on, or 0 where they take too many values."""
    return reading_grid(signal)[0]


def display_step(signal: np.ndarray) -> float:
    """Return the step to which the values of a signal are rounded, however many they take, or 0 where to none."""
    gaps = np.diff(np.unique(signal[np.isfinite(signal)]))
    if len(gaps) < FEWEST_GAPS:
        return 0.0
    among = np.diff(np.unique(np.append(gaps, 0.0)))
    step = float(among[among > ROUNDED * gaps.sum()].min(initial=math.inf))
    steps = gaps / step
    return step if np.all(steps > OFF_STEP) and np.abs(steps - np.round(steps)).max() < OFF_STEP else 0.0


def reading_grid(signal: np.ndarray) -> tuple[float, float]:
    """Return step and offset of the grid that a signal's values lie on, or (0, 0) where they do not.

    The values that occur are numbered by the middle gap between neighbours and a line is laid through them; a finer
    display step on top of a coarse encoder only roughens the line.

    Parameters
    ----------
    signal : array, shape (n,)

    Returns
    -------
    (float, float)
        In the unit of the signal; the offset is that of the grid point next to 0.
    """
    values = np.unique(signal[np.isfinite(signal)])
    if len(values) < 3:
        return 0.0, 0.0
    step = float(np.median(np.diff(values)))
    for _ in range(3):
        if step <= 0.0:
            return 0.0, 0.0
        numbers = np.concatenate([[0.0], np.cumsum(np.round(np.diff(values) / step))])
        if numbers[-1] < 2.0:
            return 0.0, 0.0
        step, offset = (float(each) for each in np.polyfit(numbers, values, 1))
    is_regular = np.abs(values - offset - step * numbers) < 0.3 * step
    if np.mean(is_regular) < 0.9:
        return 0.0, 0.0
    return step, offset - step * round(offset / step)
