"""What a kind of record determines of a valve, whatever is in it: read from the derived symmetries."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from identification.unknowns import freed_by
from valvemodel.base_valve import BY_PRESSURE
from valvemodel.equations.symmetries import GROUPS, SCALINGS
from valvemodel.model import Model
from valvemodel.records import Record

_BREAKAWAY = frozenset({"static_friction", "stribeck"})
"""Effects with which the static friction is a number of its own."""


@dataclass(frozen=True)
class Structure:
    """What the signals of a record determine of the base valve.

    Attributes
    ----------
    signals : str
        Of the record.
    groups : tuple of str
        Products and ratios of parameters that are determined.
    scalings : tuple of str
        Changes of parameters that no signal shows.
    measured_by : dict of str
        By parameter what it is known in proportion to; empty where it is determined on its own, None where it does
        not enter at all.
    """

    signals: str
    groups: tuple[str, ...]
    scalings: tuple[str, ...]
    measured_by: dict[str, str | None]

    def as_json(self) -> dict[str, Any]:
        """Return the part of fit.json."""
        return {
            "signals": self.signals,
            "determined": list(self.groups),
            "not_determined": list(self.scalings),
            "measured_by": self.measured_by,
        }


def structure_of(record: Record, model: Model) -> Structure:
    """Return what the signals of a record determine of a valve by the symmetries of its equations.

    An effect that frees what else a measured pressure tells breaks the same symmetry as that does.
    """
    freed = freed_by(model.effects, with_pressure=False)
    tells_pressure = record.pressure is not None or not freed.isdisjoint(BY_PRESSURE)
    kind = (_signals(record, has_pressure=tells_pressure), model.values["pressure_per_current"] > 0.0)
    has_breakaway = not _BREAKAWAY.isdisjoint(model.effects)
    groups = [group for group in GROUPS[kind] if has_breakaway or "static_friction" not in group]
    scalings = [{name: power for name, power in each.items() if has_breakaway or name != "static_friction"}
                for each in SCALINGS[kind]]  # fmt: skip
    measured_by: dict[str, str | None] = {}
    for scaling in scalings:
        measured_by |= dict.fromkeys(scaling) if len(scaling) == 1 else {}
    for group in groups:
        name = own_name(group)
        measured_by[name] = product({other: -power for other, power in group.items() if other != name})
    signals = _signals(record, has_pressure=record.pressure is not None)
    return Structure(signals, tuple(map(product, groups)), tuple(map(_change, scalings)), measured_by)


def own_name(group: Mapping[str, float]) -> str:
    """Return the parameter of a group that the others measure: the last."""
    return list(group)[-1]


def _signals(record: Record, *, has_pressure: bool) -> str:
    if record.kind == "stem":
        return "force, position"
    settled = "settled " if record.kind == "loop" else ""
    pressure = f", {settled}pressure" if has_pressure else ""
    return f"current{pressure}, {settled}position"


def product(powers: Mapping[str, float]) -> str:
    """Return a product of powers as text, as `a / (b * c)`."""
    above = [_power(name, power) for name, power in powers.items() if power > 0.0]
    below = [_power(name, -power) for name, power in powers.items() if power < 0.0]
    text = " * ".join(above) or ("1" if below else "")
    if not below:
        return text
    return f"{text} / {below[0]}" if len(below) == 1 else f"{text} / ({' * '.join(below)})"


def _power(name: str, power: float) -> str:
    return name if power == 1.0 else f"{name}^{power:g}"


def _change(powers: Mapping[str, float]) -> str:
    if len(powers) == 1:
        return f"{next(iter(powers))} does not enter"
    by_power: dict[float, list[str]] = {}
    for name, power in powers.items():
        by_power.setdefault(power, []).append(name)
    factor = {1.0: "any factor", -1.0: "one over it"}
    parts = [f"{', '.join(names)} by {factor.get(power, f'its power {power:g}')}" for power, names in by_power.items()]
    return "; ".join(parts)
