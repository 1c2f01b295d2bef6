"""Cells to numbers: each cell of a column is a number, or the reader says where it is not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import polars

from valvemodel.errors import InputError
from valvemodel.quantities import scale_of
from valvemodel.records.clock import first_form, read_clock
from valvemodel.records.header import DIMENSIONS, missing_unit
from valvemodel.records.sheet import Header, Sheet

_NO_VALUE = {"nan", "na", "n/a", "#n/a", "null", "none", "-", "--", "bad", "no data", "#value!", "#num!"}


@dataclass(frozen=True)
class Column:
    """A read column: its numbers in the unit of the file and in SI units, shape (n,) each.

    `unit` is the file's; `is_percent` says that the SI numbers are fractions of the full range.
    """

    name: str
    header: Header
    given: npt.NDArray[np.float64]
    values: npt.NDArray[np.float64]
    unit: str
    is_percent: bool = False
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Cells:
    """The cells of a known column, unread."""

    name: str
    header: Header
    series: polars.Series
    sheet: Sheet

    def at(self, row: int) -> str:
        """Return file, place and column of a cell, for messages."""
        return f"{self.sheet.name}, {self.sheet.place(row)}, column {self.header.text!r}"


def read_column(cells: Cells, *, has_decimal_comma: bool) -> Column:
    """Read the cells of a column and convert them to SI units.

    Raises
    ------
    InputError
        If a cell is empty or no number, or the unit is missing, unknown or of something else.
    """
    if cells.name == "time" and (clock := _read_time_of_day(cells)):
        return clock
    if cells.header.unit is None:
        raise missing_unit(cells.name, cells.header, cells.sheet)
    scale = _scale(cells)
    given = _numbers(cells, has_decimal_comma=has_decimal_comma)
    values = given if scale == (1.0, 1.0) else given * scale[0] / scale[1]
    is_percent = cells.header.unit == "%"
    if is_percent and cells.name == "current":
        values = 4e-3 + given * 16e-3 / 100
    return Column(cells.name, cells.header, given, values, cells.header.unit, is_percent)


def has_decimal_comma(columns: list[Cells]) -> bool:
    """Return whether the numbers of a file are written with a decimal comma.

    Raises
    ------
    InputError
        If commas and points are both there; names the first cell of the rarer kind.
    """
    commas, points = 0, 0
    first: dict[str, tuple[int, Cells]] = {}
    for cells in columns:
        if cells.series.dtype != polars.String or (cells.name == "time" and first_form(cells.series)):
            continue
        has_comma = cells.series.str.contains(",", literal=True).fill_null(False)
        if not has_comma.any():
            points += int(cells.series.str.contains(".", literal=True).sum())
            first.setdefault(".", (0, cells))
            continue
        has_point = cells.series.str.contains(".", literal=True).fill_null(False)
        both = has_comma & has_point
        if both.any():
            row = int(both.arg_max() or 0)
            raise InputError(
                "a number has one decimal sign and nothing between thousands",
                f"{cells.at(row)}: {cells.series[row]!r}",
                "export the numbers without marks between thousands",
            )
        commas += int(has_comma.sum())
        points += int(has_point.sum())
        first.setdefault(",", (int(has_comma.arg_max() or 0), cells))
        if has_point.any():
            first["."] = (int(has_point.arg_max() or 0), cells)
    if commas and points:
        rarer = "," if commas < points else "."
        row, cells = first[rarer]
        if rarer == "." and "." not in (cells.series[row] or ""):
            row = int(cells.series.str.contains(".", literal=True).fill_null(False).arg_max() or 0)
        raise InputError(
            "a file has one decimal sign",
            f"{cells.at(row)}: {cells.series[row]!r}, while {max(commas, points)} other cells have"
            f" {'a point' if rarer == ',' else 'a comma'}",
            "export it with one decimal sign",
        )
    return commas > 0


def _scale(cells: Cells) -> tuple[float, float]:
    unit = cells.header.unit or ""
    if unit == "%":
        if cells.name in ("current", "position"):
            return 1.0, 100.0
        raise InputError(
            "percent is for current (of 4..20 mA) and position (of the rated travel)",
            f"{cells.sheet.name}: column {cells.header.text!r}",
            f"give it in {DIMENSIONS[cells.name]}",
        )
    try:
        return scale_of(unit, DIMENSIONS[cells.name])
    except InputError as error:
        raise InputError(
            error.rule, f"{cells.sheet.name}: column {cells.header.text!r}: {error.arrived}", error.remedy
        ) from None


def _numbers(cells: Cells, *, has_decimal_comma: bool) -> npt.NDArray[np.float64]:
    """Return the numbers of a column in the unit of the file."""
    series = cells.series
    if series.dtype == polars.String:
        series = series.str.replace(",", ".", literal=True) if has_decimal_comma else series
        numbers = series.cast(polars.Float64, strict=False)
        if numbers.null_count() > series.null_count():
            numbers = series.str.strip_chars().cast(polars.Float64, strict=False)
    elif series.dtype.is_numeric():
        numbers = series.cast(polars.Float64)
    else:
        raise InputError(
            "a column holds numbers",
            f"{cells.sheet.name}: column {cells.header.text!r} holds {series.dtype}",
            "export it as numbers",
        )
    values = numbers.to_numpy()
    is_bad = ~np.isfinite(values)
    if is_bad.any():
        raise _bad_cell(cells, np.flatnonzero(is_bad))
    return values


def _bad_cell(cells: Cells, rows: npt.NDArray[np.intp]) -> InputError:
    cell = cells.series[int(rows[0])]
    more = f" (and {rows.size - 1} more cells like it)" if rows.size > 1 else ""
    where = cells.at(int(rows[0]))
    drop = "drop these rows: where a few in a row are lost, that is bridged"
    if cell is None or str(cell).strip() == "":
        return InputError("each cell holds a number", f"{where}: the cell is empty{more}", drop)
    if isinstance(cell, float) or str(cell).strip().lower() in _NO_VALUE:
        return InputError("each cell holds a number", f"{where}: {str(cell)!r} is no value{more}", drop)
    if str(cell).strip().lower().lstrip("+-") in ("inf", "infinity"):
        return InputError("each cell holds a finite number", f"{where}: {cell!r}{more}", drop)
    remedy = "correct the cell or drop the row"
    if any(sign.isdigit() for sign in str(cell)) and any(sign.isalpha() for sign in str(cell)):
        remedy += "; a unit stands in the column's name only"
    return InputError("each cell holds a number", f"{where}: {str(cell)[:40]!r} is text{more}", remedy)


def _read_time_of_day(cells: Cells) -> Column | None:
    """Return the seconds since the first date and time, or None where time is a number."""
    notes: list[str] = []
    if isinstance(cells.series.dtype, polars.Datetime):
        nanoseconds = cells.series.dt.cast_time_unit("ns").cast(polars.Int64)
        form, has_seconds = "date and time", True
    elif form := first_form(cells.series) or "":
        texts = cells.series.str.strip_chars()
        where = f"{cells.sheet.name}: column {cells.header.text!r}"
        nanoseconds, has_seconds = read_clock(texts, form, where)
    else:
        return None
    if nanoseconds.null_count():
        rows = np.flatnonzero(nanoseconds.is_null().to_numpy())
        cell = cells.series[int(rows[0])]
        found = "the cell is empty" if cell is None else f"{cell!r} is none"
        raise InputError(
            f"each cell of the time column holds a {form} as the first one does",
            f"{cells.at(int(rows[0]))}: {found}",
            "correct the cell or drop the row",
        )
    if not has_seconds:
        notes.append("the times have no seconds")
    first = cells.series[0]
    notes.append(f"time read as {form}; 0 s is {first}")
    counts = nanoseconds.to_numpy()
    values = (counts - counts[0]) / 1e9 if counts.size else np.zeros(0)
    return Column("time", cells.header, values, values, "s", notes=tuple(notes))
