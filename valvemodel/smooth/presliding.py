"""Motion of a stem on Dahl's bristles, smooth: one implicit step, stable however stiff the bristles are."""

from __future__ import annotations

from typing import Any

import casadi as ca

from valvemodel.smooth.rounding import Expression, dead_zone
from valvemodel.smooth.slip import Transition

NEWTON_STEPS = 8
"""Towards the way of a step; monotone from the way that a rigid contact would allow."""

LEAST_COMPLIANCE = 1e-11
"""Bristles are not stiffer, so that their neutral value 0 has a derivative. [m/N]"""


def advance_presliding(p: Any, x: Any, net: Expression, limit: Expression, motion: Transition) -> None:
    """Move the stem by the way at whose end the bristles, held over the step, balance it.

    References
    ----------
    Dahl (1968): df/dy = (1 - f sign(v)/F)/C, exact along a way in one direction.
    """
    reach = limit * ca.fmax(p.presliding_compliance, LEAST_COMPLIANCE)
    unresisted = motion.way_by_velocity * x.velocity + motion.way_by_force * net
    side = ca.sign(unresisted - motion.way_by_force * x.bristle)

    def bristle_after(way: Expression) -> tuple[Expression, Expression]:
        left = ca.exp(-ca.fmax(side * way, 0.0) / reach)
        return side * limit + (x.bristle - side * limit) * left, (limit - side * x.bristle) * left / reach

    held = limit * motion.way_by_force
    way = dead_zone(unresisted, held, held, p.smoothing_width * motion.way_by_force)
    way = ca.if_else(side * way > 0.0, way, 0.0)
    for _ in range(NEWTON_STEPS):
        force, slope = bristle_after(way)
        way += (unresisted - motion.way_by_force * force - way) / (1.0 + motion.way_by_force * slope)
    x.bristle = bristle_after(way)[0]
    x.position += way
    free = motion.velocity_by_velocity * x.velocity + motion.velocity_by_force * net
    x.velocity = free - motion.velocity_by_force * x.bristle
