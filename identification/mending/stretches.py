"""Stretches: where a record lost rows while the valve moved, only its longest stretch without a loss can be run."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from identification.noise import noise_level
from valvemodel.records import Record

LOST_PERIODS = 5.0
"""Usual intervals from which an interval between two rows is a gap."""

MOVED = 10.0
"""Change of the position over a gap from which the valve has moved in it unseen. [noise]"""


def longest_stretch(record: Record) -> tuple[Record, list[str]]:
    """Return the longest stretch of a record in which no movement is lost, and say what was left out.

    A gap over which current or position stay is none: some loggers write a row only where something changes.
    """
    if record.time is None or record.current is None or record.position is None or len(record.time) < 3:
        return record, []
    intervals, moved = np.diff(record.time), np.abs(np.diff(record.position))
    is_lost = (intervals > LOST_PERIODS * np.median(intervals)) & (np.diff(record.current) != 0.0)
    is_lost &= ~(moved <= MOVED * noise_level(record.position))
    ends = np.flatnonzero(is_lost) + 1
    if not len(ends):
        return record, []
    edges = [0, *ends.tolist(), len(record.time)]
    first, last = max(pairwise(edges), key=lambda pair: pair[1] - pair[0])
    note = (
        f"{record.name}: the valve moved in {len(ends)} gap(s) of the record; only the longest stretch counts, "
        f"{record.time[first]:g} s to {record.time[last - 1]:g} s: give the others as records of their own"
    )
    return record.at_rows(slice(first, last)), [note]
