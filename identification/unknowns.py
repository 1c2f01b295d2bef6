"""The unknowns of a fit: which numbers move, how they are scaled, and what holds them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from valvemodel.base_valve import BASE_PARAMETERS, BY_PRESSURE
from valvemodel.declarations import Parameter
from valvemodel.effects import effect_of_key
from valvemodel.model import Model

START_SPREAD = 0.02
"""A start position is looked for within a few of these about the first reading. [m]"""


GAP = ("gap_offset", "gap_gain")
"""Base parameters of the gap."""

OF_GAP = (*GAP, "supply_pressure")
"""Base parameters that a valve with an affine map of current to pressure does without."""

EDGE = 1e-4
"""Distance from a bound, scaled, within which a number is the bound: a search that keeps inside stands just beside it,
and the moments of a lag of a microsecond are dear to follow."""

ROUNDING = 1e-12
"""The same of a logarithmic number, relative, beyond a bound: its own logarithm may come back as what lies there."""


@dataclass(frozen=True)
class Unknown:
    """One number that a fit moves: value = centre exp(x) where it is logarithmic, else centre + spread x.

    `experiment` is the number of the experiment whose start position it is, or -1; `is_higher` marks a further one of a
    series of like numbers, `moves_pressure` one that acts on the pressure in time, from its lower bound on.
    """

    name: str
    unit: str
    centre: float
    spread: float
    is_logarithmic: bool
    low: float
    high: float
    prior_spread: float = 1.0
    experiment: int = -1
    is_higher: bool = False
    moves_pressure: bool = False

    def value(self, x: np.ndarray | float) -> np.ndarray:
        """Return the value at a scaled number, beside a bound the bound itself."""
        if self.is_logarithmic:
            value = self.centre * np.exp(np.asarray(x))
            within = np.clip(value, self.low, self.high)
            return np.where(np.abs(value - within) < ROUNDING * value, within, value)
        value, edge = self.centre + self.spread * np.asarray(x), EDGE * self.spread
        value = np.where(np.abs(value - self.low) < edge, self.low, value)
        return np.where(np.abs(value - self.high) < edge, self.high, value)

    def scaled(self, value: float) -> float:
        """Return the scaled number of a value, within the bounds."""
        value = min(max(value, self.low), self.high)
        if self.is_logarithmic:
            return math.log(max(value, self.low) / self.centre)
        return (value - self.centre) / self.spread

    def slope(self, value: float) -> float:
        """Return by how much the value moves with the scaled number."""
        return value if self.is_logarithmic else self.spread

    @property
    def bounds(self) -> tuple[float, float]:
        """Scaled bounds."""
        return self.scaled(self.low), self.scaled(self.high)


def freed_by(effects: Iterable[str], *, with_pressure: bool) -> set[str]:
    """Return the base parameters that effects free, beside those that a measured pressure tells in any case."""
    freed = {name for key in effects for name in effect_of_key(key).frees}
    return freed.difference(BY_PRESSURE if with_pressure else ())


def base_unknowns(model: Model, *, with_pressure: bool = False) -> list[Unknown]:
    """Return the free base parameters k, F_c, f_v, c0, E, the mass held by its prior, and P_1 where that is told.

    It is by a measured pressure, and by an effect of the model that frees it.
    """
    unknowns = []
    told = freed_by(model.effects, with_pressure=with_pressure) | set(BY_PRESSURE if with_pressure else ())
    has_gap = model.values["pressure_per_current"] == 0.0
    for parameter in BASE_PARAMETERS:
        is_free = parameter.is_fitted or parameter.name in told
        if not is_free or (parameter.name in OF_GAP and not has_gap):
            continue
        centre = model.values[parameter.name] or parameter.neutral
        low = max(parameter.low, centre * math.exp(-parameter.reach))
        high = min(parameter.high, centre * math.exp(parameter.reach))
        unknowns.append(
            Unknown(parameter.name, parameter.unit, centre, centre, True, low, high, parameter.prior_spread)
        )
    return unknowns


def effect_unknowns(key: str, start: dict[str, float], *, of_loops: bool = False) -> list[Unknown]:
    """Return the free parameters of an effect that starts somewhere; infinite ones and an idle series stay neutral.

    So do, in a fit to settled loops, those that act in time. Of a series that starts off neutral only the sizes move.
    Their spread is their root mean square at the start: the weak prior holds them to that.
    """
    effect = effect_of_key(key)
    fitted = [each for each in effect.free_at(start) if not (of_loops and each.acts_in_time)]
    series = [start[each.name] for each in fitted if each.is_higher and start[each.name] != each.neutral]
    if not series:
        moves = effect.acts_in_time and effect.acts_on_pressure
        return [
            replace(unknown_of(each), moves_pressure=moves and each.low == each.neutral)
            for each in fitted
            if math.isfinite(start[each.name]) and not each.is_higher
        ]
    size = math.sqrt(sum(value * value for value in series) / len(series))
    sizes = [each for each in fitted if each.scale == "linear" and start[each.name] != each.neutral]
    return [replace(unknown_of(each), spread=size, is_higher=each.is_higher) for each in sizes]


def unknown_of(parameter: Parameter) -> Unknown:
    """Return the unknown of one parameter of an effect, scaled by its smallest start, or else by its typical value."""
    starts = [each for each in parameter.starts if isinstance(each, float) and each != 0.0]
    numbers: list[float] = starts or [parameter.typical or 0.0]
    sizes = [abs(each) for each in numbers if each != 0.0 and math.isfinite(each)]
    size = min(sizes) if sizes else 0.1 * (parameter.high - parameter.low)
    if parameter.scale == "log":
        return Unknown(parameter.name, parameter.unit, size, size, True, parameter.low, parameter.high)
    return Unknown(parameter.name, parameter.unit, 0.0, size, False, parameter.low, parameter.high)


def start_unknown(first_reading: float, experiment: int) -> Unknown:
    """Return the start position of one experiment."""
    reach = 5.0 * START_SPREAD
    return Unknown(
        "start_position",
        "m",
        first_reading,
        START_SPREAD,
        False,
        first_reading - reach,
        first_reading + reach,
        experiment=experiment,
    )
