"""Rows that were filled in: readings that repeat the one before or lie straight between others were not measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from identification.noise import display_step, reading_step
from valvemodel.records import Record
from valvemodel.records.unbroken import unbroken

FILLED = 0.4
"""Share of the rows from which they count as filled in."""

ROUNDED_LINE = 2.5
"""Steps of a display by which rows on a straight line bend at most, as each of three is rounded."""

STANDS_OUT = 4.0
"""Measured rows bend by more than so many times that, as many of them as stand out from steps."""

ROUNDING = 1e-9
"""Share of the range that is taken for rounding."""

EXACT = 0.3
"""Share of the filled-in rows that change by no more than rounding, at least: those of a stem at rest have noise."""

LONGEST, EVEN, USUAL = 50, 3.0, 0.9
"""Measured rows are usually so many rows apart at most, and most of them no farther than so many times that: slips of a
stem that sticks come less often, and less evenly."""

STEPS, OFTEN = 1.5, 0.3
"""Such a share of the measured rows changes by more than so many steps of the readings: a coarse reading repeats itself
too, and changes by one step then."""

RUN, IN_RUNS = 3, 0.05
"""Of measured rows among filled-in ones at most such a share stand in runs of so many or more: where each row was
measured the stem's motion shows in all of them."""

REGULAR = 0.95
"""Share of the measured rows that are equally far apart, from which a slower logger was filled up."""


def without_filled_in(record: Record) -> tuple[Record, list[str]]:
    """Return a record without readings that were filled in, and say so.

    Exports fill a slower signal up to the rows of a faster one, by repeating what it was last or going straight. Where
    the current was filled up too, what is left is the slower record; else its rows stay, without those readings.
    """
    if record.time is None or record.current is None or record.position is None:
        return record, []
    is_measured = measured_rows(record.position)
    pressure = record.pressure
    of_pressure = np.ones(len(is_measured), bool) if pressure is None else measured_rows(pressure)
    if is_measured.all() and of_pressure.all():
        return record, []
    every, first = spacing(is_measured)
    if every > 1 and is_filled_up(record.current, every, first):
        return record.at_rows(slice(first, None, every)), [
            f"{record.name}: only every {every}th row was measured, the others repeat it or lie straight between two;"
            " only the measured ones count: export the rows as they were logged"
        ]
    known = replace(
        record,
        position=np.where(is_measured, record.position, np.nan),
        pressure=None if pressure is None else np.where(of_pressure, pressure, np.nan),
    )
    return known, [
        f"{record.name}: {1.0 - each.mean():.0%} of the rows of the {name} repeat the reading before or lie straight"
        " between two, as if filled in; they do not count: export the rows as they were logged"
        for name, each in (("position", is_measured), ("pressure", of_pressure))
        if not each.all()
    ]


def measured_rows(signal: np.ndarray) -> np.ndarray:
    """Return which rows of a signal were measured, shape (n,): all, unless most of the others tell nothing new."""
    if not np.isfinite(signal).all():
        return np.ones(len(signal), bool)
    rounding, steps = ROUNDING * float(np.ptp(signal)), STEPS * reading_step(signal)
    for order, slack in ((1, 0.0), (2, 0.0), (2, ROUNDED_LINE * display_step(signal))):
        change = np.abs(np.diff(signal, order))
        is_new = change > max(rounding, slack)
        if not 0.0 < is_new.mean() <= 1.0 - FILLED:
            continue
        is_exact = np.quantile(change[~is_new], EXACT) <= rounding
        stands_out = np.quantile(change[is_new], 1.0 - OFTEN) > max(steps, STANDS_OUT * slack)
        if is_exact and stands_out and _comes_evenly(is_new) and _stands_alone(is_new):
            return np.concatenate([[True], is_new, [True] * (order - 1)])
    return np.ones(len(signal), bool)


def _comes_evenly(is_new: np.ndarray) -> bool:
    gaps = np.diff(np.flatnonzero(is_new), prepend=0)
    middle, most = np.quantile(gaps, [0.5, USUAL])
    return bool(middle <= LONGEST and most <= EVEN * middle)


def _stands_alone(is_new: np.ndarray) -> bool:
    """Return whether hardly any new row is one of several in a row."""
    runs = np.ptp(unbroken(is_new), axis=1)
    return bool(runs[runs >= RUN].sum() <= IN_RUNS * is_new.sum())


def spacing(is_measured: np.ndarray) -> tuple[int, int]:
    """Return every how manieth row was measured and which was the first of them; 1 and 0 where that is irregular."""
    rows = np.flatnonzero(is_measured)
    every = int(np.median(np.diff(rows)))
    first = int(np.argmax(np.bincount(rows % every)))
    return (every, first) if np.mean(rows % every == first) >= REGULAR else (1, 0)


def is_filled_up(signal: np.ndarray, every: int, first: int) -> bool:
    """Return whether a signal is given by some of its rows: the others repeat them or lie straight between two."""
    rows, kept = np.arange(first, len(signal)), np.arange(first, len(signal), every)
    repeated = signal[first + (rows - first) // every * every]
    straight = np.interp(rows, kept, signal[kept])
    off = max(ROUNDED_LINE * display_step(signal), ROUNDING * float(np.ptp(signal)))
    is_before_last = rows <= kept[-1]
    return any(np.mean(np.abs(each - signal[rows])[is_before_last] <= off) >= REGULAR for each in (repeated, straight))
