"""From the gap to the gauge pressure in the actuator's chamber."""

from collections.abc import Mapping

import numpy as np
from numba import njit

from diagnosis.blindtest.chain.clock import Clock, Signal
from diagnosis.blindtest.chain.electromagnet import lagged
from diagnosis.blindtest.truth import Truth, by_effect

ATMOSPHERE = 101325.0  # Pa
HEAT_RATIO = 1.4
TABLE_SIZE = 4001  # points of a tabulated static law; linear between them errs by less than 1 Pa
BISECTIONS = 60


def static_pressure(gap: Signal, base: Mapping[str, float]) -> Signal:
    """Pressure at rest of an incompressible orifice and nozzle in series. [Pa]"""
    return base["supply_pressure"] / (1.0 + base["flow_ratio"] * gap * gap)


def _saint_venant(ratio: Signal) -> Signal:
    """Mass flow over its greatest, of the pressure ratio down to up; choked below 0.528."""
    critical = (2.0 / (HEAT_RATIO + 1.0)) ** (HEAT_RATIO / (HEAT_RATIO - 1.0))

    def flow(x: Signal) -> Signal:
        return np.sqrt(np.maximum(x ** (2 / HEAT_RATIO) - x ** ((HEAT_RATIO + 1) / HEAT_RATIO), 0.0))

    return flow(np.maximum(ratio, critical)) / flow(np.array(critical))


def _iso_6358(ratio: Signal, critical: float) -> Signal:
    """ISO 6358: a quarter ellipse above the critical pressure ratio, choked below."""
    inside = np.maximum(ratio - critical, 0.0) / (1.0 - critical)
    return np.sqrt(np.maximum(1.0 - inside * inside, 0.0))


def relative_flow(ratio: Signal, truth: Truth) -> Signal:
    """Mass flow over its greatest by the law that the truth names."""
    match truth.formulation:
        case "saint_venant":
            return _saint_venant(ratio)
        case "iso_6358":
            return _iso_6358(ratio, truth.parameters["critical_ratio"])
    raise ValueError(f"choked_flow has no formulation {truth.formulation!r}")


def choked_pressure(gap: Signal, base: Mapping[str, float], truth: Truth) -> Signal:
    """Pressure at rest between two compressible restrictions, by bisection. [Pa]

    The nozzle's area over the orifice's is sqrt(flow_ratio) times the gap, as in the base law.
    """
    supply = base["supply_pressure"]
    area_ratio = np.sqrt(base["flow_ratio"]) * gap
    low, high = np.zeros_like(gap), np.full_like(gap, supply)
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        absolute = middle + ATMOSPHERE
        supplied = (supply + ATMOSPHERE) * relative_flow(absolute / (supply + ATMOSPHERE), truth)
        vented = area_ratio * absolute * relative_flow(ATMOSPHERE / absolute, truth)
        low = np.where(supplied > vented, middle, low)
        high = np.where(supplied > vented, high, middle)
    return 0.5 * (low + high)


def leaking_pressure(source: Signal, truth: Truth) -> Signal:
    """Pressure behind a restriction and before a leak, by bisection. [Pa]

    `leak_area_ratio` is the leak's area over the restriction's.
    """
    ratio = truth.parameters["leak_area_ratio"]
    low, high = np.zeros_like(source), source.copy()
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        supplied, leaked = _leak_flows(source, middle, truth)
        low = np.where(supplied > ratio * leaked, middle, low)
        high = np.where(supplied > ratio * leaked, high, middle)
    return 0.5 * (low + high)


def _leak_flows(source: Signal, chamber: Signal, truth: Truth) -> tuple[Signal, Signal]:
    """Flow in through the restriction and out of a leak of the same area, in a common unit."""
    match truth.formulation:
        case "incompressible":
            return np.sqrt(np.maximum(source - chamber, 0.0)), np.sqrt(chamber)
        case "choked":
            inside, outside = chamber + ATMOSPHERE, source + ATMOSPHERE
            supplied = outside * _iso_6358(inside / outside, 0.35)
            return supplied, inside * _iso_6358(ATMOSPHERE / inside, 0.35)
        case "porous":
            return np.sqrt(np.maximum(source - chamber, 0.0)), chamber / np.sqrt(1e5)
    raise ValueError(f"air_leak has no formulation {truth.formulation!r}")


@njit(cache=True)
def _supply(level, substeps, step, set_pressure, refill_time, demand_gain):
    """Pressure of a receiver that a regulator refills and the orifice empties.

    `level` is P/P1 at rest; demand follows sqrt(1 - level), and is paid back with `refill_time`.
    """
    out = np.empty((level.shape[0], substeps))
    wide = level.shape[1] > 1
    first = np.sqrt(max(1.0 - level[0, 0], 0.0))
    state = set_pressure * (1.0 - demand_gain * first)
    for k in range(level.shape[0]):
        for j in range(substeps):
            out[k, j] = state
            share = level[k, j] if wide else level[k, 0]
            target = set_pressure * (1.0 - demand_gain * np.sqrt(max(1.0 - share, 0.0)))
            state += step * (target - state) / refill_time
    return out


@njit(cache=True)
def _burst_supply(level, substeps, step, set_pressure, refill_time, demand_gain):
    """Pressure of a receiver that only a filling actuator empties; it recovers slowly."""
    out = np.empty((level.shape[0], substeps))
    wide = level.shape[1] > 1
    state, before = set_pressure, level[0, 0]
    for k in range(level.shape[0]):
        for j in range(substeps):
            share = level[k, j] if wide else level[k, 0]
            state -= set_pressure * demand_gain * max(share - before, 0.0)
            before = share
            out[k, j] = state
            state += step * (set_pressure - state) / refill_time
    return out


@njit(cache=True)
def _chamber(target, supply, substeps, step, fill, vent, growth, compressible):
    """Pressure of a chamber between orifice and nozzle, by a linearly implicit midpoint rule.

    In units of the supply pressure: dp/dt = rate (sqrt(1-p) - g sqrt(p)), where g = sqrt((1-q)/q)
    belongs to the pressure q at rest. `fill` and `vent` are the rates while p rises and falls. [1/s]
    """
    out = np.empty((target.shape[0], substeps))
    wide, wide_supply = target.shape[1] > 1, supply.shape[1] > 1
    state = target[0, 0] / supply[0, 0]
    for k in range(target.shape[0]):
        for j in range(substeps):
            source = supply[k, j] if wide_supply else supply[k, 0]
            out[k, j] = state * source
            rest = (target[k, j] if wide else target[k, 0]) / source
            nozzle = np.sqrt(max(1.0 - rest, 0.0) / max(rest, 1e-9))
            state += _filling(state, nozzle, fill, vent, growth, compressible, step)
    return out


@njit(cache=True)
def _filling(state, nozzle, fill, vent, growth, compressible, step):
    """Change of the chamber's relative pressure in a step."""
    orifice_root, nozzle_root = np.sqrt(max(1.0 - state, 1e-6)), np.sqrt(max(state, 1e-6))
    balance = orifice_root - nozzle * nozzle_root
    rate = fill if balance > 0.0 else vent
    rate *= (1.0 + compressible * (state - 0.5)) / (1.0 + growth * state)
    slope = 0.5 * rate * (1.0 / orifice_root + nozzle / nozzle_root)
    return step * rate * balance / (1.0 + 0.5 * step * slope)


@njit(cache=True)
def _two_rates(target, substeps, step, fill_time, vent_time, fill_limit, vent_limit):
    """First-order approach with a time constant [s] and a rate limit [Pa/s] for either direction."""
    out = np.empty((target.shape[0], substeps))
    wide = target.shape[1] > 1
    state = target[0, 0]
    fill_share = 1.0 - np.exp(-step / fill_time)
    vent_share = 1.0 - np.exp(-step / vent_time)
    for k in range(target.shape[0]):
        for j in range(substeps):
            out[k, j] = state
            change = (target[k, j] if wide else target[k, 0]) - state
            change *= fill_share if change > 0.0 else vent_share
            state += min(max(change, -vent_limit * step), fill_limit * step)
    return out


@njit(cache=True)
def _shifted(signal, substeps, late):
    """The signal `late` fine steps later; before that its first value."""
    out = np.empty((signal.shape[0], substeps))
    wide = signal.shape[1] > 1
    for k in range(signal.shape[0]):
        for j in range(substeps):
            index = max(k * substeps + j - late, 0)
            row, column = index // substeps, index % substeps
            out[k, j] = signal[row, column if wide else 0]
    return out


def _static(gap: Signal, base: Mapping[str, float], truth: Truth | None) -> Signal:
    """Pressure at rest, choked or not; a choked law is tabulated where the gap varies in a period."""
    if truth is None:
        return static_pressure(gap, base)
    if gap.shape[1] == 1:
        return choked_pressure(gap, base, truth)
    table = np.linspace(gap.min(), gap.max() + 1e-12, TABLE_SIZE)
    return np.interp(gap, table, choked_pressure(table, base, truth))


def _droop(pressure: Signal, clock: Clock, set_pressure: float, truth: Truth) -> Signal:
    """Supply pressure while the valve draws from it. [Pa]"""
    numbers = truth.parameters
    arguments = (set_pressure, numbers["refill_time"], numbers["demand_gain"])
    level = pressure / set_pressure
    match truth.formulation:
        case "steady_consumption":
            return _supply(level, clock.substeps, clock.step, *arguments)
        case "emptied_by_filling":
            return _burst_supply(level, clock.substeps, clock.step, *arguments)
    raise ValueError(f"supply_droop has no formulation {truth.formulation!r}")


def _filled(target: Signal, supply: Signal, clock: Clock, truth: Truth) -> Signal:
    """Pressure of a chamber that orifice and nozzle fill and vent. [Pa]"""
    rate = 1.0 / truth.parameters["fill_time"]
    growth, compressible = {
        "constant_volume": (0.0, 0.0),
        "growing_volume": (truth.parameters.get("volume_growth", 0.0), 0.0),
        "isothermal": (0.0, 1.2),
    }[truth.formulation]
    return _chamber(target, supply, clock.substeps, clock.step, rate, rate, growth, compressible)


def _filled_unevenly(target: Signal, supply: Signal, clock: Clock, truth: Truth) -> Signal:
    """Pressure that rises and falls with different capacities. [Pa]"""
    numbers = truth.parameters
    slow = numbers["slow_time"]
    quick = slow * numbers["quick_share"]
    fill, vent = (quick, slow) if numbers["slow_direction"] < 0 else (slow, quick)
    match truth.formulation:
        case "orifice_vent":
            return _chamber(target, supply, clock.substeps, clock.step, 1 / fill, 1 / vent, 0.0, 0.0)
        case "two_time_constants":
            return _two_rates(target, clock.substeps, clock.step, fill, vent, np.inf, np.inf)
        case "rate_limit":
            limits = (np.inf, float(supply.max()) / slow)
            fill_limit, vent_limit = limits if numbers["slow_direction"] < 0 else limits[::-1]
            return _two_rates(target, clock.substeps, clock.step, quick, quick, fill_limit, vent_limit)
    raise ValueError(f"asymmetric_filling has no formulation {truth.formulation!r}")


def _delayed(signal: Signal, clock: Clock, truth: Truth) -> Signal:
    """Pressure at the far end of the line. [Pa]"""
    late = round(truth.parameters["delay"] / clock.step)
    out = _shifted(signal, clock.substeps, late)
    if truth.formulation == "dispersive_line":
        return lagged(out, clock, truth.parameters["delay"] * truth.parameters["dispersion"])
    return out


def chamber_pressure(gap: Signal, clock: Clock, base: Mapping[str, float], truths: tuple[Truth, ...]) -> Signal:
    """Gauge pressure that acts on the diaphragm, shape (periods, width). [Pa]"""
    effects = by_effect(truths, "nozzle")
    pressure = _static(gap, base, effects.get("choked_flow"))
    supply = np.full((clock.periods, 1), base["supply_pressure"])
    if "supply_droop" in effects:
        supply = _droop(pressure, clock, base["supply_pressure"], effects["supply_droop"])
        pressure = pressure * (supply / base["supply_pressure"])
    if "chamber_filling" in effects:
        pressure = _filled(pressure, supply, clock, effects["chamber_filling"])
    if "asymmetric_filling" in effects:
        pressure = _filled_unevenly(pressure, supply, clock, effects["asymmetric_filling"])
    if "transport_delay" in effects:
        pressure = _delayed(pressure, clock, effects["transport_delay"])
    if "air_leak" in effects:
        table = np.linspace(0.0, pressure.max(), TABLE_SIZE)
        pressure = np.interp(pressure, table, leaking_pressure(table, effects["air_leak"]))
    return pressure
