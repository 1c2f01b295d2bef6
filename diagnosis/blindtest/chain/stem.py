"""From the chamber's pressure to the stem's travel: mass, spring, friction, stops."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numba import njit

from diagnosis.blindtest.chain.clock import Clock, Signal
from diagnosis.blindtest.chain.electromagnet import creep_shape
from diagnosis.blindtest.truth import Truth, by_effect

STOP_SPEED = 1e-6  # m/s; slower than this inside the breakaway band is rest (design, section 2)
UNYIELDING = 1e300  # N/m; a stop stiffer than this is rigid
LUGRE, DAHL, IWAN = 1.0, 2.0, 3.0
ELASTIC_POWER = 40  # bonds break by slip that is plastic: near the friction's full level
SMALLEST_ROOM = 1e-9  # of Dahl's friction; nearer to its full level it no longer grows
ELEMENTS = 24  # sliders of an Iwan chain
TRAVEL_SCALE = 0.2  # m; travel at which hardening and area variation are stated


class Stem(NamedTuple):
    """Everything that the stem's equation of motion needs. SI units."""

    mass: float
    spring_rate: float
    area: float
    preload: float
    viscous_up: float
    viscous_down: float
    coulomb: float
    coulomb_up: float = 1.0  # factors on `coulomb`
    coulomb_down: float = 1.0
    static_excess: float = 0.0  # breakaway friction beyond Coulomb's, over Coulomb's
    decay_speed: float = 1e-3  # the excess is gone at a few times this speed; unused with bonds
    bond_distance: float = 0.0  # slip that breaks the bonds which carry the excess; 0: no bonds
    bond_time: float = 1.0  # time in which they heal
    stribeck_excess: float = 0.0
    stribeck_speed: float = 1e-2
    stribeck_exponent: float = 2.0  # 0: Lorentzian
    spot_height: float = 0.0  # friction added at a tight spot, over `coulomb`
    spot_centre: float = 0.0
    spot_width: float = 1.0
    spot_is_cosine: float = 0.0
    pressure_growth: float = 0.0  # friction added at `pressure_scale`, over `coulomb`
    pressure_scale: float = 1.0
    pressure_exponent: float = 1.0
    hardening_linear: float = 0.0  # relative stiffening a metre and a square metre
    hardening_cubic: float = 0.0
    area_linear: float = 0.0
    area_quadratic: float = 0.0
    stop_low: float = -np.inf
    stop_high: float = np.inf
    stop_stiffness: float = np.inf  # infinite: the stem stops dead
    bristle_law: float = 0.0  # 0: the stem sticks rigidly
    bristle_stiffness: float = 1.0
    bristle_damping: float = 0.0
    bristle_exponent: float = 1.0


@njit(cache=True)
def driving_force(travel, pressure, load, stem):
    """Force on the stem without friction, upwards positive. [N]"""
    area = stem.area * (1.0 + travel * (stem.area_linear + travel * stem.area_quadratic))
    stiffening = 1.0 + travel * (stem.hardening_linear + travel * stem.hardening_cubic)
    force = area * pressure - stem.spring_rate * travel * stiffening - stem.preload - load
    if stem.stop_stiffness < UNYIELDING:
        if travel > stem.stop_high:
            force -= stem.stop_stiffness * (travel - stem.stop_high)
        elif travel < stem.stop_low:
            force -= stem.stop_stiffness * (travel - stem.stop_low)
    return force


@njit(cache=True)
def friction_level(travel, pressure, scale, direction, stem):
    """Coulomb friction for motion in a direction (1 up, -1 down). [N]"""
    factor = 1.0
    if stem.spot_height != 0.0:
        distance = (travel - stem.spot_centre) / stem.spot_width
        if stem.spot_is_cosine > 0.0:
            if abs(distance) < 1.0:
                factor += stem.spot_height * 0.5 * (1.0 + np.cos(np.pi * distance))
        else:
            factor += stem.spot_height * np.exp(-0.5 * distance * distance)
    if stem.pressure_growth != 0.0:
        share = max(pressure, 0.0) / stem.pressure_scale
        factor += stem.pressure_growth * (share if stem.pressure_exponent == 1.0 else share * share)
    side = stem.coulomb_up if direction > 0 else stem.coulomb_down
    return stem.coulomb * scale * side * factor


@njit(cache=True)
def weakening(speed, bond, stem):
    """Friction over Coulomb friction at a speed, down to 1 when fast."""
    factor = 1.0
    if stem.bond_distance > 0.0:
        factor += stem.static_excess * bond
    elif stem.static_excess != 0.0:
        share = speed / stem.decay_speed
        factor += stem.static_excess * np.exp(-share * share)
    if stem.stribeck_excess != 0.0:
        share = abs(speed) / stem.stribeck_speed
        if stem.stribeck_exponent == 0.0:
            factor += stem.stribeck_excess / (1.0 + share * share)
        elif stem.stribeck_exponent == 1.0:
            factor += stem.stribeck_excess * np.exp(-share)
        else:
            factor += stem.stribeck_excess * np.exp(-share * share)
    return factor


@njit(cache=True)
def _bonded(bond, slip_speed, step, stem):
    """Share of the bonds that hold after a step: slip breaks them, time heals them."""
    healed = step / stem.bond_time
    return (bond + healed) / (1.0 + healed + step * slip_speed / stem.bond_distance)


@njit(cache=True)
def _acceleration(travel, speed, pressure, load, scale, direction, bond, stem):
    """Acceleration of a sliding stem. [m/s^2]"""
    viscous = stem.viscous_up if direction > 0 else stem.viscous_down
    friction = direction * friction_level(travel, pressure, scale, direction, stem) * weakening(speed, bond, stem)
    return (driving_force(travel, pressure, load, stem) - friction - viscous * speed) / stem.mass


@njit(cache=True)
def _released(travel, pressure, load, scale, bond, stem):
    """Direction in which a resting stem breaks away, 0 while it holds."""
    force = driving_force(travel, pressure, load, stem)
    direction = 1 if force > 0.0 else -1
    if abs(force) <= weakening(0.0, bond, stem) * friction_level(travel, pressure, scale, direction, stem):
        return 0
    rigid = stem.stop_stiffness > UNYIELDING
    if rigid and ((direction > 0 and travel >= stem.stop_high) or (direction < 0 and travel <= stem.stop_low)):
        return 0
    return direction


@njit(cache=True)
def _advance(travel, speed, direction, pressure, load, scale, step, bond, stem):
    """Travel, speed and the share of the step until the stem stops (1: it does not), by midpoint rule."""
    first = _acceleration(travel, speed, pressure, load, scale, direction, bond, stem)
    middle = speed + 0.5 * step * first
    half_way = travel + 0.5 * step * speed
    second = _acceleration(half_way, middle, pressure, load, scale, direction, bond, stem)
    new_speed = speed + step * second
    if new_speed * direction > 0.0:
        return travel + step * middle, new_speed, 1.0
    share = speed / (speed - new_speed) if speed != new_speed else 0.0
    return travel + 0.5 * speed * share * step, 0.0, share


@njit(cache=True)
def _slide(pressure, load, scale, substeps, step, start, keep_fine, stem):
    """Travel of a stem that sticks rigidly and slides, by the midpoint rule with located stops."""
    periods = pressure.shape[0]
    out = np.empty((periods, substeps if keep_fine else 1))
    wide = pressure.shape[1] > 1
    varying = load.min() != load.max()
    rigid = stem.stop_stiffness > UNYIELDING
    bonds, bond = stem.bond_distance > 0.0, 1.0
    travel, speed, direction = start, 0.0, 0
    for k in range(periods):
        if not keep_fine:
            out[k, 0] = travel
        for j in range(substeps):
            if keep_fine:
                out[k, j] = travel
            p = pressure[k, j] if wide else pressure[k, 0]
            force = load[k] + (load[k + 1] - load[k]) * (j / substeps) if varying else load[k]
            if bonds:
                bond = _bonded(bond, abs(speed), step, stem)
            if direction == 0:
                if j > 0 and not bonds and not wide and not varying:
                    continue
                direction = _released(travel, p, force, scale[k], bond, stem)
                if direction == 0:
                    continue
            travel, speed, share = _advance(travel, speed, direction, p, force, scale[k], step, bond, stem)
            if share < 1.0:
                # The rest of the step belongs to the other direction, or to rest.
                direction = _released(travel, p, force, scale[k], bond, stem)
                if direction != 0:
                    left = (1.0 - share) * step
                    travel, speed, _ = _advance(travel, 0.0, direction, p, force, scale[k], left, bond, stem)
            elif rigid and (travel >= stem.stop_high or travel <= stem.stop_low):
                travel = min(max(travel, stem.stop_low), stem.stop_high)
                speed, direction = 0.0, 0
            elif abs(speed) < STOP_SPEED and _released(travel, p, force, scale[k], bond, stem) == 0:
                speed, direction = 0.0, 0
    return out


@njit(cache=True)
def _bristle_force(state, yields, speed, step, level, behind, stem):
    """Elastic force of the bristles after a step [N] and their damping [N s/m].

    `state` holds the bristles' deflections and is moved on. `level` is the friction of this direction, `behind` of the
    other, which is as far as an element that is bent that way was bent.
    """
    stiffness = stem.bristle_stiffness
    way = 1.0 if speed > 0.0 else -1.0
    if stem.bristle_law == LUGRE:
        state[0] = (state[0] + step * speed) / (1.0 + step * stiffness * abs(speed) / level)
        elastic = max(1.0 - way * state[0] * stiffness / level, 0.0)
        return stiffness * state[0], stem.bristle_damping * elastic
    if stem.bristle_law == DAHL:
        room = max(1.0 - way * state[0] * stiffness / level, 0.0)
        steep = 1.0
        if stem.bristle_exponent != 1.0:
            steep = max(room, SMALLEST_ROOM) ** (stem.bristle_exponent - 1.0)
        room /= 1.0 + steep * step * abs(speed) * stiffness / level
        state[0] = way * (1.0 - room) * level / stiffness
        return stiffness * state[0], 0.0
    total, part = 0.0, stiffness / state.size
    highest, lowest = (level, -behind) if way > 0.0 else (behind, -level)
    for n in range(state.size):
        state[n] = min(max(state[n] + step * speed, lowest * yields[n] / part), highest * yields[n] / part)
        total += part * state[n]
    return total, 0.0


@njit(cache=True)
def _creep(pressure, load, scale, substeps, step, start, keep_fine, stem):
    """Travel of a stem held by bristles, by symplectic Euler with the position's trapezoid."""
    periods = pressure.shape[0]
    out = np.empty((periods, substeps if keep_fine else 1))
    wide = pressure.shape[1] > 1
    count = ELEMENTS if stem.bristle_law == IWAN else 1
    yields = np.linspace(0.0, 2.0, count) / count if count > 1 else np.ones(1)
    net = driving_force(start, pressure[0, 0], load[0], stem)
    most = friction_level(start, pressure[0, 0], scale[0], 1 if net > 0.0 else -1, stem) * weakening(0.0, 1.0, stem)
    # What bristles cannot carry, a stop does.
    state = yields * min(max(net, -most), most) * count / stem.bristle_stiffness
    travel, speed, bond = start, 0.0, 1.0
    for k in range(periods):
        if not keep_fine:
            out[k, 0] = travel
        for j in range(substeps):
            if keep_fine:
                out[k, j] = travel
            p = pressure[k, j] if wide else pressure[k, 0]
            force = load[k] + (load[k + 1] - load[k]) * (j / substeps)
            direction = 1 if speed > 0.0 else -1
            weak = weakening(speed, bond, stem)
            level = friction_level(travel, p, scale[k], direction, stem) * weak
            behind = level
            if stem.bristle_law == IWAN:
                behind = friction_level(travel, p, scale[k], -direction, stem) * weak
            friction, viscous = _bristle_force(state, yields, speed, step, level, behind, stem)
            viscous += stem.viscous_up if direction > 0 else stem.viscous_down
            if stem.bond_distance > 0.0:
                slip = abs(speed) * min(abs(friction) / level, 1.0) ** ELASTIC_POWER
                bond = _bonded(bond, slip, step, stem)
            net = driving_force(travel, p, force, stem) - friction
            new_speed = (speed + step * net / stem.mass) / (1.0 + step * viscous / stem.mass)
            travel += 0.5 * step * (speed + new_speed)
            speed = new_speed
            if stem.stop_stiffness > UNYIELDING and (travel >= stem.stop_high or travel <= stem.stop_low):
                travel = min(max(travel, stem.stop_low), stem.stop_high)
                speed = 0.0
    return out


def _static_friction(truth: Truth) -> dict[str, float]:
    numbers = truth.parameters
    changes = {"static_excess": numbers["static_excess"]}
    if truth.formulation == "karnopp":
        return changes | {"decay_speed": numbers["decay_speed"]}
    changes |= {"bond_distance": numbers["bond_distance"], "bond_time": numbers["bond_time"]}
    if truth.formulation == "lugre":
        changes |= {"bristle_law": LUGRE, "bristle_stiffness": numbers["bristle_stiffness"]}
        changes["bristle_damping"] = numbers["bristle_damping"]
    return changes


def _stribeck(truth: Truth) -> dict[str, float]:
    exponent = {"exponential": 1.0, "gaussian": 2.0, "lorentzian": 0.0}[truth.formulation]
    numbers = truth.parameters
    return {
        "stribeck_excess": numbers["static_excess"],
        "stribeck_speed": numbers["stribeck_speed"],
        "stribeck_exponent": exponent,
    }


def _asymmetric_friction(truth: Truth) -> dict[str, float]:
    excess = truth.parameters["excess"]
    other = 1.0 - excess if truth.formulation == "balanced" else 1.0
    up_is_high = truth.parameters["direction"] > 0
    return {"coulomb_up" if up_is_high else "coulomb_down": 1.0 + excess} | {
        "coulomb_down" if up_is_high else "coulomb_up": other
    }


def _position_dependent_friction(truth: Truth) -> dict[str, float]:
    numbers = truth.parameters
    return {
        "spot_height": numbers["height"],
        "spot_centre": numbers["centre"],
        "spot_width": numbers["width"],
        "spot_is_cosine": float(truth.formulation == "raised_cosine"),
    }


def _pressure_dependent_friction(truth: Truth) -> dict[str, float]:
    exponent = {"linear": 1.0, "quadratic": 2.0}[truth.formulation]
    growth, scale = truth.parameters["growth"], truth.parameters["pressure_scale"]
    return {"pressure_growth": growth, "pressure_scale": scale, "pressure_exponent": exponent}


def _presliding(truth: Truth) -> dict[str, float]:
    numbers = truth.parameters
    return {
        "bristle_law": {"lugre": LUGRE, "dahl": DAHL, "iwan": IWAN}[truth.formulation],
        "bristle_stiffness": 1.0 / numbers["compliance"],
        "bristle_damping": numbers.get("bristle_damping", 0.0),
        "bristle_exponent": numbers.get("exponent", 1.0),
    }


def _spring_hardening(truth: Truth) -> dict[str, float]:
    stiffening = truth.parameters["stiffening"]
    if truth.formulation == "cubic":
        return {"hardening_cubic": stiffening / TRAVEL_SCALE**2}
    return {"hardening_linear": stiffening / TRAVEL_SCALE}


def _area_variation(truth: Truth) -> dict[str, float]:
    change = truth.parameters["direction"] * truth.parameters["change"]
    if truth.formulation == "quadratic":
        return {"area_quadratic": change / TRAVEL_SCALE**2}
    return {"area_linear": change / TRAVEL_SCALE}


def _end_stop(truth: Truth) -> dict[str, float]:
    numbers = truth.parameters
    position = numbers["reference_travel"] - numbers["side"] * numbers["depth"]
    changes = {"stop_high" if numbers["side"] > 0 else "stop_low": position}
    if truth.formulation == "elastic":
        changes["stop_stiffness"] = numbers["stop_stiffness"]
    return changes


CHANGES = {
    "static_friction": _static_friction,
    "stribeck": _stribeck,
    "asymmetric_friction": _asymmetric_friction,
    "position_dependent_friction": _position_dependent_friction,
    "pressure_dependent_friction": _pressure_dependent_friction,
    "presliding": _presliding,
    "spring_hardening": _spring_hardening,
    "area_variation": _area_variation,
    "end_stop": _end_stop,
}


def stem_of(base: Mapping[str, float], truths: tuple[Truth, ...]) -> Stem:
    """The stem with its base parameters and its effects."""
    effects = by_effect(truths, "stem")
    stem = Stem(
        mass=base["stem_mass"],
        spring_rate=base["spring_rate"],
        area=base["diaphragm_area"],
        preload=base.get("spring_preload", 0.0),
        viscous_up=base["viscous_friction"],
        viscous_down=base["viscous_friction"],
        coulomb=base["coulomb_friction"],
        stop_low=base.get("travel_min", -np.inf),
        stop_high=base.get("travel_max", np.inf),
    )
    for key, change in CHANGES.items():
        if key in effects:
            stem = stem._replace(**change(effects[key]))
    if "asymmetric_viscous_friction" in effects:
        stem = _with_uneven_damping(stem, effects["asymmetric_viscous_friction"])
    return Stem(*(float(value) for value in stem))


def _with_uneven_damping(stem: Stem, truth: Truth) -> Stem:
    """Viscous friction that differs up and down."""
    factor, up_is_high = 1.0 + truth.parameters["excess"], truth.parameters["direction"] > 0
    high = stem.viscous_up * factor
    low = stem.viscous_up / factor**0.5 if truth.formulation == "both_sides" else stem.viscous_up
    return stem._replace(viscous_up=high if up_is_high else low, viscous_down=low if up_is_high else high)


def load_force(clock: Clock, truths: tuple[Truth, ...]) -> Signal:
    """Force that pushes the stem down, at the period starts and the end, shape (periods + 1,). [N]"""
    time = np.arange(clock.periods + 1) * clock.period
    truth = by_effect(truths, "stem").get("load_force")
    if truth is None:
        return np.zeros_like(time)
    numbers = truth.parameters
    match truth.formulation:
        case "sine":
            angle = 2 * np.pi * time / numbers["load_period"] + numbers["phase"]
            return numbers["amplitude"] * np.sin(angle)
        case "wander":
            generator = np.random.default_rng(int(numbers["wander_seed"]))
            rates = generator.uniform(0.01, 0.1, 12)
            phases = generator.uniform(0, 2 * np.pi, 12)
            waves = np.sin(2 * np.pi * np.outer(time, rates) + phases)
            return numbers["amplitude"] * waves.sum(axis=1) / np.sqrt(6.0)
    raise ValueError(f"load_force has no formulation {truth.formulation!r}")


def friction_scale(clock: Clock, truths: tuple[Truth, ...]) -> Signal:
    """Friction over its value at the start, shape (periods,)."""
    truth = by_effect(truths, "stem").get("friction_drift")
    if truth is None:
        return np.ones(clock.periods)
    numbers = truth.parameters
    return 1.0 + numbers["growth"] * creep_shape(clock.starts(), truth.formulation, numbers.get("time_constant", 0.0))


def resting_travel(stem: Stem, pressure: float, load: float, share: float) -> float:
    """Travel where friction carries `share` of its breakaway value, by bisection. [m]"""
    low, high = max(-0.2, stem.stop_low), min(1.0, stem.stop_high)
    for _ in range(60):
        middle = 0.5 * (low + high)
        force = driving_force(middle, pressure, load, stem)
        direction = 1 if force > 0 else -1
        breakaway = weakening(0.0, 1.0, stem) * friction_level(middle, pressure, 1.0, direction, stem)
        low, high = (middle, high) if force > share * breakaway else (low, middle)
    return 0.5 * (low + high)


def stem_travel(
    pressure: Signal,
    clock: Clock,
    stem: Stem,
    truths: tuple[Truth, ...],
    *,
    start: float,
    keep_fine: bool,
) -> Signal:
    """Travel from rest at `start`: every fine step, or at the period starts only. [m]"""
    move = _creep if stem.bristle_law else _slide
    load, scale = load_force(clock, truths), friction_scale(clock, truths)
    return move(pressure, load, scale, clock.substeps, clock.step, start, keep_fine, stem)
