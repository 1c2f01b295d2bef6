"""Nozzle: gap to actuator pressure, with the effects of chamber, supply, line and gas."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined
from valvemodel.declarations import Effect, Parameter, choice_of_law
from valvemodel.equations import numeric

ATMOSPHERE = 101325.0
"""Absolute pressure of the surroundings. [Pa]"""

CRITICAL = 0.528
"""Ratio of the pressures from which an ideal hole chokes (Saint-Venant and Wantzel): b of ISO 6358."""

EFFECTS = (
    Effect(
        key="chamber_filling",
        stage="nozzle",
        title="chamber filling",
        meaning="the flow through orifice and nozzle has to fill the chamber before the pressure is there",
        equation=(
            r"T\,(1 + g\,P/P_1)\,\dot P / P_1 = \epsilon\,(\sqrt{1 - P/P_1} - \sqrt{K}\,\delta\sqrt{P/P_1}),"
            r"\quad \epsilon = 1\ \text{or}\ 1 + P/P_0; \quad\text{or}\quad T\,\dot P = P_s - P"
        ),
        source=(
            "paper eq. (15) with Q_b filling a volume that grows with the pressure, as the diaphragm gives way; of one "
            "stiffness, or of a gas at constant temperature, whose bulk modulus is its absolute pressure; or through a "
            "resistance that is laminar, as a first-order lag"
        ),
        parameters=(
            Parameter(
                "chamber_filling_time",
                "s",
                "time to fill to P1 at the full orifice flow",
                0.0,
                10.0,
                0.0,
                (0.3, 1.5),
                is_lag=True,
            ),
            Parameter(
                "filling_growth",
                "1",
                "g: growth of that time from no pressure to P1",
                -0.95,
                30.0,
                0.0,
                (1.0,),
                typical=0.0,
            ),
            choice_of_law(
                "filling_of_gas",
                "0: what fills is as stiff at each pressure; 1: a gas, the stiffer the higher its absolute pressure",
            ),
            choice_of_law(
                "laminar_filling",
                "0: through orifice and nozzle, by eq. (15); 1: as the pressure lacks, through a laminar resistance",
            ),
        ),
        laws=(
            {"filling_of_gas": 0.0, "laminar_filling": 0.0},
            {"filling_of_gas": 1.0, "laminar_filling": 0.0},
            {"filling_of_gas": 0.0, "laminar_filling": 1.0},
        ),
        aliases=("asymmetric_filling", "coil_lag", "sensor_lag", "transport_delay"),
        acts_in_time=True,
        told_apart_by="a measured pressure; steps up and down at several levels",
    ),
    Effect(
        key="asymmetric_filling",
        stage="nozzle",
        title="asymmetric filling",
        meaning="the amplifier fills and vents at different capacities, down to a rate limit one way",
        equation=(
            r"\dot P = (P_s - P)/T_\pm\quad\text{or}\quad "
            r"T_\pm \dot P/P_1 = \epsilon\,(\sqrt{1 - P/P_1} - \sqrt{P_1/P_s - 1}\,\sqrt{P/P_1}),"
            r"\ \epsilon = 1\ \text{or}\ 1 + P/P_0,\quad |\dot P| \le 1/|s| \text{ one way}"
        ),
        source=(
            "spool amplifier with unequal ports, first order with rate limit; or unequal orifices and paper eq. (15), "
            "whose nozzle is open as the resting pressure P_s has it"
        ),
        parameters=(
            Parameter(
                "fill_time", "s", "time constant while the pressure rises", 0.0, 5.0, 0.0, (0.02, 0.3), is_lag=True
            ),
            Parameter(
                "vent_time", "s", "time constant while the pressure falls", 0.0, 5.0, 0.0, (0.3, 0.02), is_lag=True
            ),
            Parameter(
                "filling_slowness",
                "s/Pa",
                "s: inverse of a rate limit, of venting where positive, of filling where negative",
                -2e-3,
                2e-3,
                0.0,
                (1e-5, -1e-5, 2e-6, -2e-6),
            ),
            choice_of_law(
                "orifice_share",
                "0: the flow is as the pressure difference; 1: as square roots of pressure differences, by orifices",
            ),
            choice_of_law(
                "orifices_of_gas",
                "behind orifices, 0: what fills is as stiff at each pressure; 1: a gas, as for chamber filling",
            ),
        ),
        laws=(
            {"orifice_share": 0.0, "orifices_of_gas": 0.0},
            {"orifice_share": 1.0, "orifices_of_gas": 0.0},
            {"orifice_share": 1.0, "orifices_of_gas": 1.0},
        ),
        differing=("fill_time", "vent_time"),
        aliases=("chamber_filling", "asymmetric_viscous_friction", "coil_lag"),
        acts_in_time=True,
        told_apart_by="a measured pressure; large steps both ways",
    ),
    Effect(
        key="supply_droop",
        stage="nozzle",
        title="supply droop",
        meaning="the supply sags with the air that is drawn, to fill and to feed the nozzle, and recovers slowly",
        equation=r"P_1' = P_1 - d,\quad \dot d = g\,\max(\dot P, 0) + (c\,P_1\sqrt{1 - P/P_1} - d)/T",
        source="receiver behind a regulator of finite flow, first order",
        parameters=(
            Parameter("droop_gain", "1", "g: sag of the supply over rise of the pressure", 0.0, 2.0, 0.0, (0.2, 0.0)),
            Parameter(
                "droop_consumption",
                "1",
                "c: sag over P1 at the full flow of the orifice",
                0.0,
                0.5,
                0.0,
                (0.0, 0.05),
                typical=0.0,
                is_later=True,
            ),
            Parameter(
                "droop_recovery_time",
                "s",
                "time constant of the recovery",
                0.05,
                200.0,
                3.0,
                (2.0, 15.0),
                "log",
            ),
        ),
        aliases=("chamber_filling", "asymmetric_filling", "gap_drift"),
        acts_in_time=True,
        told_apart_by="a gauge on the supply",
    ),
    Effect(
        key="air_leak",
        stage="nozzle",
        title="air leak",
        meaning="a hole in diaphragm or tubing behind a restriction takes a part of the pressure",
        equation=(
            r"(1 + g)\,P_a + \ell\sqrt{P_1 P_a} = P_b\quad\text{or}\quad "
            r"P_b^a\,\psi(P_m^a/P_b^a) = \sqrt{g}\,P_m^a\,\psi(P_0/P_m^a),\ P_a + \ell\sqrt{P_1 P_a} = P_m"
        ),
        source=(
            "restriction, laminar (l) or turbulent (g), into a turbulent hole, at rest; as a gas by ISO 6358 with the "
            "critical ratio of Saint-Venant and Wantzel (1839)"
        ),
        parameters=(
            Parameter("leak_ratio", "1", "l: pressure lost over supply at full pressure", 0.0, 0.6, 0.0, (0.03, 0.15)),
            Parameter(
                "turbulent_leak_ratio",
                "1",
                "g: square of the hole's area over that of a turbulent restriction",
                0.0,
                2.0,
                0.0,
                (0.0, 0.1),
                is_later=True,
            ),
            choice_of_law("leak_chokes", "0: turbulent flow as of a liquid; 1: as of a gas, which chokes"),
        ),
        aliases=("choked_flow", "none", "magnetic_saturation"),
        told_apart_by="a gauge on either side of the restriction, or the air consumed",
    ),
    Effect(
        key="choked_flow",
        stage="nozzle",
        title="choked flow",
        meaning="orifice and nozzle pass a compressible gas and choke, instead of the incompressible law",
        equation=r"P_1^a\,\psi(P^a/P_1^a) = \sqrt{K}\,\delta\,P^a\,\psi(P_0/P^a),\quad \psi=\sqrt{1-((r-b)/(1-b))^2}",
        source="Saint-Venant and Wantzel (1839) in the form of ISO 6358",
        parameters=(
            Parameter(
                "compressible_share",
                "1",
                "0: incompressible, 1: compressible",
                0.0,
                1.0,
                0.0,
                (1.0,),
                is_fitted=False,
            ),
            Parameter("critical_pressure_ratio", "1", "b of ISO 6358", 0.1, 0.6, CRITICAL, (CRITICAL, 0.4)),
        ),
        # Beside the pressure of the air outside, that of the supply is no mere scale of the forces any more.
        frees=("supply_pressure",),
        aliases=("none", "air_leak", "magnetic_saturation"),
        told_apart_by="a measured pressure over the whole range of current",
    ),
    Effect(
        key="transport_delay",
        stage="nozzle",
        title="transport delay",
        meaning="the line delays the pressure by a dead time, and its friction smears what arrives",
        equation=r"d\,T_d\,\dot P = P_b(t - T_d) - P",
        source="travel of a pressure wave along the tubing; its dispersion to first order",
        parameters=(
            Parameter("transport_delay", "s", "T_d: dead time", 0.0, 3.0, 0.0, (0.08, 0.4), is_lag=True),
            Parameter(
                "line_dispersion",
                "1",
                "d: time constant of the lag behind the dead time, over it; it adds to those of an amplifier",
                0.0,
                0.3,
                0.0,
                (0.0, 0.1),
                typical=0.0,
                is_later=True,
            ),
        ),
        aliases=("coil_lag", "sensor_lag", "chamber_filling"),
        acts_in_time=True,
        told_apart_by="a measured pressure, or a faster sampling of one step",
    ),
)

static_pressure = inlined(numeric.static_pressure)


@inlined
def choking_balance(pressure, high_side, opening, critical, orifice_chokes, nozzle_chokes):
    """Return the flow through the orifice squared less that through the nozzle, ISO 6358; absolute pressures."""
    breadth = (1.0 - critical) * (1.0 - critical)
    through_orifice = high_side * high_side
    if not orifice_chokes:
        through_orifice -= (pressure - critical * high_side) ** 2 / breadth
    through_nozzle = pressure * pressure
    if not nozzle_chokes:
        through_nozzle -= (ATMOSPHERE - critical * pressure) ** 2 / breadth
    return through_orifice - opening * opening * through_nozzle


@compiled
def compressible_pressure(gap, supply, flow_ratio, critical):
    """Return the gauge pressure at which the choking orifice feeds the choking nozzle. [Pa]

    The balance falls with the pressure. Each hole either chokes or not, which its sign at the two pressures of change
    tells; in each of the four cases the balance of the squared flows is a quadratic equation.
    """
    opening = math.sqrt(flow_ratio) * abs(gap)
    high_side = supply + ATMOSPHERE
    orifice_change, nozzle_change = critical * high_side, ATMOSPHERE / critical
    orifice_chokes = orifice_change > ATMOSPHERE and (
        choking_balance(orifice_change, high_side, opening, critical, True, orifice_change >= nozzle_change) < 0.0
    )
    nozzle_chokes = nozzle_change < high_side and (
        choking_balance(nozzle_change, high_side, opening, critical, nozzle_change <= orifice_change, True) > 0.0
    )
    breadth = 1.0 / ((1.0 - critical) * (1.0 - critical))
    from_orifice = 0.0 if orifice_chokes else breadth
    from_nozzle = 0.0 if nozzle_chokes else opening * opening * breadth
    square = critical * critical * from_nozzle - from_orifice - opening * opening
    half = critical * (high_side * from_orifice - ATMOSPHERE * from_nozzle)
    constant = high_side * high_side * (1.0 - critical * critical * from_orifice) + ATMOSPHERE**2 * from_nozzle
    root = math.sqrt(max(half * half - square * constant, 0.0))
    # The root at which the balance falls, without cancellation.
    absolute = -(half + root) / square if half > 0.0 else constant / (root - half)
    return min(max(absolute - ATMOSPHERE, 0.0), supply)


@inlined
def resting_pressure(p, gap, supply):
    """Return the pressure at which the flows of orifice and nozzle agree. [Pa]"""
    pressure = static_pressure(gap, supply, p.flow_ratio)
    if p.compressible_share > 0.0:
        compressible = compressible_pressure(gap, supply, p.flow_ratio, p.critical_pressure_ratio)
        pressure += p.compressible_share * (compressible - pressure)
    return pressure


@inlined
def stiffness_of_gas(pressure, share):
    """Return how stiff what fills a volume is at a pressure, over that at none: of a share of gas as its density."""
    return 1.0 + share * pressure / ATMOSPHERE


@inlined
def has_leak(p):
    """Return whether a hole takes a part of the pressure."""
    return p.leak_ratio != 0.0 or p.turbulent_leak_ratio != 0.0


@inlined
def behind_leak(p, pressure):
    """Return the actuator pressure behind restriction and leak; the identity without a leak. [Pa]"""
    if not has_leak(p) or pressure <= 0.0:
        return pressure
    loss, turbulent = p.leak_ratio * math.sqrt(p.supply_pressure), p.turbulent_leak_ratio
    if p.leak_chokes > 0.0:
        pressure, turbulent = compressible_pressure(1.0, pressure, turbulent, CRITICAL), 0.0
    root = 2.0 * pressure / (loss + math.sqrt(loss * loss + 4.0 * (1.0 + turbulent) * pressure))
    return root * root


@inlined
def time_to_fill(p):
    """Return the time constant of a rising pressure behind the chamber. [s]"""
    return p.fill_time + p.line_dispersion * p.transport_delay


@inlined
def time_to_vent(p):
    """Return the time constant of a falling pressure behind the chamber. [s]"""
    return p.vent_time + p.line_dispersion * p.transport_delay


@inlined
def is_amplified(p):
    """Return whether the pressure behind the chamber follows it late."""
    return time_to_fill(p) > 0.0 or time_to_vent(p) > 0.0 or p.filling_slowness != 0.0


@inlined
def resting_pressure_of_chain(p, gap, current):
    """Return the pressure at rest under the full supply, by eqs. (16), (31) or by the valve's affine map. [Pa]"""
    if p.pressure_per_current > 0.0:
        return p.pressure_at_zero_current + p.pressure_per_current * current
    return resting_pressure(p, gap, p.supply_pressure)


@inlined
def advance_nozzle(p, state, gap, current):
    """Hold a gap and return the actuator pressure that it gives where nothing fills or sags. [Pa]

    Valve sets with an affine map of current to pressure use the current instead of the gap.
    """
    state.pressure = behind_leak(p, resting_pressure_of_chain(p, gap, current))
    return state.pressure


@compiled
def drawn_to_settle(p, share):
    """Return the sag of the supply that the flow through the orifice keeps up. [Pa]"""
    if p.droop_consumption == 0.0:
        return 0.0
    return p.droop_consumption * p.supply_pressure * math.sqrt(max(1.0 - share, 0.0))


@compiled
def rest_nozzle(p, state, gap, current):
    """Put the stage at rest at a gap."""
    pressure = resting_pressure_of_chain(p, gap, current)
    state.share = pressure / p.supply_pressure
    state.droop = drawn_to_settle(p, state.share)
    pressure *= 1.0 - state.droop / p.supply_pressure
    state.chamber_pressure = pressure
    state.filled_pressure = pressure
    state.pressure = behind_leak(p, pressure)
