"""Simulate a model over held currents; one door to the compiled chain."""

from __future__ import annotations

import math

import numpy as np

from valvemodel import runs
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.trajectory import TOLERANCE, Setting, Trajectory, trajectory_of

AT_REST = "rest"
"""Asks for a run that is put anew whenever the stem has come to rest."""


def simulate(
    model: Model,
    *,
    time: np.ndarray,
    current: np.ndarray,
    start_position: float = math.nan,
    measured: np.ndarray | None = None,
    reanchor: float | str | None = None,
    tolerance: float = TOLERANCE,
) -> Trajectory:
    """Simulate a valve under currents that are held from each row to the next.

    The base model is exact: stick and slip by mode, stops and breakaways in closed form, no step size. Effects that
    move the pressure within a period are integrated in parts; nonlinear slips in steps of controlled error.

    Parameters
    ----------
    model : Model
    time : array, shape (n,), increasing [s]
    current : array, shape (n,) [A]
    start_position : float
        Reading at the start; by default at rest in the middle of the stuck band, or the first measured reading of a
        run that is re-anchored. [m]
    measured : array, shape (n,)
        Readings to be re-anchored on, NaN where there is none. [m]
    reanchor : float or "rest"
        Put the stem on the measured reading every so often [s], or whenever it has come to rest; speed and friction
        stay as they are. By default the run is free and `measured` is not used.
    tolerance : float
        What the integrated effects may be off in position; a coarser one is faster. [m]

    Returns
    -------
    Trajectory

    Raises
    ------
    InputError
        If shapes differ, time does not increase, a current is negative or not finite, or there is nothing to be
        re-anchored on.

    References
    ----------
    Paper eqs. (1)-(6), (16), (31), (33); mode rule of the stop speed.
    """
    time = np.ascontiguousarray(time, float)
    current = np.ascontiguousarray(current, float)
    check_input(time, current)
    anchors = runs.FREE
    if reanchor is not None:
        anchors = anchors_of(time, measured, reanchor)
        if math.isnan(start_position):
            start_position = float(anchors[0])
    setting = Setting(model, start_position, anchors, reanchor == AT_REST, tolerance)
    samples, _, _ = setting.trace(time, current, np.empty(0), 0)
    return trajectory_of(time, current, samples, setting)


def anchors_of(time: np.ndarray, measured: np.ndarray | None, reanchor: float | str) -> np.ndarray:
    """Return the readings at which a run is put anew, NaN where it runs free. [m]

    Parameters
    ----------
    time : array, shape (n,) [s]
    measured : array, shape (n,) [m]
    reanchor : float or "rest"
        Every so often from the first row on [s]: at the first measured reading of each such interval.
    """
    rule = "a re-anchored run needs measured positions, one for each row"
    if measured is None or np.shape(measured) != np.shape(time):
        arrived = "none" if measured is None else f"shape {np.shape(measured)} for {len(time)} rows"
        raise InputError(rule, f"got {arrived}", "give a record with a position, or leave the re-anchoring out")
    measured = np.ascontiguousarray(measured, float)
    if reanchor == AT_REST:
        return measured
    if isinstance(reanchor, str) or not (math.isfinite(reanchor) and reanchor > 0.0):
        raise InputError(
            "a run is re-anchored every so many seconds, or at `rest`", f"got {reanchor!r}", 'give for instance "2 s"'
        )
    is_measured = np.isfinite(measured)
    # A sample that is short of its interval by rounding alone belongs to it.
    interval = np.floor((time - time[0]) / reanchor * (1.0 + 1e-12) + 1e-9)
    _, first = np.unique(interval[is_measured], return_index=True)
    rows = np.flatnonzero(is_measured)[first]
    anchors = np.full(len(time), np.nan)
    anchors[rows] = measured[rows]
    return anchors


def check_input(time: np.ndarray, current: np.ndarray) -> None:
    """Refuse times and currents that are none."""
    if time.ndim != 1 or time.shape != current.shape or len(time) == 0:
        raise InputError(
            "time and current are two rows of equal length",
            f"got shapes {time.shape} and {current.shape}",
            "cut one",
        )
    if not np.all(np.diff(time) > 0.0):
        row = int(np.argmin(np.diff(time)))
        raise InputError(
            "time must increase",
            f"row {row + 1} has {time[row + 1]} s after {time[row]} s",
            "sort or drop the row",
        )
    bad = ~np.isfinite(current) | (current < 0.0)
    if bad.any():
        row = int(np.argmax(bad))
        raise InputError("a current is a number from 0 A on", f"row {row} has {current[row]} A", "correct it")
