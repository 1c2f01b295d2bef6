"""Writes tables of results: whole files with exact numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import polars

from valvemodel.files import write_beside
from valvemodel.quantities import scale_of
from valvemodel.records.header import DIMENSIONS, USUAL


def usual_columns(*, is_percent: bool = False, **signals: np.ndarray) -> dict[str, np.ndarray]:
    """Return signals as a file has them, by name with unit.

    Parameters
    ----------
    is_percent : bool
        Whether the position is a share of the rated travel.
    **signals : arrays, shape (n,)
        By the names of a record. [SI]
    """
    columns = {}
    for name, values in signals.items():
        if name == "position" and is_percent:
            columns["position [%]"] = 100.0 * values
            continue
        multiplier, divisor = scale_of(USUAL[name], DIMENSIONS[name])
        columns[f"{name} [{USUAL[name]}]"] = values * divisor / multiplier
    return columns


def write_table(path: str | Path, columns: Mapping[str, Any]) -> None:
    """Write columns as CSV, or as Parquet where the file's name ends so.

    Numbers are written with as many digits as it takes to read the same float64 back, and no more.

    Parameters
    ----------
    path : str or Path
        The file; it appears whole or not at all.
    columns : mapping of str to array or list of str
        Names with units, `time [s]`, and values of equal length, shape (n,) each.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    frame = polars.DataFrame([_series(name, values) for name, values in columns.items()])
    write_frame = frame.write_parquet if Path(path).suffix.lower() in (".parquet", ".pq") else frame.write_csv

    def write(file: BinaryIO) -> None:
        try:
            write_frame(file)
        except polars.exceptions.ComputeError as error:  # a full disk, where the table is Parquet
            raise OSError(str(error)) from None

    write_beside(Path(path), write)


def _series(name: str, values: np.ndarray | Sequence[Any]) -> polars.Series:
    if isinstance(values, np.ndarray) and values.dtype.kind in "fiu":
        return polars.Series(name, np.ascontiguousarray(values))
    return polars.Series(name, [str(value) if isinstance(value, str) else value for value in values])
