"""Operating point: where the valve rests under a current, or on which branch it slips."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from valvemodel.equations import numeric
from valvemodel.errors import InputError, unknown_name
from valvemodel.model import Model
from valvemodel.parameters import PARAMETERS
from valvemodel.stages import electromagnet, nozzle, sensor, stem

SIDES = {"rising": 1.0, "falling": -1.0, "stuck": 0.0}
"""The direction of the stem in each mode."""


@dataclass(frozen=True)
class OperatingPoint:
    """The valve at the start, before anything has drifted.

    Attributes
    ----------
    mode : str
        rising or falling: on that branch; stuck: in the middle of the stuck band.
    current, effective_current : float
        At the coil, and what the flux stands for. [A]
    gap : float
        Between nozzle and flapper. [m]
    resting_pressure, supplied_pressure, pressure : float
        Under the full supply, under the one that has sagged, and at the actuator. [Pa]
    position, reading : float
        Of the stem, and what the sensor says. [m]
    speed : float
        Of the stem along its motion. [m/s]
    friction : float
        Of that side and at that speed, the viscous one aside. [N]
    """

    mode: str
    current: float
    effective_current: float
    gap: float
    resting_pressure: float
    supplied_pressure: float
    pressure: float
    position: float
    reading: float
    speed: float
    friction: float

    @property
    def side(self) -> float:
        """1 rising, -1 falling, 0 stuck."""
        return SIDES[self.mode]


def numbers_of(model: Model) -> dict[str, float]:
    """Return every number of the chain by name, those of absent effects at their neutral value. [SI]"""
    row = model.rows()[0]
    return {name: float(row[name]) for name in PARAMETERS.names or ()}


def evaluate(function: Callable[..., float], numbers: Mapping[str, float], **given: float) -> float:
    """Call a generated function with its arguments by name: those given, the rest from the valve's numbers."""
    names = inspect.signature(function).parameters
    return float(function(**{name: given.get(name, numbers.get(name, math.nan)) for name in names}))


def falling_friction(numbers: Mapping[str, float]) -> dict[str, float]:
    """Return the numbers of `stribeck` by which friction falls in slip; elastic friction falls from F_s too."""
    fall = {name: numbers[f"stribeck_{name}"] for name in ("ratio", "velocity", "shape", "tail")}
    if numbers["presliding_compliance"] > 0.0:
        if not fall["ratio"] > 1.0:
            fall |= {"velocity": stem.STATIC_DECAY, "shape": 1.0, "tail": 0.0}
        fall["ratio"] = max(fall["ratio"], numbers["static_friction_ratio"])
    return {f"stribeck_{name}": value for name, value in fall.items()}


def operating_point(model: Model, *, current: float, mode: str = "rising", speed: float = 0.0) -> OperatingPoint:
    """Return where the valve is under a current.

    Parameters
    ----------
    model : Model
    current : float
        Held. [A]
    mode : str
        rising, falling or stuck.
    speed : float
        At which the stem passes the point in slip; friction falls with it where it does. [m/s]

    Raises
    ------
    InputError
        If the mode is unknown, the current or speed impossible, or the stem is held by the end of its travel.
    """
    if mode not in SIDES:
        raise unknown_name("a mode", mode, SIDES)
    if not (math.isfinite(current) and current > 0.0):
        raise InputError("an operating point has a current above 0 A", f"got {current} A", "give it like 12 mA")
    if not (math.isfinite(speed) and speed >= 0.0):
        raise InputError("a speed along the motion is not negative", f"got {speed} m/s", "leave out its sign")
    row, side = model.rows()[0], SIDES[mode]
    branch = model.numbers.get("hysteresis_half_width", 0.0) * side
    effective = electromagnet.saturate(row, current) - branch
    gap = electromagnet.gap_of_current(row, effective, 0.0)
    resting = nozzle.resting_pressure_of_chain(row, gap, effective)
    supply = float(row["supply_pressure"])
    droop = nozzle.drawn_to_settle(row, resting / supply)
    supplied = resting * (1.0 - droop / supply)
    pressure = nozzle.behind_leak(row, supplied)
    numbers = numbers_of(model)
    speed = 0.0 if mode == "stuck" else speed
    fall = evaluate(numeric.stribeck_factor, falling_friction(numbers), speed=speed)
    viscous = speed * numbers["viscous_friction"] * (1.0 + numbers["viscous_asymmetry"] * side)

    def friction(position: float) -> float:
        return fall * float(stem.sliding_friction(row, side, position, pressure, 0.0))

    def net(position: float) -> float:
        return float(stem.thrust(row, position, pressure, 0.0)) - side * (friction(position) + viscous)

    position = _balance(net, numbers, stem.free_travel(row))
    reading = sensor.bow(row, position - side * numbers["backlash_half_width"])
    return OperatingPoint(
        mode, current, effective, gap, resting, supplied, pressure, position, reading, speed, friction(position)
    )


def _balance(net: Callable[[float], float], numbers: Mapping[str, float], travel: tuple[float, float]) -> float:
    """Return where the net force is 0. [m]"""
    from scipy.optimize import brentq

    if not numbers["spring_rate"] > 0.0:
        raise InputError("an operating point needs a spring", "spring_rate is 0", "give the valve its spring_rate")
    low, high = travel
    if net(low) <= 0.0 or net(high) >= 0.0:
        end, place = ("lower", low) if net(low) <= 0.0 else ("upper", high)
        raise InputError(
            "an operating point lies within the travel",
            f"under this current the stem rests at the {end} end, {place:.4g} m",
            "choose another current",
        )
    return float(brentq(net, low, high, xtol=1e-15, rtol=1e-15))
