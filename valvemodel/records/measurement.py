"""A measurement: the read columns of a file with their place in it, for checks that name a cell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from valvemodel.records.column import Column
from valvemodel.records.sheet import Sheet


@dataclass(frozen=True)
class Measurement:
    """The columns of a record by name, each of shape (n,), and the sheet that they stand in."""

    sheet: Sheet
    columns: dict[str, Column]

    def __len__(self) -> int:
        return next(iter(self.columns.values())).values.size

    def values(self, name: str) -> npt.NDArray[np.float64]:
        """Return a column in SI units, shape (n,)."""
        return self.columns[name].values

    def at(self, name: str, row: int) -> str:
        """Return file, place and column of a cell."""
        return f"{self.sheet.name}, {self.sheet.place(row)}, column {self.columns[name].header.text!r}"

    def place(self, row: int) -> str:
        """Return the place of a row: "line 12" or "row 11"."""
        return self.sheet.place(row)

    def given(self, name: str, row: int) -> str:
        """Return the value of a cell with the file's unit."""
        return self.amount(name, float(self.columns[name].given[row]))

    def amount(self, name: str, value: float) -> str:
        """Return a value with the unit that the file has for the column."""
        return f"{value:.10g} {self.columns[name].unit}"
