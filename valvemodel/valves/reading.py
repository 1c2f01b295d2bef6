"""Reads a valve from a TOML file: a table for each number, with value, unit and source."""

from __future__ import annotations

import difflib
import math
import re
import tomllib
from collections.abc import Callable, Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from valvemodel.base_valve import BASE_PARAMETERS, BY_PRESSURE, ON_PRESSURE
from valvemodel.equations import numeric
from valvemodel.errors import InputError, unknown_name
from valvemodel.quantities import to_si
from valvemodel.valves.valve import Entry, Valve

_BASE = {parameter.name: parameter for parameter in BASE_PARAMETERS}

_RAW_UNITS = {
    "orifice_flow_coefficient": "1",
    "nozzle_flow_coefficient": "1",
    "orifice_diameter": "m",
    "nozzle_diameter": "m",
    "maximum_gap": "m",
    "magnetic_path_length": "m",
    "leakage_coefficient": "1",
    "coil_turns": "1",
    "magnetic_area": "m^2",
    "supply_voltage": "V",
    "ansatz_exponent": "1",
    "ansatz_factor": "m/s",
}
"""Data of nozzle and coil that may be given instead of flow_ratio, gap_offset and gap_gain."""

_RAW_OF = {
    "flow_ratio": (
        "orifice_flow_coefficient",
        "orifice_diameter",
        "nozzle_flow_coefficient",
        "nozzle_diameter",
    ),
    "gap_offset": ("maximum_gap", "magnetic_path_length", "leakage_coefficient"),
    "gap_gain": (
        "coil_turns",
        "magnetic_area",
        "supply_voltage",
        "leakage_coefficient",
        "ansatz_exponent",
        "ansatz_factor",
    ),
}
_DERIVED_BY = {
    "flow_ratio": "derived from orifice and nozzle, eq. (16)",
    "gap_offset": "derived from the coil, eq. (31)",
    "gap_gain": "derived from the coil, eq. (31)",
}
_PRESSURE = tuple(name for name in ON_PRESSURE if name not in BY_PRESSURE)
"""How the current makes the pressure, by the gap or by a straight line."""

_FORMS = ("corrected", "as printed")
_DERIVATIONS: dict[tuple[str, str], Callable[..., float]] = {
    ("flow_ratio", "corrected"): numeric.flow_ratio,
    ("flow_ratio", "as printed"): numeric.flow_ratio,
    ("gap_offset", "corrected"): numeric.gap_offset_of_coil,
    ("gap_offset", "as printed"): numeric.gap_offset_of_coil,
    ("gap_gain", "corrected"): numeric.gap_gain_of_coil,
    ("gap_gain", "as printed"): numeric.gap_gain_of_coil_as_printed,
}
_NEEDED = (
    "stem_mass",
    "spring_rate",
    "diaphragm_area",
    "supply_pressure",
    "viscous_friction",
    "coulomb_friction",
)
_POSITIVE = {*_RAW_UNITS, *(parameter.name for parameter in BASE_PARAMETERS if parameter.scale == "log")} | {
    "rated_travel"
}
_NOT_NEGATIVE = ("spring_rate", "viscous_friction", "coulomb_friction", "pressure_per_current", "gap_gain")
_REMEDY = "every entry needs value, unit and source"


def valve_names() -> tuple[str, ...]:
    """Return the names of the valve sets that come with the package."""
    folder = resources.files("valvemodel.valves")
    return tuple(sorted(item.name.removesuffix(".toml") for item in folder.iterdir() if item.name.endswith(".toml")))


def read_valve(name_or_path: str | Path) -> Valve:
    """Read a valve set by its name, or a valve from a file of the same format.

    Raises
    ------
    InputError
        If there is no such set or file, or an entry is unknown, incomplete or impossible.

    Examples
    --------
    >>> read_valve("calibrated").values["spring_rate"]
    52500.0
    """
    is_set = str(name_or_path) in valve_names()
    if is_set:
        name = str(name_or_path)
        path = _place_of(name)
    else:
        path = Path(name_or_path)
        name = path.stem
        if path.suffix == ".json":
            raise InputError("a valve is a set or a TOML file", f"got {path}", "give a model.json as --model")
        if path.suffix != ".toml" and not path.exists() and path.parent == Path():
            error = unknown_name("a valve", str(name_or_path), valve_names())
            raise InputError("a valve is a known set or a TOML file", error.arrived, error.remedy)
    text = _text(path)
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError("a valve file is TOML", f"{path}: {error}", "correct that line") from None
    return _Reader(name, path.name if is_set else str(path), text, content).valve()


def _place_of(name: str) -> Any:
    """Return where the file of a valve set is."""
    return resources.files("valvemodel.valves") / f"{name}.toml"


def _text(path: Any) -> str:
    try:
        return path.read_bytes().decode("utf-8-sig")
    except OSError as error:
        reason = error.strerror or "cannot be read"
        raise InputError("a valve file can be read", f"{path}: {reason}", "check the name and the folder") from None
    except UnicodeDecodeError as error:
        raise InputError("a valve file is in UTF-8", f"{path}: byte {error.start} is not", "save it as UTF-8") from None


class _Reader:
    """The content of one valve file, read entry by entry."""

    def __init__(self, name: str, source: str, text: str, content: dict[str, Any]) -> None:
        self.name, self.source, self.text = name, source, text
        self.what = content.pop("what", "")
        self.form = content.pop("equations", _FORMS[0])
        self.based_on = content.pop("based_on", None)
        self.content = content

    def valve(self) -> Valve:
        """Return the valve, or raise for the first entry that will not do."""
        if not isinstance(self.what, str):
            raise self._error("what", "'what' says in words what the valve is", f"it is {self.what!r}", "quote it")
        if self.form not in _FORMS:
            raise self._error(
                "equations", "equations are 'corrected' or 'as printed'", f"got {self.form!r}", "choose one"
            )
        entries = {key: self._entry(key, entry) for key, entry in self.content.items()}
        given = {key: self._si(key, entry) for key, entry in entries.items()}
        taken = self._taken(given)
        given |= {key: entry.value for key, entry in taken.items()}
        self._check_complete(given)
        values = {name: given.get(name, parameter.neutral) for name, parameter in _BASE.items()}
        for name in _RAW_OF:
            if name not in given and _RAW_OF[name][0] in given:
                values[name] = self._derived(name, given)
                form = f", {self.form} form" if name == "gap_gain" else ""
                entries[name] = Entry(values[name], _BASE[name].unit, _DERIVED_BY[name] + form, False)
        if values["travel_min"] >= values["travel_max"]:
            raise self._error(
                "travel_max",
                "travel_min is below travel_max",
                f"they are {values['travel_min']:g} m and {values['travel_max']:g} m",
                "correct one of them",
            )
        if "rated_travel" not in given and {"travel_min", "travel_max"} <= given.keys():
            span = values["travel_max"] - values["travel_min"]
            if math.isfinite(span):
                values["rated_travel"] = span
                entries["rated_travel"] = Entry(span, "m", "derived: travel_max less travel_min", False)
        entries |= taken
        for name, parameter in _BASE.items():
            if name not in entries:
                entries[name] = Entry(values[name], parameter.unit, _absence(name), False)
        return Valve(self.name, values, entries, self.what, self.source)

    def _taken(self, given: Mapping[str, float]) -> dict[str, Entry]:
        """Return the entries, in SI units, that are taken from the set that the file is based on: what it lacks.

        Of how the current makes the pressure all is taken or nothing.
        """
        if self.based_on is None:
            return {}
        if self.based_on not in valve_names():
            raise self._error(
                "based_on",
                "a file is based on a valve set",
                f"got {self.based_on!r}",
                f"choose {' or '.join(valve_names())}",
            )
        base = read_valve(self.based_on)
        own_pressure = any(name in given for name in (*_PRESSURE, *_RAW_UNITS))
        left_out = {*given, "rated_travel"} | (set(_PRESSURE) if own_pressure else set())
        return {
            name: Entry(value, _BASE[name].unit, f"not given: as in {self.based_on}", False)
            for name, value in base.values.items()
            if name not in left_out and math.isfinite(value)
        }

    def _entry(self, key: str, entry: Any) -> Entry:
        known = [*_BASE, *_RAW_UNITS]
        if key not in known:
            raise self._unknown(key, known)
        if not isinstance(entry, Mapping):
            raise self._error(key, _REMEDY, f"it is {entry!r}", f"write a table [{key}] with value, unit and source")
        for part in entry:
            if part not in ("value", "unit", "source"):
                raise self._error(key, _REMEDY, f"it has {part!r}", "rename or delete it")
        for part, example in (("value", "= 1.5"), ("unit", '= "mm"'), ("source", '= "data sheet"')):
            if part not in entry:
                raise self._error(key, _REMEDY, f"it has no {part}", f"add {part} {example}")
        value, unit, source = entry["value"], entry["unit"], entry["source"]
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self._error(key, "a value is a number", f"it is {value!r}", "write it without quotes")
        if not isinstance(unit, str):
            raise self._error(key, "a unit is a text", f"it is {unit!r}", 'write unit = "1" where there is none')
        if not isinstance(source, str) or not source.strip():
            raise self._error(key, _REMEDY, f"its source is {source!r}", "say where the value comes from")
        return Entry(float(value), unit, source)

    def _si(self, key: str, entry: Entry) -> float:
        dimension = _BASE[key].unit if key in _BASE else _RAW_UNITS[key]
        try:
            value = float(to_si(entry.value, entry.unit or "1", "" if dimension == "1" else dimension))
        except InputError as error:
            raise self._error(key, error.rule, error.arrived, error.remedy) from None
        shown = f"it is {entry.value:g} {entry.unit}"
        if not math.isfinite(value) and (math.isnan(value) or not key.startswith("travel_")):
            raise self._error(key, "a value is finite", shown, "correct it, or leave the entry out")
        if key in _POSITIVE and value <= 0:
            raise self._error(key, f"{key} is above zero", shown, "correct it")
        if key in _NOT_NEGATIVE and value < 0:
            raise self._error(key, f"{key} is not negative", shown, "correct it")
        if key == "ansatz_exponent" and value != 2:
            raise self._error(
                key,
                "the gap follows the root of the current, so the ansatz exponent is 2",
                shown,
                "give gap_offset and gap_gain instead",
            )
        return value

    def _check_complete(self, given: Mapping[str, float]) -> None:
        missing = [name for name in _NEEDED if name not in given]
        is_affine = given.get("pressure_per_current", 0) > 0
        for name, raws in _RAW_OF.items():
            there = [raw for raw in raws if raw in given]
            own = [raw for raw in there if raw != "leakage_coefficient"]
            if name in given and own:
                raise self._error(
                    own[0],
                    f"{name} is given or derived, not both",
                    f"there are {name} and {own[0]}",
                    f"delete {name}, or {', '.join(own)}",
                )
            if name in given or (is_affine and not own):
                continue
            missing += [raw for raw in raws if raw not in given] if own else [name]
        if missing:
            raise InputError(
                "a valve has all numbers of the base model",
                f"{self.source} lacks {', '.join(dict.fromkeys(missing))}",
                f"add a table for each, like [{missing[0]}]; {_REMEDY}; "
                'or write based_on = "calibrated" on top, to take from there what a data sheet lacks',
            )

    def _derived(self, name: str, given: Mapping[str, float]) -> float:
        function = _DERIVATIONS[name, self.form]
        return float(function(**{raw: given[raw] for raw in _RAW_OF[name]}))

    def _unknown(self, key: str, known: list[str]) -> InputError:
        if key.startswith("static_friction"):
            remedy = "static friction above Coulomb friction is an effect: --effect static_friction"
        elif nearest := difflib.get_close_matches(key, known, n=1, cutoff=0.5):
            remedy = f"did you mean {nearest[0]}?"
        else:
            remedy = f"known: {', '.join(known)}"
        return self._error(key, "an entry is one of the known ones", f"got {key!r}", remedy)

    def _error(self, key: str, rule: str, arrived: str, remedy: str) -> InputError:
        match = re.search(
            rf"^[ \t]*(?:\[\s*\"?{re.escape(key)}\"?\s*\]|\"?{re.escape(key)}\"?\s*[=.])", self.text, re.M
        )
        line = f", line {self.text.count(chr(10), 0, match.start()) + 1}" if match else ""
        return InputError(rule, f"{self.source}{line}, {key}: {arrived}", remedy)


def valve_text(name: str) -> str:
    """Return the file of a valve set, a form to fill in for a valve of one's own.

    Raises
    ------
    InputError
        If there is no such set.
    """
    if name not in valve_names():
        raise unknown_name("a valve set", name, valve_names())
    return _text(_place_of(name))


def _absence(name: str) -> str:
    if name in _RAW_OF:
        return "not given: unused beside the straight current-pressure line"
    if name in ("pressure_at_zero_current", "pressure_per_current"):
        return "not given: pressure follows eqs. (16), (31)"
    if name == "rated_travel":
        return "not given: the usual value"
    return "not given: none"
