"""Nozzle, smooth: gap to actuator pressure; the same laws as the exact stage, over a whole part of a period."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import casadi as ca

from valvemodel.equations.symbolic import static_pressure
from valvemodel.smooth.electromagnet import CORNER
from valvemodel.smooth.lags import SHORTEST_TIME
from valvemodel.smooth.rounding import Expression, gate, passed, ramp
from valvemodel.stages.amplifier import LEAST_ROOT
from valvemodel.stages.nozzle import ATMOSPHERE, CRITICAL

NEWTON_STEPS = 12
"""From the incompressible pressure to the compressible one, to 1e-9 of the supply over the whole range of gaps."""

LEAST_PRESSURE = 1e-3
"""Keeps the slope of roots finite. [Pa]"""

LEAST_LEAK = 1e-12
"""Keeps the slope of the root of a choking leak's area finite. [1]"""

LEAST_SLOWNESS = 1e-15
"""Keeps the way of a rate limit of no slowness finite. [s/Pa]"""


def states_of(effects: Collection[str], *, smears: bool) -> tuple[str, ...]:
    """Return the names of the states that the effects need; the pressure itself is one, for it is measured."""
    droop = ("droop", "supplied_pressure") if "supply_droop" in effects else ()
    chamber = ("chamber_pressure",) if "chamber_filling" in effects else ()
    filled = ("filled_pressure",) if smears or "asymmetric_filling" in effects else ()
    return droop + chamber + filled + ("pressure",)


def rest_nozzle(p: Any, x: Any, gap: Expression, current: Expression) -> None:
    """Put the stage at rest at a gap."""
    pressure = resting_pressure(p, gap, current)
    if "supply_droop" in p.effects:
        x.droop = drawn_to_settle(p, pressure / p.supply_pressure)
        pressure = pressure * (1.0 - x.droop / p.supply_pressure)
        x.supplied_pressure = pressure
    if "chamber_filling" in p.effects:
        x.chamber_pressure = pressure
    if p.smears or "asymmetric_filling" in p.effects:
        x.filled_pressure = pressure
    x.pressure = behind_leak(p, pressure)


def advance_nozzle(p: Any, x: Any, gap: Expression, current: Expression, duration: Expression) -> Expression:
    """Hold the gap for a duration and return the mean actuator pressure over it. [Pa]"""
    pressure = after = resting_pressure(p, gap, current)
    if "supply_droop" in p.effects:
        pressure = sag_supply(p, x, pressure / p.supply_pressure, duration)
        after = x.supplied_pressure
    if "chamber_filling" in p.effects:
        pressure = fill_chamber(p, x, pressure, gap, duration)
        after = x.chamber_pressure
    if p.smears or "asymmetric_filling" in p.effects:
        law = fill_unequally if "asymmetric_filling" in p.effects else smear
        pressure = law(p, x, pressure, duration)
        after = x.filled_pressure
    x.pressure = behind_leak(p, after)
    return behind_leak(p, pressure)


def resting_pressure(p: Any, gap: Expression, current: Expression) -> Expression:
    """Return the pressure at rest under the full supply, by eqs. (16), (31) or by the valve's affine map. [Pa]"""
    if p.is_affine:
        return p.pressure_at_zero_current + p.pressure_per_current * current
    pressure = static_pressure(gap, p.supply_pressure, p.flow_ratio)
    if "choked_flow" in p.effects:
        opening = ca.sqrt(p.flow_ratio) * ca.fabs(gap)
        compressible = compressible_pressure(opening, p.supply_pressure, p.critical_pressure_ratio, pressure)
        pressure += p.compressible_share * (compressible - pressure)
    return pressure


def compressible_pressure(
    opening: Expression, supply: Expression, critical: Expression, pressure: Expression
) -> Expression:
    """Return the gauge pressure at which a hole feeds one so many times as open, by Newton's steps. [Pa]"""
    high_side = supply + ATMOSPHERE
    for _ in range(NEWTON_STEPS):
        absolute = pressure + ATMOSPHERE
        inflow, inflow_slope = passed_share(absolute / high_side, critical)
        outflow, outflow_slope = passed_share(ATMOSPHERE / absolute, critical)
        balance = high_side * inflow - opening * absolute * outflow
        slope = inflow_slope - opening * (outflow - outflow_slope * ATMOSPHERE / absolute)
        following = pressure - balance / slope
        # Halfway to an end where a step would leave the range: the root lies inside.
        pressure = ca.fmax(ca.fmin(following, 0.5 * (pressure + supply)), 0.5 * pressure)
    return pressure


def passed_share(ratio: Expression, critical: Expression) -> tuple[Expression, Expression]:
    """Return the flow through a hole over its choked flow, ISO 6358, and its slope in the ratio."""
    part = ca.fmin(ca.fmax((ratio - critical) / (1.0 - critical), 0.0), 1.0 - 1e-12)
    share = ca.sqrt(1.0 - part * part)
    return share, -part / (share * (1.0 - critical))


def behind_leak(p: Any, pressure: Expression) -> Expression:
    """Return the actuator pressure behind restriction and leak; the identity without a leak. [Pa]"""
    if "air_leak" not in p.effects:
        return pressure
    positive = ca.fmax(pressure, LEAST_PRESSURE)
    loss, turbulent, behind = p.leak_ratio * ca.sqrt(p.supply_pressure), p.turbulent_leak_ratio, positive
    if p.leaks_gas:
        opening = ca.sqrt(ca.fmax(turbulent, LEAST_LEAK))
        behind, turbulent = compressible_pressure(opening, positive, CRITICAL, positive / (1.0 + turbulent)), 0.0
    root = 2.0 * behind / (loss + ca.sqrt(loss * loss + 4.0 * (1.0 + turbulent) * behind))
    return ca.if_else(pressure > LEAST_PRESSURE, root * root, pressure)


def drawn_to_settle(p: Any, share: Expression) -> Expression:
    """Return the sag of the supply that the flow through the orifice keeps up. [Pa]"""
    least = LEAST_PRESSURE / p.supply_pressure
    return p.droop_consumption * p.supply_pressure * ca.sqrt(ca.fmax(1.0 - share, least))


def sag_supply(p: Any, x: Any, share: Expression, duration: Expression) -> Expression:
    """Let a rise of the pressure draw the supply down, which then recovers; return the mean pressure. [Pa]"""
    demand = (p.supply_pressure - x.droop) * share - x.supplied_pressure
    corner = CORNER * p.smoothing_pressure
    x.droop += p.droop_gain * ramp(demand - corner, corner) / (1.0 + p.droop_gain * share)
    settled = drawn_to_settle(p, share)
    rate = duration / (p.droop_recovery_time * (1.0 + p.droop_gain * share))
    excess = x.droop - settled
    mean = (p.supply_pressure - settled - excess * passed(rate)) * share
    x.droop = settled + excess * ca.exp(-rate)
    x.supplied_pressure = (p.supply_pressure - x.droop) * share
    return mean


def fill_chamber(p: Any, x: Any, resting: Expression, gap: Expression, duration: Expression) -> Expression:
    """Let the chamber fill towards its resting pressure and return the mean pressure (exponential midpoint). [Pa]"""
    departure = x.chamber_pressure - resting
    halfway = resting + departure * ca.exp(-0.5 * duration * filling_rate(p, x.chamber_pressure, resting, gap))
    rate = duration * filling_rate(p, halfway, resting, gap)
    x.chamber_pressure = resting + departure * ca.exp(-rate)
    return resting + departure * passed(rate)


def filling_rate(p: Any, pressure: Expression, resting: Expression, gap: Expression) -> Expression:
    """Return the rate at which a departure from rest dies out, the secant of eq. (15) without cancellation. [1/s]"""

    def root(share: Expression) -> Expression:
        return ca.sqrt(ca.fmax(share, LEAST_PRESSURE / p.supply_pressure))

    share, at_rest = pressure / p.supply_pressure, resting / p.supply_pressure
    secant = 1.0 / (root(1.0 - share) + root(1.0 - at_rest))
    secant += gap * ca.sqrt(p.flow_ratio) / (root(share) + root(at_rest))
    secant += p.laminar_filling * (1.0 - secant)
    bounded = ca.fmin(ca.fmax(share, 0.0), 1.0)
    filling_time = p.chamber_filling_time * (1.0 + p.filling_growth * bounded)
    secant *= stiffness_of_gas(bounded * p.supply_pressure, p.filling_of_gas)
    return secant / ca.fmax(filling_time, SHORTEST_TIME)


def smear(p: Any, x: Any, target: Expression, duration: Expression) -> Expression:
    """Follow a target at the end of a line that smears; return the mean. [Pa]"""
    departure = x.filled_pressure - target
    rate = duration / ca.fmax(p.line_dispersion * p.transport_delay, SHORTEST_TIME)
    x.filled_pressure = target + departure * ca.exp(-rate)
    return target + departure * passed(rate)


def fill_unequally(p: Any, x: Any, target: Expression, duration: Expression) -> Expression:
    """Follow a target at the capacity of the direction, rate-limited one way; return the mean. [Pa]"""
    departure = target - x.filled_pressure
    rises = gate(departure, p.smoothing_pressure)
    own_time = ca.fmax(p.vent_time + (p.fill_time - p.vent_time) * rises, SHORTEST_TIME)
    if p.smears:
        own_time += p.line_dispersion * p.transport_delay
    # Exponential midpoint.
    halfway = target - departure * ca.exp(-0.5 * duration * quickness(p, x.filled_pressure, target) / own_time)
    time_constant = own_time / quickness(p, halfway, target)
    limited = (1.0 - rises) * ca.fmax(p.filling_slowness, 0.0) + rises * ca.fmax(-p.filling_slowness, 0.0)
    slowness = limited + LEAST_SLOWNESS
    size = ca.fabs(departure)
    ramped = ca.fmin(ca.fmax(size * slowness - time_constant, 0.0), duration)
    area = ramped * (size - 0.5 * ramped / slowness)
    size -= ramped / slowness
    rate = (duration - ramped) / time_constant
    area += size * (duration - ramped) * passed(rate)
    side = ca.sign(departure)
    x.filled_pressure = target - side * size * ca.exp(-rate)
    return target - side * area / duration


def quickness(p: Any, pressure: Expression, target: Expression) -> Expression:
    """Return the rate at which orifices follow a target over that of first order."""
    if not p.has_orifices:
        return 1.0
    least = LEAST_ROOT * LEAST_ROOT
    share, resting = (ca.fmin(ca.fmax(each / p.supply_pressure, least), 1.0 - least) for each in (pressure, target))
    root = resting * ca.sqrt(1.0 - share) + ca.sqrt(resting * share * (1.0 - resting))
    stiffness = stiffness_of_gas(share * p.supply_pressure, p.orifices_of_gas)
    return 1.0 + p.orifice_share * (stiffness / ca.fmax(root, LEAST_ROOT) - 1.0)


def stiffness_of_gas(pressure: Expression, share: Expression) -> Expression:
    """Return how stiff what fills a volume is at a pressure, over that at none: of a share of gas as its density."""
    return 1.0 + share * pressure / ATMOSPHERE
