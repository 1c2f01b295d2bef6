"""Breakaways: how far a resting stem is from where it would just break away, read off a measured position."""

from __future__ import annotations

from valvemodel.compiled import compiled
from valvemodel.stages.bow import unbow
from valvemodel.stages.sensor import sensor_drift
from valvemodel.stages.stem import breakaway_ratio, sliding_friction, tangent_stiffness, thrust

SOFTEST = 0.1
"""Share of the spring's stiffness below which the net force does not fall along the way to a breakaway."""

WITHIN_PLAY = 2e-3
"""Weight of where in the play a slip began that the reading of a turned stem shows."""


@compiled
def ways_to_breakaway(rows, readings, befores, sides, pressures, times, ways):
    """Tell for each row of numbers and each rest how far beyond its reading the stem would just break away.

    A stem that goes on the way it came has taken up the play of its linkage, and stands before the reading by half of
    it. One that turned may have slipped within the play before: the slip that its reading shows began anywhere in it,
    most likely where the stem rested.

    Parameters
    ----------
    rows : structured array, shape (p,)
    readings, befores, sides, times : arrays, shape (n,) [m], -1 or 1, -1 or 1, [s]
        Mean reading of each rest, the side to which the stem went before, that to which it leaves, and when.
    pressures : array, shape (p, n) [Pa]
    ways : array, shape (p, n) [m]
        Filled: positive is upwards.
    """
    for row in range(len(rows)):
        p = rows[row]
        for rest in range(len(readings)):
            time, side, pressure = times[rest], sides[rest], pressures[row, rest]
            linkage = unbow(p, readings[rest] - sensor_drift(p, time))
            goes_on = side == befores[rest]
            position = linkage + side * p.backlash_half_width if goes_on else linkage
            friction = breakaway_ratio(p) * sliding_friction(p, side, position, pressure, time)
            net = thrust(p, position, pressure, time) - side * friction
            stiffness = tangent_stiffness(p, side, position, pressure, time)
            way = net / max(stiffness, SOFTEST * p.spring_rate)
            if not goes_on:
                within = min(max(way, -p.backlash_half_width), p.backlash_half_width)
                way += WITHIN_PLAY * (within - befores[rest] * p.backlash_half_width) - within
            ways[row, rest] = way
