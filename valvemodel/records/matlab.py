"""MATLAB files, whose variables carry their unit in the name: `current_mA`."""

from __future__ import annotations

import io
import re
from typing import Any

import numpy as np
import polars

from valvemodel.errors import InputError
from valvemodel.records.header import DIMENSIONS
from valvemodel.records.sheet import Header, Sheet

_PERCENT = ("percent", "pct", "prc")


def read_matlab(content: bytes, name: str) -> Sheet:
    """Return the vectors of a MAT file, up to version 7.

    Raises
    ------
    InputError
        If the file is damaged or of version 7.3, a variable is no vector of numbers, or lengths differ.
    """
    if content.startswith(b"\x89HDF") or b"MATLAB 7.3" in content[:128]:
        raise InputError("a MAT file is of version 7 or older", f"{name} is of version 7.3", "save it with -v7")
    from scipy.io import loadmat

    try:
        variables = loadmat(io.BytesIO(content))
    except Exception as error:
        # scipy raises its own error, and those of zlib, struct and NumPy, for damaged files
        raise InputError("a MAT file is whole", f"{name}: {error}", "save it again with -v7") from None
    variables = {key: value for key, value in variables.items() if not key.startswith("__")}
    headers = tuple(_header(key) for key in variables)
    vectors = list(variables.items())

    def read(numbers: list[int]) -> list[polars.Series]:
        columns = [_vector(*vectors[number], name) for number in numbers]
        if len({len(column) for column in columns}) > 1:
            lengths = ", ".join(f"{column.name} {len(column)}" for column in columns)
            raise InputError("the variables are equally long", f"{name}: {lengths}", "cut them to one length")
        return columns

    return Sheet(name, headers, read, lambda row: f"row {row + 1}", form="{name}_{unit}")


def _header(key: str) -> Header:
    match = re.fullmatch(rf"({'|'.join(DIMENSIONS)})_(\w+)", key, re.IGNORECASE)
    if not match:
        return Header(key, key.lower(), None)
    return Header(key, match[1].lower(), "%" if match[2].lower() in _PERCENT else match[2])


def _vector(key: str, value: Any, name: str) -> polars.Series:
    array = np.asarray(value)
    if array.dtype.kind not in "fiub" or array.size != max(array.shape, default=0):
        found = " x ".join(map(str, array.shape)) + f" of {array.dtype.name}"
        raise InputError("a variable is a vector of real numbers", f"{name}: {key} is {found}", "save vectors")
    return polars.Series(key, np.ascontiguousarray(array.ravel(), dtype=np.float64))
