"""Self-calibration, steps 1 to 3: the valve is moved, and a line with a loop is fitted to where it came to rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from valvemodel.control.branches import MOVED
from valvemodel.control.laws.settings import HIGHEST_CURRENT, LOWEST_CURRENT
from valvemodel.control.loop import coarse
from valvemodel.control.scenario import check_conditions
from valvemodel.equations.numeric import branch_intercept, branch_slope, current_threshold, mean_slope
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.stepping import SteppedValve

Loads = tuple[Sequence[float], Sequence[float]]

LOADS: tuple[Loads, ...] = (
    ((13e-3, 16e-3, 19e-3), (15e-3, 12e-3, 9e-3)),
    ((13e-3, 16e-3, 19e-3), (12.5e-3, 8.5e-3, 4.5e-3)),
)
"""Loads of steps 1 and 2, which the paper does not give, from 4 and 20 mA on: first where rise and fall lie close
together, so that bent branches mislead least; then farther apart, beyond the loop of twice the sliding friction. [A]"""

SETTLING = 5.0
"""Time from a load to its record. [s]"""


@dataclass(frozen=True)
class Calibration:
    """The line with a loop that self-calibration fits.

    Parameters
    ----------
    rising, falling : array, shape (3, 2) [A], [m]
        The records (I_1, A_1)..(I_3, A_3) and (I_4, B_1)..(I_6, B_3).
    """

    rising: np.ndarray
    falling: np.ndarray

    @property
    def slope(self) -> float:
        """k of (37). [m/A]"""
        slopes = (branch_slope(*branch.ravel()) for branch in (self.rising, self.falling))
        return float(mean_slope(*slopes))

    @property
    def rising_intercept(self) -> float:
        """b_1 of (38). [m]"""
        return float(branch_intercept(self.slope, *self.rising.ravel()))

    @property
    def falling_intercept(self) -> float:
        """b_2 of (39). [m]"""
        return float(branch_intercept(self.slope, *self.falling.ravel()))

    @property
    def threshold(self) -> float:
        """I_threshold of (40), the full width of the loop. [A]"""
        return float(current_threshold(self.slope, self.rising_intercept, self.falling_intercept))

    @property
    def settings(self) -> dict[str, float]:
        """What a controller's feedforward needs of it."""
        return {
            "line_slope": self.slope,
            "rising_intercept": self.rising_intercept,
            "falling_intercept": self.falling_intercept,
        }


def self_calibrate(
    model: Model,
    *,
    loads: Sequence[Loads] = LOADS,
    settling: float = SETTLING,
    noise: float = 0.0,
    resolution: float = 0.0,
    seed: int = 0,
) -> Calibration:
    """Carry out three loads upwards from 4 mA, three downwards from 20 mA, and record where the valve stands.

    Parameters
    ----------
    model : Model
    loads : sequence of pairs
        Three rising and three falling currents; the first pair whose every load moves the stem is taken. [A]
    settling : float
        Time from a load to its record. [s]
    noise, resolution : float
        Standard deviation of the reading's noise, and its step. [m]
    seed : int

    Raises
    ------
    InputError
        If the currents are not three in order within 4..20 mA, or the valve does not follow them.

    References
    ----------
    Paper, steps 1-3 of section 3, eqs. (35)-(40).
    """
    check_conditions(period=settling, noise=noise, resolution=resolution)
    for rising, falling in loads:
        _check_loads(rising, falling)
    drawn = np.random.default_rng(seed).normal(scale=noise, size=7)
    for number, (rising, falling) in enumerate(loads):
        start, records = _carry_out(model, rising, falling, settling, drawn, resolution)
        load = _unmoved(model, start, records)
        if load is None:
            break
        if number == len(loads) - 1:
            raise InputError(
                "each load of a self-calibration moves the stem along its branch",
                f"{model.name}: at {1e3 * records[load, 0]:g} mA it stayed within the loop",
                "choose currents farther from where the direction turns",
            )
    return Calibration(records[:3], records[3:])


def _carry_out(
    model: Model,
    rising: Sequence[float],
    falling: Sequence[float],
    settling: float,
    drawn: np.ndarray,
    resolution: float,
) -> tuple[float, np.ndarray]:
    """Return the reading at the start, and the current and reading of each load."""
    valve = SteppedValve(model, current=LOWEST_CURRENT)
    start = coarse(valve.reading + drawn[6], resolution)
    rows: list[tuple[float, float]] = []
    for current in (*rising, *falling):
        if len(rows) == 3:
            valve.step(HIGHEST_CURRENT, settling)
        valve.step(current, settling)
        rows.append((current, coarse(valve.reading + drawn[len(rows)], resolution)))
    return start, np.array(rows)


def _check_loads(rising: Sequence[float], falling: Sequence[float]) -> None:
    loads = (LOWEST_CURRENT, *rising, HIGHEST_CURRENT)
    returns = (HIGHEST_CURRENT, *falling, LOWEST_CURRENT)
    is_sound = len(rising) == len(falling) == 3 and np.diff(rising).min() > 0 > np.diff(falling).max()
    if not (is_sound and min(np.diff(loads)) >= 0 >= max(np.diff(returns))):
        raise InputError(
            "self-calibration takes three rising and three falling currents within 4..20 mA",
            f"got {[1e3 * each for each in rising]} and {[1e3 * each for each in falling]} mA",
            "put them in order",
        )


def _unmoved(model: Model, start: float, records: np.ndarray) -> int | None:
    """Return the load at which the stem stayed where it was, within the loop and on no branch; or none."""
    moves = np.diff(np.r_[start, records[:, 1]])
    moves[3:] *= -1.0
    return None if moves.min() > MOVED * model.values["rated_travel"] else int(np.argmin(moves))
