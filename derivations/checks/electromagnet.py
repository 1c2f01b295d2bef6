"""Eqs. (17)-(28): the circuit, the magnetic circuit and the flux."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from derivations import electromagnet
from derivations.checks.finding import compared, found, stated
from derivations.compare import is_equal
from derivations.dimensions import fault
from derivations.glossary import label, symbol, symbols
from derivations.paper import Paper
from derivations.verdict import Verdict


def verdicts(paper: Paper) -> Iterator[Verdict]:
    """Yield what is found of (17)-(28)."""
    yield stated(paper, "17", "Kirchhoff: the voltage is the drop over the resistance and the induction")
    yield _rest_state(paper)
    yield stated(paper, "18", "each turn links the flux")
    yield compared(
        paper,
        "19",
        electromagnet.voltage_balance(),
        ("(18) into (17), phi(i(t), x(t)) differentiated by the chain rule",),
    )
    yield compared(paper, "20", electromagnet.current_rate(), ("(19) solved for di/dt",))
    yield stated(paper, "21", "Kirchhoff for the magnetic circuit: the turns drive the gap and the core")
    yield _core_drop(paper)
    yield _reluctance(paper)
    yield _armature(paper)
    yield _leakage(paper)
    yield stated(paper, "24", "flux density is permeability times field strength")
    yield _permeability(paper)
    yield compared(
        paper,
        "25",
        electromagnet.coil_flux(),
        ("(21)-(24) as stated, solved for phi with phi_delta, R, H_m eliminated",),
    )
    yield compared(paper, "26", electromagnet.flux_by_current(), ("(25) differentiated by i",))
    yield _flux_slope(paper)
    yield _current_rate(paper)


def _rest_state(paper: Paper) -> Verdict:
    """With U fixed and R_s = 0 nothing can rest: set all rates to zero in (20)."""
    rate = electromagnet.current_rate_of_flux(electromagnet.flux_by_current(), electromagnet.flux_by_air_gap())
    still = rate.subs({symbol("w"): 0, symbol("R_s"): 0})
    rests = sp.solve(sp.Eq(still, 0), symbol("i"))
    numbers = paper.numbers()
    top = paper.table_1["converter input"][1]
    growth = float(still.subs(numbers).subs(symbol("x"), 0))
    resistance = numbers[symbol("U")] / top
    held = sp.solve(sp.Eq(rate.subs(symbol("w"), 0), 0), symbol("R_s"))[0]
    is_impossible = not rests and bool(still.is_positive)
    return found(
        "17",
        "wrong premise" if is_impossible else "holds",
        "U is a fixed value; the coil resistance is small and can be ignored",
        f"at rest R_s = {label(held)}",
        (
            f"(20) at rest (dx/dt = 0) with R_s = 0: di/dt = {label(sp.factor(still))} > 0 for every i",
            f"currents at which di/dt = 0: {len(rests)}, so i grows for ever",
            f"Table 2 at x = 0: di/dt = {growth:.2f} A/s, {top * 1e3:g} mA are passed after "
            f"{top / growth * 1e3:.1f} ms",
            f"to hold {top * 1e3:g} mA at {numbers[symbol('U')]:g} V takes R_s = {label(held)} = "
            f"{resistance:.0f} ohm, "
            "all of the voltage: R_s is not small",
            "the valve is driven by a current; then (17) only tells which voltage appears",
        ),
        "The current is the input (4-20 mA); the circuit (17)-(29) adds nothing to the static gap.",
    )


def _core_drop(paper: Paper) -> Verdict:
    """Share of the ampere turns that (21) with (24) spends in the core."""
    flux, length, area, constant, gap = symbols("phi L_m S mu_0 x")
    core = flux / area / constant * length
    air = symbol("sigma") * flux * 2 * gap / (constant * area)
    share = sp.simplify(core / (core + air))
    value = float(share.subs(paper.numbers()).subs(gap, paper.numbers()[symbol("delta_max")]))
    return found(
        "21",
        "wrong premise" if value > 0.5 else "holds",
        "H_m L_m with (24), while the reluctance of the armature is ignored",
        "H_m L_m = phi L_m/(mu_0 mu_r S), small beside phi_delta R for iron",
        (
            f"H_m L_m over i N with (22)-(24) as printed: {label(share)}",
            f"Table 2 at x = delta_max: the core takes {100 * value:.1f} % of the ampere turns, the gap the rest",
            "in a magnet of iron it is the other way round: the core has the permeability of air here",
        ),
        "L_m stands where L_m/mu_r belongs, see (24).",
    )


def _reluctance(paper: Paper) -> Verdict:
    gap, area, constant = symbols("x S mu_0")
    derived = 2 * gap / (constant * area)
    unknown = paper["22"].right.free_symbols - {gap, area, constant}
    repaired = paper["22"].right.subs(dict.fromkeys(unknown, constant))
    wrong = fault(paper["22"].left, paper["22"].right)
    is_repaired = bool(unknown) and is_equal(repaired, derived)
    named = ", ".join(letter.name for letter in unknown)
    return found(
        "22",
        "misprint" if is_repaired else "holds" if is_equal(paper["22"].right, derived) else "wrong premise",
        paper["22"].text,
        f"R = {label(derived)}",
        (
            "reluctance of an air gap: length over permeability and area; the flux crosses two gaps of length x",
            f"letters that the paper uses nowhere else: {named or 'none'}",
            wrong or "the dimensions agree",
            f"with mu_0 for {named or 'nothing'} printed less derived is 0: {is_equal(repaired, derived)}",
        ),
        f"R = {label(derived)}: mu_0, not u_0.",
    )


def _armature(paper: Paper) -> Verdict:
    """Pull of the magnet by (21)-(25) against the jet on the flapper: the missing balance, in numbers."""
    flux, gap, area, constant = symbols("phi_delta x S mu_0")
    pull = sp.Abs(sp.diff(flux**2 * gap / (constant * area), gap))
    numbers = paper.numbers()
    top = paper.table_1["converter input"][1]
    through = symbol("sigma") * electromagnet.coil_flux().subs(gap, 0)
    force = float(pull.subs(flux, through).subs({**numbers, symbol("i"): top}))
    pressure = paper.table_1["converter output"][1]
    jet = float(sp.pi / 4 * numbers[symbol("D_2")] ** 2 * pressure)
    balance = [
        key
        for key in paper.equations
        if paper[key].right.has(symbol("phi_delta")) and paper[key].left.has(symbol("a_y"))
    ]
    return found(
        "22",
        "holds" if balance else "incomplete",
        "no force balance of the armature",
        f"pull = {label(pull)}",
        (
            f"equations in which the flux moves anything: {len(balance)} of {len(paper.equations)}",
            f"pull of two gaps: d(phi_delta^2 x/(mu_0 S))/dx = {label(pull)}",
            f"Table 2, {top * 1e3:g} mA, x = 0, printed (23), (25): {force:.3f} N",
            f"jet on the flapper: P_b pi D_2^2/4 = {jet:.3f} N at {pressure / 1e3:g} kPa",
            f"without a lever the pull is {100 * force / jet:.0f} % of what the jet alone asks for",
        ),
        "Pull, spring and jet on the armature decide the gap; the paper gives none of them.",
    )


def _leakage(paper: Paper) -> Verdict:
    core, gap, leakage = symbols("phi phi_delta sigma")
    share = paper["23"].right / core
    value = float(share.subs(paper.numbers()))
    printed, mended = electromagnet.coil_flux(), electromagnet.coil_flux_with_iron().subs(symbol("mu_r"), 1)
    path = sp.expand(symbol("i") * symbol("N") * symbol("mu_0") * symbol("S") / mended)
    return found(
        "23",
        "wrong premise" if value > 1 else "holds",
        paper["23"].text,
        f"{label(core)} = {label(leakage * gap)}",
        (
            "flux leaks on its way to the gap, so phi_delta <= phi; printed phi_delta/phi = "
            f"{label(share)} = {value:g}",
            f"with (23) as printed: phi = {label(printed)}",
            f"with phi = sigma phi_delta: phi = {label(mended)}",
            f"so (25) has L_m + 2 sigma x where {label(path)} belongs",
        ),
        "phi = sigma phi_delta with sigma >= 1, so (25) would have L_m + 2 x/sigma.",
    )


def _permeability(paper: Paper) -> Verdict:
    relative = symbol("mu_r")
    mended = electromagnet.coil_flux_with_iron()
    path = sp.expand(symbol("i") * symbol("N") * symbol("mu_0") * symbol("S") / mended)
    of_length = path.coeff(symbol("L_m"))
    numbers = paper.numbers()
    shift = float(electromagnet.rest_shift().subs(numbers))
    opened = numbers[symbol("delta_max")]
    iron = 1000.0  # a low value for soft iron
    is_of_air = not paper["24"].right.has(relative)
    return found(
        "24",
        "wrong premise" if is_of_air and shift > opened else "holds",
        paper["24"].text,
        f"B = {label(symbol('mu_0') * relative * symbol('H_m'))}",
        (
            f"(24) has no mu_r: {is_of_air}; with it (21)-(24) give i N mu_0 S/phi = {label(path)}",
            f"the factor of L_m is {label(of_length)}, printed 1",
            f"(31) has L_m/(2 sigma) in the gap at no current: {shift * 1e3:.1f} mm, delta_max is {opened * 1e3:g} mm",
            f"with mu_r = {iron:g} it would be {shift / iron * 1e3:.3f} mm",
        ),
        "B = mu_0 mu_r H_m in the core, so L_m/mu_r stands where (21), (25), (31) have L_m.",
    )


def _flux_slope(paper: Paper) -> Verdict:
    return compared(
        paper,
        "27",
        electromagnet.flux_by_air_gap(),
        (
            f"(25): phi = {label(electromagnet.coil_flux())}",
            f"differentiated by x: {label(electromagnet.flux_by_air_gap())}",
            f"a wider gap carries less flux: the derivative is negative: {electromagnet.flux_by_air_gap().is_negative}",
        ),
        "d phi/dx = - 2 sigma N mu_0 S i/(L_m + 2 sigma x)^2.",
    )


def _current_rate(paper: Paper) -> Verdict:
    derived = sp.expand(
        electromagnet.current_rate_of_flux(electromagnet.flux_by_current(), electromagnet.flux_by_air_gap())
    )
    chained = electromagnet.current_rate_of_flux(paper["26"].right, paper["27"].right)
    return compared(
        paper,
        "28",
        derived,
        (
            "(26) and the derived (27) into (20)",
            f"with the printed (27): {label(sp.expand(chained))}",
        ),
        "The last term is + 2 sigma i/(L_m + 2 sigma x) dx/dt.",
        inherited=chained,
    )
