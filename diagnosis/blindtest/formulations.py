"""Every effect that a plant can have, and the laws that it is drawn from."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from diagnosis.blindtest.chain.nozzle import static_pressure

Numbers = dict[str, float]
Draw = Callable[[np.random.Generator, Mapping[str, float]], Numbers]

HIGH_CURRENT, LOW_CURRENT = 19.5e-3, 5e-3  # A, the turning points of the test ramps


@dataclass(frozen=True)
class Formulation:
    """One physical law for an effect.

    Attributes
    ----------
    name : str
        The law's name.
    draw : callable
        Numbers that are drawn and kept, from a generator and the base parameters; SI units.
    magnitude : str or None
        The number that sets how strong the effect is; None where the law is there or is not.
    lowest, highest : float
        Bounds within which the magnitude is physically sensible.
    """

    name: str
    draw: Draw
    magnitude: str | None = None
    lowest: float = 0.0
    highest: float = 0.0


@dataclass(frozen=True)
class Effect:
    """The stage of an effect and its laws."""

    stage: str
    formulations: tuple[Formulation, ...]


def _nothing(generator: np.random.Generator, base: Mapping[str, float]) -> Numbers:
    return {}


def _between(**bounds: tuple[float, float]) -> Draw:
    """Draw each number uniformly, or log-uniformly where the bounds span more than a factor 5."""

    def draw(generator: np.random.Generator, base: Mapping[str, float]) -> Numbers:
        numbers = {}
        for name, (low, high) in bounds.items():
            if low > 0 and high > 5 * low:
                numbers[name] = float(np.exp(generator.uniform(np.log(low), np.log(high))))
            else:
                numbers[name] = float(generator.uniform(low, high))
        return numbers

    return draw


def _signed(draw: Draw, name: str = "direction", up_share: float = 0.5) -> Draw:
    """Draw a sign as well, +1 with a given probability."""

    def with_sign(generator: np.random.Generator, base: Mapping[str, float]) -> Numbers:
        sign = 1.0 if generator.random() < up_share else -1.0
        return {name: sign, **draw(generator, base)}

    return with_sign


def _with_supply(generator: np.random.Generator, base: Mapping[str, float]) -> Numbers:
    return {"pressure_scale": base["supply_pressure"]}


def _stop_side(generator: np.random.Generator, base: Mapping[str, float]) -> Numbers:
    """Side of a stop, and the end of the travel that the ramps reach without it. [m]"""
    side = 1.0 if generator.random() < 0.7 else -1.0
    current = HIGH_CURRENT if side > 0 else LOW_CURRENT
    gap = np.array(base["gap_offset"] - base["gap_gain"] * np.sqrt(current))
    force = base["diaphragm_area"] * float(static_pressure(gap, base)) - base["spring_preload"]
    travel = (force - side * base["coulomb_friction"]) / base["spring_rate"]
    return {"side": side, "reference_travel": travel, "stop_stiffness": 5e6}


def _wander(generator: np.random.Generator, base: Mapping[str, float]) -> Numbers:
    return {"wander_seed": float(generator.integers(1 << 30))}


LOOP_REACH = {"loop_reach": (1.0e-3, 2.2e-3)}
LOOP_BOUNDS = (2e-5, 7e-4)
CREEP_TIME = {"time_constant": (20.0, 90.0)}
SLOW_START = {"time_constant": (5.0, 25.0)}


def _creeps(magnitude: str, lowest: float, highest: float) -> tuple[Formulation, ...]:
    """Linear, exponential and logarithmic creep of either sign."""
    bounds = (magnitude, lowest, highest)
    return (
        Formulation("linear", _signed(_nothing), *bounds),
        Formulation("exponential", _signed(_between(**CREEP_TIME)), *bounds),
        Formulation("logarithmic", _signed(_between(**SLOW_START)), *bounds),
    )


ELECTROMAGNET = {
    "magnetic_hysteresis": (
        Formulation(
            "bouc_wen",
            _between(**LOOP_REACH, loop_shape=(1.0, 2.0)),
            "loop_half_width",
            *LOOP_BOUNDS,
        ),
        Formulation("coleman_hodgdon", _between(**LOOP_REACH), "loop_half_width", *LOOP_BOUNDS),
        Formulation("plays", _nothing, "loop_half_width", *LOOP_BOUNDS),
    ),
    "magnetic_saturation": (
        Formulation("froehlich", _between(knee_current=(10e-3, 15e-3)), "knee_curvature", 3.0, 400.0),
        Formulation("tanh", _between(knee_current=(8e-3, 13e-3)), "knee_curvature", 15.0, 150.0),
    ),
    "coil_lag": (
        Formulation("inductance", _nothing, "time_constant", 0.03, 1.0),
        Formulation("inductance_and_eddy_currents", _between(eddy_share=(0.05, 0.2)), "time_constant", 0.03, 1.0),
    ),
    "gap_drift": _creeps("gap_change", 0.1e-6, 6e-6),
}

NOZZLE = {
    "chamber_filling": (
        Formulation("constant_volume", _nothing, "fill_time", 0.05, 1.5),
        Formulation("growing_volume", _between(volume_growth=(0.5, 2.5)), "fill_time", 0.05, 1.0),
        Formulation("isothermal", _nothing, "fill_time", 0.05, 1.5),
    ),
    "asymmetric_filling": (
        Formulation(
            "orifice_vent",
            _signed(_between(quick_share=(0.08, 0.3)), "slow_direction", 0.3),
            "slow_time",
            0.08,
            3.0,
        ),
        Formulation(
            "two_time_constants",
            _signed(_between(quick_share=(0.05, 0.3)), "slow_direction", 0.3),
            "slow_time",
            0.08,
            3.0,
        ),
        Formulation(
            "rate_limit",
            _signed(_between(quick_share=(0.002, 0.01)), "slow_direction", 0.3),
            "slow_time",
            0.5,
            15.0,
        ),
    ),
    "supply_droop": (
        Formulation("steady_consumption", _between(refill_time=(3.0, 20.0)), "demand_gain", 0.01, 0.35),
        Formulation("emptied_by_filling", _between(refill_time=(3.0, 20.0)), "demand_gain", 0.01, 0.5),
    ),
    "air_leak": (
        Formulation("incompressible", _nothing, "leak_area_ratio", 0.1, 0.7),
        Formulation("choked", _nothing, "leak_area_ratio", 0.05, 0.5),
        Formulation("porous", _nothing, "leak_area_ratio", 0.1, 0.7),
    ),
    "choked_flow": (
        Formulation("saint_venant", _nothing),
        Formulation("iso_6358", _between(critical_ratio=(0.35, 0.5))),
    ),
    "transport_delay": (
        Formulation("pure", _nothing, "delay", 0.03, 1.0),
        Formulation("dispersive_line", _between(dispersion=(0.03, 0.1)), "delay", 0.03, 1.0),
    ),
}

STATIC_BOUNDS = ("static_excess", 0.1, 1.2)
LUGRE_BRISTLES = {"bristle_stiffness": (5e7, 1e8), "bristle_damping": (1e4, 3e4)}
BONDS = {"bond_distance": (1e-5, 4e-5), "bond_time": (0.1, 0.3)}
STRIBECK_SPEED = {"stribeck_speed": (0.005, 0.06)}

STEM = {
    "static_friction": (
        Formulation("karnopp", _between(decay_speed=(2e-4, 1e-3)), *STATIC_BOUNDS),
        Formulation("rate_and_state", _between(**BONDS), *STATIC_BOUNDS),
        Formulation("lugre", _between(**BONDS, **LUGRE_BRISTLES), *STATIC_BOUNDS),
    ),
    "stribeck": (
        Formulation("exponential", _between(**STRIBECK_SPEED), *STATIC_BOUNDS),
        Formulation("gaussian", _between(**STRIBECK_SPEED), *STATIC_BOUNDS),
        Formulation("lorentzian", _between(**STRIBECK_SPEED), *STATIC_BOUNDS),
    ),
    "asymmetric_friction": (
        Formulation("balanced", _signed(_nothing), "excess", 0.1, 0.7),
        Formulation("one_sided", _signed(_nothing), "excess", 0.1, 1.2),
    ),
    "asymmetric_viscous_friction": (
        Formulation("one_sided", _signed(_nothing), "excess", 1.0, 60.0),
        Formulation("both_sides", _signed(_nothing), "excess", 1.0, 60.0),
    ),
    "position_dependent_friction": (
        Formulation("gaussian", _between(centre=(0.07, 0.19), width=(0.006, 0.02)), "height", 0.15, 4.0),
        Formulation("raised_cosine", _between(centre=(0.07, 0.19), width=(0.015, 0.045)), "height", 0.15, 4.0),
    ),
    "pressure_dependent_friction": (
        Formulation("linear", _with_supply, "growth", 0.1, 3.0),
        Formulation("quadratic", _with_supply, "growth", 0.1, 4.0),
    ),
    "presliding": (
        Formulation("lugre", _between(bristle_damping=(200.0, 800.0)), "compliance", 2e-7, 8e-6),
        Formulation("dahl", _between(exponent=(0.8, 1.5)), "compliance", 2e-7, 8e-6),
        Formulation("iwan", _nothing, "compliance", 2e-7, 8e-6),
    ),
    "spring_hardening": (
        Formulation("cubic", _nothing, "stiffening", 0.02, 0.8),
        Formulation("quadratic", _nothing, "stiffening", 0.02, 0.8),
    ),
    "area_variation": (
        Formulation("linear", _signed(_nothing, up_share=0.2), "change", 0.02, 0.35),
        Formulation("quadratic", _signed(_nothing, up_share=0.2), "change", 0.02, 0.35),
    ),
    "end_stop": (
        Formulation("rigid", _stop_side, "depth", 2e-3, 60e-3),
        Formulation("elastic", _stop_side, "depth", 2e-3, 60e-3),
    ),
    "load_force": (
        Formulation("sine", _between(load_period=(5.0, 60.0), phase=(0.0, 6.28)), "amplitude", 20.0, 900.0),
        Formulation("wander", _wander, "amplitude", 20.0, 900.0),
    ),
    "friction_drift": (
        Formulation("linear", _nothing, "growth", 0.1, 3.0),
        Formulation("exponential", _between(**CREEP_TIME), "growth", 0.1, 3.0),
    ),
}

SENSOR = {
    "linkage_backlash": (
        Formulation("play", _between(start=(-0.9, 0.9)), "play", 4e-4, 20e-3),
        Formulation("worn_play", _between(start=(-0.6, 0.6)), "play", 4e-4, 20e-3),
    ),
    "quantisation": (
        Formulation("converter", _between(phase=(0.0, 1.0)), "reading_step", 5e-4, 6e-3),
        Formulation("encoder", _between(phase=(0.0, 1.0)), "reading_step", 5e-4, 6e-3),
    ),
    "sensor_drift": _creeps("zero_change", 3e-4, 15e-3),
    "sensor_lag": (
        Formulation("first_order", _nothing, "time_constant", 0.03, 1.0),
        Formulation("second_order", _nothing, "time_constant", 0.03, 1.0),
    ),
    "linkage_nonlinearity": (
        Formulation("tangent", _between(arm_centre=(0.3, 0.7)), "arm_angle", 0.15, 1.0),
        Formulation("sine", _between(arm_centre=(0.3, 0.7)), "arm_angle", 0.15, 0.9),
        Formulation("bow", _signed(_nothing), "bow", 0.01, 0.25),
    ),
}

STAGES = {"electromagnet": ELECTROMAGNET, "nozzle": NOZZLE, "stem": STEM, "sensor": SENSOR}

EFFECTS: dict[str, Effect] = {
    key: Effect(stage, formulations) for stage, laws in STAGES.items() for key, formulations in laws.items()
}
