"""Nozzle: from the gap to the pressure at the actuator, all at rest."""

from __future__ import annotations

from math import sqrt
from types import SimpleNamespace

ATMOSPHERE = 101325.0
"""Absolute pressure of the surroundings. [Pa]"""


def resting_pressure(n: SimpleNamespace, gap: float, current: float) -> float:
    """Return the chamber's pressure at rest: eq. (16), compressible flow, or an affine map of the current. [Pa]"""
    if n.pressure_per_current > 0.0:
        return n.pressure_at_zero_current + n.pressure_per_current * current
    incompressible = n.supply_pressure / (1.0 + n.flow_ratio * gap**2)
    if n.compressible_share == 0.0:
        return incompressible
    return incompressible + n.compressible_share * (compressible_pressure(n, gap) - incompressible)


def compressible_pressure(n: SimpleNamespace, gap: float) -> float:
    """Return the pressure at which the orifice feeds what the nozzle passes; the balance falls with it. [Pa]"""
    supply = n.supply_pressure + ATMOSPHERE

    def balance(pressure: float) -> float:
        chamber = pressure + ATMOSPHERE
        inflow = supply * passed_share(n, chamber / supply)
        outflow = sqrt(n.flow_ratio) * abs(gap) * chamber * passed_share(n, ATMOSPHERE / chamber)
        return inflow - outflow

    low, high = 0.0, n.supply_pressure
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if balance(middle) > 0.0 else (low, middle)
    return high


def passed_share(n: SimpleNamespace, ratio: float) -> float:
    """Return the flow through a hole over its choked flow, ISO 6358."""
    above = (min(ratio, 1.0) - n.critical_pressure_ratio) / (1.0 - n.critical_pressure_ratio)
    return sqrt(1.0 - max(above, 0.0) ** 2)


def behind_leak(n: SimpleNamespace, pressure: float) -> float:
    """Return P_a of (1 + g) P_a + l sqrt(P_1 P_a) = P_b, a quadratic equation in the root of P_a. [Pa]"""
    if n.leak_ratio == n.turbulent_leak_ratio == 0.0 or pressure <= 0.0:
        return pressure
    loss = n.leak_ratio * sqrt(n.supply_pressure)
    root = 2.0 * pressure / (loss + sqrt(loss**2 + 4.0 * (1.0 + n.turbulent_leak_ratio) * pressure))
    return root**2
