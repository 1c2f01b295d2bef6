"""The terms of the stem's force balance as columns of a regression, base and effects, in the library's
names."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from identification.inverse_dynamics.signals import Array, StemSignals
from valvemodel.base_valve import BASE_PARAMETERS
from valvemodel.declarations import Effect
from valvemodel.errors import unknown_name
from valvemodel.stages.stem import EFFECTS

Values = Mapping[str, float]


class Estimate(NamedTuple):
    """A fitted number in SI units; `std` is None where the record does not determine it."""

    value: float
    unit: str
    std: float | None


@dataclass(frozen=True)
class StemEffect:
    """An effect of the library as columns that are linear in its amplitudes.

    Parameters
    ----------
    key : str
        In the library.
    columns : callable
        (signals, shape) to full-rate columns, shape (n, terms). [N over the unit of the amplitude]
    parameters : callable
        (amplitudes, base, shape) to the library's parameters, SI.
    grid : callable
        signals to the shapes (the parameters that are not linear) among which a search begins.
    holds : str or None
        The base parameter that has to be held at 0 beside it, an exact alias.
    reshapes : str or None
        The base parameter whose column the effect's one takes the place of; its amplitude is then that
        parameter.
    """

    key: str
    columns: Callable[[StemSignals, Values], Array]
    parameters: Callable[[Array, Values, Values], dict[str, float]]
    grid: Callable[[StemSignals], tuple[dict[str, float], ...]] = lambda signals: ({},)
    holds: str | None = None
    reshapes: str | None = None

    @property
    def declaration(self) -> Effect:
        """What the library says about the effect."""
        return next(effect for effect in EFFECTS if effect.key == self.key)

    def is_admissible(self, parameters: Values) -> bool:
        """Return whether the parameters are within the bounds of the declaration; unnamed ones are typical."""
        named = [(each, parameters[each.name]) for each in self.declaration.parameters if each.name in parameters]
        return all(math.isfinite(value) and each.low <= value <= each.high for each, value in named)


LINEAR_DRIFT_TIME = 3000.0
"""Time constant with which the library's drift is a straight line over a record, its upper bound. [s]"""


def base_columns(signals: StemSignals, *, has_spring: bool) -> dict[str, Array]:
    """Return the full-rate columns of the base model's force, by parameter.

    .. math:: F = m a + f_v v + F_c \\,\\mathrm{sign}(v) + F_0 + k y

    Parameters
    ----------
    signals : StemSignals
    has_spring : bool

    Returns
    -------
    dict of array, shape (n,)
    """
    columns = {
        "stem_mass": signals.acceleration,
        "viscous_friction": signals.velocity,
        "coulomb_friction": signals.direction,
        "spring_preload": np.ones_like(signals.velocity),
    }
    if has_spring:
        columns["spring_rate"] = signals.position
    return columns


def unit_of(name: str) -> str:
    """Return the SI unit of a parameter of the base valve or of a stem effect."""
    everything = [*BASE_PARAMETERS, *(each for effect in EFFECTS for each in effect.parameters)]
    return next(parameter.unit for parameter in everything if parameter.name == name)


def stem_candidates(*, has_spring: bool = True) -> tuple[str, ...]:
    """Return the keys of the effects that inverse dynamics can look for.

    Examples
    --------
    >>> "asymmetric_viscous_friction" in stem_candidates()
    True
    """
    return tuple(key for key in _EFFECTS if has_spring or key != "spring_hardening")


def stem_effect(key: str) -> StemEffect:
    """Return the columns of an effect.

    Raises
    ------
    InputError
        If inverse dynamics has no such effect; names the nearest.
    """
    if key not in _EFFECTS:
        raise unknown_name("an effect of inverse dynamics", key, _EFFECTS)
    return _EFFECTS[key]


NOT_APPLICABLE = {
    "static_friction": "acts while the stem rests, where inverse dynamics has no equation",
    "pressure_dependent_friction": "needs a measured pressure",
    "area_variation": "needs a measured pressure",
    "end_stop": "the force of a stop is not in the force balance of a moving stem",
}
"""Why the other effects of the stem are no candidates."""

EXACT_ALIASES = {
    "asymmetric_friction": "F_c (1 + a sign v) sign v = F_c sign v + a F_c: a constant force, which the base "
    "model's spring_preload (offset) already has; only a preload known otherwise tells them apart",
}
"""Effects whose columns are those of the base model in other words."""


def _share_of(base: Values, name: str, amplitude: float) -> float:
    return amplitude / base[name] if base[name] != 0.0 else math.nan


def _asymmetric_viscous(signals: StemSignals, shape: Values) -> Array:
    return np.abs(signals.velocity)[:, None]


def _asymmetric_coulomb(signals: StemSignals, shape: Values) -> Array:
    return np.ones((signals.velocity.size, 1))


def _tight_spot(signals: StemSignals, shape: Values) -> Array:
    distance = (signals.position - shape["tight_spot_position"]) / shape["tight_spot_width"]
    return (signals.direction * np.exp(-(distance**2)))[:, None]


def _tight_spot_grid(signals: StemSignals) -> tuple[dict[str, float], ...]:
    low, high = float(signals.position.min()), float(signals.position.max())
    return tuple(
        {"tight_spot_position": low + share * (high - low), "tight_spot_width": width * (high - low)}
        for width in (0.03, 0.05, 0.08, 0.12, 0.2)
        for share in np.linspace(0.0, 1.0, 21)
    )


def _stribeck(signals: StemSignals, shape: Values) -> Array:
    return (signals.direction * np.exp(-np.abs(signals.velocity) / shape["stribeck_velocity"]))[:, None]


def _stribeck_grid(signals: StemSignals) -> tuple[dict[str, float], ...]:
    top = float(np.quantile(np.abs(signals.velocity), 0.95))
    return tuple({"stribeck_velocity": top * share} for share in np.geomspace(0.005, 0.4, 12))


def _drift(signals: StemSignals, shape: Values) -> Array:
    return (signals.direction * signals.time)[:, None]


def _hardening(signals: StemSignals, shape: Values) -> Array:
    return (signals.position**3)[:, None]


def _load(signals: StemSignals, shape: Values) -> Array:
    angle = 2.0 * np.pi * signals.time / shape["load_period"]
    return -np.column_stack([np.sin(angle), np.cos(angle)])


def _load_grid(signals: StemSignals) -> tuple[dict[str, float], ...]:
    """Frequencies half a line of the record's spectrum apart, from one period in it, at most 60 of them."""
    duration = float(signals.time[-1] - signals.time[0])
    highest = min(2.0, 0.2 / signals.row_interval)
    count = min(60, max(2, int(2.0 * duration * highest)))
    return tuple({"load_period": duration / (1.0 + 0.5 * step)} for step in range(count))


def _presliding(signals: StemSignals, shape: Values) -> Array:
    """Friction over F_c by Dahl's law along the measured way, exact between two samples."""
    decays = np.exp(-np.abs(np.diff(signals.position)) / shape["presliding_way"])
    sides = np.sign(np.diff(signals.position))
    friction = np.empty(signals.position.size)
    friction[0] = value = float(signals.direction[0])
    for row, (decay, side) in enumerate(zip(decays.tolist(), sides.tolist(), strict=True), start=1):
        if side:
            value = side + (value - side) * decay
        friction[row] = value
    return friction[:, None]


def _presliding_grid(signals: StemSignals) -> tuple[dict[str, float], ...]:
    travel = float(np.ptp(signals.position))
    return tuple({"presliding_way": travel * share} for share in np.geomspace(2e-5, 4e-2, 16))


_EFFECTS = {
    effect.key: effect
    for effect in (
        StemEffect(
            "asymmetric_viscous_friction",
            _asymmetric_viscous,
            lambda c, base, shape: {"viscous_asymmetry": _share_of(base, "viscous_friction", c[0])},
        ),
        StemEffect(
            "asymmetric_friction",
            _asymmetric_coulomb,
            lambda c, base, shape: {"friction_asymmetry": _share_of(base, "coulomb_friction", c[0])},
            holds="spring_preload",
        ),
        StemEffect(
            "position_dependent_friction",
            _tight_spot,
            lambda c, base, shape: {"tight_spot_excess": _share_of(base, "coulomb_friction", c[0]), **shape},
            _tight_spot_grid,
        ),
        StemEffect(
            "stribeck",
            _stribeck,
            lambda c, base, shape: {
                "stribeck_ratio": 1.0 + _share_of(base, "coulomb_friction", c[0]),
                **shape,
            },
            _stribeck_grid,
        ),
        StemEffect(
            "friction_drift",
            _drift,
            lambda c, base, shape: {
                "friction_drift_rate": _share_of(base, "coulomb_friction", c[0]),
                "friction_drift_time": LINEAR_DRIFT_TIME,
            },
        ),
        StemEffect(
            "spring_hardening",
            _hardening,
            lambda c, base, shape: {"spring_hardening": _share_of(base, "spring_rate", c[0])},
        ),
        StemEffect(
            "load_force",
            _load,
            lambda c, base, shape: {"load_sine": float(c[0]), "load_cosine": float(c[1]), **shape},
            _load_grid,
        ),
        StemEffect(
            "presliding",
            _presliding,
            lambda c, base, shape: {
                "presliding_compliance": _share_of(base, "coulomb_friction", shape["presliding_way"])
            },
            _presliding_grid,
            reshapes="coulomb_friction",
        ),
    )
}
