"""Column names with their units: `current [mA]`, in any case, also with round brackets."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

from valvemodel.errors import InputError, unknown_name
from valvemodel.quantities import is_unit_of
from valvemodel.records.sheet import Header, Sheet

DIMENSIONS = {"time": "s", "current": "A", "pressure": "Pa", "position": "m", "force": "N"}
"""The columns that are known, each with its SI unit."""

USUAL = {"time": "s", "current": "mA", "pressure": "kPa", "position": "mm", "force": "N"}
"""The unit of the examples in messages."""

TIME_NAMES = ("timestamp", "datetime", "date time", "date/time", "date-time", "date_time", "time stamp")
"""Other names of a time column that holds dates and times of day."""

NOTHING: Mapping[str, Header] = {}
"""No column is called otherwise."""

_BRACKETED = re.compile(r"(.*?)\s*(?:\[([^\[\]]*)\]|\((.*)\))", re.DOTALL)


def read_header(text: str) -> Header:
    """Split a column's name from its unit.

    Examples
    --------
    >>> read_header(" Current (mA) ")
    Header(text='Current (mA)', name='current', unit='mA')
    """
    text = " ".join(text.split())
    match = _BRACKETED.fullmatch(text)
    if not match:
        return Header(text, text.lower(), None)
    unit = match[2] if match[2] is not None else match[3]
    return Header(text, match[1].strip().lower(), unit.strip() or None)


def read_identifier(text: str) -> Header:
    """Split a column's name from its unit, which may also stand behind an underscore as in `current_mA`."""
    header = read_header(text)
    name = _unbracketed(header.text) if header.unit is None else None
    return header if name is None else Header(header.text, name, _written_unit(name, header.text))


def read_called(columns: Mapping[str, str]) -> dict[str, Header]:
    """Return what known columns are called in a file, each with the unit that is told of it, or None.

    Raises
    ------
    InputError
        If a name is none of the known ones or comes twice, or a header does.

    Examples
    --------
    >>> read_called({"current [mA]": "OP"})
    {'current': Header(text='OP', name='op', unit='mA')}
    """
    called: dict[str, Header] = {}
    for told, text in columns.items():
        wanted, own = read_identifier(told), read_header(text)
        if wanted.name not in DIMENSIONS:
            raise unknown_name("a column", wanted.name, DIMENSIONS)
        if wanted.name in called:
            raise named_twice(wanted.name)
        if twin := next((name for name, other in called.items() if other.text.casefold() == own.text.casefold()), None):
            raise InputError("a column has one name", f"{own.text!r} came as {twin} and {wanted.name}", "leave one out")
        called[wanted.name] = replace(own, unit=wanted.unit)
    return called


def named_twice(name: str) -> InputError:
    """Make the error for a column of which it is told twice what it is called."""
    return InputError("a column is named once", f"{name} came twice", "name one header for it")


def find_columns(headers: Sequence[Header], called: Mapping[str, Header] = NOTHING) -> dict[str, list[int]]:
    """Return for each known name the numbers of the columns that carry it, or that are called what is told of it."""
    found: dict[str, list[int]] = {}
    for number, header in enumerate(headers):
        if name := known_name(header, called):
            found.setdefault(name, []).append(number)
    if "time" not in found and "time" not in called:
        stamps = [number for number, header in enumerate(headers) if header.name in TIME_NAMES]
        if stamps:
            found["time"] = stamps
    return found


def known_name(header: Header, called: Mapping[str, Header]) -> str | None:
    """Return the known name of a column: what is told of it, else its own unless another column is told to have it."""
    for name, own in called.items():
        if own.text.casefold() in (header.text.casefold(), header.name):
            return name
    written = header.name if header.name in DIMENSIONS else None
    if written is None and header.unit is None:
        written = _unbracketed(header.text)
    return None if written in called else written


def with_told_unit(header: Header, own: Header | None) -> Header:
    """Return a header with the unit that is told of its column, if any."""
    return header if own is None or own.unit is None else replace(header, unit=own.unit)


def not_there(own: Header, sheet: Sheet) -> InputError:
    """Make the error for a column that is told by a header which the file does not have."""
    nearest = difflib.get_close_matches(own.text, [header.text for header in sheet.headers], n=1)
    remedy = f"did you mean {nearest[0]!r}?" if nearest else "give the header as it stands in the file"
    return InputError("a column that is named is in the file", f"{own.text!r} is not: {_there(sheet)}", remedy)


def missing_column(names: Sequence[str], found: Mapping[str, list[int]], sheet: Sheet) -> InputError:
    """Make the error for columns that are needed and not there, with the nearest that are there.

    A column of times that is not read is named as well: the next thing to be missed.
    """
    headers = sheet.headers
    wanted = " and ".join(repr(sheet.form.format(name=name, unit=_unit_there(name, headers))) for name in names)
    what = "column" if len(names) == 1 else "columns"
    remedy = f"name the {what} {wanted}"
    meant = {name: nearest for name in ("time", *names) if name not in found and (nearest := likely(name, headers))}
    if meant:
        likely_ones = " and ".join(f"{text!r} is the {name}" for name, text in meant.items())
        remedy += f"; if {likely_ones}, rename {'it' if len(meant) == 1 else 'them'}, or give {_told(meant)}"
    if any("," in header.text or ";" in header.text or "\t" in header.text for header in headers):
        remedy += "; columns are separated by comma, semicolon or tab"
    return InputError(f"the record needs the {what} {wanted}", _there(sheet), remedy)


def likely(name: str, headers: Sequence[Header]) -> str | None:
    """Return the text of the column that is likely a known one: by its name, or as the only one in such a unit."""
    if nearest := misspelt(name, headers):
        return nearest
    unit = _unit_there(name, headers)
    alike = [header.text for header in _others(headers) if header.unit and is_alike(header.unit, unit)]
    return alike[0] if len(alike) == 1 else None


def is_alike(unit: str, other: str) -> bool:
    """Return whether two units measure the same, percent only itself."""
    return unit == other or (other != "%" and is_unit_of(unit, other))


def _unit_there(name: str, headers: Sequence[Header]) -> str:
    """Return the unit that a known column likely has: percent where that is all that unknown ones are in."""
    units = {header.unit for header in _others(headers) if header.unit}
    in_percent = name in ("current", "position") and "%" in units
    return "%" if in_percent and not any(is_unit_of(unit, DIMENSIONS[name]) for unit in units) else USUAL[name]


def _told(columns: Mapping[str, str]) -> str:
    """Return how one tells what columns are called, on the command line and in Python."""
    options = " ".join(f"--column '{name}={text}'" for name, text in columns.items())
    return f"{options} (columns= in Python)"


def _there(sheet: Sheet) -> str:
    return f"{sheet.name} has {', '.join(repr(header.text) for header in sheet.headers if header.text) or 'nothing'}"


def _others(headers: Sequence[Header]) -> list[Header]:
    """Return the columns that are not known."""
    return [
        header for header in headers if header.name and header.name not in DIMENSIONS and not _unbracketed(header.text)
    ]


def misspelt(name: str, headers: Sequence[Header]) -> str | None:
    """Return the text of the column that looks like a misspelling of a known name, if any."""
    others = {header.name: header.text for header in _others(headers)}
    nearest = difflib.get_close_matches(name, list(others), n=1, cutoff=0.75)
    return others[nearest[0]] if nearest else None


def unread_time(header: Header, sheet: Sheet) -> InputError:
    """Make the error for a column of times under a name that is not read, in a record that would pass for a loop."""
    name = "time" if header.unit is None else sheet.form.format(name="time", unit=header.unit)
    return InputError(
        "the column of times is called 'time'; without one the rows are pairs of a settled loop",
        f"{sheet.name}: column {header.text!r} holds times and is not read",
        f"rename it to {name!r}, or give {_told({'time': header.text})}; "
        "if the rows are pairs of a settled loop, delete the column",
    )


def missing_unit(name: str, header: Header, sheet: Sheet) -> InputError:
    """Make the error for a known column without a unit."""
    unit = _written_unit(name, header.text) or USUAL[name]
    rule = "ends with its unit in brackets" if "[" in sheet.form else "ends with its unit"
    return InputError(
        f"a column's name {rule} (units are read, not guessed)",
        f"{sheet.name}: column {header.text!r} has none",
        f"write it as {sheet.form.format(name=name, unit=unit)!r}, with the unit it is in",
    )


def _unbracketed(text: str) -> str | None:
    """Return the known name of a column like `current_mA` or `current / mA`."""
    for name in DIMENSIONS:
        if _written_unit(name, text):
            return name
    return None


def _written_unit(name: str, text: str) -> str | None:
    match = re.fullmatch(rf"{name}\s*[\s_/,:-]\s*(\S+)", text, re.IGNORECASE)
    return match[1] if match and (match[1] == "%" or is_unit_of(match[1], DIMENSIONS[name])) else None
