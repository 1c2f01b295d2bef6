"""Whether a valve's numbers can be true: checks by physics, which know no valve's name."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from valvemodel.base_valve import BASE_PARAMETERS
from valvemodel.quantities import format_quantity, scale_of
from valvemodel.valves.figures import CURRENTS, Figures, figures
from valvemodel.valves.valve import Valve

_RINGS_BELOW = 0.05  # damping ratio: a slip then overshoots by 85 % and more
_SETTLES_WITHIN = 5.0  # [s]
_PRESSURE_RANGE = (20e3, 300e3)  # [Pa]: 0.2..1 bar and 3..15 psi signals, with room on both sides
_GAP_AT_MOST = 1e-3  # [m]: flapper gaps are tenths of a millimetre
_SUPPLY_AT_MOST = 0.7e6  # [Pa]: the converter's limit in the paper's Table 1
_DEAD_BAND_AT_MOST = 0.5  # of the pressure span
_TRAVEL_SHARE = (0.2, 1.5)  # of the rated travel
_SUPPORT = 2  # other round imperial numbers that it takes to suspect a mass of pounds
_ODD_DIGITS = 3
_POUNDS = {
    "stem_mass": "lb",
    "spring_rate": "lbf/in",
    "diaphragm_area": "in^2",
    "coulomb_friction": "lbf",
    "spring_preload": "lbf",
}


@dataclass(frozen=True)
class Doubt:
    """A warning about a valve: which check found it, and a sentence for the user."""

    check: str
    text: str


def plausibility(valve: Valve) -> list[Doubt]:
    """Return what is doubtful about a valve's numbers, nothing for a plausible one.

    Examples
    --------
    >>> from valvemodel.valves import read_valve
    >>> plausibility(read_valve("calibrated"))
    []
    """
    found = figures(valve)
    return [Doubt(name, text) for name, check in _CHECKS.items() for text in check(valve, found)]


def _damping_ratio(valve: Valve, found: Figures) -> Iterator[str]:
    if found.damping_ratio < _RINGS_BELOW:
        yield (
            f"damping ratio {found.damping_ratio:.2g}: a slipping stem rings at {1 / found.period:.3g} Hz;"
            " is viscous_friction too small?"
        )


def _time_constant(valve: Valve, found: Figures) -> Iterator[str]:
    if found.settling > _SETTLES_WITHIN:
        yield f"a slip takes a time constant of {found.settling:.3g} s to end; valves take below a second"
    elif found.damping_ratio < _RINGS_BELOW and found.settling > 1:
        yield f"the ringing dies out with a time constant of {found.settling:.3g} s"


def _pressure_range(valve: Valve, found: Figures) -> Iterator[str]:
    low, high = float(found.pressure.min()), float(found.pressure.max())
    span = f"4..20 mA gives {format_quantity(low, 'Pa')} to {format_quantity(high, 'Pa')}"
    supply = valve.values["supply_pressure"]
    usual = f"{_PRESSURE_RANGE[0] / 1e3:.0f}..{_PRESSURE_RANGE[1] / 1e3:.0f} kPa"
    if high < _PRESSURE_RANGE[0]:
        yield f"{span}: the pressure never rises; usual is within {usual}"
    elif low < _PRESSURE_RANGE[0] or high > _PRESSURE_RANGE[1]:
        yield f"{span}, outside the usual {usual}"
    if high > supply:
        yield f"{span}, above the supply of {format_quantity(supply, 'Pa')}"
    if np.any(np.diff(found.pressure) < 0):
        current = CURRENTS[int(np.argmax(found.pressure))]
        yield f"the pressure falls again above {format_quantity(float(current), 'A')}"


def _gap_range(valve: Valve, found: Figures) -> Iterator[str]:
    if found.gap is None:
        return
    low, high = float(found.gap.min()), float(found.gap.max())
    span = f"4..20 mA gives gaps of {format_quantity(high, 'm')} to {format_quantity(low, 'm')}"
    if low < 0:
        current = CURRENTS[int(np.argmax(found.gap < 0))]
        yield f"{span}: from {format_quantity(float(current), 'A')} on the flapper would be inside the nozzle"
    largest = _maximum_gap(valve)
    if high > largest * (1 + 1e-9):
        yield f"{span}, beyond the maximum gap of {format_quantity(largest, 'm')}"
    elif high > _GAP_AT_MOST:
        yield f"{span}; usual gaps are below {format_quantity(_GAP_AT_MOST, 'm')}"


def _maximum_gap(valve: Valve) -> float:
    entry = valve.entries.get("maximum_gap")
    if entry is None:
        return math.inf
    multiplier, divisor = scale_of(entry.unit, "m")
    return entry.value * multiplier / divisor


def _pounds_as_mass(valve: Valve, found: Figures) -> Iterator[str]:
    """Suspect pounds of force read as pounds of mass, where nothing else explains a stem without damping."""
    friction = valve.values["viscous_friction"]
    pounds = _round_number(valve, "viscous_friction", "lb/s", "kg/s")
    if found.damping_ratio >= _RINGS_BELOW or pounds is None:
        return
    multiplier, _ = scale_of("lbf*s/in", "N*s/m")
    meant = pounds * multiplier
    ratio = found.damping_ratio * meant / friction
    others = [
        f"{name} is {number:g} {unit}"
        for name, unit in _POUNDS.items()
        if (number := _round_number(valve, name, unit, _UNIT[name])) is not None
    ]
    if ratio >= _RINGS_BELOW and len(others) >= _SUPPORT:
        yield (
            f"viscous_friction {friction:g} kg/s is {pounds:g} lb/s in mass: probably {pounds:g} lbf*s/in,"
            f" which is {meant:.4g} N*s/m and gives a damping ratio of {ratio:.3g}"
            f" (an inference: {', '.join(others)})"
        )


def _round_number(valve: Valve, name: str, unit: str, si_unit: str) -> float | None:
    """Return a parameter in an imperial unit if that is a number of two digits within the digits given."""
    value = valve.values[name]
    entry = valve.entries.get(name)
    if value <= 0 or (entry is not None and not entry.is_given):
        return None
    multiplier, divisor = scale_of(unit, si_unit)
    number = value / multiplier * divisor
    nearest = float(f"{number:.1e}")
    digits = f"{entry.value if entry else value:.12e}".partition("e")[0].rstrip("0").replace(".", "")
    # half a unit of the last digit given; with fewer digits the number is round as it stands
    is_odd = len(digits) >= _ODD_DIGITS
    return nearest if is_odd and abs(number / nearest - 1) <= 0.5 / float(digits) else None


def _travel(valve: Valve, found: Figures) -> Iterator[str]:
    low, high = found.travel
    rated = valve.values["rated_travel"]
    low_share, high_share = _TRAVEL_SHARE
    if math.isfinite(high - low) and not low_share * rated <= high - low <= high_share * rated:
        yield (
            f"4..20 mA moves the stem by {format_quantity(high - low, 'm')},"
            f" {(high - low) / rated:.2g} of the rated travel of {format_quantity(rated, 'm')}"
        )


def _dead_band(valve: Valve, found: Figures) -> Iterator[str]:
    if found.dead_band >= 1:
        times = f"{found.dead_band:.2g} times the pressure span"
        yield f"Coulomb friction holds the stem: turning it takes {times}"
    elif found.dead_band > _DEAD_BAND_AT_MOST:
        yield f"the dead band of the friction is {found.dead_band:.0%} of the pressure span"


def _supply_pressure(valve: Valve, found: Figures) -> Iterator[str]:
    supply = valve.values["supply_pressure"]
    if supply > _SUPPLY_AT_MOST:
        yield f"supply of {format_quantity(supply, 'Pa')} is above {format_quantity(_SUPPLY_AT_MOST, 'Pa')}"


def _parameter_range(valve: Valve, found: Figures) -> Iterator[str]:
    for parameter in BASE_PARAMETERS:
        value = valve.values[parameter.name]
        if value != parameter.neutral and not parameter.low <= value <= parameter.high:
            shown, low, high = (
                format_quantity(number, parameter.unit) for number in (value, parameter.low, parameter.high)
            )
            yield f"{parameter.name} is {shown}, outside {low}..{high}"


_UNIT = {parameter.name: parameter.unit for parameter in BASE_PARAMETERS}

_CHECKS: dict[str, Callable[[Valve, Figures], Iterator[str]]] = {
    "damping_ratio": _damping_ratio,
    "time_constant": _time_constant,
    "pressure_range": _pressure_range,
    "gap_range": _gap_range,
    "pounds_as_mass": _pounds_as_mass,
    "travel": _travel,
    "dead_band": _dead_band,
    "supply_pressure": _supply_pressure,
    "parameter_range": _parameter_range,
}
