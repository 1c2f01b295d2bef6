"""The nozzle and flapper, eqs. (7)-(16), derived from flow through two thin-walled holes in series."""

from __future__ import annotations

from functools import cache

import sympy as sp

from derivations.glossary import symbol, symbols


@cache
def hole_flow() -> sp.Expr:
    """Flow through a hole: Bernoulli gives the speed, the flow coefficient the narrowing of the jet."""
    area, coefficient, density, drop = symbols("A_1 C_q1 rho dP_1")
    speed = sp.Symbol("speed", positive=True)
    (jet,) = sp.solve(sp.Eq(drop, density * speed**2 / 2), speed)
    return coefficient * area * jet


@cache
def disc_area() -> sp.Expr:
    """Area of the orifice, as an integral over rings."""
    radius = sp.Symbol("r", positive=True)
    return sp.integrate(2 * sp.pi * radius, (radius, 0, symbol("D_1") / 2))


@cache
def curtain_area() -> sp.Expr:
    """Area of the cylinder between the nozzle's rim and the flapper."""
    angle = sp.Symbol("angle", real=True)
    nozzle_diameter, gap = symbols("D_2 delta")
    return sp.integrate(nozzle_diameter / 2 * gap, (angle, 0, 2 * sp.pi))


@cache
def orifice_flow() -> sp.Expr:
    """Flow into the chamber, (8) with (10) and (13)."""
    supply, pressure = symbols("P_1 P_b")
    return hole_flow().subs(symbol("A_1"), disc_area()).subs(symbol("dP_1"), supply - pressure)


@cache
def nozzle_flow() -> sp.Expr:
    """Flow out of the chamber, (9) with (11) and (14)."""
    swap = {symbol("C_q1"): symbol("C_q2"), symbol("A_1"): curtain_area(), symbol("dP_1"): symbol("P_b")}
    return hole_flow().subs(swap, simultaneous=True)


@cache
def chamber_flow() -> sp.Expr:
    """Flow on to the amplifier, (15), by continuity (7)."""
    return orifice_flow() - nozzle_flow()


@cache
def flow_ratio() -> sp.Expr:
    """K: the nozzle's flow at unit gap over the orifice's, squared, at equal drops."""
    at_unit_gap = nozzle_flow().subs(symbol("delta"), 1) / sp.sqrt(symbol("P_b"))
    orifice = hole_flow().subs(symbol("A_1"), disc_area()) / sp.sqrt(symbol("dP_1"))
    return sp.simplify((at_unit_gap / orifice) ** 2)


@cache
def static_pressure() -> sp.Expr:
    """Pressure at which nothing flows on, (16), in the paper's letters."""
    # Q_1 = Q_2 with both sides positive is the same as the equality of their squares, which is linear in P_b.
    (pressure,) = sp.solve(sp.Eq(orifice_flow() ** 2, nozzle_flow() ** 2), symbol("P_b"))
    return sp.factor(pressure)


@cache
def static_pressure_by_ratio() -> sp.Expr:
    """(16) with K for the geometry: P_1 / (1 + K delta^2)."""
    (diameter,) = sp.solve(sp.Eq(symbol("K"), flow_ratio()), symbol("D_2"))
    gap, supply, ratio = symbols("delta P_1 K")
    reduced = sp.simplify(static_pressure().subs(symbol("D_2"), diameter))
    wanted = supply / (1 + ratio * gap**2)
    assert sp.simplify(reduced - wanted) == 0
    return wanted


@cache
def normalised_inflow() -> sp.Expr:
    """(15) over the orifice's flow into an empty chamber: no density, no area, only K."""
    pressure, supply, gap, ratio = symbols("P_b P_1 delta K")
    share = chamber_flow() / orifice_flow().subs(pressure, 0)
    (diameter,) = sp.solve(sp.Eq(ratio, flow_ratio()), symbol("D_2"))
    wanted = sp.sqrt(1 - pressure / supply) - sp.sqrt(ratio) * gap * sp.sqrt(pressure / supply)
    difference = share.subs(symbol("D_2"), diameter) - wanted
    below_supply = sp.Symbol("p", positive=True)
    assert sp.simplify(difference.subs(supply, pressure + below_supply)) == 0
    return wanted


@cache
def pressure_by_gap() -> sp.Expr:
    """Slope of (16) in the gap."""
    return sp.diff(static_pressure_by_ratio(), symbol("delta"))
