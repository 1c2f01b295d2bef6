"""Stem: actuator pressure to stem position, stick and slip located exactly, with the effects of friction, spring and load."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled
from valvemodel.declarations import Effect, Parameter
from valvemodel.equations import numeric

STUCK, RISING, FALLING = 0.0, 1.0, -1.0
STOP_SPEED = 1e-6
"""Below this speed a slip has ended where the net force is within the breakaway force. [m/s]"""

NEGLIGIBLE_SWING = 1e-7
"""A presliding stem whose next swing is shorter than this is at rest. [m]"""

EFFECTS = (
    Effect(
        key="static_friction",
        stage="stem",
        title="static friction",
        meaning="breaking away takes more force than sliding: the stem jumps",
        equation=r"|F| \le F_s = r\,F_c \text{ while stuck}",
        source="paper eqs. (5), (6)",
        parameters=(Parameter("static_friction_ratio", "1", "F_s / F_c", 1.0, 3.0, 1.0, (1.2, 1.03, 1.06, 1.1, 1.15, 1.25, 1.3, 1.4, 1.5, 1.7)),),
        is_jagged=True,
        aliases=("stribeck",),
        told_apart_by="slow ramps: Stribeck friction also drops while the stem already moves",
    ),
    Effect(
        key="stribeck",
        stage="stem",
        title="Stribeck friction",
        meaning="friction falls from breakaway to Coulomb as the stem speeds up",
        equation=r"F = F_c\,(1 + (r - 1) e^{-|v|/v_s})\,\mathrm{sign}(v)",
        source="Stribeck (1902); Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994)",
        parameters=(
            Parameter("stribeck_ratio", "1", "friction at speed 0 over Coulomb friction", 1.0, 3.0, 1.0, (1.3, 1.1, 1.2, 1.5)),
            Parameter("stribeck_velocity", "m/s", "speed at which the drop has fallen to 1/e", 1e-4, 0.3, 5e-3, (5e-3, 1.5e-3, 1.5e-2, 5e-2), "log"),
        ),
        is_jagged=True,
        is_chaotic=True,
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
        parameters=(Parameter("friction_asymmetry", "1", "a: share by which rising is rougher", -0.95, 0.95, 0.0, (0.15, -0.15)),),
        aliases=("none", "load_force"),
        told_apart_by="the spring's preload known, or position at no pressure",
    ),
    Effect(
        key="asymmetric_viscous_friction",
        stage="stem",
        title="asymmetric viscous friction",
        meaning="viscous friction differs up and down",
        equation=r"f_v\,(1 + a\,\mathrm{sign}(v))\,v",
        source="EMPS benchmark: wear of the screw; a check valve in the damping",
        parameters=(Parameter("viscous_asymmetry", "1", "a: share by which rising is more damped", -0.98, 0.98, 0.0, (0.4, -0.4)),),
        aliases=("asymmetric_filling",),
        told_apart_by="a measured pressure; fast strokes both ways",
    ),
    Effect(
        key="position_dependent_friction",
        stage="stem",
        title="tight spot",
        meaning="friction is higher around one place of the travel",
        equation=r"F_c\,(1 + A\,e^{-((y - y_0)/w)^2})",
        source="bent stem, scored packing",
        parameters=(
            Parameter("tight_spot_excess", "1", "A: excess friction in the middle", -0.9, 5.0, 0.0, (0.4, 1.0)),
            Parameter("tight_spot_position", "m", "middle of the spot", -0.1, 0.6, 0.13, ("travel_place",), typical=0.14),
            Parameter("tight_spot_width", "m", "half-width at 1/e", 1e-3, 0.2, 0.02, (0.012, 0.006, 0.03), "log"),
        ),
        is_jagged=True,
        told_apart_by="strokes through the whole travel at low speed",
    ),
    Effect(
        key="pressure_dependent_friction",
        stage="stem",
        title="pressure-dependent friction",
        meaning="seal or packing friction grows with the pressure",
        equation=r"F_c + S_p\,P",
        source="self-energising lip seals",
        parameters=(Parameter("friction_area", "m^2", "friction per pressure", -0.01, 0.03, 0.0, (2e-3, -2e-3)),),
        aliases=("spring_hardening", "magnetic_hysteresis"),
        told_apart_by="minor loops at low and high pressure",
    ),
    Effect(
        key="presliding",
        stage="stem",
        title="presliding",
        meaning="a stuck stem gives way elastically before it slides",
        equation=r"df/dy = (1 - f\,\mathrm{sign}(v)/F)/C",
        source="Dahl (1968); with F_s > F_c the LuGre model, IEEE TAC 40 (1995)",
        parameters=(Parameter("presliding_compliance", "m/N", "C: yield of the stuck stem over force", 0.0, 2e-5, 0.0, (2e-7, 2e-6)),),
        aliases=("linkage_backlash", "magnetic_hysteresis"),
        told_apart_by="small reversals, smaller than the dead band",
    ),
    Effect(
        key="spring_hardening",
        stage="stem",
        title="spring hardening",
        meaning="the spring stiffens with travel",
        equation=r"F_k = k\,y\,(1 + h\,y^2)",
        source="Duffing's cubic spring",
        parameters=(Parameter("spring_hardening", "1/m^2", "h: share of stiffening over travel squared", -8.0, 60.0, 0.0, (3.0, -2.0)),),
        aliases=("linkage_nonlinearity", "area_variation", "magnetic_saturation"),
        told_apart_by="a measured pressure tells it from magnet and nozzle; a straight scale on the stem from the linkage",
    ),
    Effect(
        key="area_variation",
        stage="stem",
        title="area variation",
        meaning="the effective area of the diaphragm changes with travel",
        equation=r"S_1\,(1 + a\,y)",
        source="rolling diaphragm; ISA handbook of control valves",
        parameters=(Parameter("area_slope", "1/m", "a: share of area over travel", -3.0, 3.0, 0.0, (-0.5, 0.5)),),
        aliases=("spring_hardening", "linkage_nonlinearity", "magnetic_saturation"),
        told_apart_by="the force at a blocked stem at two positions",
    ),
    Effect(
        key="end_stop",
        stage="stem",
        title="end stop",
        meaning="the travel ends short of the expected range",
        equation=r"y_{lo} \le y \le y_{hi}",
        source="mechanical stop, inelastic",
        parameters=(
            Parameter("upper_stop", "m", "highest position", 0.0, 1.0, math.inf, ("highest_reading",), typical=0.2),
            Parameter("lower_stop", "m", "lowest position", -0.5, 0.5, -math.inf, ("lowest_reading",), typical=-math.inf),
        ),
        is_one_of=True,
        aliases=("magnetic_saturation",),
        told_apart_by="the readings themselves: they stay at one value while the current goes on",
    ),
    Effect(
        key="load_force",
        stage="stem",
        title="load force",
        meaning="flow on the plug or another unmeasured force, periodic or slowly varying",
        equation=r"F_g = A \sin(2\pi t/T) + B \cos(2\pi t/T)",
        source="paper eq. (1), F_g; one Fourier component",
        parameters=(
            Parameter("load_sine", "N", "A", -5000.0, 5000.0, 0.0, (200.0,)),
            Parameter("load_cosine", "N", "B", -5000.0, 5000.0, 0.0, (200.0,)),
            Parameter("load_period", "s", "T", 0.5, 2000.0, 30.0, ("residual_period",), "log", typical=30.0),
        ),
        aliases=("gap_drift", "sensor_drift"),
        told_apart_by="the disturbance in a phase where the current is held",
    ),
    Effect(
        key="friction_drift",
        stage="stem",
        title="friction drift",
        meaning="friction grows over the record as the packing heats or dries",
        equation=r"F_c\,(1 + r\,T\,(1 - e^{-t/T}))",
        source="packing that heats or dries, first order",
        parameters=(
            Parameter("friction_drift_rate", "1/s", "r: share of friction over time at the start", -0.05, 0.2, 0.0, (2e-3, -2e-3)),
            Parameter("friction_drift_time", "s", "T: time constant", 5.0, 3000.0, 300.0, (300.0, 30.0), "log"),
        ),
        told_apart_by="the same slow stroke early and late",
    ),
)

driving_force = compiled(numeric.driving_force)


@compiled
def thrust(p, position, pressure, time):
    """Return the force that drives the stem, all but friction. [N]"""
    force = driving_force(pressure, position, p.diaphragm_area, p.spring_rate, p.spring_preload)
    if p.area_slope != 0.0:
        force += p.diaphragm_area * p.area_slope * position * pressure
    if p.spring_hardening != 0.0:
        force -= p.spring_rate * p.spring_hardening * position * position * position
    if p.load_sine != 0.0 or p.load_cosine != 0.0:
        angle = 2.0 * math.pi * time / p.load_period
        force += p.load_sine * math.sin(angle) + p.load_cosine * math.cos(angle)
    return force


@compiled
def sliding_friction(p, side, position, pressure, time):
    """Return the Coulomb friction of a stem that moves to a side, at high speed. [N]"""
    friction = p.coulomb_friction
    if p.friction_asymmetry != 0.0:
        friction *= 1.0 + p.friction_asymmetry * side
    if p.friction_drift_rate != 0.0:
        grown = -p.friction_drift_rate * p.friction_drift_time * math.expm1(-time / p.friction_drift_time)
        friction *= max(1.0 + grown, 0.0)
    if p.tight_spot_excess != 0.0:
        distance = (position - p.tight_spot_position) / p.tight_spot_width
        friction *= 1.0 + p.tight_spot_excess * math.exp(-distance * distance)
    if p.friction_area != 0.0:
        friction = max(friction + p.friction_area * max(pressure, 0.0), 0.0)
    return friction


@compiled
def breakaway_ratio(p):
    """Return the breakaway force over the Coulomb friction."""
    return max(p.static_friction_ratio, p.stribeck_ratio)


@compiled
def tangent_stiffness(p, side, position, pressure, time):
    """Return by how much the net force falls with the position. [N/m]"""
    stiffness = p.spring_rate
    if p.spring_hardening != 0.0:
        stiffness += 3.0 * p.spring_rate * p.spring_hardening * position * position
    if p.area_slope != 0.0:
        stiffness -= p.diaphragm_area * p.area_slope * pressure
    if p.tight_spot_excess != 0.0:
        distance = (position - p.tight_spot_position) / p.tight_spot_width
        bump = p.tight_spot_excess * math.exp(-distance * distance)
        friction = sliding_friction(p, side, position, pressure, time)
        stiffness += -2.0 * distance / p.tight_spot_width * side * friction * bump / (1.0 + bump)
    return stiffness


@compiled
def is_linear(p):
    """Return whether a slip under a held pressure is a linear equation, so that one step is exact."""
    return (
        p.spring_hardening == 0.0
        and p.tight_spot_excess == 0.0
        and p.stribeck_ratio == 1.0
        and p.presliding_compliance == 0.0
    )


@compiled
def transition(mass, damping, stiffness, duration):
    """Return the exact map of (v, a) over a duration of m a' = -c a - k v.

    Six numbers: v from v and a, a from v and a, the way from v and a. Any sign of damping and stiffness.
    """
    alpha = 0.5 * damping / mass
    omega_squared = stiffness / mass
    discriminant = alpha * alpha - omega_squared
    if stiffness == 0.0:
        decay = math.exp(-2.0 * alpha * duration)
        if abs(alpha * duration) < 1e-4:
            x = 2.0 * alpha * duration
            sine = duration * (1.0 - x / 2.0 * (1.0 - x / 3.0 * (1.0 - x / 4.0)))
            way = duration * duration * (0.5 - x / 6.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0)))
        else:
            sine = -math.expm1(-2.0 * alpha * duration) / (2.0 * alpha)
            way = (duration - sine) / (2.0 * alpha)
        return 1.0, sine, 0.0, decay, duration, way
    beta = math.sqrt(abs(discriminant))
    x = beta * duration
    if x < 0.03:
        square = x * x if discriminant > 0.0 else -x * x
        decay = math.exp(-alpha * duration)
        cosine = decay * (1.0 + square / 2.0 * (1.0 + square / 12.0 * (1.0 + square / 30.0 * (1.0 + square / 56.0))))
        sine = decay * duration * (1.0 + square / 6.0 * (1.0 + square / 20.0 * (1.0 + square / 42.0)))
    elif discriminant > 0.0:
        slow = math.exp((beta - alpha) * duration)
        fast = math.exp(-(beta + alpha) * duration)
        cosine = 0.5 * (slow + fast)
        sine = 0.5 * (slow - fast) / beta
    else:
        decay = math.exp(-alpha * duration)
        cosine = decay * math.cos(x)
        sine = decay * math.sin(x) / beta
    way = (1.0 - cosine - alpha * sine) / omega_squared
    return (
        cosine + alpha * sine,
        sine,
        -omega_squared * sine,
        cosine - alpha * sine,
        sine + 2.0 * alpha * way,
        way,
    )


@compiled
def remembered_transition(p, state, damping, stiffness, duration):
    """Return `transition`, computed anew only where its arguments differ from the last ones."""
    if (
        state.known_duration != duration
        or state.known_damping != damping
        or state.known_stiffness != stiffness
        or state.known_mass != p.stem_mass
    ):
        vv, va, av, aa, yv, ya = transition(p.stem_mass, damping, stiffness, duration)
        state.known_vv, state.known_va, state.known_av = vv, va, av
        state.known_aa, state.known_yv, state.known_ya = aa, yv, ya
        state.known_duration, state.known_damping = duration, damping
        state.known_stiffness, state.known_mass = stiffness, p.stem_mass
    return state.known_vv, state.known_va, state.known_av, state.known_aa, state.known_yv, state.known_ya


@compiled
def first_stop(mass, damping, stiffness, speed, acceleration):
    """Return when a speed that is not negative first falls to 0, or infinity. [s]"""
    if speed < 0.0 or (speed == 0.0 and acceleration <= 0.0):
        return 0.0
    alpha = 0.5 * damping / mass
    discriminant = alpha * alpha - stiffness / mass
    beta = math.sqrt(abs(discriminant))
    falling = -(alpha * speed + acceleration)
    if discriminant < 0.0:
        if speed == 0.0:
            return math.pi / beta
        angle = math.atan2(beta * speed, falling)
        return angle / beta
    if falling <= 0.0 or speed == 0.0 or beta * speed >= falling:
        return math.inf
    ratio = beta * speed / falling
    return math.atanh(ratio) / beta if ratio > 1e-8 else speed / falling


@compiled
def slip_end(mass, damping, stiffness, speed, acceleration, excess, high):
    """Return when a slip has ended by the stop-speed rule, known to have ended by the end of a bracket. [s]

    The later of two instants: the speed falls below the stop speed, and the net force below the breakaway force,
    which is `excess` (Coulomb less breakaway, not positive) plus viscous friction plus inertia.
    """
    jerk = -(damping * acceleration + stiffness * speed) / mass
    peak = first_stop(mass, damping, stiffness, acceleration, jerk) if acceleration > 0.0 else 0.0
    low = min(peak, high)
    slow = falling_instant(mass, damping, stiffness, speed, acceleration, 1.0, 0.0, STOP_SPEED, low, high)
    within = falling_instant(mass, damping, stiffness, speed, acceleration, damping, mass, -excess, 0.0, high)
    return max(slow, within)


@compiled
def falling_instant(mass, damping, stiffness, speed, acceleration, of_speed, of_acceleration, level, low, high):
    """Return when of_speed v + of_acceleration a falls to a level inside a bracket. [s]

    Bracketed Newton iteration on the closed form; the lower end where it is already below.
    """
    instant = low
    for _ in range(80):
        vv, va, av, aa, _, _ = transition(mass, damping, stiffness, instant)
        v = vv * speed + va * acceleration
        a = av * speed + aa * acceleration
        value = of_speed * v + of_acceleration * a - level
        if value > 0.0:
            low = instant
        else:
            high = instant
        slope = of_speed * a - of_acceleration * (damping * a + stiffness * v) / mass
        following = instant - value / slope if slope < 0.0 else 0.5 * (low + high)
        if not low < following < high:
            following = 0.5 * (low + high)
        if abs(following - instant) <= 1e-15 * high or high - low <= 1e-15 * high:
            break
        instant = following
    return instant


@compiled
def advance_stem(p, state, pressure, time, duration, tolerance):
    """Hold the pressure and move the stem until its next event or the end of a duration; return the time used. [s]

    Events are breakaway, stop, reversal, a travel limit. A linear slip is one closed-form step. Else the forces
    are linearised at the start of a step, whose length keeps the force left over below the tolerance. [N]
    """
    if p.presliding_compliance > 0.0:
        return advance_presliding(p, state, pressure, time, duration, tolerance)
    middle = time + 0.5 * duration
    position = state.position
    net = thrust(p, position, pressure, middle)
    highest = min(p.travel_max, p.upper_stop)
    lowest = max(p.travel_min, p.lower_stop)
    if state.mode == STUCK:
        side = RISING if net > 0.0 else FALLING
        breakaway = breakaway_ratio(p) * sliding_friction(p, side, position, pressure, middle)
        is_blocked = (side > 0.0 and position >= highest) or (side < 0.0 and position <= lowest)
        if abs(net) <= breakaway or is_blocked:
            return duration
        state.mode = side
        state.velocity = 0.0
    side = state.mode
    velocity = state.velocity
    coulomb = sliding_friction(p, side, position, pressure, middle)
    viscous = p.viscous_friction * (1.0 + p.viscous_asymmetry * side)
    stiffness = tangent_stiffness(p, side, position, pressure, middle)
    friction, damping = coulomb, viscous
    if p.stribeck_ratio > 1.0:
        excess = coulomb * (p.stribeck_ratio - 1.0) * math.exp(-abs(velocity) / p.stribeck_velocity)
        friction += excess
        damping -= excess / p.stribeck_velocity
    mass = p.stem_mass
    start = (side * net - friction - viscous * abs(velocity)) / mass
    speed = side * velocity
    step = duration
    if damping < 0.0:
        step = min(step, -3.0 * mass / damping)
    linear = is_linear(p)
    stop = first_stop(mass, damping, stiffness, speed, start)
    has_stopped = stop <= step
    if has_stopped:
        step = stop
    while True:
        vv, va, av, aa, yv, ya = remembered_transition(p, state, damping, stiffness, step)
        next_speed = 0.0 if has_stopped else vv * speed + va * start
        next_acceleration = av * speed + aa * start
        way = yv * speed + ya * start
        if linear:
            break
        left_over = slip_left_over(
            p, side, position, way, next_speed, next_acceleration, pressure, middle, viscous
        )
        if abs(left_over) <= tolerance or step < 1e-7:
            correction = left_over / (3.0 * mass)
            way += ya * correction
            if not has_stopped:
                next_speed = max(next_speed + va * correction, 0.0)
            break
        step *= 0.5
        has_stopped = False
    at_limit = side * (position + side * way) > (highest if side > 0.0 else -lowest)
    if at_limit:
        step, way = time_to_limit(mass, damping, stiffness, speed, start, highest - position if side > 0.0 else position - lowest, step)
        has_stopped = True
    elif next_speed < STOP_SPEED and -1.0 < next_acceleration < 0.0:
        # A harder stop than 1 m/s^2 goes less than 1e-12 m between the stop speed and 0.
        excess = coulomb * (1.0 - breakaway_ratio(p))
        if excess + viscous * next_speed + mass * next_acceleration <= 0.0:
            has_stopped = True
            if linear:
                step = slip_end(mass, damping, stiffness, speed, start, excess, step)
                _, _, _, _, yv, ya = transition(mass, damping, stiffness, step)
                way = yv * speed + ya * start
    state.position = position + side * way
    if at_limit:
        state.position = highest if side > 0.0 else lowest
    if has_stopped:
        state.velocity = 0.0
        state.mode = STUCK
    else:
        state.velocity = side * next_speed
    return step


@compiled
def slip_left_over(p, side, position, way, speed, acceleration, pressure, time, viscous):
    """Return the net force at the end of a linearised slip step less the one that the step assumed. [N]"""
    end = position + side * way
    friction = sliding_friction(p, side, end, pressure, time)
    if p.stribeck_ratio > 1.0:
        friction *= 1.0 + (p.stribeck_ratio - 1.0) * math.exp(-abs(speed) / p.stribeck_velocity)
    net = side * thrust(p, end, pressure, time) - friction - viscous * speed
    return net - p.stem_mass * acceleration


@compiled
def time_to_limit(mass, damping, stiffness, speed, acceleration, distance, step):
    """Return when a slip has gone a distance, and that distance; bisection on the closed form. [s], [m]"""
    low, high = 0.0, step
    for _ in range(60):
        middle = 0.5 * (low + high)
        _, _, _, _, yv, ya = transition(mass, damping, stiffness, middle)
        if yv * speed + ya * acceleration < distance:
            low = middle
        else:
            high = middle
        if high - low <= 1e-13 * step:
            break
    return high, distance


@compiled
def advance_presliding(p, state, pressure, time, duration, tolerance):
    """Move a stem whose friction is elastic before it slides until its next reversal; return the time used. [s]

    Along a way in one direction the friction is a function of the position alone (Dahl), so that the step is the
    linearised one of `advance_stem` with the stiffness of the bristles added.
    """
    middle = time + 0.5 * duration
    position = state.position
    contact = 1.0 / p.presliding_compliance
    net = thrust(p, position, pressure, middle) - state.bristle
    mass = p.stem_mass
    if state.mode == STUCK:
        if abs(net) <= 0.5 * NEGLIGIBLE_SWING * (contact + p.spring_rate):
            return duration
        state.mode = RISING if net > 0.0 else FALLING
        state.velocity = 0.0
    side = state.mode
    speed = side * state.velocity
    limit = limiting_friction(p, side, position, pressure, middle, speed)
    viscous = p.viscous_friction * (1.0 + p.viscous_asymmetry * side)
    slope = contact * (1.0 - side * state.bristle / limit) if limit > 0.0 else 0.0
    stiffness = tangent_stiffness(p, side, position, pressure, middle) + slope
    start = (side * net - viscous * speed) / mass
    stop = first_stop(mass, viscous, stiffness, speed, start)
    step = min(duration, stop)
    has_stopped = stop <= duration
    while True:
        vv, va, av, aa, yv, ya = transition(mass, viscous, stiffness, step)
        next_speed = 0.0 if has_stopped else vv * speed + va * start
        next_acceleration = av * speed + aa * start
        way = yv * speed + ya * start
        end = position + side * way
        limit = limiting_friction(p, side, end, pressure, middle, next_speed)
        bristle = side * limit + (state.bristle - side * limit) * math.exp(-contact * abs(way) / limit)
        left_over = side * (thrust(p, end, pressure, middle) - bristle) - viscous * next_speed
        left_over -= mass * next_acceleration
        if abs(left_over) <= tolerance or step < 1e-7:
            way += ya * left_over / (3.0 * mass)
            if not has_stopped:
                next_speed = max(next_speed + va * left_over / (3.0 * mass), 0.0)
            break
        step *= 0.5
        has_stopped = False
    end = position + side * way
    highest = min(p.travel_max, p.upper_stop)
    lowest = max(p.travel_min, p.lower_stop)
    if end > highest or end < lowest:
        end = min(max(end, lowest), highest)
        has_stopped = True
        step = duration
    limit = limiting_friction(p, side, end, pressure, middle, next_speed)
    state.bristle = side * limit + (state.bristle - side * limit) * math.exp(-contact * abs(end - position) / limit)
    state.position = end
    state.velocity = 0.0 if has_stopped else side * next_speed
    if has_stopped:
        state.mode = STUCK
    return step


@compiled
def limiting_friction(p, side, position, pressure, time, speed):
    """Return the friction that the bristles approach at a speed. [N]"""
    friction = sliding_friction(p, side, position, pressure, time)
    ratio = breakaway_ratio(p)
    if ratio > 1.0:
        decay_speed = p.stribeck_velocity if p.stribeck_ratio > 1.0 else 1e-3
        friction *= 1.0 + (ratio - 1.0) * math.exp(-abs(speed) / decay_speed)
    return max(friction, 1e-9)


@compiled
def is_creeping(p, state):
    """Return whether a slip goes on only as the tail of an overdamped one, too slow to be called motion."""
    return abs(state.velocity) < STOP_SPEED


@compiled
def rest_stem(p, state, pressure, time):
    """Put the stem at rest in the middle of its stuck band under a pressure, by bisection of the thrust."""
    highest, lowest = min(p.travel_max, p.upper_stop), max(p.travel_min, p.lower_stop)
    state.velocity = 0.0
    state.mode = STUCK
    position = 0.0
    if p.spring_rate > 0.0:
        position = (p.diaphragm_area * pressure - p.spring_preload) / p.spring_rate
        for _ in range(60):
            slope = tangent_stiffness(p, 1.0, position, pressure, time)
            change = thrust(p, position, pressure, time) / max(slope, 0.1 * p.spring_rate)
            position += change
            if abs(change) < 1e-15:
                break
    state.position = min(max(position, lowest), highest)
    state.bristle = 0.0


@compiled
def put_stem(p, state, position, pressure, time):
    """Put the stem at rest at a position; bristles carry the thrust as far as they can."""
    state.position = position
    state.velocity = 0.0
    state.mode = STUCK
    limit = limiting_friction(p, 0.0, position, pressure, time, 0.0)
    state.bristle = min(max(thrust(p, position, pressure, time), -limit), limit)
