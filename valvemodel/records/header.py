"""Column names with their units: `current [mA]`, in any case, also with round brackets."""

from __future__ import annotations

import difflib
import re

from valvemodel.errors import InputError
from valvemodel.quantities import is_unit_of
from valvemodel.records.sheet import Header, Sheet

DIMENSIONS = {"time": "s", "current": "A", "pressure": "Pa", "position": "m", "force": "N"}
"""The columns that are known, each with its SI unit."""

USUAL = {"time": "s", "current": "mA", "pressure": "kPa", "position": "mm", "force": "N"}
"""The unit of the examples in messages."""

TIME_NAMES = ("timestamp", "datetime", "date time", "date/time", "date-time", "date_time", "time stamp")
"""Other names of a time column that holds dates and times of day."""

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


def find_columns(headers: tuple[Header, ...]) -> dict[str, list[int]]:
    """Return for each known name the numbers of the columns that carry it."""
    found: dict[str, list[int]] = {}
    for number, header in enumerate(headers):
        if header.name in DIMENSIONS:
            found.setdefault(header.name, []).append(number)
        elif header.unit is None and (name := _unbracketed(header.text)):
            found.setdefault(name, []).append(number)
    if "time" not in found:
        stamps = [number for number, header in enumerate(headers) if header.name in TIME_NAMES]
        if stamps:
            found["time"] = stamps
    return found


def missing_column(names: list[str], sheet: Sheet) -> InputError:
    """Make the error for columns that are needed and not there, with the nearest that is there."""
    headers = sheet.headers
    there = ", ".join(repr(header.text) for header in headers if header.text) or "nothing"
    wanted = " and ".join(repr(sheet.form.format(name=name, unit=USUAL[name])) for name in names)
    remedy = f"name the column {wanted}" if len(names) == 1 else f"name the columns {wanted}"
    for name in names:
        if nearest := misspelt(name, headers):
            remedy += f"; if {nearest!r} is meant, rename it"
    if any("," in header.text or ";" in header.text or "\t" in header.text for header in headers):
        remedy += "; columns are separated by comma, semicolon or tab"
    return InputError(f"the record needs the column {wanted}", f"{sheet.name} has {there}", remedy)


def misspelt(name: str, headers: tuple[Header, ...]) -> str | None:
    """Return the text of the column that looks like a misspelling of a known name, if any."""
    others = {
        header.name: header.text
        for header in headers
        if header.name and header.name not in DIMENSIONS and not _unbracketed(header.text)
    }
    nearest = difflib.get_close_matches(name, list(others), n=1, cutoff=0.75)
    return others[nearest[0]] if nearest else None


def unread_time(header: Header, sheet: Sheet) -> InputError:
    """Make the error for a column of times under a name that is not read, in a record that would pass for a loop."""
    name = "time" if header.unit is None else sheet.form.format(name="time", unit=header.unit)
    return InputError(
        "the column of times is called 'time'; without one the rows are pairs of a settled loop",
        f"{sheet.name}: column {header.text!r} holds times and is not read",
        f"rename it to {name!r}; if the rows are pairs of a settled loop, delete the column",
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
