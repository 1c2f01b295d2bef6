"""The slopes that a linearisation needs: the laws of base valve and effects, differentiated."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import sympy as sp

from derivations.glossary import symbol, symbols
from derivations.nozzle import normalised_inflow

_PARTS = (
    "above_knee", "share_of_supply", "relative_ratio", "relative_distance", "distance_power", "fall", "steepness",
    "relative_speed", "speed_power", "power_slope", "share_slope", "share_of_travel", "bow_slope", "skew_slope", "ramp",
    "ramp_slope", "loss_slope", "arm_lever", "arm_centre", "arm_way", "arm_spread",
)  # fmt: skip
(
    ABOVE,
    PRESSURE_SHARE,
    RELATIVE,
    DISTANCE,
    DISTANCE_POWER,
    FALL,
    STEEPNESS,
    RELATIVE_SPEED,
    SPEED_POWER,
    POWER_SLOPE,
    SHARE_SLOPE,
    TRAVEL_SHARE,
    BOW_SLOPE,
    SKEW_SLOPE,
    RAMP,
    RAMP_SLOPE,
    LOSS_SLOPE,
    ARM_LEVER,
    ARM_CENTRE,
    ARM_WAY,
    ARM_SPREAD,
) = (sp.Symbol(name, positive=True) for name in _PARTS)
"""What the laws are functions of; each is a part with a line of its own."""


def rows() -> Iterator[tuple[Any, ...]]:
    """Yield the arguments of `Source` for each function to generate, in the order of the chain."""
    for name, law, lost in (
        ("saturated_current_by_current", "", lost_current()),
        ("current_saturated_as_tanh_by_current", " by the law of tanh", lost_by_tanh()),
    ):
        yield (
            name, "electromagnet", "i r_m i_k w_i b_i",
            1 - (1 - symbol("r_m")) * LOSS_SLOPE * RAMP_SLOPE,
            f"Slope of the current that the flux stands for{law}.", "magnetic_saturation, differentiated", "1",
            (
                (ABOVE.name, symbol("i") - symbol("i_k")),
                (RAMP.name, rounded_ramp()),
                (RAMP_SLOPE.name, sp.diff(rounded_ramp(), ABOVE)),
                (LOSS_SLOPE.name, sp.factor(sp.diff(lost, RAMP))),
            ),
        )  # fmt: skip
    yield (
        "chamber_rate", "nozzle", "P_b delta P_1 K T_f g_f", chamber_rate(),
        "Rate at which a small departure of the pressure from its rest dies out.",
        "chamber_filling, differentiated", "1/s",
        (
            (PRESSURE_SHARE.name, symbol("P_b") / symbol("P_1")),
            ("filling_time", filling_time()),
            ("inflow_slope", inflow_slope()),
        ),
    )  # fmt: skip
    relative_ratio = ((RELATIVE.name, (symbol("r_p") - symbol("b_c")) / (1 - symbol("b_c"))),)
    yield (
        "subsonic_share", "nozzle", "r_p b_c", subsonic_share(),
        "Flow through a hole over its choked flow, above the critical ratio.", "choked_flow", "1", relative_ratio,
    )  # fmt: skip
    yield (
        "subsonic_share_by_ratio", "nozzle", "r_p b_c", sp.diff(subsonic_share(), RELATIVE) / (1 - symbol("b_c")),
        "Slope of that flow in the ratio.", "choked_flow, differentiated", "1", relative_ratio,
    )  # fmt: skip
    yield (
        "settled_droop_by_share", "nozzle", "s_p c_d P_1", sp.diff(settled_droop(), symbol("s_p")),
        "Slope of the sag that the nozzle's own air keeps up.", "supply_droop, differentiated", "Pa",
    )  # fmt: skip
    yield (
        "leaked_pressure_by_pressure", "nozzle", "P_a l_a g_a P_1", 1 / sp.diff(pressure_before_leak(), symbol("P_a")),
        "Slope of the actuator pressure behind the leak in the pressure before it.",
        "air_leak, differentiated", "1",
    )  # fmt: skip
    yield (
        "thrust_by_pressure", "stem", "y S_1 a_y1 a_y2", effective_area(),
        "Slope of the driving force in the pressure: the effective area.", "area_variation, differentiated", "m^2",
    )  # fmt: skip
    yield (
        "thrust_by_position", "stem", "P_b y S_1 k h_k g_k a_y1 a_y2",
        symbol("P_b") * sp.Symbol("area_by_position", positive=True) - sp.Symbol("spring_stiffness", positive=True),
        "Slope of the driving force in the position, negative where the stem is stable.",
        "spring_hardening and area_variation, differentiated", "N/m",
        (
            ("area_by_position", sp.factor(sp.diff(effective_area(), symbol("y")))),
            ("spring_stiffness", sp.factor(sp.diff(spring_force(), symbol("y")))),
        ),
    )  # fmt: skip
    from_middle = symbol("y") - symbol("y_t")
    power = DISTANCE ** symbol("n_t")
    for name, letters, shape in (
        ("tight_friction_by_position", "n_t", fading_spot()),
        ("ending_friction_by_position", "n_t q_t", ending_spot()),
    ):
        yield (
            name, "stem", f"y F_c A_t y_t w_t {letters}",
            sp.powsimp(sp.diff(tight_friction(shape), DISTANCE_POWER)) * symbol("n_t") * STEEPNESS / symbol("w_t"),
            "Slope of the Coulomb friction in the position.", "position_dependent_friction, differentiated", "N/m",
            (
                (DISTANCE.name, sp.Abs(from_middle) / symbol("w_t")),
                (DISTANCE_POWER.name, power),
                (FALL.name, sp.powsimp(sp.diff(shape, DISTANCE_POWER))),
                (STEEPNESS.name, sp.powsimp(sp.diff(power, DISTANCE)) / symbol("n_t") * sp.sign(from_middle)),
            ),
        )  # fmt: skip
    yield (
        "seal_friction_by_pressure", "stem", "P_b S_p n_p P_1",
        sp.powsimp(sp.diff(seal_friction(), PRESSURE_SHARE)) / symbol("P_1"),
        "Slope of the Coulomb friction in the pressure.", "pressure_dependent_friction, differentiated", "m^2",
        ((PRESSURE_SHARE.name, symbol("P_b") / symbol("P_1")),),
    )  # fmt: skip
    power = RELATIVE_SPEED ** symbol("n_s")
    faster = ((RELATIVE_SPEED.name, symbol("u_y") / symbol("v_b")), (SPEED_POWER.name, power))
    yield (
        "stribeck_factor", "stem", "u_y r_s v_b n_s t_s", stribeck_factor(),
        "Friction in slip over Coulomb friction.", "stribeck", "1", faster,
    )  # fmt: skip
    yield (
        "stribeck_factor_by_speed", "stem", "u_y r_s v_b n_s t_s",
        (symbol("r_s") - 1) * SHARE_SLOPE * POWER_SLOPE / symbol("v_b"),
        "Slope of that factor in the speed, negative.", "stribeck, differentiated", "s/m",
        (
            *faster,
            (POWER_SLOPE.name, sp.powsimp(sp.diff(power, RELATIVE_SPEED))),
            (SHARE_SLOPE.name, sp.diff(stribeck_share(), SPEED_POWER)),
        ),
    )  # fmt: skip
    yield (
        "reading_by_position", "sensor", "y h_l s_l L",
        1 + (symbol("h_l") * BOW_SLOPE + symbol("s_l") * SKEW_SLOPE) / symbol("L"),
        "Slope of the reading in the position of the linkage.", "linkage_nonlinearity, differentiated", "1",
        (
            (TRAVEL_SHARE.name, symbol("y") / symbol("L")),
            (BOW_SLOPE.name, bow_by_share(symbol("h_l"))),
            (SKEW_SLOPE.name, bow_by_share(symbol("s_l"))),
        ),
    )  # fmt: skip
    for name, angle in (("slot", sp.atan), ("rod", sp.asin)):
        yield (
            f"reading_by_position_with_{name}", "sensor", "y h_l s_l L",
            ARM_LEVER * sp.diff(angle(ARM_WAY), ARM_WAY) / ARM_SPREAD,
            f"Slope of the reading in the position of a whole arm that a {name} turns.",
            "linkage_nonlinearity, differentiated", "1",
            (
                (TRAVEL_SHARE.name, symbol("y") / symbol("L")),
                (ARM_LEVER.name, sp.sqrt(arm_lever_squared(angle))),
                (ARM_CENTRE.name, arm_centre()),
                (ARM_WAY.name, ARM_LEVER * (TRAVEL_SHARE - ARM_CENTRE)),
                (ARM_SPREAD.name, angle(ARM_LEVER * (1 - ARM_CENTRE)) + angle(ARM_LEVER * ARM_CENTRE)),
            ),
        )  # fmt: skip


def rounded_ramp() -> sp.Expr:
    """The current above the knee, 0 below it, with a rounded corner."""
    return (ABOVE + sp.sqrt(ABOVE**2 + symbol("w_i") ** 2)) / 2


def lost_current() -> sp.Expr:
    """What is lost above the knee with no slope far above it: the rest is Froehlich's hyperbola, or nothing."""
    return RAMP**2 / (RAMP + symbol("b_i"))


def lost_by_tanh() -> sp.Expr:
    """The same where the rest is a hyperbolic tangent."""
    return RAMP - symbol("b_i") * sp.tanh(RAMP / symbol("b_i"))


def filling_time() -> sp.Expr:
    """The time to fill grows with the pressure, as the diaphragm gives way."""
    duration, growth = symbols("T_f g_f")
    return duration * (1 + growth * PRESSURE_SHARE)


def inflow_slope() -> sp.Expr:
    """How the inflow (15) falls as the pressure's share of the supply grows."""
    inflow = normalised_inflow().subs(symbol("P_b"), PRESSURE_SHARE * symbol("P_1"))
    return -sp.diff(inflow, PRESSURE_SHARE)


def chamber_rate() -> sp.Expr:
    """T dP/dt = P_1 inflow, linearised in the pressure."""
    return sp.Symbol("inflow_slope", positive=True) / sp.Symbol("filling_time", positive=True)


def subsonic_share() -> sp.Expr:
    """ISO 6358: an ellipse between the critical ratio of the pressures and 1."""
    return sp.sqrt(1 - RELATIVE**2)


def settled_droop() -> sp.Expr:
    """The sag of the supply under the flow that the orifice passes at rest."""
    share, consumption, supply = symbols("s_p c_d P_1")
    return consumption * supply * sp.sqrt(1 - share)


def pressure_before_leak() -> sp.Expr:
    """Restriction, laminar or turbulent, into a turbulent hole, at rest."""
    behind, ratio, turbulent, supply = symbols("P_a l_a g_a P_1")
    return (1 + turbulent) * behind + ratio * sp.sqrt(supply * behind)


def effective_area() -> sp.Expr:
    """The diaphragm's area changes with travel."""
    position, area, slope, curvature = symbols("y S_1 a_y1 a_y2")
    return area * (1 + slope * position + curvature * position**2)


def spring_force() -> sp.Expr:
    """A progressive spring, and Duffing's cubic one."""
    position, rate, hardening, progression = symbols("y k h_k g_k")
    return rate * position * (1 + progression * position + hardening * position**2)


def tight_friction(shape: sp.Expr) -> sp.Expr:
    """Coulomb friction with a tight spot of some shape."""
    coulomb, excess = symbols("F_c A_t")
    return coulomb * (1 + excess * shape)


def fading_spot() -> sp.Expr:
    """A bell, or with an exponent above 2 one with steeper sides and a flat top."""
    return sp.exp(-DISTANCE_POWER)


def ending_spot() -> sp.Expr:
    """The same that ends at a distance, or fades out more slowly: Tsallis' exponential."""
    closure = symbol("q_t")
    return (1 - closure * DISTANCE_POWER) ** (1 / closure)


def seal_friction() -> sp.Expr:
    """Friction of a self-energising lip."""
    area, order, supply = symbols("S_p n_p P_1")
    return area * supply * PRESSURE_SHARE**order


def stribeck_factor() -> sp.Expr:
    """Friction falls from breakaway to Coulomb as the stem speeds up."""
    return 1 + (symbol("r_s") - 1) * stribeck_share()


def stribeck_share() -> sp.Expr:
    """What is left of that drop, exponential or with Hess and Soom's tail."""
    tail = symbol("t_s")
    return (1 - tail) * sp.exp(-SPEED_POWER) + tail / (1 + SPEED_POWER)


def bow_by_share(amount: sp.Symbol) -> sp.Expr:
    """Slope of the bow or the skew of a rotary linkage in the share of the rated travel, over its amount."""
    bow, skew = symbols("h_l s_l")
    swing = sp.sqrt(27) / 2 * skew * (1 - 2 * TRAVEL_SHARE)
    indicated = 4 * TRAVEL_SHARE * (1 - TRAVEL_SHARE) * (bow + swing)
    return sp.factor(sp.diff(indicated, TRAVEL_SHARE, amount))


def arm_lever_squared(angle: type[sp.Function]) -> sp.Expr:
    """Squared way of an arm through the travel over its length, at which its third order is the skew."""
    return _matched(angle)[0]


def arm_centre() -> sp.Expr:
    """Share of the travel at which an arm stands square to the stem, at which its third order is the bow."""
    return _matched(sp.atan)[1]


def _matched(angle: type[sp.Function]) -> tuple[sp.Expr, sp.Expr]:
    """Square of the lever and the centre of an arm whose indicated share is bow and skew to third order."""
    bow, skew, travel = symbols("h_l s_l L")
    small, square, centre = sp.Symbol("small", positive=True), sp.Symbol("square"), sp.Symbol("centre")
    way = sp.series(angle(small), small, 0, 4).removeO()
    third = way.coeff(small, 3) * square

    def turned(share: sp.Expr) -> sp.Expr:
        return (share - centre) + third * (share - centre) ** 3

    share = TRAVEL_SHARE
    # To first order in the square of the lever the ends are kept by a line.
    straight = turned(sp.S.Zero) + share * (turned(sp.S.One) - turned(sp.S.Zero))
    bent = sp.expand(sp.diff(turned(share) - straight, square))
    wanted = sp.expand(4 * share * (1 - share) * (bow + sp.sqrt(27) / 2 * skew * (1 - 2 * share)) / travel)
    order = [sp.Poly(square * bent - wanted, share).coeff_monomial(share**power) for power in (3, 2)]
    (found,) = sp.solve(order, [square, centre], dict=True)
    return sp.simplify(found[square]), sp.expand(found[centre])
