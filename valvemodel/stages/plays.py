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

SHARES = -np.arange(PLAYS + 1) / PLAYS * math.expm1(-CUT)
"""Shares of the whole density below the ends of equal shares of what is kept of it."""

LEAST_EVENNESS, ALIKE = 1e-6, 1.0 - 1e-9
"""Evenness up to which the density is the exponential one, and from which on all plays are one."""

TAKEN_UP = 1e-12
"""A play with less room is taken up. [A]"""


@compiled
def lay_radii(p, radii):
    """Fill in the mean radii of equal shares of the density, least first; their own mean is 1.

    A share u of the plays has no more than a radius in proportion to 1 - (1 - u)^(e / (1 - e)), at an evenness e: an
    exponential density in the limit of 0, an even one at 1/2, one radius at 1 (generalised Pareto distribution).
    """
    even = p.play_evenness
    if even >= ALIKE:
        radii[:] = 1.0
        return
    for index in range(PLAYS):
        least, most = 1.0 - SHARES[index], 1.0 - SHARES[index + 1]
        if even < LEAST_EVENNESS:
            radii[index] = (least - least * math.log(least)) - (most - most * math.log(most))
        else:
            power = 1.0 / (1.0 - even)
            radii[index] = (least - most) - (least**power - most**power) / power
    radii *= PLAYS / radii.sum()


@inlined
def scale_of_plays(p):
    """Return the mean radius of the plays; what share of the flux is without a play makes up for it. [A]"""
    return p.hysteresis_half_width * (1.0 + p.hysteresis_roundness)


@compiled
def begin_plays(p, state):
    """Put the plays where they start, all alike in their rooms."""
    lay_radii(p, state.radii)
    for index in range(PLAYS):
        room = scale_of_plays(p) * state.radii[index]
        state.plays[index] = state.hysteresis_input - p.hysteresis_start * room


@inlined
def play_after(play, radius, current):
    """Return where a play is once the current has gone one way: dragged where its room is used up. [A]"""
    return min(max(play, current - radius), current + radius)


@compiled
def place_among_plays(p, state, current):
    """Return where in their common loop the plays are, -1..1, once the current has gone one way."""
    scale, total = scale_of_plays(p), 0.0
    for index in range(PLAYS):
        total += current - play_after(state.plays[index], scale * state.radii[index], current)
    return total / (PLAYS * scale)


@compiled
def pull_plays(p, state, current):
    """Let the plays follow a current."""
    scale = scale_of_plays(p)
    for index in range(PLAYS):
        state.plays[index] = play_after(state.plays[index], scale * state.radii[index], current)


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
        left = scale * state.radii[index] - side * (currents[0] - state.plays[index])
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
