"""Reads a record from a file or a DataFrame: columns by name, numbers by unit, nothing guessed or repaired."""

from __future__ import annotations

import stat
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from valvemodel.errors import InputError
from valvemodel.quantities import is_unit_of
from valvemodel.records.checks import check_column, check_length, check_motion
from valvemodel.records.clock import first_form, with_dates
from valvemodel.records.column import Cells, Column, has_decimal_comma, read_column
from valvemodel.records.delimited import read_delimited
from valvemodel.records.doubts import doubts
from valvemodel.records.frame import read_frame
from valvemodel.records.header import (
    DIMENSIONS,
    find_columns,
    missing_column,
    not_there,
    read_called,
    unread_time,
    with_told_unit,
)
from valvemodel.records.matlab import read_matlab
from valvemodel.records.measurement import Measurement
from valvemodel.records.parquet import read_parquet
from valvemodel.records.record import Record
from valvemodel.records.sheet import Header, Sheet

if TYPE_CHECKING:
    import pandas

_LARGEST = 2 * 1024**3  # [bytes]: the cells of a text file take several times this in memory

_OTHER_KINDS = {
    b"PK\x03\x04": "an Excel workbook or a ZIP archive",
    b"\xd0\xcf\x11\xe0": "an old Excel workbook",
    b"\x1f\x8b": "packed with gzip",
    b"%PDF": "a PDF",
}


def read_record(
    source: str | Path | pandas.DataFrame,
    *,
    name: str | None = None,
    rated_travel: float | None = None,
    needs: tuple[str, ...] = ("current", "position"),
    allow_loop: bool = True,
    columns: Mapping[str, str] | None = None,
) -> Record:
    """Read a record from a CSV, Parquet or MAT file, or from a DataFrame of pandas.

    Columns are found by name and unit, `current [mA]`, in any order and case; others are ignored. `%` is of
    4..20 mA for current and of the rated travel for position. Where current is missing, `force` may stand in.

    Parameters
    ----------
    source : str, Path or DataFrame
        The file, or the table.
    name : str, optional
        What the record is called; by default the file's name without its suffix, or "table".
    rated_travel : float, optional
        Travel from 0 to 100 %, for positions in percent. Without it they stay fractions. [m]
    needs : tuple of str
        The columns that the purpose needs. Others that are there are read too; where "position" is not
        needed, a defect in them is a warning.
    allow_loop : bool
        Whether a record without time will do.
    columns : mapping of str to str, optional
        What columns are called in the file where that is not their name here, as
        `{"current": "Strom [mA]", "position [%]": "PV"}`; a unit that is told counts, not the file's.

    Returns
    -------
    Record
        Signals in SI units, shape (n,) each, with the warnings about them.

    Raises
    ------
    InputError
        If the file cannot be read or the record makes an answer meaningless; names line, column and value.

    Examples
    --------
    >>> record = read_record("valve.csv")  # doctest: +SKIP
    """
    called = read_called(columns or {})
    if isinstance(source, str | Path):
        path = Path(source)
        sheet, name, place = _open(path, called), name or path.stem, str(path)
    else:
        name, place = name or "table", None
        sheet = read_frame(source, name)
    read, warnings = _read(sheet, called, needs=needs, allow_loop=allow_loop)
    is_moving = "position" in needs
    measurement = Measurement(sheet, read)
    check_length(measurement, is_moving=is_moving)
    for each in tuple(read):
        try:
            check_column(measurement, each)
        except InputError as error:
            if _is_required(each, read, needs):
                raise
            warnings.append(_left_out(read.pop(each), error))
    if is_moving:
        check_motion(measurement)
    warnings += doubts(measurement, is_moving=is_moving)
    position = read.get("position")
    in_percent = position is not None and position.is_percent
    signals = {each: column.values for each, column in read.items()}
    if in_percent and rated_travel is not None:
        signals["position"] = signals["position"] * rated_travel
    elif in_percent and is_moving:
        warnings.append("position stays in percent: the valve's rated travel is not known")
    return Record(
        name,
        place,
        **signals,
        position_unit="%" if in_percent and rated_travel is None else "m",
        warnings=tuple(warnings),
    )


def _open(path: Path, called: Mapping[str, Header]) -> Sheet:
    content = _load(path)
    name = path.name
    for magic, what in _OTHER_KINDS.items():
        if content.startswith(magic):
            raise InputError("a record is CSV, Parquet or MAT", f"{name} is {what}", "export or unpack it as CSV")
    suffix = path.suffix.lower()
    if content.startswith(b"PAR1") or suffix in (".parquet", ".pq"):
        return read_parquet(content, name)
    if content.startswith((b"MATLAB", b"\x89HDF")) or suffix == ".mat":
        return read_matlab(content, name)
    return read_delimited(content, name, called)


def _load(path: Path) -> bytes:
    rule = "a record is a file that can be read"
    try:
        status = path.stat()
        if stat.S_ISDIR(status.st_mode):
            raise InputError(rule, f"{path} is a folder", "name a file in it")
        if stat.S_ISCHR(status.st_mode) or stat.S_ISBLK(status.st_mode):
            raise InputError(rule, f"{path} is a device", "name a file")
        if status.st_size > _LARGEST:
            size = f"{status.st_size / 1024**3:.1f} GiB"
            raise InputError(
                "a record is at most 2 GiB",
                f"{path} has {size}",
                "cut it, or export it as Parquet with fewer rows",
            )
        content = path.read_bytes()
    except InputError:  # a ValueError too
        raise
    except FileNotFoundError:
        raise InputError(rule, f"{path} does not exist", "check the name and the folder") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(rule, f"{path}: {reason}", "check the name and the permissions") from None
    if not content.strip():
        raise InputError("a record has a line of column names and rows", f"{path} is empty", "export it again")
    return content


def _read(
    sheet: Sheet, called: Mapping[str, Header], *, needs: tuple[str, ...], allow_loop: bool
) -> tuple[dict[str, Column], list[str]]:
    """Return the columns in SI units, and what is to be said about how they were read."""
    found = find_columns(sheet.headers, called)
    if absent := [own for name, own in called.items() if name not in found]:
        raise not_there(absent[0], sheet)
    required = list(needs)
    if "current" in needs and "position" in needs and "current" not in found and "force" in found:
        required[required.index("current")] = "force"
    if not allow_loop and "time" not in required:
        required.insert(0, "time")
    if missing := [name for name in required if name not in found]:
        raise missing_column(missing, found, sheet)
    if "time" not in found and "current" in found:
        _check_no_times(sheet, found)
    names = [name for name in DIMENSIONS if name in found]
    numbers = [found[name][0] for name in names]
    cells = [
        Cells(name, with_told_unit(sheet.headers[number], called.get(name)), series, sheet)
        for name, number, series in zip(names, numbers, sheet.read(numbers), strict=True)
    ]
    cells = [_dated(each, sheet) if each.name == "time" else each for each in cells]
    has_comma = has_decimal_comma(cells)
    warnings = _notes(sheet, has_comma=has_comma)
    columns = {}
    for one in cells:
        try:
            _check_is_single(one, found[one.name])
            columns[one.name] = read_column(one, has_decimal_comma=has_comma)
        except InputError as error:
            if _is_required(one.name, found, needs):
                raise
            warnings.append(_left_out(one, error))
        else:
            warnings += columns[one.name].notes
    return columns, warnings


def _dated(times: Cells, sheet: Sheet) -> Cells:
    """Return times of day with the dates of a column `date`, if there is one: midnight does not start them anew."""
    number = next((number for number, header in enumerate(sheet.headers) if header.name == "date"), None)
    together = None if number is None else with_dates(times.series, sheet.read([number])[0])
    return times if together is None else replace(times, series=together)


def _check_no_times(sheet: Sheet, found: dict[str, list[int]]) -> None:
    """Refuse a record without a column of times whose times stand under another name."""
    read = {number for numbers in found.values() for number in numbers}
    unread = [number for number in range(len(sheet.headers)) if number not in read]
    for number, series in zip(unread, sheet.read(unread), strict=True):
        header = sheet.headers[number]
        if (header.unit and is_unit_of(header.unit, DIMENSIONS["time"])) or first_form(series):
            raise unread_time(header, sheet)


def _is_required(name: str, found: dict, needs: tuple[str, ...]) -> bool:
    """Return whether a defect of a column makes the answer meaningless."""
    if name in needs or name == "time":
        return True
    return "position" in needs and (name != "force" or "current" not in found)


def _check_is_single(cells: Cells, numbers: list[int]) -> None:
    if len(numbers) > 1:
        texts = " and ".join(repr(cells.sheet.headers[number].text) for number in numbers)
        raise InputError(
            f"there is one column {cells.name}",
            f"{cells.sheet.name} has {texts}",
            "rename or delete all but one",
        )


def _left_out(column: Cells | Column, error: InputError) -> str:
    return f"column {column.header.text!r} is left out: {error.arrived}"


def _notes(sheet: Sheet, *, has_comma: bool) -> list[str]:
    notes = list(sheet.notes)
    if has_comma:
        decimal = "',' as decimal sign"
        if notes and notes[-1].endswith("between columns"):
            notes[-1] += f" and {decimal}"
        else:
            notes.append(f"read with {decimal}")
    return notes
