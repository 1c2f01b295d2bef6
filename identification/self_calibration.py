"""The paper's self-calibration, eqs. (35)-(40), as an estimator of a loop's width from three points on each branch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from identification.noise import noise_level
from valvemodel.equations import numeric
from valvemodel.errors import InputError
from valvemodel.records import Record

POINTS = 3
"""On each branch, as in the paper."""

NOT_PARALLEL = 0.1
"""Slopes of the two branches, or of the two secants of one, that differ by more than this share are doubtful."""

NOISY = 0.05
"""Standard deviation over the width from which the noise is said."""

MARGIN = 0.15
"""Share of the common positions at either end that no point is taken from: a branch begins with a corner."""

CLEAR = 4.0
"""A stem that has moved by more than this many times the noise moves. [noise]"""


@dataclass(frozen=True)
class Calibration:
    """What six points say of a loop.

    Attributes
    ----------
    width : float [A]
        I_threshold of (40): from the falling to the rising branch, the **full** width.
    std : float [A]
        From the noise of the six readings alone; bias by curvature or by a point off its branch is in `warnings`.
    slope : float [m/A]
        Of (37).
    warnings : tuple of str
        Why the width may be biased.
    """

    width: float
    std: float
    slope: float
    warnings: tuple[str, ...]


def calibrate(
    *,
    rising_current: npt.ArrayLike,
    rising_position: npt.ArrayLike,
    falling_current: npt.ArrayLike,
    falling_position: npt.ArrayLike,
    noise: float = 0.0,
) -> Calibration:
    """Estimate the width of a loop from three settled points on each branch, in the order taken.

    Unbiased for straight parallel branches. A curved valve gives the width of its chords: the error grows with the
    square of the points' distance. A first point taken before the stem has left its dead band makes the loop look too
    narrow or too wide by a third of what it is short of the branch; such points are warned of where the slopes show
    them.

    Parameters
    ----------
    rising_current, rising_position : array, shape (3,) [A], [m]
    falling_current, falling_position : array, shape (3,) [A], [m]
    noise : float
        Standard deviation of one reading. [m]

    Raises
    ------
    InputError
        If currents of a branch repeat, or the mean slope is not positive: then no width can be told.

    References
    ----------
    Paper eqs. (35)-(40).
    """
    current = np.array([rising_current, falling_current], float)
    position = np.array([rising_position, falling_position], float)
    if current.shape != (2, POINTS) or position.shape != (2, POINTS):
        raise InputError("self-calibration takes three points on each branch", f"got {current.shape}", "choose three")
    if np.any(np.diff(current, axis=1) == 0.0):
        raise InputError("the currents of a branch differ", f"got {current.tolist()} A", "choose other points")
    width, slope, slopes = _threshold(current, position)
    if not slope > 0.0:
        raise InputError(
            "the position rises with the current on both branches",
            f"mean slope {slope:.3g} m/A",
            "choose points at which the stem has moved, farther apart",
        )
    std = noise * float(np.sqrt(sum(_sensitivity(current, position, place) ** 2 for place in np.ndindex(2, POINTS))))
    return Calibration(width, std, slope, tuple(_doubts(current, position, width, std, slopes)))


def calibrate_record(record: Record) -> Calibration:
    """Estimate the width of a loop from a record, by three points of each branch at the same positions.

    Parameters
    ----------
    record : Record
        A settled loop, or a slow record with time: a lag behind the current counts as width.

    Raises
    ------
    InputError
        If the stem does not move both ways over common positions.
    """
    if record.current is None or record.position is None:
        raise InputError("self-calibration takes current and position", f"{record.name} lacks one", "record both")
    noise = noise_level(record.position)
    branches = [_branch(record.current, record.position, noise, side) for side in (1.0, -1.0)]
    if min(len(places) for places in branches) >= POINTS:
        low = max(record.position[places].min() for places in branches)
        high = min(record.position[places].max() for places in branches)
    else:
        low = high = 0.0
    if not high - low > CLEAR * noise:
        raise InputError(
            "self-calibration takes a stem that moves up and down over the same positions",
            f"{record.name}: {len(branches[0])} rising and {len(branches[1])} falling samples",
            "drive the valve up and down through at least a quarter of its travel, in steps or slowly",
        )
    goals = np.linspace(low + MARGIN * (high - low), high - MARGIN * (high - low), POINTS)
    rising, falling = (
        [places[np.argmin(np.abs(record.position[places] - goal))] for goal in ordered]
        for places, ordered in ((branches[0], goals), (branches[1], goals[::-1]))
    )
    return calibrate(
        rising_current=record.current[rising],
        rising_position=record.position[rising],
        falling_current=record.current[falling],
        falling_position=record.position[falling],
        noise=noise,
    )


def _branch(current: np.ndarray, position: np.ndarray, noise: float, side: float) -> np.ndarray:
    """Return the samples at which the stem has just followed the current to a side."""
    usual = np.abs(np.diff(position))
    reach = max(round(CLEAR * noise / max(float(np.quantile(usual, 0.75)), 1e-12)), 1)
    reach = min(reach, max(len(position) // 20, 1))
    moved = side * (position[reach:] - position[:-reach]) > CLEAR * noise
    driven = side * (current[reach:] - current[:-reach]) > 0.0
    return np.flatnonzero(moved & driven) + reach


def _threshold(current: np.ndarray, position: np.ndarray) -> tuple[float, float, tuple[float, float]]:
    """Return width (40), mean slope (37) and the slopes of both branches (35), (36)."""
    (rising, falling) = (
        numeric.branch_slope(i[0], y[0], i[1], y[1], i[2], y[2]) for i, y in zip(current, position, strict=True)
    )
    slope = numeric.mean_slope(rising, falling)
    first, second = (
        numeric.branch_intercept(slope, i[0], y[0], i[1], y[1], i[2], y[2])
        for i, y in zip(current, position, strict=True)
    )
    return float(numeric.current_threshold(slope, first, second)), float(slope), (float(rising), float(falling))


def _sensitivity(current: np.ndarray, position: np.ndarray, place: Sequence[int]) -> float:
    """Return by how much the width changes with one reading (central difference). [A/m]"""
    step = 1e-4 * float(np.ptp(position))
    change = np.zeros_like(position)
    change[tuple(place)] = step
    return (_threshold(current, position + change)[0] - _threshold(current, position - change)[0]) / (2.0 * step)


def _doubts(
    current: np.ndarray, position: np.ndarray, width: float, std: float, slopes: tuple[float, float]
) -> list[str]:
    found = []
    secants = np.diff(position, axis=1) / np.diff(current, axis=1)
    for name, pair in zip(("rising", "falling"), secants, strict=True):
        if pair.min() < (1.0 - 2.0 * NOT_PARALLEL) * pair.max():
            found.append(
                f"the {name} branch bends: its secants are {pair[0]:.3g} and {pair[1]:.3g} m/A; a point may lie in the "
                "dead band, or the valve is curved; take the points farther from the reversal and nearer to each other"
            )
    if abs(slopes[0] - slopes[1]) > NOT_PARALLEL * max(slopes):
        found.append(
            f"the branches are not parallel, {slopes[0]:.3g} and {slopes[1]:.3g} m/A: the width depends on the "
            "position; take both branches' points at the same positions"
        )
    if width <= 0.0:
        found.append("the rising branch is not to the right of the falling one: this is no friction's loop")
    elif std > NOISY * width:
        found.append(f"noise alone makes the width uncertain by {std / width:.0%}: average several readings a point")
    return found
