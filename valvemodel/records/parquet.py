"""Parquet files, with the same column names as text files."""

from __future__ import annotations

import io

import polars

from valvemodel.errors import InputError
from valvemodel.records.header import read_header
from valvemodel.records.sheet import Sheet


def read_parquet(content: bytes, name: str) -> Sheet:
    """Return the columns of a Parquet file.

    Raises
    ------
    InputError
        If the file is damaged.
    """
    try:
        frame = polars.read_parquet(io.BytesIO(content))
    except polars.exceptions.PolarsError as error:
        raise InputError(
            "a Parquet file is whole", f"{name}: {str(error).splitlines()[0]}", "export it again"
        ) from None
    return Sheet(
        name,
        tuple(read_header(column) for column in frame.columns),
        lambda numbers: [frame.to_series(number) for number in numbers],
        lambda row: f"row {row + 1}",
    )
