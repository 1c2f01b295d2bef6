"""Bow of a linkage: what it indicates for a true position, and what its bend adds to a lag."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined
from valvemodel.stages.nodes import fit_powers, left_out

SKEW = 0.5 * math.sqrt(27.0)
"""Scales the skew so that its largest swing is the parameter (4 x (1 - x) (1 - 2 x) peaks at 4/sqrt(108))."""

BY_SLOT, BY_ROD = 24.0 * SKEW, 48.0 * SKEW
"""Square of an arm's way over its length through the whole travel, over the skew, where a slot or a rod turns it.

The angle of the arm is the arc tangent or the arc sine of its way over its length; both are matched to third order.
"""

DEAD_POINT = 0.98
"""Way over length of an arm on a rod from which on it goes on turning as it does there."""

STRAIGHT = 0.01
"""Share of the tolerance by which a linkage may bend along a step and still be straight."""

MOST_SOLVING = 60
"""Newton's steps from a reading to the position that a bowed linkage indicates so."""


@inlined
def is_arm(p):
    """Return whether the linkage is a whole arm: one without a skew is long, and its bow all that there is."""
    return p.linkage_arm > 0.0 and p.linkage_skew != 0.0


@inlined
def lever(p):
    """Return the way of an arm through the whole travel over its length."""
    return math.sqrt((BY_SLOT if p.linkage_skew < 0.0 else BY_ROD) * abs(p.linkage_skew) / p.rated_travel)


@inlined
def arm_way(p, share):
    """Return the way over its length of an arm at a share of the travel, from where it stands square to the stem."""
    return lever(p) * (share - 0.5 - p.linkage_bow / (6.0 * SKEW * p.linkage_skew))


@inlined
def arm_angle(p, way):
    """Return the angle of an arm by its way over its length."""
    if p.linkage_skew < 0.0:
        return math.atan(way)
    inside = min(max(way, -DEAD_POINT), DEAD_POINT)
    return math.asin(inside) + (way - inside) / math.sqrt(1.0 - inside * inside)


@inlined
def angle_slope(p, way):
    """Return how the angle of an arm changes with its way over its length."""
    if p.linkage_skew < 0.0:
        return 1.0 / (1.0 + way * way)
    inside = min(max(way, -DEAD_POINT), DEAD_POINT)
    return 1.0 / math.sqrt(1.0 - inside * inside)


@compiled
def arm_reading(p, share):
    """Return the share of the travel that an arm indicates, which reads true at both ends."""
    low, high = arm_angle(p, arm_way(p, 0.0)), arm_angle(p, arm_way(p, 1.0))
    return (arm_angle(p, arm_way(p, share)) - low) / (high - low)


@compiled
def arm_slope(p, share):
    """Return how that changes with the true share."""
    low, high = arm_angle(p, arm_way(p, 0.0)), arm_angle(p, arm_way(p, 1.0))
    return lever(p) * angle_slope(p, arm_way(p, share)) / (high - low)


@inlined
def bow(p, position):
    """Return the indicated for a true position; the identity for a straight linkage. [m]"""
    if p.linkage_bow == 0.0 and p.linkage_skew == 0.0:
        return position
    share = position / p.rated_travel
    if is_arm(p):
        return p.rated_travel * arm_reading(p, share)
    return position + 4.0 * share * (1.0 - share) * (p.linkage_bow + SKEW * p.linkage_skew * (1.0 - 2.0 * share))


@compiled
def unbow(p, reading):
    """Return the position that a bowed linkage indicates so, by Newton's steps from the reading. [m]"""
    if p.linkage_bow == 0.0 and p.linkage_skew == 0.0:
        return reading
    position = reading
    for _ in range(MOST_SOLVING):
        change = reading - bow(p, position)
        if is_arm(p):
            change /= bow_slope(p, position)
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
    if most <= STRAIGHT * tolerance and not is_arm(p):
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
    if is_arm(p):
        return arm_slope(p, share)
    slope = 4.0 * (1.0 - 2.0 * share) * (p.linkage_bow + SKEW * p.linkage_skew * (1.0 - 2.0 * share))
    slope -= 8.0 * share * (1.0 - share) * SKEW * p.linkage_skew
    return 1.0 + slope / p.rated_travel
