"""The stem linearised: actuator pressure to position."""

from __future__ import annotations

from collections.abc import Mapping

import control as ct
import numpy as np

from valvemodel.equations import numeric
from valvemodel.linear.block import Treatment, block, gain
from valvemodel.linear.point import OperatingPoint, evaluate, falling_friction

TREATMENTS = {
    "static_friction": Treatment(False, "breaking away is an event; see the describing function and the return map"),
    "stribeck": Treatment(True, "a damping that is less, or negative, by the slope of friction in speed"),
    "asymmetric_friction": Treatment(True, "the friction of its side places the branch"),
    "asymmetric_viscous_friction": Treatment(True, "the damping of its side; the mean of both when stuck"),
    "position_dependent_friction": Treatment(True, "a stiffness, the slope of friction in position"),
    "pressure_dependent_friction": Treatment(True, "less area rising and more falling, by its slope"),
    "presliding": Treatment(
        True,
        "stuck: the bristles' stiffness and damping add to the spring's and the stem's; in slip sliders follow the "
        "friction at once, bristles at speed/(C F), and not at all where their exponent is above 1",
    ),
    "spring_hardening": Treatment(True, "the tangent stiffness"),
    "area_variation": Treatment(True, "the effective area, and a stiffness of the pressure"),
    "end_stop": Treatment(False, "a stem that an end of the travel holds has no operating point"),
    "load_force": Treatment(False, "a disturbance: the point is taken at the start"),
    "friction_drift": Treatment(False, "a disturbance: the point is taken at the start"),
}


def blocks(numbers: Mapping[str, float], point: OperatingPoint) -> list[ct.StateSpace]:
    """Return the block from `pressure` to `position`."""
    compliance = numbers["presliding_compliance"]
    if point.side == 0.0 and compliance == 0.0:
        return [gain("stem", 0.0, "pressure", "position")]
    mass = numbers["stem_mass"]
    area = evaluate(numeric.thrust_by_pressure, numbers, position=point.position)
    stiffness = -evaluate(numeric.thrust_by_position, numbers, position=point.position, pressure=point.pressure)
    damping = numbers["viscous_friction"] * (1.0 + numbers["viscous_asymmetry"] * point.side)
    if point.side == 0.0:
        stiffness += 1.0 / compliance
        damping += (1.0 - numbers["slider_share"]) * numbers["bristle_damping"]
        return [_oscillator(mass, damping, stiffness, area)]
    by_position, by_speed, by_pressure = friction_slopes(numbers, point)
    if compliance == 0.0:
        return [_oscillator(mass, damping + by_speed, stiffness + by_position, area - by_pressure)]
    share, follows = numbers["slider_share"], numbers["bristle_exponent"] == 1.0
    rate = point.speed / (compliance * point.friction) if follows else 0.0
    own = (damping + share * by_speed, stiffness + share * by_position, area - share * by_pressure)
    viscous = numbers["bristle_damping"] * compliance
    slopes = (by_position, by_speed, by_pressure)
    return [_bristled(mass, *own, bristles=1.0 - share, viscous=viscous, rate=rate, slopes=slopes)]


def friction_slopes(numbers: Mapping[str, float], point: OperatingPoint) -> tuple[float, float, float]:
    """Return by how much the friction, positive along the position, grows with position, velocity and pressure.

    Returns
    -------
    tuple of float
        [N/m], [N s/m], [m^2]
    """
    if point.friction == 0.0:
        return 0.0, 0.0, 0.0
    fall = falling_friction(numbers)
    factor = evaluate(numeric.stribeck_factor, fall, speed=point.speed)
    coulomb = numbers["coulomb_friction"] * (1.0 + numbers["friction_asymmetry"] * point.side)
    by_position = tight_slope(numbers, position=point.position, coulomb_friction=coulomb)
    by_pressure = evaluate(numeric.seal_friction_by_pressure, numbers, pressure=point.pressure)
    by_speed = evaluate(numeric.stribeck_factor_by_speed, fall, speed=point.speed)
    side = point.side
    return side * factor * by_position, point.friction / factor * by_speed, side * factor * by_pressure


def tight_slope(numbers: Mapping[str, float], **given: float) -> float:
    """Return how the Coulomb friction grows with the position. [N/m]"""
    closure = numbers["tight_spot_closure"]
    if closure == 0.0:
        return evaluate(numeric.tight_friction_by_position, numbers, **given)
    distance = abs(given["position"] - numbers["tight_spot_position"]) / numbers["tight_spot_width"]
    if closure * distance ** numbers["tight_spot_exponent"] >= 1.0:
        return 0.0
    return evaluate(numeric.ending_friction_by_position, numbers, **given)


def _oscillator(mass: float, damping: float, stiffness: float, area: float) -> ct.StateSpace:
    a = [[0.0, 1.0], [-stiffness / mass, -damping / mass]]
    states = ["position", "velocity"]
    return block("stem", a, [[0.0], [area / mass]], [[1.0, 0.0]], [[0.0]], states, "pressure", "position")


def _bristled(
    mass: float,
    damping: float,
    stiffness: float,
    area: float,
    *,
    bristles: float,
    viscous: float,
    rate: float,
    slopes: tuple[float, float, float],
) -> ct.StateSpace:
    """Return a stem on bristles that are bent to the friction, which they follow at a rate [1/s].

    They carry a share of the friction, and so many seconds of its change by their damping.
    """
    by_position, by_speed, by_pressure = slopes
    follows = np.array([rate * by_position, rate * by_speed, -rate])
    moves = np.array([-stiffness, -damping, -bristles]) - bristles * viscous * follows
    a = np.array([[0.0, 1.0, 0.0], moves / mass, follows])
    b = np.array([[0.0], [(area - bristles * viscous * rate * by_pressure) / mass], [rate * by_pressure]])
    states, size = ["position", "velocity", "bristle_force"], 3 if rate > 0.0 else 2
    c = np.array([[1.0, 0.0, 0.0]])
    return block("stem", a[:size, :size], b[:size], c[:, :size], [[0.0]], states[:size], "pressure", "position")
