"""A pressure that only the record has which is kept back: no fit knows the supply, so it judges nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from valvemodel.records import Record


def without_lone_pressure(records: Sequence[Record]) -> tuple[list[Record], list[str]]:
    """Return records of one valve without the pressure of the last, which is scored on, where no other has one.

    Returns
    -------
    records : list of Record
    notes : list of str
        What is to be said of it.
    """
    *fitted, last = records
    if not fitted or last.pressure is None or any(record.pressure is not None for record in fitted):
        return list(records), []
    said = f"{last.name}: its pressure is not used, as no record that is fitted has one: give this record first"
    return [*fitted, replace(last, pressure=None)], [said]
