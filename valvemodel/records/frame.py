"""Tables of pandas, in and out; pandas itself is needed only where one is asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import polars

from valvemodel.errors import InputError
from valvemodel.records.header import DIMENSIONS, read_identifier
from valvemodel.records.sheet import Sheet

if TYPE_CHECKING:
    import pandas


def make_frame(columns: Mapping[str, Any], index: Sequence[str] | None = None) -> pandas.DataFrame:
    """Return a DataFrame of columns of equal length.

    Raises
    ------
    InputError
        If pandas is not installed.
    """
    try:
        import pandas
    except ImportError:
        raise InputError(
            "a table for pandas needs pandas", "it is not installed", "pip install 'valvemodel[notebooks]'"
        ) from None
    return pandas.DataFrame(dict(columns), index=index)


def read_frame(frame: pandas.DataFrame, name: str) -> Sheet:
    """Return the columns of a DataFrame, named like `current [mA]` or `current_mA`; so may its index be.

    Raises
    ------
    InputError
        If it is no DataFrame.
    """
    if not all(hasattr(frame, each) for each in ("columns", "index", "reset_index", "iloc")):
        arrived = f"got {type(frame).__name__}"
        raise InputError("a record is a file or a DataFrame of pandas", arrived, "pass a path, or the DataFrame")
    if read_identifier(str(frame.index.name)).name in DIMENSIONS:
        frame = frame.reset_index()
    return Sheet(
        name,
        tuple(read_identifier(str(column)) for column in frame.columns),
        lambda numbers: [_series(frame.iloc[:, number]) for number in numbers],
        lambda row: f"row {row + 1}",
    )


def _series(column: pandas.Series) -> polars.Series:
    """Return a column as numbers, instants or text."""
    name = str(column.name)
    if column.dtype.kind == "M":
        # In UTC no hour is missing or twice.
        instants = column if column.dt.tz is None else column.dt.tz_convert(None)
        return polars.Series(name, instants.to_numpy().astype("datetime64[ns]"))
    if column.dtype.kind in "iuf":
        return polars.Series(name, column.to_numpy(dtype=float, na_value=float("nan")))
    return polars.Series(name, [None if cell is None or cell != cell else str(cell) for cell in column])
