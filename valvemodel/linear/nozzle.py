"""The nozzle linearised: effective current to actuator pressure."""

from __future__ import annotations

import math
from collections.abc import Mapping

import control as ct

from valvemodel.equations import numeric
from valvemodel.linear.block import Treatment, block, gain, lag
from valvemodel.linear.point import OperatingPoint, evaluate
from valvemodel.stages.amplifier import LEAST_ROOT
from valvemodel.stages.nozzle import ATMOSPHERE, CRITICAL, compressible_pressure, stiffness_of_gas

TREATMENTS = {
    "chamber_filling": Treatment(True, "a first-order lag whose rate is the slope of eq. (15) at rest"),
    "asymmetric_filling": Treatment(
        True,
        "the lag of its direction, filling when stuck, by the slope of its flow; the rate limit is not reached",
    ),
    "supply_droop": Treatment(True, "a lead-lag of its direction: a rise draws the supply down, a fall does not"),
    "air_leak": Treatment(True, "its slope at the pressure"),
    "choked_flow": Treatment(True, "the slope of the balance of flows"),
    "transport_delay": Treatment(
        True, "Pade's approximation of the stated order, at the inlet; the lag behind it with that of the amplifier"
    ),
}


def blocks(numbers: Mapping[str, float], point: OperatingPoint) -> list[ct.StateSpace]:
    """Return the blocks from `effective_current` to `pressure`."""
    chamber = 0.0
    if numbers["chamber_filling_time"] > 0.0:
        chamber = time_to_settle(numbers, point)
    amplifier = numbers["vent_time" if point.side < 0.0 else "fill_time"]
    amplifier += numbers["line_dispersion"] * numbers["transport_delay"]
    amplifier /= quickness_at_rest(numbers, point.supplied_pressure)
    return [
        gain("nozzle", pressure_by_current(numbers, point), "effective_current", "resting_pressure"),
        supply(numbers, point),
        lag("chamber", chamber, "pressure", "supplied_pressure", "chamber_pressure"),
        lag("amplifier", amplifier, "pressure", "chamber_pressure", "filled_pressure"),
        gain("leak", leak_slope(numbers, point), "filled_pressure", "pressure"),
    ]


def time_to_settle(numbers: Mapping[str, float], point: OperatingPoint) -> float:
    """Return the time constant at which the chamber fills. [s]"""
    pressure = point.supplied_pressure
    turbulent = evaluate(numeric.chamber_rate, numbers, pressure=pressure, gap=point.gap)
    growth = 1.0 + numbers["filling_growth"] * pressure / numbers["supply_pressure"]
    laminar = 1.0 / (numbers["chamber_filling_time"] * growth)
    stiffness = stiffness_of_gas(pressure, numbers["filling_of_gas"])
    return 1.0 / (stiffness * (turbulent + numbers["laminar_filling"] * (laminar - turbulent)))


def quickness_at_rest(numbers: Mapping[str, float], pressure: float) -> float:
    """Return the rate of orifices over that of first order, the slope of eq. (15) over the pressure."""
    share = pressure / numbers["supply_pressure"]
    root = max(2.0 * share * math.sqrt(1.0 - share), LEAST_ROOT)
    stiffness = stiffness_of_gas(pressure, numbers["orifices_of_gas"])
    return 1.0 + numbers["orifice_share"] * (stiffness / root - 1.0)


def pressure_by_current(numbers: Mapping[str, float], point: OperatingPoint) -> float:
    """Return the slope of the pressure under the full supply. [Pa/A]"""
    if numbers["pressure_per_current"] > 0.0:
        return numbers["pressure_per_current"]
    by_gap = evaluate(numeric.pressure_by_gap, numbers, gap=point.gap)
    if (share := numbers["compressible_share"]) > 0.0:
        by_gap += share * (compressible_by_gap(numbers, point.gap) - by_gap)
    return by_gap * evaluate(numeric.gap_by_current, numbers, current=point.effective_current)


def compressible_by_gap(numbers: Mapping[str, float], gap: float) -> float:
    """Return the slope of the pressure at which choking flows agree, by the implicit function's theorem. [Pa/m]"""
    supply, ratio, critical = (numbers[name] for name in ("supply_pressure", "flow_ratio", "critical_pressure_ratio"))
    before = supply + ATMOSPHERE
    behind = compressible_pressure(gap, supply, ratio, critical) + ATMOSPHERE
    opening = math.sqrt(ratio) * abs(gap)
    out = passed_share(ATMOSPHERE / behind, critical)
    by_gap = -math.copysign(math.sqrt(ratio), gap) * behind * out
    return -by_gap / balance_by_pressure(before, behind, opening, critical)


def balance_by_pressure(before: float, between: float, opening: float, critical: float) -> float:
    """Return the slope in the pressure between them of the balance of a hole's flow and one so many times as open."""
    out = passed_share(ATMOSPHERE / between, critical)
    by_pressure = share_slope(between / before, critical)
    return by_pressure - opening * (out - share_slope(ATMOSPHERE / between, critical) * ATMOSPHERE / between)


def passed_share(ratio: float, critical: float) -> float:
    """Return a hole's flow over its choked flow. [1]"""
    return 1.0 if ratio <= critical else float(numeric.subsonic_share(min(ratio, 1.0), critical))


def share_slope(ratio: float, critical: float) -> float:
    """Return the slope of a hole's flow in the ratio of the pressures; 0 where it is choked or at rest."""
    if not critical < ratio < 1.0:
        return 0.0
    return float(numeric.subsonic_share_by_ratio(ratio, critical))


def supply(numbers: Mapping[str, float], point: OperatingPoint) -> ct.StateSpace:
    """Return how the supplied pressure follows the resting one: at once, less a sag that comes and recovers."""
    source, target = "resting_pressure", "supplied_pressure"
    growth, consumption = numbers["droop_gain"], numbers["droop_consumption"]
    if growth == 0.0 and consumption == 0.0:
        return gain("supply", 1.0, source, target)
    full = numbers["supply_pressure"]
    share = point.resting_pressure / full
    available = point.supplied_pressure / share
    settled = evaluate(numeric.settled_droop_by_share, numbers, pressure_share=share)
    if point.side < 0.0:
        growth = 0.0
    drawn = growth * available / (1.0 + growth * share)
    rate = 1.0 / (numbers["droop_recovery_time"] * (1.0 + growth * share))
    # The state is the sag less what a rise draws at once; inputs are pressures, the laws are in shares.
    return block(
        "supply", [[-rate]], [[rate * (settled - drawn) / full]], [[-share]], [[(available - share * drawn) / full]],
        ["sag"], source, target,
    )  # fmt: skip


def leak_slope(numbers: Mapping[str, float], point: OperatingPoint) -> float:
    """Return the slope of the actuator pressure behind the leak."""
    if numbers["leak_ratio"] == numbers["turbulent_leak_ratio"] == 0.0 or point.pressure <= 0.0:
        return 1.0
    if numbers["leak_chokes"] == 0.0:
        return evaluate(numeric.leaked_pressure_by_pressure, numbers, actuator_pressure=point.pressure)
    porous = {**numbers, "turbulent_leak_ratio": 0.0}
    slope = evaluate(numeric.leaked_pressure_by_pressure, porous, actuator_pressure=point.pressure)
    return slope * choking_leak_slope(point.supplied_pressure, numbers["turbulent_leak_ratio"])


def choking_leak_slope(supplied: float, turbulent: float) -> float:
    """Return the slope of the pressure behind a choking leak in the one before, by the implicit function's theorem."""
    if turbulent == 0.0:
        return 1.0
    before, between = supplied + ATMOSPHERE, compressible_pressure(1.0, supplied, turbulent, CRITICAL) + ATMOSPHERE
    ratio = between / before
    by_supply = passed_share(ratio, CRITICAL) - ratio * share_slope(ratio, CRITICAL)
    return -by_supply / balance_by_pressure(before, between, math.sqrt(turbulent), CRITICAL)
