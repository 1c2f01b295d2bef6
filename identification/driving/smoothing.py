"""A signal without its noise, smoothed as far as the signal itself allows: jumps, corners and curves stay."""

from __future__ import annotations

import numpy as np

WINDOWS = (2, 3, 5, 8, 12, 18, 27, 40, 60)
"""Samples that a window reaches to one side, from the narrowest to the widest."""

SHAPES = ((1, 1), (1, 0), (0, 1))
"""What share of its reach a window has before and behind a sample."""

ORDERS = (0, 1, 2)
"""Of the polynomials that are laid through a window: level, line, parabola."""

AGREEMENT = 2.0
"""Standard errors within which wider windows agree with the narrower ones."""


def smoothed(signal: np.ndarray, noise: float) -> np.ndarray:
    """Return a signal without white noise, at each sample by the widest windows that agree with the narrower ones.

    Before, behind and about each sample, levels, lines and parabolas are laid through ever more samples, for as long as
    what they say at the sample has intervals that intersect: a wider one that reaches over a jump or corner does not.
    The last of each kind count by their variance.

    Parameters
    ----------
    signal : array, shape (n,)
    noise : float
        Standard deviation, in the unit of the signal.

    Returns
    -------
    array, shape (n,)

    References
    ----------
    V. Katkovnik, K. Egiazarian, J. Astola, "Local Approximation Techniques in Signal and Image Processing", 2006: the
    intersection of confidence intervals, with anisotropic windows.
    """
    from scipy.signal import savgol_coeffs

    total, weight = np.zeros(len(signal)), np.zeros(len(signal))
    for before, behind in SHAPES:
        for order in ORDERS:
            low, high = signal - AGREEMENT * noise, signal + AGREEMENT * noise
            found, variance = signal.copy(), np.full(len(signal), noise**2)
            agrees = np.ones(len(signal), bool)
            for reach in WINDOWS:
                first, last = before * reach, behind * reach
                count = first + last + 1
                if not order + 1 < count <= len(signal):
                    continue
                shares = savgol_coeffs(count, order, pos=first, use="dot")
                said = np.full(len(signal), np.nan)
                said[first : len(signal) - last] = np.correlate(signal, shares, "valid")
                square = noise**2 * float(np.sum(shares**2))
                low = np.maximum(low, said - AGREEMENT * np.sqrt(square))
                high = np.minimum(high, said + AGREEMENT * np.sqrt(square))
                agrees &= low <= high
                is_better = agrees & (square < variance)
                found, variance = np.where(is_better, said, found), np.where(is_better, square, variance)
            total += found / variance
            weight += 1.0 / variance
    return np.asarray(total / weight)
