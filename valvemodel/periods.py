"""Periods: the time from one sample to the next, cut into parts, and signals that move on through it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

JUMP, APART = 0.01, 0.5
"""A signal jumps from one sample to the next where it changes by more than this share of its range, and its changes
just before and after are less than that share of this one."""

STRAIGHT = 0.2
"""A signal turns sharply where on either side it bends by less than this share of its turn."""

FEWEST, BEYOND = 3, 2
"""Samples from which a curve is laid through them, and how many beyond either end bend it there."""


def finer(time: np.ndarray, parts: int) -> np.ndarray:
    """Return instants that cut each period into equal parts, shape ((n - 1) parts + 1,). [s]"""
    if parts == 1:
        return time
    within = np.diff(time)[:, None] * np.arange(parts) / parts
    return np.append((time[:-1, None] + within).ravel(), time[-1])


def straight(signal: np.ndarray, parts: int, late: float = 0.0) -> np.ndarray:
    """Return what `passing` does, where the signal goes straight from sample to sample."""
    return np.interp(_places(len(signal), parts, late), np.arange(len(signal)), signal)


def passing(signal: np.ndarray, parts: int, late: float = 0.0) -> np.ndarray:
    """Return what a signal is in the middle of each part of a period, where it moves on through the samples.

    It goes along a curve through the samples (Akima's, which does not overshoot where a ramp begins or ends), broken
    where the signal jumps: there it goes straight.

    Parameters
    ----------
    signal : array, shape (n,)
        As it stands at each sample.
    parts : int
    late : float
        Share of a period by which it comes late.

    Returns
    -------
    array, shape ((n - 1) parts + 1,)
        The last as at the last sample.

    References
    ----------
    H. Akima, "A new method of interpolation and smooth curve fitting based on local procedures", 1970, as modified by
    Moler.
    """
    from scipy.interpolate import Akima1DInterpolator

    places, is_jump = _places(len(signal), parts, late), jumps(signal)
    firsts = np.append(0, np.flatnonzero(is_jump) + 1)
    lengths = np.diff(firsts, append=len(signal))
    # One curve for all stretches: laying one takes longer than a run that goes along it.
    among = _with_beyond(signal, firsts, firsts + lengths - 1)
    curve = Akima1DInterpolator(np.arange(len(among)), among, method="makima")
    stretch = np.searchsorted(firsts, places, side="right") - 1
    before = np.minimum(places.astype(int), len(signal) - 2)
    is_curved = ~is_jump[before] & (lengths[stretch] >= FEWEST)
    found = straight(signal, parts, late)
    found[is_curved] = curve((places + BEYOND * (1 + 2 * stretch))[is_curved])
    return found


def _with_beyond(signal: np.ndarray, firsts: np.ndarray, lasts: np.ndarray) -> np.ndarray:
    """Return a signal with samples more at either end of each of its stretches, so that its curve ends as if alone.

    There its slope changes as it does from the last but one period to the last, which is Akima's rule for an end.
    """

    def beyond(ends: np.ndarray, inwards: int) -> np.ndarray:
        end, near, far = (signal[np.clip(ends + inwards * step, 0, len(signal) - 1)] for step in range(3))
        slope, change = end - near, end - 2.0 * near + far
        return np.stack([end + slope + change, end + 2.0 * slope + 3.0 * change], axis=1)

    places = np.repeat(np.concatenate([lasts + 1, firsts]), BEYOND)
    samples = np.concatenate([beyond(lasts, -1), beyond(firsts, 1)[:, ::-1]])
    among: np.ndarray = np.insert(signal, places, samples.ravel())
    return among


def passing_otherwise(signal: np.ndarray, parts: int, late: float = 0.0) -> Iterator[np.ndarray]:
    """Yield how else a signal may pass through its samples: straight, to the tip of each turn, and its jumps moved.

    Two straight lines that turn between two samples go on to where they meet. A jump comes at once or at the very last;
    on either side of it the signal goes on as it does there.
    """
    places = _places(len(signal), parts, late)
    yield straight(signal, parts, late)
    yield _to_the_tips(signal, places, straight(signal, parts, late))
    before = np.minimum(places.astype(int), len(signal) - 2)
    through, is_jump = passing(signal, parts, late), jumps(signal)
    slopes = np.concatenate([[0.0], np.where(is_jump, 0.0, np.diff(signal)), [0.0]])
    for side in (1, 0):
        near = before + side
        goes_on = signal[near] + slopes[near + side] * (places - near)
        yield np.where(is_jump[before], goes_on, through)


def jumps(signal: np.ndarray) -> np.ndarray:
    """Return after which samples a signal jumps to the next one, shape (n - 1,)."""
    change = np.abs(np.diff(signal))
    beside = np.concatenate([[0.0, 0.0], change, [0.0, 0.0]])
    nearby = np.maximum.reduce([beside[:-4], beside[1:-3], beside[3:-1], beside[4:]])
    found: np.ndarray = (change > JUMP * np.ptp(signal)) & (nearby < APART * change)
    return found


def _to_the_tips(signal: np.ndarray, places: np.ndarray, found: np.ndarray) -> np.ndarray:
    """Put the tips of its sharp turns into a signal that goes straight through its samples, found at places."""
    slopes = np.diff(signal)
    inside = np.arange(2, len(slopes) - 2)
    rising, falling = slopes[inside - 1], slopes[inside + 1]
    bend = np.abs(rising - falling)
    beside = np.maximum(np.abs(rising - slopes[inside - 2]), np.abs(falling - slopes[inside + 2]))
    is_straight = beside < STRAIGHT * bend
    is_within = (slopes[inside] - rising) * (falling - slopes[inside]) > 0.0
    for sample in inside[is_straight & is_within & (rising * falling < 0.0)]:
        before, after = slopes[sample - 1], slopes[sample + 1]
        tip = (slopes[sample] - after) / (before - after)
        found[np.argmin(np.abs(places - (sample + tip)))] = signal[sample] + before * tip
    return found


def _places(count: int, parts: int, late: float) -> np.ndarray:
    """Return where the middles of all parts lie, and the last sample, on a signal that comes late. [samples]"""
    middles = np.append((np.arange((count - 1) * parts) + 0.5) / parts, count - 1.0)
    return np.clip(middles - late, 0.0, count - 1.0)
