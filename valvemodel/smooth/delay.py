"""A delayed current: what comes out of a line in each period, smooth in its dead time."""

from __future__ import annotations

import casadi as ca
import numpy as np

from valvemodel.smooth.rounding import Expression

BEFORE = 1e6
"""The first current has stood at the line's entry for this long. [s]"""


def delayed_current(time: np.ndarray, current: np.ndarray, delay: Expression) -> Expression:
    """Return the mean over each period of a held current that a line delays, interpolated in its sum over time.

    Parameters
    ----------
    time : array, shape (n,), increasing [s]
    current : array, shape (n,) [A]
        Held from each row to the next.
    delay : expression [s]

    Returns
    -------
    MX, shape (1, n - 1) [A]
    """
    knots = np.concatenate([[time[0] - BEFORE], time])
    held = np.concatenate([[current[0]], current[:-1]])
    charge = np.concatenate([[0.0], np.cumsum(held * np.diff(knots))])
    passed = ca.interpolant("charge", "linear", [knots], charge - charge[1])
    instants = ca.MX(ca.DM(time).T) - delay
    through = passed.map(len(time))(instants)
    return ca.diff(through, 1, 1) / ca.DM(np.diff(time)).T
