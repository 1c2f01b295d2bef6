"""Core that remembers where its current turned: a stack of plays whose mean the flux follows."""

from __future__ import annotations

import math

import numpy as np

from valvemodel.compiled import compiled, inlined
from valvemodel.stages.nodes import first_fall

PLAYS = 8
"""In the stack; their steps are 1.5 % of the loop, and more of them no longer narrow that."""

CUT = 3.0
"""Where the exponential density of the plays ends, in its scales: 5 % would lie beyond, but a core saturates."""

TAKEN_UP = 1e-12
"""A play with less room is taken up. [A]"""


def _radii() -> np.ndarray:
    """Return the mean radii of equal shares of the density, least first; their own mean is 1."""
    ends = -np.log1p(-np.arange(PLAYS + 1) / PLAYS * -math.expm1(-CUT))
    moments = (ends + 1.0) * np.exp(-ends)
    radii = moments[:-1] - moments[1:]
    return radii / radii.mean()


RADII = _radii()


@inlined
def scale_of_plays(p):
    """Return the mean radius of the plays; what share of the flux is without a play makes up for it. [A]"""
    return p.hysteresis_half_width * (1.0 + p.hysteresis_roundness)


@inlined
def play_after(play, radius, current):
    """Return where a play is once the current has gone one way: dragged where its room is used up. [A]"""
    return min(max(play, current - radius), current + radius)


@compiled
def place_among_plays(p, state, current):
    """Return where in their common loop the plays are, -1..1, once the current has gone one way."""
    scale, total = scale_of_plays(p), 0.0
    for index in range(PLAYS):
        total += current - play_after(state.plays[index], scale * RADII[index], current)
    return total / (PLAYS * scale)


@compiled
def pull_plays(p, state, current):
    """Let the plays follow a current."""
    scale = scale_of_plays(p)
    for index in range(PLAYS):
        state.plays[index] = play_after(state.plays[index], scale * RADII[index], current)


@compiled
def lay_plays(p, state, memory, count):
    """Take the currents at the nodes from Bouc and Wen's curve to the plays; return where is a kink, in spacings."""
    for node in range(count + 1):
        behind = memory.values[node] - memory.currents[node]
        behind_plays = p.hysteresis_half_width * place_among_plays(p, state, memory.values[node])
        memory.currents[node] -= p.return_point_memory * (behind_plays - behind)
    return next_taken_up(p, state, memory, count)


@compiled
def next_taken_up(p, state, memory, count):
    """Return where along the currents at the nodes the next play is taken up, a kink of the flux, in spacings."""
    currents, scale, room = memory.values, scale_of_plays(p), math.inf
    side = 1.0 if currents[count] > currents[0] else -1.0
    for index in range(PLAYS):
        left = scale * RADII[index] - side * (currents[0] - state.plays[index])
        if left > TAKEN_UP:
            room = min(room, left)
    return math.inf if room == math.inf else used_up(memory, count, room)


@compiled
def used_up(memory, count, room):
    """Return where along the currents at the nodes a room for their change is used up, in spacings. [A]"""
    currents = memory.values
    side = 1.0 if currents[count] > currents[0] else -1.0
    for node in range(count + 1):
        memory.forces[node] = room + TAKEN_UP - side * (currents[node] - currents[0])
    return first_fall(count, memory.forces, memory.powers)
