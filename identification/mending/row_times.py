"""Times of rows: those that were rounded come evenly, and rows that were lost among them are put back."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from identification.mending.stretches import LOST_PERIODS
from identification.noise import display_step
from valvemodel.records import Record

COARSE = 0.02
"""Share of the usual interval from which the step of rounded times matters."""

EXACT, WITHIN = 0.05, 0.7
"""Parts of that step by which rounded times are off those of rows that come evenly, at least and at most."""

SEVERAL = 1.9
"""Usual intervals from which an interval lacks a row."""

ROUNDS = 2
"""How often the interval is found from the numbers of the rows, and these from it."""

RARE = 0.1
"""Share of the intervals up to which rows were lost; a logger that writes changes only has more."""


def evenly_timed(record: Record) -> tuple[Record, list[str]]:
    """Return a record with the times of rows that come evenly, where its own are these rounded, and say so."""
    if record.time is None or len(record.time) < 3:
        return record, []
    time, intervals = record.time, np.diff(record.time)
    step = display_step(time)
    if step < COARSE * np.median(intervals) or np.ptp(intervals) < EXACT * step:
        return record, []
    even = next((each for each in _even(time, intervals) if _is_rounded(time, each, step)), None)
    if even is None:
        return record, []
    period = float(np.median(np.diff(even)))
    return replace(record, time=even), [
        f"{record.name}: its times are rounded to {step:.3g} s; its rows come evenly, every {period:.4g} s, and are"
        " taken so: export the times with more digits"
    ]


def _is_rounded(time: np.ndarray, even: np.ndarray, step: float) -> bool:
    return bool(EXACT * step < np.abs(even - time).max() < WITHIN * step)


def _even(time: np.ndarray, intervals: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the times of rows that come evenly, nearest to their own: if none was lost, then as intervals tell. [s]"""
    numbers = np.arange(float(len(time)))
    yield np.polyval(np.polyfit(numbers, time, 1), numbers)
    period = float(np.mean(intervals[intervals < SEVERAL * np.median(intervals)]))
    for _ in range(ROUNDS):
        numbers = np.concatenate([[0.0], np.cumsum(np.maximum(np.round(intervals / period), 1.0))])
        line = np.polyfit(numbers, time, 1)
        yield np.polyval(line, numbers)
        period = float(line[0])


def with_lost_rows(record: Record) -> tuple[Record, list[str]]:
    """Return a record with rows where some were lost while the current moved: it goes straight, nothing was read."""
    if record.time is None or record.current is None or record.position is None or len(record.time) < 3:
        return record, []
    intervals = np.diff(record.time)
    periods = intervals / np.median(intervals)
    missing = np.round(periods).astype(int) - 1
    is_late = (missing > 0) & (missing < LOST_PERIODS) & (np.diff(record.current) != 0.0)
    is_lost = is_late & (periods > SEVERAL)
    if is_late.mean() > RARE or not is_lost.any():
        return record, []
    counts = np.where(is_lost, missing, 0) + 1
    places = np.concatenate([number + np.arange(count) / count for number, count in enumerate(counts)])
    places = np.append(places, len(record.time) - 1.0)
    rows, is_row = np.arange(len(record.time)), places == np.floor(places)

    def between(signal: np.ndarray) -> np.ndarray:
        return np.interp(places, rows, signal)

    def unread(signal: np.ndarray) -> np.ndarray:
        return np.where(is_row, signal[np.floor(places).astype(int)], np.nan)

    whole = replace(
        record,
        time=between(record.time),
        current=between(record.current),
        position=unread(record.position),
        pressure=None if record.pressure is None else unread(record.pressure),
    )
    return whole, [
        f"{record.name}: {missing[is_lost].sum()} row(s) were lost while the current moved, which is taken to have gone"
        " straight through them"
    ]
