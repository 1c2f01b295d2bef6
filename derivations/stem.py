"""The stem, eqs. (1)-(6), derived from Newton's law and the friction of the packing."""

from __future__ import annotations

from functools import cache

import sympy as sp

from derivations.glossary import symbol, symbols


@cache
def driving_force() -> sp.Expr:
    """F_p + F_k with (2), (3), and the preload that the paper leaves out."""
    area, pressure, rate, position, preload = symbols("S_1 P_b k y F_0")
    return area * pressure - rate * position - preload


@cache
def kinetic_friction() -> sp.Expr:
    """What the moving stem must overcome, along the velocity: (5), first branch, times -1."""
    coulomb, viscous, velocity = symbols("F_c f_v v")
    return coulomb * sp.sign(velocity) + viscous * velocity


@cache
def smooth_friction() -> sp.Expr:
    """The same with tanh for sign, for gradients only."""
    return kinetic_friction().subs(sp.sign(symbol("v")), sp.tanh(symbol("v") / symbol("v_s")))


@cache
def acceleration() -> sp.Expr:
    """(1) solved for the acceleration, F_g = F_i = 0."""
    mass, rate, driving, friction = symbols("m a_y F_d F_f")
    (solution,) = sp.solve(sp.Eq(mass * rate, driving + friction), rate)
    return solution


@cache
def slip_acceleration() -> sp.Expr:
    """(6) in slip: the kinetic friction against the motion."""
    return acceleration().subs(symbol("F_f"), -kinetic_friction())


@cache
def outside_band(acceleration: sp.Expr) -> sp.Piecewise:
    """(33) as printed: no acceleration at all within the velocity band, whatever the force."""
    velocity, band = symbols("v epsilon")
    return sp.Piecewise((0, sp.Abs(velocity) < band), (acceleration, True))


@cache
def breakaway_excess() -> sp.Expr:
    """How far the driving force is beyond the static friction; the stem sticks while this is not positive."""
    return sp.Abs(symbol("F_d")) - symbol("F_s")


@cache
def moving_force(direction: int) -> sp.Expr:
    """Net force while the stem moves up (+1) or down (-1)."""
    friction = kinetic_friction().subs(sp.sign(symbol("v")), direction)
    return driving_force().subs(symbol("F_0"), 0) - friction


@cache
def starting_force(direction: int) -> sp.Expr:
    """Net force at v = 0 beyond the static friction, (5), third branch."""
    return driving_force().subs(symbol("F_0"), 0) - direction * symbol("F_s")
