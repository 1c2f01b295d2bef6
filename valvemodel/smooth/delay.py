"""A delayed current: what comes out of a line in each period, smooth in its dead time."""

from __future__ import annotations

import casadi as ca
import numpy as np

from valvemodel.periods import finer
from valvemodel.smooth.rounding import Expression

BEFORE = 1e6
"""The first current has stood at the line's entry for this long. [s]"""


def delayed_current(time: np.ndarray, current: np.ndarray, delay: Expression, parts: int) -> Expression:
    """Return the mean over each part of a period of a held current that a line delays.

    Parameters
    ----------
    time : array, shape (n,), increasing [s]
    current : array, shape (n,) [A]
        Held from each row to the next.
    delay : expression [s]
    parts : int
        Parts of a period.

    Returns
    -------
    MX, shape (1, (n - 1) parts) [A]
        Interpolated in the current's sum over time, so that it is differentiable in the delay.
    """
    knots = np.concatenate([[time[0] - BEFORE], time])
    held = np.concatenate([[current[0]], current[:-1]])
    charge = np.concatenate([[0.0], np.cumsum(held * np.diff(knots))])
    instants = finer(time, parts)
    passed = ca.interpolant("charge", "linear", [knots], charge - charge[1]).map(len(instants))
    through = passed(ca.MX(ca.DM(instants).T) - delay)
    return ca.diff(through, 1, 1) / ca.DM(np.diff(instants)).T
