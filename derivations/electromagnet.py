"""The electromagnet, eqs. (17)-(31), derived from the circuit and the magnetic circuit.

`flux_slope_sign` runs through as a parameter: -1 is what differentiating (25) gives, +1 what (27) prints.
"""

from __future__ import annotations

from functools import cache

import sympy as sp

from derivations.glossary import symbol, symbols

RIGHT, PRINTED = -1, 1


@cache
def coil_flux() -> sp.Expr:
    """Flux of the core, (25), with phi_delta, R, H_m, B eliminated from (21)-(24) as the paper has them."""
    current, turns, gap_flux, reluctance, field, flux = symbols("i N phi_delta R H_m phi")
    length, gap, area, leakage, constant = symbols("L_m x S sigma mu_0")
    circuit = [
        sp.Eq(current * turns, gap_flux * reluctance + field * length),
        sp.Eq(reluctance, 2 * gap / (constant * area)),
        sp.Eq(gap_flux, leakage * flux),
        sp.Eq(flux / area, constant * field),
    ]
    (solution,) = sp.solve(circuit, [flux, gap_flux, reluctance, field], dict=True)
    return sp.factor(solution[flux])


@cache
def coil_flux_with_iron() -> sp.Expr:
    """Flux of the core with leakage the right way round and a core of relative permeability mu_r."""
    current, turns, gap_flux, reluctance, field, flux = symbols("i N phi_delta R H_m phi")
    length, gap, area, leakage, constant, relative = symbols("L_m x S sigma mu_0 mu_r")
    circuit = [
        sp.Eq(current * turns, gap_flux * reluctance + field * length),
        sp.Eq(reluctance, 2 * gap / (constant * area)),
        sp.Eq(flux, leakage * gap_flux),
        sp.Eq(flux / area, constant * relative * field),
    ]
    (solution,) = sp.solve(circuit, [flux, gap_flux, reluctance, field], dict=True)
    return sp.factor(solution[flux])


@cache
def flux_by_current() -> sp.Expr:
    """(26)."""
    return sp.factor(sp.diff(coil_flux(), symbol("i")))


@cache
def flux_by_air_gap() -> sp.Expr:
    """(27) with the sign that differentiating gives."""
    return sp.factor(sp.diff(coil_flux(), symbol("x")))


@cache
def voltage_balance() -> sp.Expr:
    """(19): (17) with (18), the flux differentiated along i(t), x(t)."""
    time = symbol("t")
    current, gap = sp.Function("i")(time), sp.Function("x")(time)
    flux = sp.Function("phi")(current, gap)
    rate = sp.diff(symbol("N") * flux, time)
    letters = {
        sp.Derivative(flux, current): symbol("phi_i"),
        sp.Derivative(flux, gap): symbol("phi_x"),
        sp.Derivative(current, time): symbol("i_t"),
        sp.Derivative(gap, time): symbol("w"),
    }
    return symbol("i") * symbol("R_s") + rate.subs(letters)


@cache
def current_rate() -> sp.Expr:
    """(20): (19) solved for di/dt."""
    (rate,) = sp.solve(sp.Eq(symbol("U"), voltage_balance()), symbol("i_t"))
    return sp.expand(rate)


def current_rate_of_flux(by_current: sp.Expr, by_gap: sp.Expr) -> sp.Expr:
    """(28): (20) with the derivatives of the flux put in."""
    return current_rate().subs({symbol("phi_i"): by_current, symbol("phi_x"): by_gap})


@cache
def ansatz_factor(sign: int) -> sp.Expr:
    """e/(b n) for which i = e t^v, X = n t^(v-1) solves (1/b) di/dt = X - sign (1/b)(i/X) dX/dt."""
    time, slope, factor, exponent, amplitude = symbols("t b n nu e")
    current, gap = amplitude * time**exponent, factor * time ** (exponent - 1)
    balance = sp.diff(current, time) / slope - gap + sign * current / gap * sp.diff(gap, time) / slope
    (solution,) = sp.solve(sp.powsimp(sp.expand(balance / time ** (exponent - 1))), amplitude)
    return sp.factor(sp.simplify(solution / (slope * factor)))


def gap_of_ansatz(factor: sp.Expr) -> sp.Expr:
    """(31): t eliminated from i = b n factor t^v, X = n t^(v-1), with x = X - L_m/(2 sigma)."""
    time, slope, scale, exponent, current = symbols("t b n nu i")
    (moment,) = sp.solve(sp.Eq(sp.log(current), sp.log(slope * scale * factor) + exponent * sp.log(time)), time)
    travel = scale * sp.powdenest(moment, force=True) ** (exponent - 1) - rest_shift()
    return symbol("delta_max") - travel


def rest_shift() -> sp.Expr:
    """a/b = j/s = L_m/(2 sigma): what stands beside x in X."""
    return symbol("L_m") / (2 * symbol("sigma"))


@cache
def rate_slope() -> sp.Expr:
    """b of (29)."""
    turns, constant, area, leakage, voltage = symbols("N mu_0 S sigma U")
    return 2 * leakage * voltage / (turns**2 * constant * area)


@cache
def gap_offset() -> sp.Expr:
    """c0 of (31): the gap at no current."""
    return symbol("delta_max") + rest_shift()


@cache
def gap_gain(sign: int) -> sp.Expr:
    """E of (31), so that delta = c0 - E i^((v-1)/v), b left as it is."""
    exponent, scale, slope = symbols("nu n b")
    power = (exponent - 1) / exponent
    inner = scale ** (1 / (exponent - 1)) / (slope * ansatz_factor(sign))
    gain = inner**power
    closing = gap_offset() - gap_of_ansatz(ansatz_factor(sign))
    log_ratio = sp.expand_log(sp.log(closing) - sp.log(gain * symbol("i") ** power), force=True)
    assert sp.simplify(log_ratio) == 0, "gap_gain is not (31)"
    return gain


@cache
def coil_gap() -> sp.Expr:
    """(31) with v = 2, as a function of c0 and E."""
    return symbol("c_0") - symbol("E") * sp.sqrt(symbol("i"))


@cache
def gap_by_current() -> sp.Expr:
    """Slope of the gap in the current."""
    return sp.diff(coil_gap(), symbol("i"))
