"""Breakaways: how far a resting stem is from where it would just break away, read off a measured position."""

from __future__ import annotations

from valvemodel.compiled import compiled
from valvemodel.stages.bow import unbow
from valvemodel.stages.sensor import sensor_drift
from valvemodel.stages.stem import breakaway_ratio, sliding_friction, tangent_stiffness, thrust

SOFTEST = 0.1
"""Share of the spring's stiffness below which the net force does not fall along the way to a breakaway."""


@compiled
def ways_to_breakaway(rows, readings, sides, pressures, times, ways):
    """Tell for each row of numbers and each rest how far beyond its reading the stem would just break away.

    Parameters
    ----------
    rows : structured array, shape (p,)
    readings, sides, times : arrays, shape (n,) [m], -1 or 1, [s]
        Mean reading of each rest, the side to which the stem leaves, and when.
    pressures : array, shape (p, n) [Pa]
    ways : array, shape (p, n) [m]
        Filled: positive is upwards.
    """
    for row in range(len(rows)):
        p = rows[row]
        for rest in range(len(readings)):
            time, side, pressure = times[rest], sides[rest], pressures[row, rest]
            position = unbow(p, readings[rest] - sensor_drift(p, time))
            friction = breakaway_ratio(p) * sliding_friction(p, side, position, pressure, time)
            net = thrust(p, position, pressure, time) - side * friction
            stiffness = tangent_stiffness(p, side, position, pressure, time)
            ways[row, rest] = net / max(stiffness, SOFTEST * p.spring_rate)
