"""The steps in which a record is mended."""

from __future__ import annotations

from identification.mending.clocks import check_clocks
from identification.mending.dropouts import without_dropouts
from identification.mending.filled_in import without_filled_in
from identification.mending.row_times import evenly_timed, with_lost_rows
from identification.mending.spikes import without_spikes
from identification.mending.stretches import longest_stretch
from valvemodel.records import Record

STEPS = (without_filled_in, evenly_timed, without_spikes, without_dropouts, longest_stretch, with_lost_rows)
"""In their order; each returns the record as it is from then on, and says what it did."""


def mend(record: Record) -> tuple[Record, list[str]]:
    """Return a record without what was not measured or cannot be, and say what was left out or put right.

    Raises
    ------
    InputError
        If the stem moves before its current.
    """
    notes = []
    for step in STEPS:
        record, said = step(record)
        notes += said
    check_clocks(record)
    return record, notes
