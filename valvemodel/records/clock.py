"""Dates and times of day, as ISO 8601, spreadsheets and historians write them; minutes and seconds of a stopwatch."""

from __future__ import annotations

import re

import numpy as np
import polars

from valvemodel.errors import InputError

_OF_DAY = (
    r"(?P<hour>\d{1,2}):(?P<minute>\d{2})(?::(?P<second>\d{2})(?:[.,](?P<fraction>\d{1,9})\d*)?)?"
    r"(?:\s*(?P<half>[AaPp])\.?[Mm]\.?)?"
)
_ZONE = r"(?:\s*(?:[Zz]|UTC|GMT|(?P<sign>[+-])(?P<zone_hour>\d{2}):?(?P<zone_minute>\d{2})?))?"
_DAY, _MONTH, _YEAR = r"(?P<day>\d{1,2})", r"(?P<month>\d{1,2})", r"(?P<year>\d{4})"
_EITHER = r"(?P<first>\d{1,2})[-/](?P<second_part>\d{1,2})"
_SHORT_YEAR = r"(?P<year>\d{2}(?:\d{2})?)"
_NAMED = rf"(?P<month_name>[A-Za-z]{{3}})[-\s]{_SHORT_YEAR}"
TIME_OF_DAY = "time of day"
_FORMS = {
    "ISO date and time": rf"{_YEAR}[-/.]{_MONTH}[-/.]{_DAY}[T\s]\s*{_OF_DAY}{_ZONE}",
    "day.month.year and time": rf"{_DAY}[.]{_MONTH}[.]{_SHORT_YEAR},?\s+{_OF_DAY}",
    "date with slashes and time": rf"{_EITHER}[-/]{_YEAR},?\s+{_OF_DAY}",
    "day-month name-year and time": rf"{_DAY}[-\s]{_NAMED}\s+{_OF_DAY}",
    TIME_OF_DAY: _OF_DAY,
    "minutes and seconds": r"(?P<minute>\d{1,3}):(?P<second>\d{2})[.,](?P<fraction>\d{1,9})\d*",
}
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")


def form_of(text: str) -> str | None:
    """Return in which form a text is a date and time of day, or None if it is none.

    Examples
    --------
    >>> form_of("01.03.2026 12:00:00,25")
    'day.month.year and time'
    """
    for form, pattern in _FORMS.items():
        if re.fullmatch(pattern, text, re.ASCII):
            return form
    return None


def with_dates(times: polars.Series, dates: polars.Series) -> polars.Series | None:
    """Return times of day with the dates of another column before them, or None where the two make no date and time."""
    if first_form(times) != TIME_OF_DAY:
        return None
    together = polars.select(polars.concat_str(dates.cast(polars.String), times, separator=" ")).to_series()
    form = first_form(together)
    return None if form in (None, TIME_OF_DAY) else together


def first_form(cells: polars.Series) -> str | None:
    """Return the form of the first cell's date and time of day, if it is one."""
    first = cells.drop_nulls().head(1)
    if first.dtype != polars.String or not len(first):
        return None
    return form_of(first[0].strip())


def read_clock(texts: polars.Series, form: str, where: str) -> tuple[polars.Series, bool]:
    """Return nanoseconds since some instant, null where a text is of another form.

    Parameters
    ----------
    texts : series of text, shape (n,)
        The cells of the time column.
    form : str
        The form of the first of them, from `form_of`.
    where : str
        Column and file, for messages.

    Returns
    -------
    nanoseconds : series of int64, shape (n,)
        [ns]
    has_seconds : bool
        Whether the cells have seconds at all.

    Raises
    ------
    InputError
        If day and month cannot be told apart and the record runs over more than one day.
    """
    pattern = "^" + _FORMS[form].replace(r"\d", "[0-9]") + "$"
    parts = texts.str.extract_groups(pattern).struct.unnest()
    matched = texts.str.contains(pattern) & parts["minute"].is_not_null()

    def number(name: str, missing: int = 0) -> polars.Series:
        if name not in parts.columns:
            return polars.Series(np.full(len(parts), missing, dtype=np.int64))
        return parts[name].cast(polars.Int64, strict=False).fill_null(missing)

    hour = number("hour")
    if "half" in parts.columns and parts["half"].is_not_null().any():
        hour = hour % 12 + 12 * (parts["half"].str.to_lowercase() == "p").fill_null(False).cast(polars.Int64)
    seconds = hour * 3600 + number("minute") * 60 + number("second")
    if "sign" in parts.columns:
        sign = (parts["sign"] == "-").fill_null(False).cast(polars.Int64) * 2 - 1
        seconds = seconds + sign * (number("zone_hour") * 3600 + number("zone_minute") * 60)
    seconds = seconds + _days(parts, form, where) * 86400
    nanoseconds = seconds * 1_000_000_000
    if "fraction" in parts.columns:
        nanoseconds = nanoseconds + parts["fraction"].fill_null("").str.pad_end(9, "0").cast(polars.Int64)
    nanoseconds = nanoseconds.zip_with(matched.fill_null(False), polars.Series([None], dtype=polars.Int64))
    return nanoseconds, bool(parts["second"].is_not_null().any())


def _days(parts: polars.DataFrame, form: str, where: str) -> polars.Series:
    """Return the number of each day, null where the date does not exist."""
    if "year" not in parts.columns:
        return polars.Series(np.zeros(len(parts), dtype=np.int64))
    columns = {name: parts[name].cast(polars.Int32, strict=False) for name in parts.columns if name in _DATE}
    if "month_name" in parts.columns:
        months = {name: number + 1 for number, name in enumerate(_MONTHS)}
        columns["month"] = (
            parts["month_name"].str.to_lowercase().replace_strict(months, default=None, return_dtype=polars.Int32)
        )
    columns["year"] = columns["year"] + 2000 * (columns["year"] < 100).cast(polars.Int32)
    if "first" in columns:
        columns["day"], columns["month"] = _ordered(columns["first"], columns["second_part"], where)
    frame = polars.DataFrame({name: columns[name] for name in ("year", "month", "day")})
    is_date = frame["month"].is_between(1, 12) & frame["day"].is_between(1, 31)
    text = frame.select(
        polars.format(
            "{}-{}-{}",
            *(
                polars.col(name).cast(polars.String).str.zfill(width)
                for name, width in (("year", 4), ("month", 2), ("day", 2))
            ),
        )
    ).to_series()
    days = text.str.to_date("%Y-%m-%d", strict=False).cast(polars.Int32).cast(polars.Int64)
    return days.zip_with(is_date.fill_null(False), polars.Series([None], dtype=polars.Int64))


_DATE = ("year", "month", "day", "first", "second_part")


def _ordered(first: polars.Series, second: polars.Series, where: str) -> tuple[polars.Series, polars.Series]:
    """Return day and month of dates with slashes."""
    if (first > 12).any():
        return first, second
    if (second > 12).any() or (first.n_unique() == 1 and second.n_unique() == 1):
        return second, first
    raise InputError(
        "day and month can be told apart",
        f"{where} has dates like {first[0]}/{second[0]}, over more than one day",
        "export the time as ISO 8601, like 2026-03-01 12:00:00.250",
    )
