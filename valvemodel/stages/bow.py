"""Bow of a linkage: what it indicates for a true position, and what its bend adds to a lag."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined
from valvemodel.stages.nodes import fit_powers, left_out

SKEW = 0.5 * math.sqrt(27.0)
"""Scales the skew so that its largest swing is the parameter (4 x (1 - x) (1 - 2 x) peaks at 4/sqrt(108))."""

STRAIGHT = 0.01
"""Share of the tolerance by which a linkage may bend along a step and still be straight."""


@inlined
def bow(p, position):
    """Return the indicated for a true position; the identity for a straight linkage. [m]"""
    if p.linkage_bow == 0.0 and p.linkage_skew == 0.0:
        return position
    share = position / p.rated_travel
    return position + 4.0 * share * (1.0 - share) * (p.linkage_bow + SKEW * p.linkage_skew * (1.0 - 2.0 * share))


@compiled
def unbow(p, reading):
    """Return the position that a bowed linkage indicates so, by iteration from the reading. [m]"""
    if p.linkage_bow == 0.0 and p.linkage_skew == 0.0:
        return reading
    position = reading
    for _ in range(60):
        change = reading - bow(p, position)
        position += change
        if abs(change) < 1e-15:
            break
    return position


@compiled
def bow_left_out(p, memory, count, tolerance):
    """Return by how much a lagged reading is off where a bow is a polynomial through the nodes of a step. [m]"""
    way = memory.ways[count]
    curvature = 8.0 * (abs(p.linkage_bow) + 6.0 * SKEW * abs(p.linkage_skew)) / (p.rated_travel * p.rated_travel)
    most = curvature * way * way
    if most <= STRAIGHT * tolerance:
        return most
    side = memory.step_side
    start = memory.step_position - side * p.backlash_half_width
    gain = bow_slope(p, start + 0.5 * side * way)
    for node in range(count + 1):
        slope = bow_slope(p, start + side * memory.ways[node])
        memory.forces[node] = (slope - gain) * memory.speeds[node]
    fit_powers(count, memory.forces, memory.powers)
    return left_out(count, memory.powers) * memory.step_spacing * count


@inlined
def bow_slope(p, position):
    """Return how the indicated position changes with the true one."""
    share = position / p.rated_travel
    slope = 4.0 * (1.0 - 2.0 * share) * (p.linkage_bow + SKEW * p.linkage_skew * (1.0 - 2.0 * share))
    slope -= 8.0 * share * (1.0 - share) * SKEW * p.linkage_skew
    return 1.0 + slope / p.rated_travel
