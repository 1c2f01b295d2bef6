"""A sheet: the columns of a file as they stand there, before units and numbers are read."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import polars


@dataclass(frozen=True)
class Header:
    """The name of a column: as written, its plain name in lower case, and its unit or None."""

    text: str
    name: str
    unit: str | None


@dataclass(frozen=True)
class Sheet:
    """A file's columns, unread.

    Parameters
    ----------
    name : str
        The file, for messages.
    headers : tuple of Header
        One for each column.
    read : callable
        Takes column numbers and returns those columns, each a text or number series of equal length.
    place : callable
        Takes a row number from 0 and returns where it stands in the file, "line 12" or "row 11".
    notes : tuple of str
        How the file was read where that is not the plain form.
    separator : str or None
        What stands between columns, of a text file.
    form : str
        How name and unit of a column are written in such a file.
    """

    name: str
    headers: tuple[Header, ...]
    read: Callable[[list[int]], list[polars.Series]]
    place: Callable[[int], str]
    notes: tuple[str, ...] = ()
    separator: str | None = None
    form: str = "{name} [{unit}]"
