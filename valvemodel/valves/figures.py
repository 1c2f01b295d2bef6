"""What follows from a valve's numbers at rest and in slip: the figures that an engineer judges it by."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from valvemodel.equations import numeric
from valvemodel.valves.valve import Valve

CURRENTS = np.linspace(4e-3, 20e-3, 161)
"""The standard signal range. [A]"""


@dataclass(frozen=True)
class Figures:
    """Figures of a valve over 4..20 mA.

    Parameters
    ----------
    pressure : array, shape (161,)
        Gauge pressure at rest at `CURRENTS`. [Pa]
    gap : array, shape (161,), or None
        Distance from nozzle to flapper, None for an affine current-pressure map. [m]
    travel : tuple of float
        Positions at rest without friction at the lowest and the highest pressure. [m]
    dead_band : float
        Pressure to turn the stem round over the pressure range, infinite where that is 0. [1]
    damping_ratio : float
        Viscous friction over that of critical damping, infinite without a spring. [1]
    period : float
        Of the undamped stem, infinite without a spring. [s]
    settling : float
        The slowest time constant of a slip, infinite without friction. [s]
    """

    pressure: npt.NDArray[np.float64]
    gap: npt.NDArray[np.float64] | None
    travel: tuple[float, float]
    dead_band: float
    damping_ratio: float
    period: float
    settling: float


def figures(valve: Valve) -> Figures:
    """Return what follows from a valve's numbers.

    Examples
    --------
    >>> from valvemodel.valves import read_valve
    >>> round(figures(read_valve("calibrated")).damping_ratio, 2)
    1.15
    """
    values = valve.values
    gap = None
    if values["pressure_per_current"] > 0:
        pressure = values["pressure_at_zero_current"] + values["pressure_per_current"] * CURRENTS
    else:
        gap = numeric.coil_gap(CURRENTS, values["gap_offset"], values["gap_gain"])
        pressure = numeric.static_pressure(gap, values["supply_pressure"], values["flow_ratio"])
    mass, rate, friction = values["stem_mass"], values["spring_rate"], values["viscous_friction"]
    span = values["diaphragm_area"] * float(np.ptp(pressure))
    return Figures(
        pressure,
        gap,
        (_position(valve, float(pressure.min())), _position(valve, float(pressure.max()))),
        2 * values["coulomb_friction"] / span if span > 0 else math.inf,
        friction / (2 * math.sqrt(rate * mass)) if rate > 0 else math.inf,
        2 * math.pi * math.sqrt(mass / rate) if rate > 0 else math.inf,
        _slowest(mass, rate, friction),
    )


def _position(valve: Valve, pressure: float) -> float:
    values = valve.values
    force = values["diaphragm_area"] * pressure - values["spring_preload"]
    position = force / values["spring_rate"] if values["spring_rate"] > 0 else math.copysign(math.inf, force)
    return min(max(position, values["travel_min"]), values["travel_max"])


def _slowest(mass: float, rate: float, friction: float) -> float:
    """Return the slowest time constant of m y'' + f y' + k y = 0."""
    if friction == 0:
        return math.inf
    half = friction / (2 * mass)
    discriminant = half**2 - rate / mass
    if rate == 0 or discriminant <= 0:
        return mass / friction if rate == 0 else 1 / half
    # the slow root by the product of the two, which does not cancel
    return (half + math.sqrt(discriminant)) / (rate / mass)
