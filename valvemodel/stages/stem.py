"""Stem: the forces between actuator pressure and stem position, with the effects of friction, spring and load."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined
from valvemodel.declarations import Effect, Parameter, choice_of_law
from valvemodel.equations import numeric
from valvemodel.stages.load import HIGHER_COSINES, HIGHER_SINES, MOST_WAVES, has_load, load_if_any, steepest_slope
from valvemodel.stages.sliders import bend_sliders, has_sliders
from valvemodel.stages.slip import STOP_SPEED

STUCK, RISING, FALLING = 0.0, 1.0, -1.0
STATIC_DECAY = 1e-3
"""Speed at which the static friction of bristles has fallen to 1/e of what it is above Coulomb's. [m/s]"""

FARTHEST = 10.0
"""No stem goes farther, the bound of the travel limits; one that its spring does not hold ends here. [m]"""

EFFECTS = (
    Effect(
        key="static_friction",
        stage="stem",
        title="static friction",
        meaning="breaking away takes more force than sliding: the stem jumps, and it sticks where it creeps",
        equation=r"|F| \le F_s = r\,F_c \text{ while stuck, and where } |v| < v_s",
        source="paper eqs. (5), (6); Karnopp, J. Dyn. Sys. Meas. Control 107 (1985)",
        parameters=(
            Parameter(
                "static_friction_ratio",
                "1",
                "F_s / F_c",
                1.0,
                3.0,
                1.0,
                (1.2, 1.03, 1.06, 1.1, 1.15, 1.25, 1.3, 1.4, 1.5, 1.7),
            ),
            Parameter(
                "stick_speed",
                "m/s",
                "v_s: speed below which a slip sticks where the breakaway force holds it",
                STOP_SPEED,
                5e-2,
                STOP_SPEED,
                (1.5e-3, 5e-3),
                typical=STOP_SPEED,
                is_later=True,
            ),
        ),
        is_jagged=True,
        stops_again=True,
        breakaway="static_friction_ratio",
        aliases=("stribeck",),
        told_apart_by="slow ramps: Stribeck friction also drops while the stem already moves",
    ),
    Effect(
        key="stribeck",
        stage="stem",
        title="Stribeck friction",
        meaning="friction falls from breakaway to Coulomb as the stem speeds up",
        equation=r"F = F_c\,(1 + (r - 1)\,((1 - t)\,e^{-u} + t/(1 + u)))\,\mathrm{sign}(v), \quad u = (|v|/v_s)^n",
        source=(
            "Stribeck (1902); Hess and Soom, J. Tribology 112 (1990), t; Armstrong-Helouvry, Dupont, Canudas de Wit, "
            "Automatica 30 (1994)"
        ),
        parameters=(
            Parameter(
                "stribeck_ratio",
                "1",
                "friction at speed 0 over Coulomb friction",
                1.0,
                3.0,
                1.0,
                (1.3, 1.05, 1.1, 1.15, 1.2, 1.4, 1.5, 1.7),
            ),
            Parameter(
                "stribeck_velocity",
                "m/s",
                "speed at which the drop has fallen to 1/e; half of a tail is left there",
                1e-4,
                0.3,
                5e-3,
                (5e-3, 1.5e-3, 1.5e-2, 5e-2),
                "log",
            ),
            choice_of_law("stribeck_shape", "n: 1 falls at once, 2 as a bell", first=1.0, second=2.0),
            choice_of_law("stribeck_tail", "t: share that falls as a fraction, with a long tail, not exponentially"),
        ),
        is_jagged=True,
        is_chaotic=True,
        stops_again=True,
        breakaway="stribeck_ratio",
        # A long tail without the bell is hardly told from a shorter one beside less viscous friction.
        laws=(
            {"stribeck_shape": 1.0, "stribeck_tail": 0.0},
            {"stribeck_shape": 2.0, "stribeck_tail": 0.0},
            {"stribeck_shape": 2.0, "stribeck_tail": 1.0},
        ),
        aliases=("static_friction",),
        told_apart_by="ramps at several slow speeds",
    ),
    Effect(
        key="asymmetric_friction",
        stage="stem",
        title="asymmetric Coulomb friction",
        meaning="Coulomb friction differs up and down",
        equation=r"F_c\,(1 + a\,\mathrm{sign}(v))",
        source="packing lips and side load; a constant force in addition to F_c",
        parameters=(
            Parameter(
                "friction_asymmetry",
                "1",
                "a: share by which rising is rougher",
                -0.95,
                0.95,
                0.0,
                (0.15, -0.15),
            ),
        ),
        aliases=("none", "load_force", "air_leak", "magnetic_saturation"),
        told_apart_by="the spring's preload known, or position at no pressure",
    ),
    Effect(
        key="asymmetric_viscous_friction",
        stage="stem",
        title="asymmetric viscous friction",
        meaning="viscous friction differs up and down",
        equation=r"f_v\,(1 + a\,\mathrm{sign}(v))\,v",
        source="EMPS benchmark: wear of the screw; a check valve in the damping",
        parameters=(
            Parameter(
                "viscous_asymmetry",
                "1",
                "a: share by which rising is more damped",
                -0.98,
                0.98,
                0.0,
                (0.4, -0.4, 0.8, -0.8),
            ),
        ),
        aliases=("asymmetric_filling",),
        acts_in_time=True,
        told_apart_by="a measured pressure; fast strokes both ways",
    ),
    Effect(
        key="position_dependent_friction",
        stage="stem",
        title="tight spot",
        meaning="friction is higher around one place of the travel",
        equation=r"F_c\,(1 + A\,(1 - q\,u)_+^{1/q}), \quad u = |(y - y_0)/w|^n; \quad q = 0:\ e^{-u}",
        source="bent stem, scored packing; Tsallis, J. Stat. Phys. 52 (1988), for the form",
        parameters=(
            Parameter("tight_spot_excess", "1", "A: excess friction in the middle", -0.9, 5.0, 0.0, (0.4, 1.0)),
            Parameter(
                "tight_spot_position",
                "m",
                "middle of the spot",
                -0.1,
                0.6,
                0.13,
                ("travel_place",),
                typical=0.14,
            ),
            Parameter(
                "tight_spot_width",
                "m",
                "w: half-width, at 1/e where q is 0",
                1e-3,
                0.2,
                0.02,
                (0.012, 0.006, 0.03),
                "log",
            ),
            Parameter(
                "tight_spot_exponent",
                "1",
                "n: 2 for a bell; more for steep sides, less for a sharp middle",
                1.0,
                40.0,
                2.0,
                (2.0,),
                "log",
                is_later=True,
            ),
            Parameter(
                "tight_spot_closure",
                "1",
                "q: 0 fades out, 0.4 ends as a raised cosine, 1 with a corner; below 0 tails",
                -0.5,
                1.0,
                0.0,
                (0.0,),
                is_later=True,
            ),
        ),
        is_jagged=True,
        told_apart_by="strokes through the whole travel at low speed",
    ),
    Effect(
        key="pressure_dependent_friction",
        stage="stem",
        title="pressure-dependent friction",
        meaning="seal or packing friction grows with the pressure",
        equation=r"F_c + S_p\,P\,(P/P_1)^{n - 1}",
        source="self-energising lip seals",
        parameters=(
            Parameter("friction_area", "m^2", "S_p: friction per pressure", -0.01, 0.05, 0.0, (2e-3, -2e-3)),
            choice_of_law("friction_pressure_order", "n: power of the pressure", first=1.0, second=2.0),
        ),
        aliases=("spring_hardening", "magnetic_hysteresis", "linkage_nonlinearity", "area_variation"),
        told_apart_by="minor loops at low and high pressure",
    ),
    Effect(
        key="presliding",
        stage="stem",
        title="presliding",
        meaning="a stuck stem gives way elastically before it slides",
        equation=r"(1 - s)(f + D\,C\,\dot f) + s\,f_s, \quad df/dy = (1 - f\,\mathrm{sign}(v)/F)^n/C",
        source=(
            "Dahl (1968), f; with D and F_s > F_c the LuGre model, IEEE TAC 40 (1995); sliders f_s: Iwan, "
            "J. Appl. Mech. 33 (1966)"
        ),
        parameters=(
            Parameter(
                "presliding_compliance",
                "m/N",
                "C: yield of the stuck stem over force",
                0.0,
                2e-5,
                0.0,
                (6e-7,),
                typical=2e-7,
            ),
            Parameter(
                "bristle_damping",
                "N s/m",
                "D: viscous friction of the bristles while they bend",
                0.0,
                1e4,
                0.0,
                (100.0,),
                typical=0.0,
                is_later=True,
            ),
            Parameter(
                "bristle_exponent",
                "1",
                "n: the higher, the later the bristles slide",
                1.0,
                3.0,
                1.0,
                (1.0,),
                is_later=True,
            ),
            Parameter(
                "slider_share",
                "1",
                "s: share of F in sliders, elastic up to forces spread from 0 to 2 F, which remember each turn",
                0.0,
                1.0,
                0.0,
                (0.0, 1.0),
                is_later=True,
            ),
        ),
        takes_long=True,
        aliases=("linkage_backlash", "magnetic_hysteresis"),
        told_apart_by="small reversals, smaller than the dead band",
    ),
    Effect(
        key="spring_hardening",
        stage="stem",
        title="spring hardening",
        meaning="the spring stiffens with travel",
        equation=r"F_k = k\,y\,(1 + g\,y + h\,y^2)",
        source="progressive spring g and Duffing's cubic spring h",
        parameters=(
            Parameter(
                "spring_hardening",
                "1/m^2",
                "h: share of stiffening over travel squared",
                -8.0,
                60.0,
                0.0,
                (3.0, -2.0),
            ),
            Parameter(
                "spring_progression",
                "1/m",
                "g: share of stiffening over travel",
                -1.5,
                6.0,
                0.0,
                (0.0,),
                is_later=True,
            ),
        ),
        aliases=("linkage_nonlinearity", "area_variation", "magnetic_saturation", "magnetic_hysteresis"),
        told_apart_by=(
            "a measured pressure (from magnet and nozzle), a straight scale on the stem (from the linkage), the force "
            "at a blocked stem (from the area)"
        ),
    ),
    Effect(
        key="area_variation",
        stage="stem",
        title="area variation",
        meaning="the effective area of the diaphragm changes with travel",
        equation=r"S_1\,(1 + a\,y + b\,y^2)",
        source="rolling diaphragm; ISA handbook of control valves",
        parameters=(
            Parameter("area_slope", "1/m", "a: share of area over travel", -3.0, 3.0, 0.0, (-0.5, 0.5)),
            Parameter(
                "area_curvature",
                "1/m^2",
                "b: share of area over travel squared",
                -10.0,
                10.0,
                0.0,
                (0.0,),
                is_later=True,
            ),
        ),
        aliases=("spring_hardening", "linkage_nonlinearity", "magnetic_saturation", "magnetic_hysteresis"),
        told_apart_by="the force at a blocked stem at two positions",
    ),
    Effect(
        key="end_stop",
        stage="stem",
        title="end stop",
        meaning="the travel ends short of the expected range, dead or elastically",
        equation=r"y_{lo} \le y \le y_{hi}; \quad C > 0: F = (y - y_{hi})/C \text{ where } y > y_{hi}",
        source="mechanical stop: inelastic, or a linear contact spring 1/C (Kelvin-Voigt with the stem's damping)",
        parameters=(
            Parameter(
                "upper_stop",
                "m",
                "highest position, or where the stop begins to give way",
                0.0,
                1.0,
                math.inf,
                ("highest_reading",),
                typical=0.2,
            ),
            Parameter(
                "lower_stop",
                "m",
                "lowest position, or where the stop begins to give way",
                -0.5,
                0.5,
                -math.inf,
                ("lowest_reading",),
                typical=-math.inf,
            ),
            Parameter(
                "stop_compliance",
                "m/N",
                "C: how far the stop gives way over force; 0 stops dead",
                0.0,
                5e-6,
                0.0,
                (0.0, 2e-7),
                is_later=True,
                acts_in_time=True,
            ),
        ),
        is_one_of=True,
        # A stop that gives way throws the stem back, however stiff it is; one that stops dead does not.
        laws=({"stop_compliance": 0.0}, {}),
        aliases=("magnetic_saturation",),
        told_apart_by="the readings themselves: they stay at one value while the current goes on",
    ),
    Effect(
        key="load_force",
        stage="stem",
        title="load force",
        meaning="flow on the plug or another unmeasured force, periodic or slowly varying",
        equation=r"F_g = \sum_{n=1}^N A_n \sin(2\pi n t/T) + B_n \cos(2\pi n t/T)",
        source="paper eq. (1), F_g; its Fourier series: a periodic load is one wave, a slowly varying one is many",
        parameters=(
            Parameter("load_sine", "N", "A", -5000.0, 5000.0, 0.0, (200.0,)),
            Parameter("load_cosine", "N", "B", -5000.0, 5000.0, 0.0, (200.0,)),
            Parameter("load_period", "s", "T", 0.5, 2000.0, 30.0, ("residual_period",), "log", typical=30.0),
            Parameter(
                "load_waves",
                "1",
                "N: waves that act; A_n, B_n from the second on are load_sine_n, load_cosine_n",
                1.0,
                MOST_WAVES,
                1.0,
                (1.0,),
                is_fitted=False,
                is_later=True,
            ),
            *(
                Parameter(name, "N", f"{letter}_n, n = {number}", -5000.0, 5000.0, 0.0, (0.0,), is_higher=True)
                for letter, names in (("A", HIGHER_SINES), ("B", HIGHER_COSINES))
                for number, name in enumerate(names, start=2)
            ),
        ),
        aliases=("gap_drift", "sensor_drift"),
        acts_in_time=True,
        told_apart_by="the disturbance in a phase where the current is held",
    ),
    Effect(
        key="friction_drift",
        stage="stem",
        title="friction drift",
        meaning="friction grows over the record as the packing heats or dries",
        equation=r"F\,(1 + r\,T\,(1 - e^{-t/T}))",
        source="packing and seals that heat or dry, first order; all dry friction F rests on their coefficient",
        parameters=(
            Parameter(
                "friction_drift_rate",
                "1/s",
                "r: share of friction over time at the start",
                -0.05,
                0.2,
                0.0,
                (2e-3, -2e-3),
            ),
            Parameter("friction_drift_time", "s", "T: time constant", 25.0, 3000.0, 300.0, (300.0, 40.0), "log"),
        ),
        acts_in_time=True,
        told_apart_by="the same slow stroke early and late",
    ),
)

driving_force = inlined(numeric.driving_force)


@inlined
def friction_growth(p, time):
    """Return the friction at an instant over that at the start."""
    return max(1.0 - p.friction_drift_rate * p.friction_drift_time * math.expm1(-time / p.friction_drift_time), 0.0)


@compiled
def thrust(p, position, pressure, time):
    """Return the force that drives the stem, all but friction. [N]"""
    return inner_thrust(p, position, pressure) + load_if_any(p, time)


@inlined
def inner_thrust(p, position, pressure):
    """Return the force of pressure, spring and stops on the stem: what drives it without a load. [N]"""
    force = thrust_off_stops(p, position, pressure)
    if p.stop_compliance > 0.0:
        force -= (max(position - p.upper_stop, 0.0) - max(p.lower_stop - position, 0.0)) / p.stop_compliance
    return force


@inlined
def thrust_off_stops(p, position, pressure):
    """Return that force without the one of stops that give way. [N]"""
    force = driving_force(pressure, position, p.diaphragm_area, p.spring_rate, p.spring_preload)
    if p.area_slope != 0.0:
        force += p.diaphragm_area * p.area_slope * position * pressure
    if p.area_curvature != 0.0:
        force += p.diaphragm_area * p.area_curvature * position * position * pressure
    if p.spring_hardening != 0.0:
        force -= p.spring_rate * p.spring_hardening * position * position * position
    if p.spring_progression != 0.0:
        force -= p.spring_rate * p.spring_progression * position * position
    return force


@inlined
def tight_spot_bump(p, distance):
    """Return the excess friction at a distance from the middle of a tight spot, in half-widths."""
    return p.tight_spot_excess * ending(p, tight_spot_power(p, distance))


@inlined
def tight_spot_power(p, distance):
    """Return the power of a distance from the middle of a tight spot, in half-widths, with which its excess falls."""
    if p.tight_spot_exponent == 2.0:
        return distance * distance
    return abs(distance) ** p.tight_spot_exponent


@inlined
def ending(p, power):
    """Return the share of the excess friction of a tight spot that is left at that power of the distance."""
    if p.tight_spot_closure == 0.0:
        return math.exp(-power)
    if p.tight_spot_closure * power >= 1.0:
        return 0.0
    return math.exp(math.log1p(-p.tight_spot_closure * power) / p.tight_spot_closure)


@inlined
def tight_spot_slope(p, distance, bump):
    """Return how fast the excess friction, given, grows with the distance from the middle of a tight spot."""
    power = tight_spot_power(p, distance)
    if distance == 0.0 or p.tight_spot_closure * power >= 1.0:
        return 0.0
    return -p.tight_spot_exponent * power / distance * (bump / (1.0 - p.tight_spot_closure * power))


@compiled
def reach_of_tight_spot(p, force):
    """Return how far from its middle a tight spot adds less friction than a force to a stem that slips. [m]"""
    excess = abs(p.tight_spot_excess) * p.coulomb_friction * (1.0 + abs(p.friction_asymmetry))
    if excess <= force:
        return 0.0
    power = math.log(excess / force)
    if p.tight_spot_closure != 0.0:
        power = -math.expm1(-p.tight_spot_closure * power) / p.tight_spot_closure
    return p.tight_spot_width * power ** (1.0 / p.tight_spot_exponent)


@compiled
def sliding_friction(p, side, position, pressure, time):
    """Return the Coulomb friction of a stem that moves to a side, at high speed. [N]"""
    friction = p.coulomb_friction
    if p.friction_asymmetry != 0.0:
        friction *= 1.0 + p.friction_asymmetry * side
    if p.tight_spot_excess != 0.0:
        friction *= 1.0 + tight_spot_bump(p, (position - p.tight_spot_position) / p.tight_spot_width)
    if p.friction_area != 0.0:
        seal = p.friction_area * max(pressure, 0.0)
        if p.friction_pressure_order != 1.0:
            seal *= (max(pressure, 0.0) / p.supply_pressure) ** (p.friction_pressure_order - 1.0)
        friction = max(friction + seal, 0.0)
    if p.friction_drift_rate != 0.0:
        friction *= friction_growth(p, time)
    return friction


@compiled
def breakaway_ratio(p):
    """Return the breakaway force over the Coulomb friction."""
    return max(p.static_friction_ratio, p.stribeck_ratio)


@inlined
def is_above(p, side, position):
    """Return whether a stem that moves to a side presses on the upper stop, or is about to."""
    return position > p.upper_stop or (position == p.upper_stop and side > 0.0)


@inlined
def is_below(p, side, position):
    """Return whether a stem that moves to a side presses on the lower stop, or is about to."""
    return position < p.lower_stop or (position == p.lower_stop and side < 0.0)


@compiled
def tangent_stiffness(p, side, position, pressure, time):
    """Return by how much the net force falls with the position. [N/m]"""
    stiffness = p.spring_rate
    if p.spring_hardening != 0.0:
        stiffness += 3.0 * p.spring_rate * p.spring_hardening * position * position
    if p.spring_progression != 0.0:
        stiffness += 2.0 * p.spring_rate * p.spring_progression * position
    if p.area_slope != 0.0:
        stiffness -= p.diaphragm_area * p.area_slope * pressure
    if p.area_curvature != 0.0:
        stiffness -= 2.0 * p.diaphragm_area * p.area_curvature * position * pressure
    if p.stop_compliance > 0.0 and (is_above(p, side, position) or is_below(p, side, position)):
        stiffness += 1.0 / p.stop_compliance
    if p.tight_spot_excess != 0.0:
        distance = (position - p.tight_spot_position) / p.tight_spot_width
        bump = tight_spot_bump(p, distance)
        friction = sliding_friction(p, side, position, pressure, time)
        stiffness += tight_spot_slope(p, distance, bump) / p.tight_spot_width * side * friction / (1.0 + bump)
    return stiffness


@compiled
def is_linear(p):
    """Return whether a slip on dry friction under a held pressure is a linear equation, so that one step is exact."""
    has_straight_spring = p.spring_hardening == 0.0 and p.spring_progression == 0.0
    return has_straight_spring and p.area_curvature == 0.0 and p.tight_spot_excess == 0.0 and p.stribeck_ratio == 1.0


@compiled
def has_held_limit(p):
    """Return whether the force that bristles approach is the same along a slip to one side."""
    return (
        breakaway_ratio(p) == 1.0
        and p.tight_spot_excess == 0.0
        and p.friction_area == 0.0
        and p.friction_drift_rate == 0.0
    )


@compiled
def varies_in_time(p):
    """Return whether the forces on the stem change under a held pressure and position."""
    return has_load(p) or p.friction_drift_rate != 0.0


@compiled
def fastest_drift(p):
    """Return how fast the forces that hold a resting stem change at most under a held pressure. [N/s]"""
    return steepest_slope(p) + friction_drift(p)


@compiled
def friction_drift(p):
    """Return how fast the breakaway force changes at most. [N/s]"""
    roughest = p.coulomb_friction * (1.0 + abs(p.friction_asymmetry)) * (1.0 + max(p.tight_spot_excess, 0.0))
    roughest += max(p.friction_area, 0.0) * p.supply_pressure
    return breakaway_ratio(p) * roughest * abs(p.friction_drift_rate)


@compiled
def highest_position(p):
    """Return the upper end of the travel, which nothing exceeds. [m]"""
    highest = min(p.travel_max, FARTHEST)
    return highest if p.stop_compliance > 0.0 else min(highest, p.upper_stop)


@compiled
def lowest_position(p):
    """Return the lower end of the travel, which nothing goes below. [m]"""
    lowest = max(p.travel_min, -FARTHEST)
    return lowest if p.stop_compliance > 0.0 else max(lowest, p.lower_stop)


@compiled
def free_travel(p):
    """Return between which positions no stop acts, lowest and highest. [m]"""
    return max(lowest_position(p), p.lower_stop), min(highest_position(p), p.upper_stop)


@compiled
def held_by_stops(p, position, pressure, time):
    """Return a position, no deeper in a stop that gives way than where friction holds the stem. [m]"""
    if p.stop_compliance == 0.0:
        return position
    stiffness = p.spring_rate + 1.0 / p.stop_compliance
    for side, stop in ((RISING, p.upper_stop), (FALLING, p.lower_stop)):
        if side * position > side * stop:
            held = breakaway_ratio(p) * sliding_friction(p, -side, stop, pressure, time)
            deepest = max(side * thrust(p, stop, pressure, time) + held, 0.0) / stiffness
            return stop + side * min(side * (position - stop), deepest)
    return position


@compiled
def lay_span(p, state, side):
    """Write down between which positions one law of force holds: off the stops that give way, or against one."""
    state.span_lowest, state.span_highest = state.plan_lowest, state.plan_highest
    if p.stop_compliance == 0.0:
        return
    if is_above(p, side, state.position):
        state.span_lowest = p.upper_stop
    elif is_below(p, side, state.position):
        state.span_highest = p.lower_stop
    else:
        state.span_lowest, state.span_highest = free_travel(p)


@inlined
def room_to(state, side):
    """Return how far the stem may go to a side under one law of force. [m]"""
    return state.span_highest - state.position if side > 0.0 else state.position - state.span_lowest


@inlined
def speed_power(p, relative):
    """Return a relative speed to the power of the law's shape."""
    if p.stribeck_shape == 1.0:
        return relative
    # A power of any exponent takes as long as all other forces on a slip.
    return relative * relative if p.stribeck_shape == 2.0 else abs(relative) ** p.stribeck_shape


@compiled
def stribeck_share(p, speed):
    """Return the share of the drop that is left at a speed."""
    # A trial may run past the stop; the friction goes on smoothly there.
    relative = speed_power(p, max(speed / p.stribeck_velocity, -0.5))
    share = math.exp(-relative)
    if p.stribeck_tail != 0.0:
        share += p.stribeck_tail * (1.0 / (1.0 + relative) - share)
    return share


@inlined
def stribeck_excess(p, coulomb, speed):
    """Return the friction above Coulomb's at a speed. [N]"""
    return coulomb * (p.stribeck_ratio - 1.0) * stribeck_share(p, speed)


@compiled
def stribeck_slope(p, coulomb, speed):
    """Return by how much that friction falls with the speed. [N s/m]"""
    relative, steepness = speed / p.stribeck_velocity, 1.0
    if p.stribeck_shape == 2.0:
        steepness = 2.0 * relative
    elif p.stribeck_shape != 1.0:
        steepness = p.stribeck_shape * relative ** (p.stribeck_shape - 1.0)
    relative = speed_power(p, relative)
    share = math.exp(-relative)
    if p.stribeck_tail != 0.0:
        share += p.stribeck_tail * (1.0 / ((1.0 + relative) * (1.0 + relative)) - share)
    return coulomb * (p.stribeck_ratio - 1.0) * share * steepness / p.stribeck_velocity


@compiled
def limiting_friction(p, side, position, pressure, time, speed):
    """Return the friction that the bristles approach at a speed. [N]"""
    friction = sliding_friction(p, side, position, pressure, time)
    ratio = breakaway_ratio(p)
    if ratio > 1.0:
        fast = abs(speed)
        share = stribeck_share(p, fast) if p.stribeck_ratio > 1.0 else math.exp(-fast / STATIC_DECAY)
        friction *= 1.0 + (ratio - 1.0) * share
    return max(friction, 1e-9)


@compiled
def rest_stem(p, state, pressure, time):
    """Put the stem at rest in the middle of its stuck band under a pressure, where the thrust is 0."""
    state.velocity = 0.0
    state.mode = STUCK
    position = 0.0
    if p.spring_rate > 0.0:
        position = (p.diaphragm_area * pressure - p.spring_preload) / p.spring_rate
        for _ in range(60):
            slope = tangent_stiffness(p, 1.0, position, pressure, time)
            change = thrust(p, position, pressure, time) / max(slope, 0.1 * p.spring_rate)
            position += change
            if abs(change) < 1e-15 or abs(position) > FARTHEST:
                break
    put_stem(p, state, position, pressure, time)


@compiled
def put_stem(p, state, position, pressure, time):
    """Put the stem at rest at a position within its travel; bristles carry the thrust as far as they can.

    They are bent as if it had come from off a stop that gives way: that is pressed by what they cannot carry.
    """
    position = min(max(position, lowest_position(p)), highest_position(p))
    position = held_by_stops(p, position, pressure, time)
    state.position = position
    state.velocity = 0.0
    state.mode = STUCK
    limit = limiting_friction(p, 0.0, position, pressure, time, 0.0)
    carried = thrust_off_stops(p, position, pressure) + load_if_any(p, time)
    state.bristle = min(max(carried, -limit), limit)
    if has_sliders(p):
        bend_sliders(p, state, state.bristle)
