"""Electromagnet: current to gap, with the effects of coil, core and flapper."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined
from valvemodel.declarations import Effect, Parameter, choice_of_law
from valvemodel.equations import numeric
from valvemodel.stages.creep import creep_parameters, crept
from valvemodel.stages.lag import COIL_LAG, EDDY_LAG, in_series, longer_and_shorter, remembered_lag
from valvemodel.stages.plays import begin_plays, lay_plays, place_among_plays, pull_plays, used_up

TURNED = 1e-9
"""Share of a part within which its end is the turn of the flux."""

STRAIGHT = 1e-9
"""Steepness of the curve behind the middle of the loop below which it is a straight line there."""

EFFECTS = (
    Effect(
        key="magnetic_hysteresis",
        stage="electromagnet",
        title="magnetic hysteresis",
        meaning=(
            "the flux lags the current by a rate-independent loop of nearly constant width in current; small loops "
            "within it drift along (Bouc and Wen, Dahl) or close where they began (plays)"
        ),
        equation=(
            r"i_e = i - h z,\quad dz = (1 - |z|\,((1 - \gamma)\,\mathrm{sign}(z\,di) + \gamma))\,"
            r"di / (2 h (1 - \gamma) (1 + \rho))"
            r"\quad\text{or}\quad z = \overline{i - i_r}/(h (1 + \rho)),\ |i - i_r| \le r"
        ),
        source=(
            "Bouc (1967), Wen, J. Eng. Mech. Div. ASCE 102 (1976), exponent 1; with gamma = 0 Coleman and Hodgdon, J. "
            "Appl. Phys. 63 (1988), the same curve as Dahl (1968); plays i_r of spread half-widths r: Prandtl (1928), "
            "Ishlinskii (1944); Visintin, Models of Hysteresis (1994); spread as Pickands, Ann. Statist. 3 (1975)"
        ),
        parameters=(
            Parameter(
                "hysteresis_half_width",
                "A",
                "half the width of the loop in current",
                0.0,
                3e-3,
                0.0,
                (4e-4, 1e-4),
            ),
            Parameter(
                "hysteresis_roundness",
                "1",
                "0: flat after a reversal; large: rounded",
                0.0,
                20.0,
                0.5,
                (0.5,),
            ),
            Parameter(
                "bouc_wen_gamma",
                "1",
                "gamma / (beta + gamma) of the curve: 0 for Dahl's, steepest after a reversal; 0.5: straight there",
                0.0,
                0.8,
                0.5,
                (0.25,),
                typical=0.0,
                is_later=True,
            ),
            choice_of_law(
                "return_point_memory",
                "0: Bouc and Wen's curve, which forgets where it turned; 1: plays, whose minor loops close",
            ),
            Parameter(
                "play_evenness",
                "1",
                "spread of the plays' half-widths, 0: exponential; 0.5: even, from none to twice the mean; 1: one play",
                0.0,
                1.0,
                0.0,
                (0.0, 0.5),
                typical=0.0,
                is_later=True,
            ),
            Parameter(
                "hysteresis_start",
                "1",
                "z where the core starts: -1 behind a fall of the current, 1 behind a rise",
                -1.0,
                1.0,
                0.0,
                (0.0,),
                is_later=True,
                acts_in_time=True,
                is_start=True,
            ),
        ),
        laws=(
            {"return_point_memory": 0.0, "play_evenness": 0.0},
            {"return_point_memory": 1.0, "bouc_wen_gamma": 0.25},
        ),
        aliases=(
            "linkage_backlash",
            "pressure_dependent_friction",
            "linkage_nonlinearity",
            "spring_hardening",
            "area_variation",
        ),
        told_apart_by=(
            "a measured pressure shows it upstream of the stem; friction makes the loop wider where the branch is flat"
        ),
    ),
    Effect(
        key="magnetic_saturation",
        stage="electromagnet",
        title="magnetic saturation",
        meaning="the gain from current to flux falls above a knee",
        equation=(
            r"i_e = i - (1 - r)\,a^2/(a + b)\quad\text{or}\quad i - (1 - r)\,(a - b\tanh(a/b)),"
            r"\quad a = \mathrm{ramp}_w(i - i_k)"
        ),
        source=(
            "normal magnetisation curve of soft iron: two straight parts with a rounded knee (b = 0), or above the "
            "knee Froehlich's hyperbola (r = 0), Elektrotechnische Zeitschrift 2 (1881); Kennelly (1891); or tanh, "
            "Brillouin's function of spin 1/2, J. Phys. Radium 8 (1927)"
        ),
        parameters=(
            Parameter(
                "saturation_slope",
                "1",
                "slope above the knee over slope below",
                0.0,
                1.0,
                1.0,
                (0.7, 0.0),
            ),
            Parameter("saturation_knee", "A", "current at the knee", 4e-3, 20e-3, 14e-3, (12e-3, 16e-3)),
            Parameter("saturation_rounding", "A", "width of the knee", 1e-4, 6e-3, 1e-3, (1e-3,)),
            Parameter(
                "saturation_reach",
                "A",
                "way above the knee over which the gain falls",
                0.0,
                0.5,
                0.0,
                (0.0, 50e-3),
                is_later=True,
            ),
            choice_of_law("saturation_law", "0: a hyperbola above the knee, or a straight line; 1: tanh"),
        ),
        laws=(
            {"saturation_slope": 0.0, "saturation_law": 0.0},
            {"saturation_slope": 0.0, "saturation_law": 1.0},
            {"saturation_reach": 0.0, "saturation_law": 0.0},
        ),
        aliases=("spring_hardening", "linkage_nonlinearity", "area_variation", "asymmetric_friction"),
        told_apart_by="a measured pressure shows it upstream of the stem",
    ),
    Effect(
        key="coil_lag",
        stage="electromagnet",
        title="coil lag",
        meaning="the inductance delays the current, and eddy currents in a solid core delay the flux behind it",
        equation=(
            r"\tau\,di_1/dt = i - i_1,\quad \tau_e\,di_e/dt = i_1 - i_e,"
            r"\quad\text{before the core bends the current or behind it}"
        ),
        source=(
            "eq. (17) with the resistance kept; the eddy currents of a solid core by their slowest mode: Stoll, The "
            "Analysis of Eddy Currents (1974)"
        ),
        parameters=(
            Parameter("coil_time_constant", "s", "time constant of the coil", 0.0, 3.0, 0.0, (0.1, 0.5), is_lag=True),
            Parameter(
                "eddy_time_constant",
                "s",
                "second lag in series, of the core's eddy currents",
                0.0,
                1.0,
                0.0,
                (0.0, 0.03),
                is_later=True,
            ),
            choice_of_law(
                "lag_behind_core",
                "0: the current lags, and saturation and loop follow it; 1: they are of the current, and the flux lags",
            ),
        ),
        aliases=("sensor_lag", "chamber_filling", "transport_delay", "asymmetric_filling"),
        acts_in_time=True,
        told_apart_by=(
            "a measured pressure, or fast steps at low and high current: the lag is in current, before the bend"
        ),
    ),
    Effect(
        key="gap_drift",
        stage="electromagnet",
        title="gap drift",
        meaning="the gap creeps with time as the converter warms or settles",
        equation=r"\delta(t) = \delta_0 + r\,T\,(1 - e^{-t/T})\quad\text{or}\quad\delta_0 + r\,T\,\ln(1 + t/T)",
        source="thermal expansion of the flapper mount, first order; logarithmic creep: Phillips, Phil. Mag. 9 (1905)",
        parameters=(
            Parameter("gap_drift_rate", "m/s", "rate at the start", -1e-5, 1e-5, 0.0, (3e-8, -3e-8)),
            *creep_parameters("gap_drift"),
        ),
        aliases=("sensor_drift", "load_force", "friction_drift", "supply_droop"),
        acts_in_time=True,
        told_apart_by="a measured pressure; or drift followed at low and high current, where the gap acts differently",
    ),
)


@inlined
def has_coil_lag(p):
    """Return whether the flux lags the current."""
    return p.coil_time_constant > 0.0 or p.eddy_time_constant > 0.0


@inlined
def flux_departs(p, state, current):
    """Return by how much the flux, or the current behind the longer of two lags, departs from what it follows. [A]"""
    aim = followed_by_lags(p, state, current)
    departure = abs(state.flux_current - aim)
    longer, shorter = longer_and_shorter(p.coil_time_constant, p.eddy_time_constant)
    if shorter > 0.0:
        flux = in_series(longer, shorter, state.flux_current, state.less_lagged_flux)
        departure = max(departure, abs(flux - aim))
    return departure


@inlined
def saturate(p, current):
    """Bend the current above the knee; the identity while the slope is 1."""
    if p.saturation_slope == 1.0:
        return current
    lost = lost_above_knee(p, current - p.saturation_knee) - lost_above_knee(p, -p.saturation_knee)
    return current - (1.0 - p.saturation_slope) * lost


@inlined
def lost_above_knee(p, above):
    """Return how much of the current the core would lose with no slope above its knee. [A]"""
    width = p.saturation_rounding
    ramp = 0.5 * (above + math.sqrt(above * above + width * width))
    if p.saturation_law > 0.0 and p.saturation_reach > 0.0:
        return ramp - p.saturation_reach * math.tanh(ramp / p.saturation_reach)
    return ramp * (ramp / (ramp + p.saturation_reach))


@inlined
def advance_flux(p, state, current):
    """Switch the current and return the one that the flux stands for. [A]"""
    effective = saturate(p, current)
    if p.hysteresis_half_width > 0.0:
        change = effective - state.hysteresis_input
        if change != 0.0:
            state.hysteresis = hysteresis_after(p, state, change)
            state.hysteresis_input = effective
            if p.return_point_memory > 0.0:
                pull_plays(p, state, effective)
        place = state.hysteresis
        if p.return_point_memory > 0.0:
            place += p.return_point_memory * (place_among_plays(p, state, effective) - place)
        effective -= p.hysteresis_half_width * place
    return effective


@inlined
def followed_by_lags(p, state, current):
    """Return what the lags follow under a held current: that, or what the core made of it when it was switched. [A]"""
    return advance_flux(p, state, current) if p.lag_behind_core > 0.0 else current


@inlined
def reach_of_loop(p):
    """Return the change of the current over which the curve forgets: none is flatter than flat after a reversal. [A]"""
    return 2.0 * p.hysteresis_half_width * (1.0 - p.bouc_wen_gamma) * (1.0 + p.hysteresis_roundness)


@compiled
def hysteresis_after(p, state, change):
    """Return the place on Bouc and Wen's curve after a change of the current one way, exact."""
    side = 1.0 if change > 0.0 else -1.0
    way, place = abs(change) / reach_of_loop(p), side * state.hysteresis
    if p.bouc_wen_gamma == 0.0:
        return side * (1.0 + (place - 1.0) * math.exp(-way))
    steepness = 1.0 - 2.0 * p.bouc_wen_gamma
    back = min(way, way_to_middle(steepness, place))
    behind = min(place, 0.0) * math.exp(-steepness * back) + way_passed(steepness, back)
    return side * (behind + 1.0 + (max(place, 0.0) - 1.0) * math.exp(back - way))


@inlined
def way_to_middle(steepness, place):
    """Return how far the current goes until a place behind the loop's middle is there, in reaches; 0 beyond it."""
    missing = max(-place, 0.0)
    return missing if abs(steepness) < STRAIGHT else math.log1p(steepness * missing) / steepness


@inlined
def way_passed(steepness, way):
    """Return (1 - exp(-s x)) / s of a way x and a steepness s."""
    return way if abs(steepness) < STRAIGHT else -math.expm1(-steepness * way) / steepness


@compiled
def lay_currents(p, state, memory, current, spacing, count):
    """Write the currents that the flux stands for at the nodes of a part, exact under a held current.

    Return where they have a kink, in spacings.
    """
    current = followed_by_lags(p, state, current)
    flux, less_lagged = current, current
    memory.end_input, memory.end_hysteresis = state.hysteresis_input, state.hysteresis
    has_core = p.lag_behind_core == 0.0
    longer, shorter = longer_and_shorter(p.coil_time_constant, p.eddy_time_constant)
    if longer > 0.0:
        lag = remembered_lag(memory, COIL_LAG, 1.0 / longer, spacing, count)
    if shorter > 0.0:
        shorter_lag = remembered_lag(memory, EDDY_LAG, 1.0 / shorter, spacing, count)
    for node in range(count + 1):
        if longer > 0.0:
            flux = current + (state.flux_current - current) * lag.decay[node]
        acting = flux
        if shorter > 0.0:
            less_lagged = current + (state.less_lagged_flux - current) * shorter_lag.decay[node]
            acting = in_series(longer, shorter, flux, less_lagged)
        effective = acting
        if has_core:
            effective = saturate(p, acting)
            memory.values[node] = memory.end_input = effective
            if p.hysteresis_half_width > 0.0 and effective != state.hysteresis_input:
                memory.end_hysteresis = hysteresis_after(p, state, effective - state.hysteresis_input)
            effective -= p.hysteresis_half_width * memory.end_hysteresis
        memory.currents[node] = effective
    memory.end_flux, memory.end_less_lagged_flux = flux, less_lagged
    if p.hysteresis_half_width == 0.0 or not has_core:
        return math.inf
    end = lay_plays(p, state, memory, count) if p.return_point_memory > 0.0 else middle_of_loop(p, state, memory, count)
    return min(end, turn_of_flux(longer, shorter, state, current, spacing * count) / spacing)


@compiled
def turn_of_flux(longer, shorter, state, current, duration):
    """Return when the flux turns, behind two lags after the current did, within a duration; else never. [s]

    di_e/dt = ((i - i_l) e^(-t/l) - (i - i_s) e^(-t/s)) / (l - s), of the longer and the shorter lag alone.
    """
    behind_longer, behind_shorter = state.flux_current - current, state.less_lagged_flux - current
    if shorter == 0.0 or behind_longer == 0.0 or behind_shorter / behind_longer <= 1.0:
        return math.inf
    turn = math.log(behind_shorter / behind_longer) * longer * shorter / (longer - shorter)
    return turn if turn < (1.0 - TURNED) * duration else math.inf


@compiled
def middle_of_loop(p, state, memory, count):
    """Return where along the currents at the nodes the curve passes the middle of the loop, in spacings.

    Bouc and Wen's has a kink there, of its bend.
    """
    side = 1.0 if memory.values[count] > memory.values[0] else -1.0
    if p.bouc_wen_gamma == 0.0 or side * state.hysteresis >= 0.0:
        return math.inf
    way = way_to_middle(1.0 - 2.0 * p.bouc_wen_gamma, side * state.hysteresis)
    return used_up(memory, count, reach_of_loop(p) * way)


@compiled
def accept_currents(p, state, memory):
    """Take the stage to the end of the part that was laid."""
    state.flux_current, state.less_lagged_flux = memory.end_flux, memory.end_less_lagged_flux
    if p.return_point_memory > 0.0:
        pull_plays(p, state, memory.end_input)
    state.hysteresis_input, state.hysteresis = memory.end_input, memory.end_hysteresis


@inlined
def gap_drift(p, time):
    """Return by how much the gap has grown since the start. [m]"""
    return p.gap_drift_rate * crept(time, p.gap_drift_time, p.gap_drift_creep)


@inlined
def gap_of_current(p, current, time):
    """Return the gap at an effective current, drift included. [m]"""
    gap = coil_gap(max(current, 0.0), p.gap_offset, p.gap_gain)
    if p.gap_drift_rate != 0.0:
        gap += gap_drift(p, time)
    return gap


@compiled
def rest_electromagnet(p, state, current):
    """Put the stage at rest under a current, where it starts in its loop; return what the flux stands for. [A]"""
    state.hysteresis_input = saturate(p, current)
    state.hysteresis = p.hysteresis_start
    if p.return_point_memory > 0.0:
        begin_plays(p, state)
    state.flux_current = state.less_lagged_flux = followed_by_lags(p, state, current)
    return advance_flux(p, state, current)


coil_gap = inlined(numeric.coil_gap)
