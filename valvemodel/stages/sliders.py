"""Many small contacts in parallel, each elastic until it slides: Iwan's sliders. They remember each turn.

None carries more than what holds it, ahead or behind: where friction falls, sliders that were bent farther slide back.
Beside a tight spot so steep, or sliders so soft, that what holds one grows faster than the stem moves, where it sticks
anew is known to the nodes of a step only: a run may be off by some tenths of a millimetre.
"""

from __future__ import annotations

import math

import numpy as np

from valvemodel.compiled import compiled, inlined

SLIDERS = 16
"""In parallel; their polygon is within 0.1 % of the friction of the parabola that ever more of them approach."""

YIELDS = (2.0 * np.arange(SLIDERS) + 1.0) / SLIDERS
"""Forces at which they slide, over their mean: spread evenly from none to twice it."""

TAKEN_UP = 1e-12
"""A slider with less room slides. [m]"""


LEAST_SHARE = 1e-8
"""Of the friction, below which sliders are left out: 0, to a search that stays within its bounds."""


@inlined
def has_sliders(p):
    """Return whether sliders carry a share of the friction."""
    return p.slider_share > LEAST_SHARE


@inlined
def bend_after(bend, way, room, room_behind):
    """Return how far a slider is bent along the motion after a way. [m]"""
    return min(max(bend, -room_behind) + way, room)


@compiled
def bend_sliders(p, state, force):
    """Let the sliders carry a force at rest, each in proportion to what it can."""
    for index in range(SLIDERS):
        state.sliders[index] = YIELDS[index] * force * p.presliding_compliance


@compiled
def force_of_sliders(p, state):
    """Return the force of the sliders. [N]"""
    total = 0.0
    for index in range(SLIDERS):
        total += state.sliders[index]
    return total / (SLIDERS * p.presliding_compliance)


@compiled
def sliders_after(p, state, side, way, limit, limit_behind):
    """Return the force of the sliders after a way to one side, counted against it. [N]"""
    reach, behind, total = limit * p.presliding_compliance, limit_behind * p.presliding_compliance, 0.0
    for index in range(SLIDERS):
        yields = YIELDS[index]
        total += bend_after(side * state.sliders[index], way, yields * reach, yields * behind)
    return total / (SLIDERS * p.presliding_compliance)


@compiled
def pull_sliders(p, state, side, way, limit, limit_behind):
    """Take the sliders along a way to one side."""
    reach, behind = limit * p.presliding_compliance, limit_behind * p.presliding_compliance
    for index in range(SLIDERS):
        yields = YIELDS[index]
        state.sliders[index] = side * bend_after(side * state.sliders[index], way, yields * reach, yields * behind)


@compiled
def stiffness_of_sliders(p, state, side, limit):
    """Return by how much the force of the sliders grows with the way to one side. [N/m]"""
    reach, bending = limit * p.presliding_compliance, 0.0
    for index in range(SLIDERS):
        if side * state.sliders[index] < YIELDS[index] * reach - TAKEN_UP:
            bending += 1.0
    return bending / (SLIDERS * p.presliding_compliance)


@compiled
def way_to_sliding(p, state, side, limit):
    """Return the way to one side after which the next slider slides, infinity where all do. [m]"""
    reach, way = limit * p.presliding_compliance, math.inf
    for index in range(SLIDERS):
        room = YIELDS[index] * reach - side * state.sliders[index]
        if room > TAKEN_UP:
            way = min(way, room)
    return way


@compiled
def lay_sliders(p, state, memory, count, keep):
    """Write the force of the sliders at the nodes of a step, under the limits there; keep where they end if wanted."""
    side = memory.step_side
    for node in range(count + 1):
        memory.slid[node] = 0.0
    for index in range(SLIDERS):
        bend, before = side * state.sliders[index], 0.0
        for node in range(count + 1):
            reach = YIELDS[index] * p.presliding_compliance
            way = memory.ways[node] - before
            bend = bend_after(bend, way, reach * memory.limits[node], reach * memory.limits_behind[node])
            before = memory.ways[node]
            memory.slid[node] += bend / (SLIDERS * p.presliding_compliance)
        if keep:
            state.sliders[index] = side * bend
