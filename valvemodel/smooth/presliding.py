"""Motion of a stem on bristles and sliders, smooth: one implicit step, stable however stiff they are."""

from __future__ import annotations

from typing import Any

import casadi as ca

from valvemodel.smooth.contact import take_along
from valvemodel.smooth.rounding import Expression, dead_zone, gate, ramp
from valvemodel.smooth.slip import Transition
from valvemodel.stages.sliders import SLIDERS, YIELDS

NEWTON_STEPS = 8
"""Towards the way of a step; monotone from the way that a rigid contact would allow."""

LEAST_COMPLIANCE = 1e-11
"""Bristles are not stiffer, so that their neutral value 0 has a derivative. [m/N]"""


LEAST_BEND, LEAST_ROOM = 1e-6, 1e-9
"""The exponent of bristles is above 1 by as much more, and their room over the limit not less, for the derivatives."""

SLIDER_STATES = tuple(f"slider_{index}" for index in range(SLIDERS))


def advance_presliding(
    p: Any, x: Any, net: Expression, limit: Expression, motion: Transition, duration: Expression
) -> None:
    """Move the stem by the way at whose end bristles and sliders, held over the step, balance it.

    References
    ----------
    Dahl (1968): df/dy = (1 - f sign(v)/F)^n/C, exact along a way in one direction.
    """
    compliance = compliance_of(p)
    reach = limit * compliance
    unresisted = motion.way_by_velocity * x.velocity + motion.way_by_force * net
    side = ca.sign(unresisted - motion.way_by_force * elastic_friction(p, x))
    # What the bristles' damping takes over the step is the change of their force.
    viscous = p.bristle_damping * compliance / duration

    def friction_after(way: Expression) -> tuple[Expression, Expression]:
        bristle, slope = bristle_after(p, x, side, way, limit, reach)
        force, stiffness = bristle + viscous * (bristle - x.bristle), slope * (1.0 + viscous)
        if p.slides:
            bends = [slider_after(p, x, index, side, way, reach) for index in range(SLIDERS)]
            sliders, rate = (sum(each) / (SLIDERS * compliance) for each in zip(*bends, strict=True))
            force += p.slider_share * (side * sliders - force)
            stiffness += p.slider_share * (rate - stiffness)
        return force, stiffness

    held = limit * motion.way_by_force
    way = dead_zone(unresisted, held, held, p.smoothing_width * motion.way_by_force)
    way = ca.if_else(side * way > 0.0, way, 0.0)
    for _ in range(NEWTON_STEPS):
        force, slope = friction_after(way)
        way += (unresisted - motion.way_by_force * force - way) / (1.0 + motion.way_by_force * slope)
    force = friction_after(way)[0]
    if p.slides:
        after = [side * slider_after(p, x, index, side, way, reach)[0] for index in range(SLIDERS)]
        for name, bend in zip(SLIDER_STATES, after, strict=True):
            setattr(x, name, bend)
    x.bristle = bristle_after(p, x, side, way, limit, reach)[0]
    take_along(p, x, way)
    free = motion.velocity_by_velocity * x.velocity + motion.velocity_by_force * net
    x.velocity = free - motion.velocity_by_force * force


def compliance_of(p: Any) -> Expression:
    """Return the yield over force, not quite 0. [m/N]"""
    return ca.fmax(p.presliding_compliance, LEAST_COMPLIANCE)


def bend_sliders(p: Any, x: Any, force: Expression) -> None:
    """Let the sliders carry a force at rest, each in proportion to what it can."""
    for name, share in zip(SLIDER_STATES, YIELDS, strict=True):
        setattr(x, name, share * force * compliance_of(p))


def let_slide(p: Any, x: Any, rising: Expression, falling: Expression) -> None:
    """Let sliders slide that friction, upwards or downwards, does not hold any more where it fell."""
    for name, share in zip(SLIDER_STATES, YIELDS, strict=True):
        reach = float(share) * compliance_of(p)
        setattr(x, name, ca.fmin(ca.fmax(getattr(x, name), -reach * falling), reach * rising))


def elastic_friction(p: Any, x: Any) -> Expression:
    """Return the force of bristles and sliders at rest. [N]"""
    if not p.slides:
        return x.bristle
    sliders = sum(getattr(x, name) for name in SLIDER_STATES) / (SLIDERS * compliance_of(p))
    return x.bristle + p.slider_share * (sliders - x.bristle)


def bristle_after(
    p: Any, x: Any, side: Expression, way: Expression, limit: Expression, reach: Expression
) -> tuple[Expression, Expression]:
    """Return the force of the bristles after a way, and by how much it grows with it. [N], [N/m]"""
    gone = ca.fmax(side * way, 0.0) / reach
    if not p.curves:
        left = ca.exp(-gone)
        return side * limit + (x.bristle - side * limit) * left, (limit - side * x.bristle) * left / reach
    bend = p.bristle_exponent - 1.0 + LEAST_BEND
    steep = ca.fmax(1.0 - side * x.bristle / limit, LEAST_ROOM) ** bend
    left = ca.exp(-ca.log1p(bend * steep * gone) / bend)
    slope = (limit - side * x.bristle) * left * steep / (1.0 + bend * steep * gone) / reach
    return side * limit + (x.bristle - side * limit) * left, slope


def slider_after(
    p: Any, x: Any, index: int, side: Expression, way: Expression, reach: Expression
) -> tuple[Expression, Expression]:
    """Return how far a slider is bent along the motion after a way, and whether it still bends. [m], 1"""
    width = p.smoothing_share * reach
    left = float(YIELDS[index]) * reach - side * (getattr(x, SLIDER_STATES[index]) + way)
    return float(YIELDS[index]) * reach - ramp(left, width), gate(left, width)
