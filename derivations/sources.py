"""The one list of the functions that are generated: the derived expression, its name, its arguments."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import sympy as sp

from derivations import electromagnet, nozzle, self_calibration, slopes, stem
from derivations.electromagnet import PRINTED, RIGHT
from derivations.glossary import LETTERS, symbol, symbols


@dataclass(frozen=True)
class Source:
    """One function to generate; `letters` are its arguments in order, in the glossary's letters."""

    name: str
    stage: str
    letters: str
    expression: sp.Expr
    sentence: str
    equation: str
    unit: str
    parts: tuple[tuple[str, sp.Expr], ...] = ()

    def __post_init__(self) -> None:
        known = {*self.symbols, symbol("mu_0"), symbol("epsilon"), *(name for name, _ in self.named_parts)}
        missing = self.expression.free_symbols - known
        assert not missing, f"{self.name}: {missing}"

    @property
    def symbols(self) -> tuple[sp.Symbol, ...]:
        """The arguments as symbols, in order."""
        return symbols(self.letters)

    @property
    def named_parts(self) -> tuple[tuple[sp.Symbol, sp.Expr], ...]:
        """Subexpressions that get a line and a name of their own."""
        return tuple((_name(name), part) for name, part in self.parts)

    @property
    def closed_form(self) -> sp.Expr:
        """The expression in the arguments alone, the parts put back."""
        expression = self.expression
        for name, part in reversed(self.named_parts):
            expression = expression.subs(name, part)
        return expression

    @property
    def arguments(self) -> tuple[str, ...]:
        """The arguments as full names, in order."""
        return tuple(LETTERS[letter].name for letter in self.letters.split())


def _name(name: str) -> sp.Symbol:
    """The symbol of a part: the glossary's letter where the part is one."""
    return symbol("b") if name == LETTERS["b"].name else sp.Symbol(name, positive=True)


def sources() -> tuple[Source, ...]:
    """Return all functions to generate, in the order of the chain."""
    return (
        *_electromagnet(),
        *_flux(),
        *_nozzle(),
        *_stem(),
        *_self_calibration(),
        *(Source(*row) for row in slopes.rows()),
    )


def _electromagnet() -> Iterator[Source]:
    offset, slope_of_root = symbols("c_0 E")
    pressure = nozzle.static_pressure_by_ratio().subs(symbol("delta"), electromagnet.coil_gap())
    coil = "N S U sigma nu n"
    slope = (
        ("inductance_length", symbol("N") ** 2 * symbol("mu_0") * symbol("S")),
        ("rate_slope", 2 * symbol("sigma") * symbol("U") / _name("inductance_length")),
        ("power", 1 - 1 / symbol("nu")),
    )
    gain, printed_gain = (
        electromagnet.gap_gain(sign).subs((symbol("nu") - 1) / symbol("nu"), slope[2][1]) for sign in (RIGHT, PRINTED)
    )
    yield Source(
        "coil_gap", "electromagnet", "i c_0 E", electromagnet.coil_gap(),
        "Gap between nozzle and flapper, closing with the root of the current.", "(31) with v = 2", "m",
    )  # fmt: skip
    yield Source(
        "gap_by_current", "electromagnet", "i E", electromagnet.gap_by_current(),
        "Slope of the gap in the current, negative.", "(31) with v = 2, differentiated", "m/A",
    )  # fmt: skip
    yield Source(
        "gap_offset_of_coil", "electromagnet", "delta_max L_m sigma", electromagnet.gap_offset(),
        "Gap at no current that the coil's data give.", "(31)", "m",
    )  # fmt: skip
    yield Source(
        "gap_gain_of_coil", "electromagnet", coil, gain,
        "Gap gain that the coil's data give, with the right sign of (27): the factor is 1.",
        "(31), corrected", "m/A^((v-1)/v)", slope,
    )  # fmt: skip
    yield Source(
        "gap_gain_of_coil_as_printed", "electromagnet", coil, printed_gain,
        "Gap gain that the coil's data give with the wrong sign of (27): the factor is 2 v - 1.",
        "(31), as printed", "m/A^((v-1)/v)", slope,
    )  # fmt: skip
    yield Source(
        "pressure_of_current", "electromagnet", "i c_0 E P_1 K", pressure,
        "Gauge pressure at rest that a current gives.", "(32) with v = 2", "Pa",
    )  # fmt: skip
    assert {offset, slope_of_root} < pressure.free_symbols


def _flux() -> Iterator[Source]:
    coil = "i x N S L_m sigma"
    rate = "i x w U R_s N S L_m sigma"
    length, gap, leakage, turns, constant, area = symbols("L_m x sigma N mu_0 S")
    path = (("equivalent_length", length + 2 * leakage * gap),)
    constants = (*path, ("coil_constant", turns * constant * area))
    long = _name("equivalent_length")
    inductance = (
        *path,
        ("inductance", turns**2 * constant * area / long),
        ("rate_of_motion", 2 * leakage * symbol("i") * symbol("w") / long),
    )
    (root,) = sp.solve(sp.Eq(_name("inductance"), inductance[1][1]), turns)
    by_current, by_gap = electromagnet.flux_by_current(), electromagnet.flux_by_air_gap()
    right, printed = (
        sp.expand(electromagnet.current_rate_of_flux(by_current, slope).subs(path[0][1], _name("equivalent_length")))
        for slope in (by_gap, -by_gap)
    )
    yield Source(
        "coil_flux", "electromagnet", coil, electromagnet.coil_flux(),
        "Flux of the coil's core, from the magnetic circuit (21)-(24) as the paper states it.", "(25)",
        "Wb", path,
    )  # fmt: skip
    yield Source(
        "flux_by_current", "electromagnet", "x N S L_m sigma", by_current,
        "Slope of the flux in the current.", "(26)", "Wb/A", path,
    )  # fmt: skip
    yield Source(
        "flux_by_air_gap", "electromagnet", coil, by_gap,
        "Slope of the flux in the air gap, negative: a wider gap carries less flux.",
        "(27), corrected", "Wb/m", constants,
    )  # fmt: skip
    yield Source(
        "flux_by_air_gap_as_printed", "electromagnet", coil, -by_gap,
        "Slope of the flux in the air gap with the wrong sign.", "(27), as printed", "Wb/m", constants,
    )  # fmt: skip
    yield Source(
        "current_rate", "electromagnet", rate, right.subs(turns, root),
        "Rate of the current under a voltage while the air gap moves.", "(28), corrected", "A/s", inductance,
    )  # fmt: skip
    yield Source(
        "current_rate_as_printed", "electromagnet", rate, printed.subs(turns, root),
        "Rate of the current with the wrong sign of (27).", "(28), as printed", "A/s", inductance,
    )  # fmt: skip


def _nozzle() -> Iterator[Source]:
    drop, hole = symbol("dP_1"), nozzle.hole_flow().subs(symbol("A_1"), _name("area"))
    sizes = (
        ("nozzle_size", 4 * symbol("C_q2") * symbol("D_2")),
        ("orifice_size", symbol("C_q1") * symbol("D_1") ** 2),
    )
    ratio = (_name("nozzle_size") / _name("orifice_size")) ** 2
    disc = (("area", nozzle.disc_area()),)
    yield Source(
        "orifice_flow", "nozzle", "dP_1 C_q1 D_1 rho", hole,
        "Volume flow through the orifice, the pressure drop under the root.",
        "(8), corrected, with (10)", "m^3/s", disc,
    )  # fmt: skip
    yield Source(
        "orifice_flow_as_printed", "nozzle", "dP_1 C_q1 D_1 rho", hole * sp.sqrt(drop),
        "The same with the pressure drop outside the root, which is not a volume flow.",
        "(8), as printed, with (10)", "m^3/s*Pa^(1/2)", disc,
    )  # fmt: skip
    yield Source(
        "flow_ratio", "nozzle", "C_q1 D_1 C_q2 D_2", ratio,
        "K, how much the nozzle passes against the orifice, squared.", "(16)", "1/m^2", sizes,
    )  # fmt: skip
    yield Source(
        "static_pressure", "nozzle", "delta P_1 K", nozzle.static_pressure_by_ratio(),
        "Gauge back-pressure at rest, falling as the gap opens.", "(16)", "Pa",
    )  # fmt: skip
    yield Source(
        "pressure_by_gap", "nozzle", "delta P_1 K", nozzle.pressure_by_gap(),
        "Slope of the back-pressure in the gap, negative.", "(16), differentiated", "Pa/m",
    )  # fmt: skip
    yield Source(
        "chamber_inflow", "nozzle", "P_b delta P_1 K", nozzle.normalised_inflow(),
        "Flow into the chamber over the orifice's flow into an empty one.", "(15), normalised", "1",
    )  # fmt: skip


def _stem() -> Iterator[Source]:
    friction = (("friction", stem.kinetic_friction()),)
    slip = stem.acceleration().subs(symbol("F_f"), -_name("friction"))
    yield Source(
        "driving_force", "stem", "P_b y S_1 k F_0", stem.driving_force(),
        "Pressure force less spring force, positive along the position.", "(1)-(3)", "N",
    )  # fmt: skip
    yield Source(
        "kinetic_friction", "stem", "v F_c f_v", stem.kinetic_friction(),
        "Friction that the moving stem overcomes, positive along the velocity.",
        "(5), v not 0, times -1", "N",
    )  # fmt: skip
    yield Source(
        "smooth_friction", "stem", "v F_c f_v v_s", stem.smooth_friction(),
        "The same with tanh for the sign: for gradients, never for the truth.", "(5), smoothed", "N",
    )  # fmt: skip
    yield Source(
        "slip_acceleration", "stem", "F_d v m F_c f_v", slip,
        "Acceleration of the stem in slip.", "(6), v not 0, without the velocity band", "m/s^2", friction,
    )  # fmt: skip
    yield Source(
        "slip_acceleration_as_printed", "stem", "F_d v m F_c f_v", stem.outside_band(slip),
        "Acceleration with the paper's velocity band of 1e-4 m/s, in which nothing accelerates.",
        "(33), as printed", "m/s^2", friction,
    )  # fmt: skip
    yield Source(
        "breakaway_excess", "stem", "F_d F_s", stem.breakaway_excess(),
        "Driving force beyond the static friction; a resting stem sticks while this is not positive.",
        "(5), v = 0", "N",
    )  # fmt: skip


def _self_calibration() -> Iterator[Source]:
    currents, positions = symbols("I_1 I_2 I_3"), symbols("Y_1 Y_2 Y_3")
    means = (("mean_current", sp.Add(*currents) / 3), ("mean_position", sp.Add(*positions) / 3))
    secants = tuple(
        (name, (positions[j + 1] - positions[j]) / (currents[j + 1] - currents[j]))
        for j, name in enumerate(("first_secant", "second_secant"))
    )
    slope = _name("first_secant") / 2 + _name("second_secant") / 2
    intercept = _name("mean_position") - symbol("k_m") * _name("mean_current")
    yield Source(
        "branch_slope", "self-calibration", "I_1 Y_1 I_2 Y_2 I_3 Y_3", slope,
        "Slope of one branch from three records.", "(35), (36)", "m/A", secants,
    )  # fmt: skip
    yield Source(
        "mean_slope", "self-calibration", "k_1 k_2", self_calibration.mean_slope(),
        "Slope of both branches.", "(37)", "m/A",
    )  # fmt: skip
    yield Source(
        "branch_intercept", "self-calibration", "k_m I_1 Y_1 I_2 Y_2 I_3 Y_3", intercept,
        "Intercept of one branch from three records and the slope.", "(38), (39)", "m", means,
    )  # fmt: skip
    yield Source(
        "current_threshold", "self-calibration", "k_m b_1 b_2", self_calibration.loop_width(),
        "Full width of the loop in current.", "(40)", "A",
    )  # fmt: skip
