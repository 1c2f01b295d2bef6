"""Many valves over one or many inputs, on all cores, in bounded memory."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from valvemodel import runs
from valvemodel.chain import CURRENT
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.parameters import MEMORY, PARAMETERS, STATE
from valvemodel.simulation import anchors_of, check_input
from valvemodel.trajectory import TOLERANCE

CHUNK = 64
"""Rows that a core takes at a time, so that an interrupt is heard soon."""


def rows_of(models: Sequence[Model]) -> np.ndarray:
    """Return the compiled rows of several models, shape (n,), dtype PARAMETERS."""
    return np.concatenate([model.rows() for model in models]) if models else np.empty(0, PARAMETERS)


def objectives(
    rows: np.ndarray,
    *,
    time: np.ndarray,
    current: np.ndarray,
    position: np.ndarray,
    reanchor: float | None = None,
    tolerance: float = TOLERANCE,
    workers: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> np.ndarray:
    """Return the sum of squared errors of every valve over every input; no trajectory is kept.

    Parameters
    ----------
    rows : array, shape (n,), dtype PARAMETERS
        From `Model.rows` or `rows_of`; columns may be changed at will.
    time : array, shape (m,), increasing [s]
    current : array, shape (m,) or (k, m) [A]
        One or many inputs.
    position : array, shape of `current` [m]
        Measured readings; NaN counts for nothing.
    reanchor : float
        Put each run on the measured reading every so often [s]; by default it runs free.
    tolerance : float
        As in `simulate`. [m]
    workers : int
        Threads; by default one for each core.
    progress : callable
        Called with the number of runs that have just been done.

    Returns
    -------
    array, shape (n,) or (k, n) [m^2]
    """
    time, currents, shape = _inputs(time, current)
    measured = np.ascontiguousarray(position, float)
    if measured.shape != np.shape(current):
        raise InputError("position has the shape of current", f"got {measured.shape}", "cut one")
    measured = measured.reshape(currents.shape)
    sums = np.empty((len(currents), len(rows)))

    def score(index: int, part: slice) -> None:
        some, anchors = rows[part], runs.FREE
        if reanchor is not None:
            anchors = anchors_of(time, measured[index], reanchor)
            some = some.copy()
            some["start_position"] = np.where(np.isnan(some["start_position"]), anchors[0], some["start_position"])
        runs.score_rows(
            some, np.zeros(1, STATE), np.zeros(1, MEMORY), time, currents[index], measured[index], 0.0, np.inf,
            anchors, CURRENT, tolerance, np.empty(len(time)), np.full(len(some), np.inf), sums[index, part],
        )  # fmt: skip

    _in_parallel(score, len(currents), len(rows), workers, progress)
    return sums.reshape((*shape, len(rows)))


def readings(
    rows: np.ndarray,
    *,
    time: np.ndarray,
    current: np.ndarray,
    tolerance: float = TOLERANCE,
    workers: int | None = None,
    at_once: int = 256,
) -> Iterator[tuple[slice, np.ndarray]]:
    """Yield the readings of every valve over one input, some valves at a time.

    Parameters
    ----------
    rows : array, shape (n,), dtype PARAMETERS
    time, current : arrays, shape (m,) [s], [A]
    at_once : int
        Valves whose readings are in memory together.

    Yields
    ------
    (slice, array)
        Which valves, and their readings, shape (valves, m). [m]
    """
    time, currents, _ = _inputs(time, current)
    for start in range(0, len(rows), at_once):
        some = rows[start : start + at_once]
        found = np.empty((len(some), len(time)))

        def run(
            _: int, part: slice, some: np.ndarray = some, found: np.ndarray = found, drive: np.ndarray = currents[0]
        ) -> None:
            runs.run_chain(
                some[part], np.zeros(len(some[part]), STATE), np.zeros(1, MEMORY), time, drive, runs.FREE,
                CURRENT, tolerance, found[part], runs.NONE, runs.NONE,
            )  # fmt: skip

        _in_parallel(run, 1, len(some), workers, None)
        yield slice(start, start + len(some)), found


def _inputs(time: np.ndarray, current: np.ndarray) -> tuple[np.ndarray, np.ndarray, tuple[int, ...]]:
    """Return time from 0, currents of shape (k, m), and the shape that the results have in front."""
    time = np.ascontiguousarray(time, float)
    currents = np.ascontiguousarray(np.atleast_2d(current), float)
    for one in currents:
        check_input(time, one)
    return time - time[0], currents, np.shape(current)[:-1]


def _in_parallel(
    work: Callable[[int, slice], None],
    inputs: int,
    rows: int,
    workers: int | None,
    progress: Callable[[int], None] | None,
) -> None:
    """Do the work of every input and chunk of rows in threads: compiled code runs without Python's lock."""
    tasks = [(index, slice(at, min(at + CHUNK, rows))) for index in range(inputs) for at in range(0, rows, CHUNK)]
    with ThreadPoolExecutor(workers or os.cpu_count()) as pool:
        try:
            for (_, part), _ in zip(tasks, pool.map(lambda task: work(*task), tasks), strict=True):
                if progress is not None:
                    progress(part.stop - part.start)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
