"""Dropouts: a current far outside the live range for a few rows, which the stem does not answer, was not measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from identification.mending.spikes import LONGEST, RARE
from identification.noise import noise_level
from valvemodel.records import Record
from valvemodel.records.unbroken import unbroken

FAILED_BELOW, FAILED_ABOVE = 3.6e-3, 21.0e-3
"""Beyond these a signal tells a failure (NAMUR NE 43). [A]"""

BEFORE, ANSWERED_IN = 4, 2
"""Readings up to a dropout that tell where the stem goes, and rows after it within which a stem begins to answer."""

ANSWERED = 10.0
"""A stem has answered dropouts if half of them leave it aside by so many times the noise."""


def without_dropouts(record: Record) -> tuple[Record, list[str]]:
    """Return a record whose current stays as it was through dropouts of its measurement, and say so.

    Where the loop itself failed, the stem answers: such a current is what drove the valve.
    """
    if record.time is None or record.current is None or record.position is None:
        return record, []
    dropouts = dropouts_of(record.current)
    lost = np.zeros(len(record.current), bool)
    for first, end in dropouts:
        lost[first:end] = True
    if not 0.0 < lost.mean() <= RARE or is_answered(record.position, record.current, dropouts):
        return record, []
    current = record.current.copy()
    for first, end in dropouts:
        current[first:end] = current[first - 1]
    return replace(record, current=current), [
        f"{record.name}: the current fails in {lost.sum()} row(s) and the stem does not answer, the first at"
        f" {record.time[dropouts[0][0]]:g} s; it is taken to have stayed as it was: look for a loose contact"
    ]


def dropouts_of(current: np.ndarray) -> list[tuple[int, int]]:
    """Return the first row of each short failure of a current and the one behind it, between rows in which it lives."""
    has_failed = (current < FAILED_BELOW) | (current > FAILED_ABOVE)
    return [
        (int(first), int(end))
        for first, end in unbroken(has_failed)
        if first > 0 and end < len(current) and end - first <= LONGEST
    ]


def is_answered(position: np.ndarray, current: np.ndarray, dropouts: list[tuple[int, int]]) -> bool:
    """Return whether the stem leaves its way after dropouts of its current, to the side to which that went.

    Where no readings tell, it is taken to have.
    """
    aside = []
    for first, end in dropouts:
        rows = np.arange(first - BEFORE + 1, first + 1)
        if first < BEFORE or end + ANSWERED_IN > len(position) or not np.isfinite(position[rows]).all():
            continue
        behind = np.arange(first + 1, end + ANSWERED_IN)
        slope, at_first = np.polyfit(rows - first, position[rows], 1)
        left = position[behind] - (at_first + slope * (behind - first))
        aside.append(np.max(np.sign(current[first] - current[first - 1]) * left))
    known = np.array(aside)[np.isfinite(aside)]
    return not len(known) or float(np.median(known)) > ANSWERED * noise_level(position)
