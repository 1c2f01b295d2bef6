"""A run of the valve in plain Python over a whole input."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from itertools import pairwise
from math import nan

import numpy as np

from valvemodel.model import Model
from valvemodel.reference.numbers import numbers_of
from valvemodel.reference.valve import Valve
from valvemodel.trajectory import Setting, Trajectory

ROUNDING = 1e-12
"""Instants that differ by less are equal but for rounding. [s]"""

TICKS = 1.26e12
"""In a second: spans of time are whole numbers of ticks, so that equal ones are equal to the last bit. [1/s]"""


def simulate_slowly(model: Model, *, time: np.ndarray, current: np.ndarray, start_position: float = nan) -> Trajectory:
    """Simulate a valve in plain Python, to see what `simulate` does and to check it; a thousand times slower.

    What has a closed form is computed by it; all else is integrated between events at a relative error of 1e-12.

    Parameters
    ----------
    model : Model
    time : array, shape (n,), increasing [s]
    current : array, shape (n,) [A]
        Held from each row to the next.
    start_position : float
        Reading at the start; by default at rest in the middle of the stuck band. [m]

    Returns
    -------
    Trajectory
        Its samples are those of this run; events and energies, computed when asked for, are the compiled chain's.

    References
    ----------
    Paper eqs. (1)-(6), (16), (31), (33); each effect's source is in its declaration.
    """
    clock = [float(instant - time[0]) for instant in time]
    drive = [float(each) for each in current]
    valve = Valve(numbers_of(model), drive[0], start_position)
    rows = [row_of(valve, 0.0)]
    arrival = [instant + valve.numbers.transport_delay for instant in clock]
    for start, end in pairwise(clock):
        duration = round((end - start) * TICKS) / TICKS
        for held, begin, lasting in out_of_the_line(arrival, drive, start, start + duration):
            valve.hold(held, begin, lasting)
        rows.append(row_of(valve, end))
    pressure, position, mode, stem_position, velocity = (np.array(column) for column in zip(*rows, strict=True))
    return Trajectory(
        time=np.asarray(time, float),
        current=np.asarray(current, float),
        pressure=pressure,
        position=position,
        mode=mode,
        stem_position=stem_position,
        velocity=velocity,
        setting=Setting(model, start_position),
    )


def row_of(valve: Valve, time: float) -> tuple[float, ...]:
    """Return what stands at a time: pressure, reading, mode, and the stem's position and velocity."""
    stem = valve.stem
    return valve.pressure, valve.sensor.reading(time), valve.mode, stem.position, stem.velocity


def out_of_the_line(
    arrival: list[float], drive: list[float], start: float, end: float
) -> Iterator[tuple[float, float, float]]:
    """Yield the currents that the line lets out between two instants: which, from when, for how long."""
    first = bisect_right(arrival, start + ROUNDING)
    last = bisect_left(arrival, end - ROUNDING)
    drives = [drive[max(first - 1, 0)], *drive[first:last]]
    switches = [start, *arrival[first:last], end]
    for held, begin, finish in zip(drives, switches, switches[1:], strict=False):
        yield held, begin, finish - begin
