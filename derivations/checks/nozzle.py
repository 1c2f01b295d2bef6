"""Eqs. (7)-(16): flow through orifice and nozzle, and where its premises end."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from derivations import electromagnet, nozzle
from derivations.checks.finding import compared, found, stated
from derivations.compare import is_equal
from derivations.glossary import label, symbol, symbols
from derivations.paper import Paper
from derivations.verdict import Verdict

ATMOSPHERE = 101325.0  # Pa, standard
HEAT_RATIO = 1.4  # air


def verdicts(paper: Paper) -> Iterator[Verdict]:
    """Yield what is found of (7)-(16)."""
    yield stated(paper, "7", "what flows in flows out: Q_1 = Q_2 + Q_b")
    yield _density(paper)
    yield _orifice(paper)
    yield _choked(paper, "8", "orifice")
    yield _nozzle(paper)
    yield _choked(paper, "9", "nozzle")
    yield compared(paper, "10", nozzle.disc_area(), ("area of a disc: integral of 2 pi r dr from 0 to D_1/2",))
    yield compared(paper, "11", nozzle.curtain_area(), ("area of the curtain: integral of delta D_2/2 over the angle",))
    yield _curtain(paper)
    yield stated(paper, "12", "the flapper's travel closes the gap")
    yield _travel(paper)
    yield stated(paper, "13", "the drop over the orifice is the supply less the chamber")
    yield _gauge(paper)
    yield _chamber(paper)
    yield _rest(paper)
    yield _limits(paper)


def _density(paper: Paper) -> Verdict:
    low, high = paper.table_1["converter output"]
    supply = paper.numbers()[symbol("P_1")] + ATMOSPHERE
    ratios = [supply / (pressure + ATMOSPHERE) for pressure in (low, high)]
    return found(
        "7",
        "wrong premise" if max(ratios) > 1.1 else "holds",  # a tenth is what an engineer lets pass
        "one rho in (8) and (9)",
        "rho_1 Q_1 = rho_2 Q_2 + rho_b Q_b",
        (
            "a gas keeps its mass, not its volume; at one temperature rho goes with the absolute pressure",
            f"before the orifice {supply / 1e3:.1f} kPa, before the nozzle {(low + ATMOSPHERE) / 1e3:.1f}.."
            f"{(high + ATMOSPHERE) / 1e3:.1f} kPa absolute over the converter's range",
            f"the densities differ by a factor {ratios[1]:.2f}..{ratios[0]:.2f}",
        ),
        "Mass is kept, so (8) and (9) need two densities; with one, K takes up the difference at one pressure only.",
    )


def _orifice(paper: Paper) -> Verdict:
    mended = nozzle.orifice_flow() - nozzle.nozzle_flow()
    swap = {symbol("A_1"): nozzle.disc_area(), symbol("dP_1"): symbol("P_1") - symbol("P_b")}
    as_printed = paper["8"].right.subs(swap) - nozzle.nozzle_flow()
    return compared(
        paper,
        "8",
        nozzle.hole_flow(),
        (
            "Bernoulli: dP_1 = rho u^2/2, so u = sqrt(2 dP_1/rho); the flow is C_q1 A_1 u",
            f"(15) follows from the derived form: {is_equal(mended, paper['15'].right)}; "
            f"from the printed one: {is_equal(as_printed, paper['15'].right)}",
        ),
        "Delta P_1 belongs under the root, as in (9): Q_1 = C_q1 A_1 sqrt(2 Delta P_1/rho).",
    )


def _nozzle(paper: Paper) -> Verdict:
    letters = dict(zip(symbols("C_q1 A_1 dP_1"), symbols("C_q2 A_2 dP_2"), strict=True))
    derived = nozzle.hole_flow().subs(letters, simultaneous=True)
    return compared(paper, "9", derived, ("Bernoulli at the nozzle: Q_2 = C_q2 A_2 u with dP_2 = rho u^2/2",))


def critical_ratio() -> float:
    """Ratio of absolute pressures below which a hole passes sound: where its mass flow is largest."""
    ratio, heat = sp.symbols("r kappa", positive=True)
    squared = ratio ** (2 / heat) - ratio ** ((heat + 1) / heat)
    # r^(1 - 1/kappa) is linear in the condition that the derivative vanishes.
    power = sp.Symbol("q", positive=True)
    condition = sp.powsimp(sp.expand(sp.diff(squared, ratio) / ratio ** (2 / heat - 1)), force=True)
    (best,) = sp.solve(condition.subs(ratio, power ** (heat / (heat - 1))), power)
    return float((best ** (heat / (heat - 1))).subs(heat, HEAT_RATIO))


def choked_limits(paper: Paper) -> dict[str, float]:
    """Gauge pressures: below the first the orifice, above the second the nozzle is choked."""
    ratio = critical_ratio()
    supply = paper.numbers()[symbol("P_1")] + ATMOSPHERE
    return {"orifice": float(ratio * supply - ATMOSPHERE), "nozzle": float(ATMOSPHERE / ratio - ATMOSPHERE)}


def _choked(paper: Paper, equation: str, hole: str) -> Verdict:
    limits = choked_limits(paper)
    low, high = paper.table_1["converter output"]
    limit, side = limits[hole], "below" if hole == "orifice" else "above"
    share = (limit - low if hole == "orifice" else high - limit) / (high - low)
    is_always = limits["orifice"] >= limits["nozzle"]
    return found(
        equation,
        "wrong premise" if share > 0 else "holds",
        f"incompressible flow through the {hole}",
        f"choked {side} P_b = {limit / 1e3:.1f} kPa gauge",
        (
            f"the largest mass flow of a gas (kappa = {HEAT_RATIO:g}) is at r = (2/(kappa + "
            "1))^(kappa/(kappa - 1))"
            f" = {critical_ratio():.4f}",
            f"with {ATMOSPHERE / 1e3:.1f} kPa outside the {hole} is choked {side} {limit / 1e3:.1f} "
            "kPa gauge, "
            f"{100 * share:.0f} % of the converter's range {low / 1e3:g}..{high / 1e3:g} kPa",
            f"orifice below {limits['orifice'] / 1e3:.1f}, nozzle above {limits['nozzle'] / 1e3:.1f} kPa: "
            f"one of the two is choked at every pressure: {is_always}",
        ),
        "Compressible flow (Saint-Venant and Wantzel, or ISO 6358); the effect `choked_flow` has it.",
    )


def _curtain(paper: Paper) -> Verdict:
    gap, bore = symbol("delta"), sp.pi * symbol("D_2") ** 2 / 4
    (limit,) = sp.solve(sp.Eq(nozzle.curtain_area(), bore), gap)
    numbers = paper.numbers()
    wide, offset = limit.subs(numbers), float(electromagnet.gap_offset().subs(numbers))
    opened = numbers[symbol("delta_max")]
    return found(
        "11",
        "wrong premise" if offset > wide else "holds",
        paper["11"].text,
        f"A_2 = pi*D_2*delta while delta <= {label(limit)}",
        (
            f"the curtain is as wide as the bore at delta = {label(limit)} = {wide * 1e3:.2f} mm",
            f"delta_max = {opened * 1e3:g} mm is within: {bool(opened <= wide)}",
            f"but (31) puts the gap at no current at {offset * 1e3:.1f} mm, {float(offset / wide):.0f} times too far",
        ),
        "A_2 is the smaller of pi D_2 delta and pi D_2^2/4; with (31) and Table 2 the gap is outside.",
    )


def _travel(paper: Paper) -> Verdict:
    """One x in (12) and (22): follow the signs from current to pressure."""
    gap, flux, area, constant = symbols("x phi_delta S mu_0")
    reluctance = 2 * gap / (constant * area)
    force = sp.simplify(-sp.diff(flux**2 * reluctance / 2, gap))
    opening = sp.diff(paper["12"].right, gap)
    pressure = nozzle.pressure_by_gap()
    step = sp.sign(force) * opening * sp.sign(pressure)
    is_against = bool(step.is_negative) and paper.sentences["rising current"] == "the stem rises"
    return found(
        "12",
        "wrong premise" if is_against else "holds",
        "x is the flapper's travel in (12) and the magnet's air gap in (22)",
        "delta = delta_max - (x_0 - x) with x the air gap, and a force balance of the armature",
        (
            f"force along x: -d(phi_delta^2 R/2)/dx = {label(force)}, an attraction: x shrinks as i grows",
            f"(12): d delta/dx = {label(opening)}, so delta grows",
            f"(16): dP_b/d delta = {label(pressure)} < 0, so P_b falls and the stem goes down",
            f"sign of dP_b/di = {label(step)}; the text says: with more current {paper.sentences['rising current']}",
        ),
        "Two lengths are needed, tied so that the magnet closes the nozzle, and the armature's force balance.",
    )


def _gauge(paper: Paper) -> Verdict:
    total = sp.expand(paper["13"].right + paper["14"].right)
    return stated(
        paper,
        "14",
        f"the nozzle blows into the atmosphere; both drops add to {label(total)}, so the atmosphere is 0: gauge",
        is_met=bool(total == symbol("P_1")),
    )


def _chamber(paper: Paper) -> Verdict:
    return compared(
        paper,
        "15",
        nozzle.chamber_flow(),
        (
            f"(8) as it should be, with (10), (13): Q_1 = {label(nozzle.orifice_flow())}",
            f"(9) with (11), (14): Q_2 = {label(nozzle.nozzle_flow())}",
            "(7): Q_b = Q_1 - Q_2",
            f"over Q_1 at P_b = 0 it is {label(nozzle.normalised_inflow())} with K = {label(nozzle.flow_ratio())}",
        ),
    )


def _rest(paper: Paper) -> Verdict:
    ratio = float(nozzle.flow_ratio().subs(paper.numbers()))
    return compared(
        paper,
        "16",
        nozzle.static_pressure(),
        (
            "(15) with Q_b = 0: Q_1 = Q_2, both squared, is linear in P_b; solved for P_b",
            f"with K = {label(nozzle.flow_ratio())} it reads P_b = {label(nozzle.static_pressure_by_ratio())}",
            f"Table 2: K = {ratio:.5g} 1/m^2",
        ),
    )


def _limits(paper: Paper) -> Verdict:
    gap = symbol("delta")
    closed, opened = paper["16"].right.subs(gap, 0), sp.limit(paper["16"].right, gap, sp.oo)
    is_right = is_equal(closed, symbol("P_1")) and opened == 0
    return found(
        "text-16",
        "holds" if is_right else "wrong premise",
        "P_b = P_1 at delta = 0, P_b -> 0 as delta grows",
        f"P_b = {label(closed)} at delta = 0, P_b -> {label(opened)} as delta grows",
        (f"(16) at delta = 0: {label(closed)}", f"limit of (16) for delta to infinity: {label(opened)}"),
        "",
    )
