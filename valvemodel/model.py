"""A model: a valve and the effects that are switched on, immutable, written to and read from model.json."""

from __future__ import annotations

import json
import math
import reprlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from valvemodel.base_valve import BASE_PARAMETERS
from valvemodel.declarations import Parameter
from valvemodel.display import Card, Shown, model_card
from valvemodel.effects import effect_of_key
from valvemodel.errors import InputError, unknown_name
from valvemodel.files import write_json
from valvemodel.parameters import parameter_rows

SCHEMA = "valvemodel.model/1"

Values = Mapping[str, float]


@dataclass(frozen=True, repr=False)
class Model(Shown):
    """A valve with its effects.

    Parameters
    ----------
    name : str
        What the valve is called: a set, a file, or the record it was fitted to.
    values : mapping
        Base parameters by name [SI]; absent ones are neutral.
    effects : mapping
        By effect key the values of its parameters [SI]; absent parameters are at their typical value.
    """

    name: str
    values: Values
    effects: Mapping[str, Values] = field(default_factory=dict)

    def __post_init__(self) -> None:
        base = {parameter.name: parameter.neutral for parameter in BASE_PARAMETERS}
        for name, value in self.values.items():
            if name not in base:
                raise unknown_name("a parameter of the valve", name, base)
            base[name] = float(value)
        check_valve(base)
        effects = {}
        for key, given in self.effects.items():
            effect = effect_of_key(key)
            values = effect.typical
            for name, value in given.items():
                values[name] = _within(effect.parameter(name), float(value))
            effects[key] = MappingProxyType(values)
        object.__setattr__(self, "values", MappingProxyType(base))
        object.__setattr__(self, "effects", MappingProxyType(effects))

    def __reduce__(self) -> tuple[Any, ...]:
        return Model, (
            self.name,
            dict(self.values),
            {key: dict(values) for key, values in self.effects.items()},
        )

    def with_effect(self, key: str, **values: float) -> Model:
        """Return the model with an effect switched on or changed."""
        return Model(self.name, self.values, {**self.effects, key: values})

    def without_effect(self, key: str) -> Model:
        """Return the model with an effect switched off."""
        return Model(self.name, self.values, {k: v for k, v in self.effects.items() if k != key})

    def without_starts(self) -> Model:
        """Return the model of the valve alone: where something stood as a record began is that of no other."""
        effects = {}
        for key, values in self.effects.items():
            neutral = {each.name: each.neutral for each in effect_of_key(key).parameters if each.is_start}
            effects[key] = {**values, **neutral}
        return Model(self.name, self.values, effects)

    def with_values(self, **values: float) -> Model:
        """Return the model with base parameters changed."""
        return Model(self.name, {**self.values, **values}, self.effects)

    @property
    def numbers(self) -> dict[str, float]:
        """Every number that is not neutral, base and effects together, by name. [SI]"""
        numbers = dict(self.values)
        for values in self.effects.values():
            numbers.update(values)
        return numbers

    def rows(self, count: int = 1, start_position: float = math.nan) -> np.ndarray:
        """Return the compiled chain's rows of numbers, dtype PARAMETERS, shape (count,)."""
        return parameter_rows({**self.numbers, "start_position": start_position}, count)

    def as_json(self) -> dict[str, Any]:
        """Return the content of model.json; infinite travel limits are left out."""
        return {
            "schema": SCHEMA,
            "name": self.name,
            "valve": {
                parameter.name: {"value": self.values[parameter.name], "unit": parameter.unit}
                for parameter in BASE_PARAMETERS
                if math.isfinite(self.values[parameter.name])
            },
            "effects": {
                key: {
                    name: {"value": value, "unit": effect_of_key(key).parameter(name).unit}
                    for name, value in values.items()
                    if math.isfinite(value)
                }
                for key, values in self.effects.items()
            },
        }

    def _card(self) -> Card:
        return model_card(self)

    def write(self, path: Path) -> None:
        """Write model.json."""
        write_json(path, self.as_json())


def read_model(path: Path) -> Model:
    """Read a model.json or base.json.

    Raises
    ------
    InputError
        If the file is not such a model, a number is missing or its unit is not the declared one; says which
        entry and why.
    """
    path = Path(path)
    remedy = "give a model.json or base.json that valvemodel fit or diagnose wrote"
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError("a model file must be readable", f"{path}: {error.strerror}", remedy) from None
    except ValueError as error:
        raise InputError("a model file must be JSON", f"{path}: {error}", remedy) from None
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        found = content.get("schema") if isinstance(content, dict) else type(content).__name__
        raise InputError(f"a model file has the schema {SCHEMA!r}", f"{path} has {found!r}", remedy)
    valve = _numbers(path, "the valve", BASE_PARAMETERS, _table(path, "valve", content.get("valve", {})))
    effects = {
        key: _numbers(path, key, effect_of_key(key).parameters, _table(path, key, values))
        for key, values in _table(path, "effects", content.get("effects", {})).items()
    }
    return Model(str(content.get("name", path.stem)), valve, effects)


def check_valve(values: Values) -> None:
    """Refuse a valve that physics does not allow, with the rule and the value."""
    for name in ("stem_mass", "diaphragm_area", "supply_pressure", "flow_ratio", "rated_travel"):
        if not values[name] > 0.0 or not math.isfinite(values[name]):
            raise InputError(f"{name} must be positive", f"it is {values[name]:g}", "correct the valve")
    for name in ("spring_rate", "viscous_friction", "coulomb_friction", "gap_gain", "pressure_per_current"):
        if not values[name] >= 0.0 or not math.isfinite(values[name]):
            raise InputError(f"{name} must not be negative", f"it is {values[name]:g}", "correct the valve")
    if not values["travel_min"] < values["travel_max"]:
        arrived = f"they are {values['travel_min']:g} and {values['travel_max']:g} m"
        raise InputError("travel_min must be below travel_max", arrived, "correct the valve")


def _within(parameter: Parameter, value: float) -> float:
    if value == parameter.within_bounds(value):
        return value
    unit = "" if parameter.unit == "1" else f" {parameter.unit}"
    raise InputError(
        f"{parameter.name} must lie in {parameter.low:g}..{parameter.high:g}{unit}",
        f"got {value:g}",
        f"its meaning is: {parameter.meaning}",
    )


def _table(path: Path, name: str, table: Any) -> dict[str, Any]:
    if not isinstance(table, dict):
        raise InputError(
            f"{name!r} of a model file is a table", f"{path}: it is {reprlib.repr(table)}", "write it anew"
        )
    return table


def _numbers(path: Path, owner: str, parameters: Sequence[Parameter], table: dict[str, Any]) -> dict[str, float]:
    """Return the numbers of the valve or of an effect.

    Only those may be left out that are infinite when neutral, or came later than their effect.
    """
    declared = {parameter.name: parameter for parameter in parameters}
    for name in table:
        if name not in declared:
            raise unknown_name(f"a parameter of {owner}", name, declared)
    missing = [name for name, parameter in declared.items() if name not in table and not _may_be_left_out(parameter)]
    if missing:
        raise InputError(
            f"a model file has every number of {owner}",
            f"{path} lacks {', '.join(missing)}",
            "add it with its unit, or write the file anew",
        )
    return {
        name: _number(path, parameter, table[name]) if name in table else _left_out(parameter)
        for name, parameter in declared.items()
    }


def _may_be_left_out(parameter: Parameter) -> bool:
    return parameter.is_later or parameter.is_higher or math.isinf(parameter.neutral)


def _left_out(parameter: Parameter) -> float:
    """Return what a file means that leaves a number out."""
    return float(parameter.typical or 0.0) if parameter.is_later else parameter.neutral


def _number(path: Path, parameter: Parameter, entry: Any) -> float:
    name, unit = parameter.name, parameter.unit
    try:
        value = float(entry["value"]) if type(entry["value"]) in (int, float) else math.nan
    except (KeyError, TypeError, OverflowError):
        value = math.nan
    if not isinstance(entry, dict) or not math.isfinite(value):
        raise InputError(
            "each number of a model file is a table with a value and a unit",
            f"{path}: {name} is {reprlib.repr(entry)}",
            f'write "{name}": {{"value": NUMBER, "unit": "{unit}"}}',
        )
    if entry.get("unit") != unit:
        arrived = f"the unit {entry['unit']!r}" if "unit" in entry else "no unit"
        raise InputError(
            f"{name} of a model file is in {unit!r}",
            f"{path}: {name} has {arrived}",
            f"convert the value and give it the unit {unit!r}",
        )
    return value
