"""When a row was read: before or after the current that stands in it has acted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from identification.determined.adequacy import adequate
from identification.experiment import Experiment, experiment_of
from identification.mending import mend
from identification.mending.lone_pressure import without_lone_pressure
from identification.noise import noise_level, reading_step
from valvemodel.records import Record

STEP_CURRENT = 2e-4
"""Smallest change of the current from row to row that counts as a step. [A]"""

STEP_OVER_RAMP = 8.0
"""A step is so many times the usual change from row to row."""

CALM_SHARE = 0.1
"""The current may have changed in the two rows before a step by this share of the step: the reading is still calm."""

CERTAINTY = 6.0
"""Standard errors by which readings must answer the current of their own row."""

BY_CHANCE = 0.1
"""Share of the steps, the one with the largest turn at least, that do not count: a stem that sticks may break away in
the row of a step by chance."""

FEWEST_STEPS = 3
"""Steps of the current from which a record tells when it was read."""

SAME_PACE = 1.5
"""Factor within which the rows of two records follow each other as fast."""

END_OF_PERIOD = "rows hold the state at the end of each period: readings answer the current of their own row"


def experiments_of(records: Sequence[Record], *, is_ramped: bool = False) -> tuple[list[Experiment], list[str]]:
    """Make experiments of one valve's records, and say where rows hold the state at a period's end, or are left out.

    A row that was read just before its current acts cannot know that current. Where readings at steps of the current
    answer it in the same row, a record is taken to be read at the end, and so are others at its pace and those that
    have too few steps to tell. `is_ramped` is about settled loops: their current ramps slowly from value to value,
    instead of stepping.

    Raises
    ------
    InputError
        If nothing can be fitted to any of them, or in one the stem moves before its current.
    """
    records, notes = without_lone_pressure(records)
    mended = [mend(record) for record in records]
    read_at_end = are_read_at_end([record for record, _ in mended])
    notes += [note for _, said in mended for note in said] + [END_OF_PERIOD] * any(read_at_end)
    experiments = [
        experiment_of(record, reads_at_end=reads_at_end, is_ramped=is_ramped)
        for (record, _), reads_at_end in zip(mended, read_at_end, strict=True)
    ]
    experiments, lacking = adequate(experiments)
    return experiments, notes + lacking


def are_read_at_end(records: Sequence[Record]) -> list[bool]:
    """Return of each record whether its rows hold the state at a period's end, as it or others of the valve tell.

    A logger that is slower than what drives the valve has rows in which the current moved on before them: it answers
    its own rows, and says nothing of a record at another pace.
    """
    paces = [record.interval for record in records if answers_own_row(record)]

    def is_alike(record: Record) -> bool:
        cannot_tell = len(steps_of(record)) < FEWEST_STEPS
        return cannot_tell or any(1.0 / SAME_PACE < record.interval / pace < SAME_PACE for pace in paces)

    return [bool(paces) and is_alike(record) for record in records]


def steps_of(record: Record) -> np.ndarray:
    """Return the rows at which the current steps after it was calm, shape (k,); none of a settled loop."""
    if record.time is None or record.current is None:
        return np.empty(0, int)
    change = np.diff(record.current)
    size = np.abs(change)
    is_step = size > max(STEP_CURRENT, STEP_OVER_RAMP * float(np.median(size)))
    is_step[2:] &= np.maximum(size[1:-1], size[:-2]) < CALM_SHARE * size[2:]
    steps = np.flatnonzero(is_step) + 1
    return np.asarray(steps[steps >= 3])


def answers_own_row(record: Record) -> bool:
    """Return whether pressure or position turn with a step of the current in the very row of the step."""
    steps = steps_of(record)
    if len(steps) < FEWEST_STEPS:
        return False
    assert record.current is not None
    side = np.sign(record.current[steps] - record.current[steps - 1])
    for signal in (record.pressure, record.position):
        if signal is None:
            continue
        turn = side * (signal[steps] - 2.0 * signal[steps - 1] + signal[steps - 2])
        rounding = reading_step(signal[np.isfinite(signal)]) / np.sqrt(12.0)
        known = np.sort(turn[np.isfinite(turn)])
        counts = known[: len(known) - max(1, round(BY_CHANCE * len(known)))]
        error = float(np.hypot(noise_level(signal), rounding)) * np.sqrt(6.0 / max(len(counts), 1))
        if len(counts) > 0 and float(np.mean(counts)) > CERTAINTY * error:
            return True
    return False
