"""Nozzle: from the gap to the pressure at the actuator, all at rest."""

from __future__ import annotations

from math import sqrt
from types import SimpleNamespace

ATMOSPHERE = 101325.0
"""Absolute pressure of the surroundings. [Pa]"""

IDEAL = 0.528
"""Critical ratio of the pressures at an ideal hole."""


def resting_pressure(n: SimpleNamespace, gap: float, current: float) -> float:
    """Return the chamber's pressure at rest: eq. (16), compressible flow, or an affine map of the current. [Pa]"""
    if n.pressure_per_current > 0.0:
        return n.pressure_at_zero_current + n.pressure_per_current * current
    incompressible = n.supply_pressure / (1.0 + n.flow_ratio * gap**2)
    if n.compressible_share == 0.0:
        return incompressible
    opening = sqrt(n.flow_ratio) * abs(gap)
    compressible = compressible_pressure(n.supply_pressure, opening, n.critical_pressure_ratio)
    return incompressible + n.compressible_share * (compressible - incompressible)


def compressible_pressure(supply: float, opening: float, critical: float) -> float:
    """Return the pressure at which a hole feeds what another so many times as open passes. [Pa]

    The balance of the flows falls with the pressure.
    """
    before = supply + ATMOSPHERE

    def balance(pressure: float) -> float:
        between = pressure + ATMOSPHERE
        inflow = before * passed_share(between / before, critical)
        return inflow - opening * between * passed_share(ATMOSPHERE / between, critical)

    low, high = 0.0, supply
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if balance(middle) > 0.0 else (low, middle)
    return high


def passed_share(ratio: float, critical: float) -> float:
    """Return the flow through a hole over its choked flow, ISO 6358."""
    above = (min(ratio, 1.0) - critical) / (1.0 - critical)
    return sqrt(1.0 - max(above, 0.0) ** 2)


def behind_leak(n: SimpleNamespace, pressure: float) -> float:
    """Return P_a of (1 + g) P_a + l sqrt(P_1 P_a) = P_b, a quadratic equation in the root of P_a. [Pa]

    Where the leak chokes g stands for a hole and a restriction that pass a gas, before the laminar part.
    """
    if n.leak_ratio == n.turbulent_leak_ratio == 0.0 or pressure <= 0.0:
        return pressure
    loss, turbulent = n.leak_ratio * sqrt(n.supply_pressure), n.turbulent_leak_ratio
    if n.leak_chokes > 0.0:
        pressure, turbulent = compressible_pressure(pressure, sqrt(turbulent), IDEAL), 0.0
    root = 2.0 * pressure / (loss + sqrt(loss**2 + 4.0 * (1.0 + turbulent) * pressure))
    return root**2
