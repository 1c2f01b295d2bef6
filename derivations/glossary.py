"""Every letter of the paper, bound once to a full name, a unit, a meaning and a sign."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import sympy as sp


@dataclass(frozen=True)
class Letter:
    """One letter: `letter` is ours and unique, `printed` is the paper's where that differs."""

    letter: str
    name: str
    unit: str
    meaning: str
    sign: str = "positive"
    printed: str = ""

    @property
    def label(self) -> str:
        """The letter as the paper prints it."""
        return self.printed or self.letter


_STEM = (
    Letter("t", "time", "s", "time"),
    Letter("m", "stem_mass", "kg", "mass of the stem"),
    Letter("y", "position", "m", "stem displacement", "any; grows with the pressure", "y_1"),
    Letter("v", "velocity", "m/s", "stem velocity", "any; positive while y grows"),
    Letter("a_y", "acceleration", "m/s^2", "stem acceleration", "any; positive along y", "(d2y_1/dt2)"),
    Letter("F_p", "pressure_force", "N", "force of the pressure on the diaphragm", "any; positive along y"),
    Letter("F_k", "spring_force", "N", "force of the spring", "any; negative for y > 0"),
    Letter("F_f", "friction_force", "N", "force of the packing on the stem", "any; against the motion"),
    Letter("F_g", "flow_force", "N", "force of the fluid on the plug", "any; taken as 0"),
    Letter("F_i", "seat_force", "N", "force that presses the plug into its seat", "any; taken as 0"),
    Letter("F_0", "spring_preload", "N", "spring force at y = 0; not in the paper", "any; against y"),
    Letter("F_d", "driving", "N", "net driving force F_p + F_k", "any; positive along y"),
    Letter("F_c", "coulomb_friction", "N", "Coulomb friction"),
    Letter("F_s", "static_friction", "N", "largest static friction"),
    Letter("f_v", "viscous_friction", "kg/s", "viscous friction"),
    Letter("epsilon", "velocity_band", "m/s", "speed below which the paper says v = 0"),
    Letter("v_s", "smoothing_velocity", "m/s", "width of the tanh that smooths sign(v); not in the paper"),
    Letter("S_1", "diaphragm_area", "m^2", "area of the diaphragm"),
    Letter("k", "spring_rate", "N/m", "spring rate"),
)
_NOZZLE = (
    Letter("P_b", "pressure", "Pa", "gauge pressure of the back-pressure chamber"),
    Letter("P_1", "supply_pressure", "Pa", "gauge supply pressure"),
    Letter("dP_1", "orifice_pressure_drop", "Pa", "pressure drop over the orifice", printed="DeltaP_1"),
    Letter("dP_2", "nozzle_pressure_drop", "Pa", "pressure drop over the nozzle", printed="DeltaP_2"),
    Letter("Q_1", "orifice_flow", "m^3/s", "flow through the orifice", "any; into the chamber"),
    Letter("Q_2", "nozzle_flow", "m^3/s", "flow through the nozzle", "any; out of the chamber"),
    Letter("Q_b", "chamber_flow", "m^3/s", "flow on to the amplifier", "any; out of the chamber"),
    Letter("C_q1", "orifice_flow_coefficient", "1", "flow coefficient of the orifice"),
    Letter("C_q2", "nozzle_flow_coefficient", "1", "flow coefficient of the nozzle"),
    Letter("A_1", "orifice_area", "m^2", "area of the orifice"),
    Letter("A_2", "nozzle_area", "m^2", "area of the gas passage at the nozzle"),
    Letter("D_1", "orifice_diameter", "m", "diameter of the orifice"),
    Letter("D_2", "nozzle_diameter", "m", "diameter of the nozzle"),
    Letter("rho", "density", "kg/m^3", "density of the gas"),
    Letter("delta", "gap", "m", "distance from nozzle to flapper"),
    Letter("delta_max", "maximum_gap", "m", "that distance with no current"),
    Letter("K", "flow_ratio", "1/m^2", "16 C_q2^2 D_2^2 / (C_q1^2 D_1^4)"),
    Letter(
        "P_0", "pressure_at_zero_current", "Pa", "offset of a straight current-pressure line; not in the paper", "any"
    ),
    Letter("P_i", "pressure_per_current", "Pa/A", "slope of a straight current-pressure line; not in the paper"),
)
_ELECTROMAGNET = (
    Letter("x", "air_gap", "m", "travel of the flapper in (12), air gap of the magnet in (22)"),
    Letter("w", "air_gap_velocity", "m/s", "dx/dt", "any", "(dx/dt)"),
    Letter("i", "current", "A", "coil current"),
    Letter("i_t", "current_rate", "A/s", "di/dt", "any", "(di/dt)"),
    Letter("U", "supply_voltage", "V", "voltage of the coil"),
    Letter("R_s", "coil_resistance", "ohm", "resistance of the coil"),
    Letter("psi", "flux_linkage", "Wb", "flux linkage"),
    Letter("N", "coil_turns", "1", "turns of the coil"),
    Letter("phi", "coil_flux", "Wb", "flux of the core"),
    Letter("phi_delta", "gap_flux", "Wb", "flux of the air gap"),
    Letter("phi_i", "flux_by_current", "Wb/A", "partial derivative of phi by i", printed="(dphi/di)"),
    Letter("phi_x", "flux_by_air_gap", "Wb/m", "partial derivative of phi by x", "any", "(dphi/dx)"),
    Letter("R", "gap_reluctance", "A/Wb", "reluctance of the air gap"),
    Letter("B", "flux_density", "T", "flux density of the core"),
    Letter("H_m", "field_strength", "A/m", "field strength in the core"),
    Letter("L_m", "magnetic_path_length", "m", "length of the magnetic path"),
    Letter("S", "magnetic_area", "m^2", "area of the magnetic path"),
    Letter("sigma", "leakage_coefficient", "1", "leakage coefficient of the air gap, core flux over gap flux"),
    Letter("mu_0", "magnetic_constant", "H/m", "permeability of free space"),
    Letter("mu_r", "relative_permeability", "1", "relative permeability of the core; not in the paper"),
    Letter("a", "rate_offset", "A/s", "L_m U/(N^2 mu_0 S)"),
    Letter("b", "rate_slope", "A/(m*s)", "2 sigma U/(N^2 mu_0 S)"),
    Letter("j", "path_length", "m", "L_m in (29)"),
    Letter("s", "double_leakage", "1", "2 sigma in (29)"),
    Letter("X", "shifted_gap", "m", "a/b + x in (30)"),
    Letter("X_t", "shifted_gap_rate", "m/s", "dX/dt", "any", "(dX/dt)"),
    Letter("e", "current_factor", "A/s^nu", "factor of the ansatz i = e t^v"),
    Letter("n", "ansatz_factor", "m/s^(nu-1)", "factor of the ansatz X = n t^(v-1)"),
    Letter("nu", "ansatz_exponent", "1", "exponent of the ansatz; the paper's second v", printed="v"),
    Letter("c_0", "gap_offset", "m", "gap at no current, delta_max + L_m/(2 sigma)"),
    Letter("E", "gap_gain", "m/A^(1/2)", "closing of the gap with sqrt(i); (33)'s E over 4 C_q2 D_2"),
)
_INTEGRATION = (
    Letter("C_33", "pressure_constant", "m^4*Pa", "C of (33)", printed="C"),
    Letter("D_33", "gap_constant", "m^2", "D of (33)", printed="D"),
    Letter("E_33", "current_constant", "m^2/A^((nu-1)/nu)", "E of (33)", printed="E"),
    Letter("F_33", "orifice_constant", "m^4", "F of (33)", printed="F"),
)
_CALIBRATION = (
    *(Letter(f"I_{j}", f"current_{j}", "A", f"current of record {j}") for j in range(1, 7)),
    *(Letter(f"Y_{j}", f"position_{j}", "m", f"position {j}, rising", "any", f"A_{j}") for j in range(1, 4)),
    *(Letter(f"B_{j}", f"falling_position_{j}", "m", f"position {j}, falling", "any") for j in range(1, 4)),
    Letter("k_1", "rising_slope", "m/A", "slope of the rising branch"),
    Letter("k_2", "falling_slope", "m/A", "slope of the falling branch"),
    Letter("k_m", "slope", "m/A", "mean slope; the paper's second k", printed="k"),
    Letter("b_1", "rising_intercept", "m", "intercept of the rising branch", "any"),
    Letter("b_2", "falling_intercept", "m", "intercept of the falling branch", "any; above b_1"),
    Letter("W", "current_threshold", "A", "I_threshold", printed="I_threshold"),
    Letter("i_SC", "calibrated_current", "A", "current of the self-calibration"),
    Letter("u", "controller_output", "A", "output of the controller", "any"),
    Letter("K_P", "proportional_gain", "A/m", "proportional gain"),
    Letter("K_I", "integral_gain", "A/m", "integral gain of one sample"),
    Letter("K_D", "derivative_gain", "A/m", "derivative gain of one sample"),
    Letter("e_0", "error_now", "m", "e(k)", "any", "e(k)"),
    Letter("e_1", "error_before", "m", "e(k - 1)", "any", "e(k-1)"),
    Letter("e_sum", "error_sum", "m", "sum of e(j), j = 0..k", "any", "sum_e"),
)

_EFFECTS = (
    Letter("r_m", "saturation_slope", "1", "slope above the knee over slope below"),
    Letter("i_k", "saturation_knee", "A", "current at the knee"),
    Letter("w_i", "saturation_rounding", "A", "width of the knee"),
    Letter("b_i", "saturation_reach", "A", "way above the knee over which the gain falls"),
    Letter("T_f", "chamber_filling_time", "s", "time to fill to P_1 at the full orifice flow"),
    Letter("g_f", "filling_growth", "1", "growth of that time from no pressure to P_1", "any"),
    Letter("r_p", "pressure_ratio", "1", "absolute pressure behind a hole over that before it"),
    Letter("b_c", "critical_pressure_ratio", "1", "b of ISO 6358"),
    Letter("s_p", "pressure_share", "1", "pressure over supply"),
    Letter("c_d", "droop_consumption", "1", "sag over P_1 at the full flow of the orifice"),
    Letter("P_a", "actuator_pressure", "Pa", "gauge pressure behind the leak"),
    Letter("l_a", "leak_ratio", "1", "pressure lost over supply at full pressure"),
    Letter("g_a", "turbulent_leak_ratio", "1", "square of the hole's area over that of a turbulent restriction", "any"),
    Letter("a_y1", "area_slope", "1/m", "share of area over travel", "any"),
    Letter("a_y2", "area_curvature", "1/m^2", "share of area over travel squared", "any"),
    Letter("h_k", "spring_hardening", "1/m^2", "share of stiffening over travel squared", "any"),
    Letter("g_k", "spring_progression", "1/m", "share of stiffening over travel", "any"),
    Letter("A_t", "tight_spot_excess", "1", "excess friction in the middle of the spot", "any"),
    Letter("y_t", "tight_spot_position", "m", "middle of the spot", "any"),
    Letter("w_t", "tight_spot_width", "m", "half-width, at 1/e where q_t is 0"),
    Letter("n_t", "tight_spot_exponent", "1", "2 for a bell, more for steeper sides"),
    Letter(
        "q_t", "tight_spot_closure", "1", "how the spot ends: 0 fading out, more at a distance, less with tails", "any"
    ),
    Letter("S_p", "friction_area", "m^2", "friction per pressure", "any"),
    Letter("n_p", "friction_pressure_order", "1", "power of the pressure"),
    Letter("u_y", "speed", "m/s", "speed of the stem along its motion"),
    Letter("r_s", "stribeck_ratio", "1", "friction at speed 0 over Coulomb friction"),
    Letter(
        "v_b", "stribeck_velocity", "m/s", "speed at which the drop has fallen to 1/e; half of a tail is left there"
    ),
    Letter("n_s", "stribeck_shape", "1", "1 falls at once, 2 as a bell"),
    Letter("t_s", "stribeck_tail", "1", "share of the drop that falls as a fraction, not exponentially", "any"),
    Letter("h_l", "linkage_bow", "m", "bow in the middle of the travel", "any"),
    Letter("s_l", "linkage_skew", "m", "swing between the halves of the travel", "any"),
    Letter("L", "rated_travel", "m", "travel from 0 to 100 %"),
)
"""What the paper has no letters for: named as the effects declare it."""

LETTERS = {
    letter.letter: letter for letter in (*_STEM, *_NOZZLE, *_ELECTROMAGNET, *_INTEGRATION, *_CALIBRATION, *_EFFECTS)
}
assert len(LETTERS) == sum(map(len, (_STEM, _NOZZLE, _ELECTROMAGNET, _INTEGRATION, _CALIBRATION, _EFFECTS))), (
    "a letter is bound twice"
)

MAGNETIC_CONSTANT = sp.Float(4e-7) * sp.pi  # H/m, the value before 2019; the new one differs by 1e-10


@cache
def symbol(letter: str) -> sp.Symbol:
    """Return the sympy symbol of one letter of the glossary."""
    if LETTERS[letter].sign == "positive":
        return sp.Symbol(letter, positive=True)
    return sp.Symbol(letter, real=True)


def symbols(letters: str) -> tuple[sp.Symbol, ...]:
    """Return the symbols of several letters, written with blanks between them."""
    return tuple(symbol(letter) for letter in letters.split())


def label(expression: sp.Basic) -> str:
    """Write an expression with the letters that the paper prints."""
    shown = sp.sympify(expression).xreplace(_printed_symbols())
    if not isinstance(shown, sp.Piecewise):
        return sp.sstr(shown)
    return "; ".join(
        f"{sp.sstr(value)} {'else' if condition == sp.true else f'if {sp.sstr(condition)}'}"
        for value, condition in shown.args
    )


def typeset(expression: sp.Basic) -> str:
    """Write an expression in LaTeX."""
    return sp.latex(expression, symbol_names=_latex_names(), mul_symbol=r"\,")


@cache
def _printed_symbols() -> dict[sp.Symbol, sp.Symbol]:
    return {symbol(key): sp.Symbol(letter.label) for key, letter in LETTERS.items() if letter.printed}


@cache
def _latex_names() -> dict[sp.Symbol, str]:
    special: dict[str, str] = {
        "a_y": r"\ddot{y}_1",
        "phi_i": r"\frac{\partial\phi}{\partial i}",
        "phi_x": r"\frac{\partial\phi}{\partial x}",
        "dP_1": r"\Delta P_1",
        "dP_2": r"\Delta P_2",
        "w": r"\frac{dx}{dt}",
        "i_t": r"\frac{di}{dt}",
        "X_t": r"\frac{dX}{dt}",
        "W": r"I_{threshold}",
        "e_0": "e(k)",
        "e_1": "e(k-1)",
        "e_sum": r"{\textstyle\sum_{j=0}^{k} e(j)}",
        "nu": "v",
    }
    names = {symbol(key): sp.latex(sp.Symbol(letter.label)) for key, letter in LETTERS.items()}
    return names | {symbol(key): text for key, text in special.items()}
