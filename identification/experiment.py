"""An experiment: one record made ready for simulation and comparison."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from itertools import accumulate

import numpy as np

from identification.cores import in_parts
from identification.noise import flicker_level, noise_level
from valvemodel import chain, loops, runs
from valvemodel.parameters import MEMORY, STATE, by_pressure, one_by_one
from valvemodel.periods import finer, passing
from valvemodel.records import Record
from valvemodel.stages.part import COARSE

SETTLING_TIME = 5.0
"""How long each current of a settled loop is held. [s]"""

BLOCK_TIME = 3.0
"""Length of the blocks in time that are fitted or held out. [s]"""

ANCHOR_INTERVAL = 2.0
"""Usual time between two anchors. [s]"""

ANCHOR_REACH = 3
"""Readings on either side that an anchor is the mean of."""

SPARSE = 0.5
"""Share of the rows with a reading below which those beside it are the next ones that were read."""

ANCHOR_TOLERANCE = 1.5
"""A run is put anew on an anchor from which it is off by more than this, far above the anchor's own error. [noise]"""

HALF_A_STEP = 0.5
"""Steps of a coarse reading within which a model is right."""

LEAST_LOOP_NOISE = 1e-4
"""Noise of a settled loop over its range, where its readings show less."""

NEAR_STEPS = 0.15
"""Distance from a grid, root mean square over its step, of readings that come in steps; of others it is twice that."""

BESIDE_STEPS = 2.0
"""Distance from a grid, root mean square, up to which readings lie on it: a stem that rests every so often does not.
[noise]"""

SAME_STEP = 0.25
"""Share of a step by which the level of readings that come in steps may move on the same one: they lie about a grid."""

LONGEST_STAY = 10
"""Samples as which the readings of a stay on one coarse step count at most: where the stem rests beside the edge of a
step, a hair decides on all of them, and a rest of seconds tells no more than one crossing."""

PERIODS_OF_BLOCK = 25
"""A block has at least so many samples."""


class _Own(threading.local):
    """What the runs of a thread remember, shape (1,), dtype MEMORY; each run overwrites it."""

    def __init__(self) -> None:
        self.memory = np.zeros(1, MEMORY)


_own = _Own()


@dataclass(frozen=True, eq=False)
class Experiment:
    """Held drives and what was measured.

    Attributes
    ----------
    name : str
    time : array, shape (n,) [s]
        From 0 on.
    current : array, shape (n,) [A]
        Held from each sample to the next.
    position : array, shape (n,) [m]
        NaN where nothing was measured.
    pressure : array, shape (n,) [Pa], or None
    noise, pressure_noise : float [m], [Pa]
        Of the readings, estimated from themselves.
    block : array of int, shape (n,)
        Number of the block in time that a sample belongs to.
    is_loop : bool
        Whether the time is made up: settled pairs without one.
    is_ramped : bool
        Whether the current of a loop ramps slowly from value to value, instead of stepping.
    reach : float [noise]
        Error of the position far beyond which a sample counts by the logarithm; infinite for plain squares.
    start : float [s]
        What the record's own time is at 0.
    reads_at_end : bool
        Whether a row of the record holds the state at its period's end: each reading stands a sample later here.
    parts : int
        Parts into which a period is divided where the current moves on, through it, to that of the next sample; 1 where
        it is held.
    late : float
        Share of a period by which a current that moves on comes later than its rows say, as one that is held for
        shorter periods does.
    sampling_error : float [m]
        By how much the readings hang on where a current that moves on was meanwhile, root mean square but for the
        largest tenth, as the fit tells it by which those that hang on it most were left out.
    current_noise, current_step : float [A]
        White noise that was taken out of the current, and the step to which it was rounded before; 0 where it is as it
        was recorded.
    """

    name: str
    time: np.ndarray
    current: np.ndarray
    position: np.ndarray
    pressure: np.ndarray | None
    noise: float
    pressure_noise: float
    block: np.ndarray
    is_loop: bool = False
    is_ramped: bool = False
    reach: float = math.inf
    start: float = 0.0
    reads_at_end: bool = False
    parts: int = 1
    late: float = 0.0
    sampling_error: float = 0.0
    current_noise: float = 0.0
    current_step: float = 0.0

    @property
    def period(self) -> float:
        """Usual time from one sample to the next. [s]"""
        return float(np.median(np.diff(self.time)))

    @property
    def record_time(self) -> np.ndarray:
        """Time as the record has it, shape (n,): what is told and drawn. [s]"""
        return self.start + self.time

    @cached_property
    def anchors(self) -> np.ndarray:
        """Readings at quiet instants some seconds apart, each the mean of a few, NaN elsewhere, shape (n,). [m]

        A run that is put anew there is judged by what it predicts over a short horizon: stick-slip loses its phase in a
        free run even where the model is right.
        """
        anchors = np.full(len(self.time), np.nan)
        width = 2 * ANCHOR_REACH + 1
        is_read = np.isfinite(self.position)
        rows = np.flatnonzero(is_read) if is_read.mean() < SPARSE else np.arange(len(anchors))
        if len(rows) <= width:
            return anchors
        windows = np.lib.stride_tricks.sliding_window_view(self.position[rows], width)
        spread, means = np.full(len(anchors), np.inf), np.full(len(anchors), np.nan)
        middles = rows[ANCHOR_REACH:-ANCHOR_REACH]
        spread[middles], means[middles] = windows.std(axis=1), windows.mean(axis=1)
        spread[~np.isfinite(spread)] = np.inf
        for number in range(1, int(self.time[-1] / ANCHOR_INTERVAL)):
            middle = number * ANCHOR_INTERVAL
            first, last = np.searchsorted(self.time, [middle - 0.4 * ANCHOR_INTERVAL, middle + 0.4 * ANCHOR_INTERVAL])
            if last <= first:
                continue
            quietest = first + int(np.argmin(spread[first:last]))
            if spread[quietest] < 2.0 * self.noise:
                anchors[quietest] = means[quietest]
        return anchors

    def is_same(self, other: Experiment) -> bool:
        """Return whether another holds the same samples: one that comes back from another process does."""
        own, others = ((each.time, each.current, each.position, each.parts, each.late) for each in (self, other))
        return self is other or all(map(partial(np.array_equal, equal_nan=True), own, others))

    @cached_property
    def drive(self) -> tuple[np.ndarray, np.ndarray]:
        """Times and held currents that a run takes, both of shape ((n - 1) parts + 1,). [s], [A]"""
        return finer(self.time, self.parts), self.moving(self.current)

    def moving(self, signal: np.ndarray) -> np.ndarray:
        """Return a signal, shape (n,), as a run takes it: itself where it is held, else through each period."""
        return signal if self.parts == 1 else np.maximum(passing(signal, self.parts, self.late), 0.0)

    def held_from(self, signal: np.ndarray) -> np.ndarray:
        """Return what drives a run, shape (..., n), where a signal stands just before each sample, as pressure does."""
        return np.concatenate([signal[..., 1:], signal[..., -1:]], axis=-1) if self.parts == 1 else signal

    def spread(self, values: np.ndarray) -> np.ndarray:
        """Return what stands at the samples, shape (n,), among the times of a run: NaN between them."""
        if self.parts == 1 or not len(values):
            return values
        among = np.full((len(self.time) - 1) * self.parts + 1, np.nan)
        among[:: self.parts] = values
        return among

    def stepping(self, current: np.ndarray) -> Experiment:
        """Return the same at the times of its run, with a current, shape ((n - 1) parts + 1,), held between those."""
        return replace(
            self,
            time=finer(self.time, self.parts),
            current=current,
            position=self.spread(self.position),
            pressure=None,
            block=np.zeros(len(current), int),
            parts=1,
            late=0.0,
        )

    @property
    def has_stairs(self) -> bool:
        """Whether the stem goes in stairs: an error far beyond the reach counts by the logarithm."""
        return math.isfinite(self.reach)

    @property
    def floor(self) -> float:
        """Error that the right model leaves: the noise, of which a coarse converter makes whole steps. [m]"""
        return max(self.noise, flicker_level(self.position))

    def comes_in_steps(self, step: float, offset: float) -> bool:
        """Return whether the readings lie about a grid of steps. [m]"""
        if step <= 0.0:
            return False
        places = (self.position[np.isfinite(self.position)] - offset) / step
        return float(np.std(places - np.round(places))) < min(NEAR_STEPS, BESIDE_STEPS * self.noise / step)

    def worth_in_steps(self, step: float) -> np.ndarray:
        """Return what each reading counts among those that come in steps, shape (n,), 1 in the mean; all alike in none.

        All stays on a step count alike, but for short ones. A flicker between two steps ends no stay.
        """
        return _worth_in_steps(self, step) if step > 0.0 else np.ones(len(self.time))

    def pressures_in(self, samples: np.ndarray) -> np.ndarray:
        """Return in which of some samples, a mask of shape (n,), the pressure was measured: in none without one."""
        return np.zeros(len(samples), bool) if self.pressure is None else samples & np.isfinite(self.pressure)

    def errors_of(self, simulated: Simulated, within: float = HALF_A_STEP) -> np.ndarray:
        """Return measured less simulated positions, shape (rows, n), as they count: squared and summed. [noise]

        A model that reads in coarse steps is right where it was within half a step of the reading, or so many steps.
        """
        errors = np.empty_like(simulated.smooth, order="C")
        self.fill_errors(errors, 0, simulated, np.arange(len(self.time)), within=within, lost=math.nan)
        return errors

    def fill_errors(
        self,
        errors: np.ndarray,
        first: int,
        simulated: Simulated,
        places: np.ndarray,
        *,
        lost: float,
        within: float = HALF_A_STEP,
    ) -> None:
        """Fill in errors as they count at some samples, from a column on; `lost` where one is no number. [noise]"""
        runs.errors_along(
            np.ascontiguousarray(simulated.smooth), self.position[places], places, self.noise,
            within * simulated.step, self.reach, lost, errors, first,
        )  # fmt: skip

    def beyond(self, simulated: Simulated, within: float = HALF_A_STEP) -> np.ndarray:
        """Return measured less simulated positions beyond so many steps of a coarse reading, shape (rows, n). [m]"""
        error = self.position - simulated.smooth
        if simulated.step > 0.0:
            error = np.copysign(np.maximum(np.abs(error) - within * simulated.step, 0.0), error)
        return error

    def tempered(self, error: np.ndarray) -> np.ndarray:
        """Return errors as they count: by their logarithm where the stem goes in stairs. [noise]"""
        if not self.has_stairs:
            return error
        return np.copysign(self.reach * np.sqrt(np.log1p((error / self.reach) ** 2)), error)

    @property
    def first_reading(self) -> float:
        """Median of the first readings: where a search for the start position begins. [m]"""
        return float(np.median(self.position[np.isfinite(self.position)][:5]))


def block_time_at(period: float) -> float:
    """Return the length of a block in time of a record that is sampled so often. [s]"""
    return max(BLOCK_TIME, PERIODS_OF_BLOCK * period)


def experiment_of(record: Record, *, reads_at_end: bool = False, is_ramped: bool = False) -> Experiment:
    """Make an experiment from a time record or a settled loop.

    Each current is held for a period. A row of a time record holds the state at the period's start, just before its
    current acts, or where `reads_at_end` at its end. A loop has no time: each current is held until the stem has
    settled, and the row holds the state at the end.
    """
    assert record.current is not None
    assert record.position is not None
    current = np.ascontiguousarray(record.current, float)
    position = np.ascontiguousarray(record.position, float)
    pressure = None if record.pressure is None else np.ascontiguousarray(record.pressure, float)
    if record.time is None:
        time = SETTLING_TIME * np.arange(len(current))
        noise = _noise_of_loop(position)
        pressure_noise = 0.0 if pressure is None else _noise_of_loop(pressure)
        period, block_time, start = SETTLING_TIME, 4.0 * SETTLING_TIME, 0.0
    else:
        start = float(record.time[0])
        time = np.ascontiguousarray(record.time - start, float)
        period = float(np.median(np.diff(time)))
        block_time = block_time_at(period)
        noise = noise_level(position)
        pressure_noise = 0.0 if pressure is None else noise_level(pressure)
    if reads_at_end or record.time is None:
        start -= period
        time = np.append(time, time[-1] + period)
        current = np.append(current, current[-1])
        position = np.insert(position, 0, np.nan)
        pressure = None if pressure is None else np.insert(pressure, 0, np.nan)
    block = (time // block_time).astype(int)
    is_loop = record.time is None
    return Experiment(
        record.name, time, current, position, pressure, noise, pressure_noise, block, is_loop, is_loop and is_ramped,
        start=start, reads_at_end=reads_at_end,
    )  # fmt: skip


def _noise_of_loop(signal: np.ndarray) -> float:
    return max(noise_level(signal), LEAST_LOOP_NOISE * float(np.ptp(signal)), 1e-9)


@lru_cache(maxsize=4)
def _worth_in_steps(experiment: Experiment, step: float) -> np.ndarray:
    def follow(level: float, reading: float) -> float:
        # As a play of one step does; by comparisons that a reading that is no number leaves as it is.
        return min(max(level, reading - 0.5 * step), reading + 0.5 * step)

    readings = experiment.position
    levels = np.fromiter(accumulate(readings, follow, initial=experiment.first_reading), float, len(readings) + 1)[1:]
    stay = np.cumsum(np.abs(np.diff(levels, prepend=levels[0])) > SAME_STEP * step)
    worth = np.minimum(LONGEST_STAY / np.bincount(stay)[stay], 1.0)
    return np.asarray(worth / worth.mean())


@dataclass(frozen=True, eq=False)
class Simulated:
    """Rows of numbers run over one experiment; arrays of shape (rows, n).

    Attributes
    ----------
    position : array [m]
        As it is read.
    pressure, mode : arrays [Pa], -1 falling 0 stuck 1 rising
    step : float
        Of a reading that comes in coarse steps, else 0. [m]
    smooth : array [m]
        As it would be read without the steps.
    """

    position: np.ndarray
    pressure: np.ndarray
    mode: np.ndarray
    step: float
    smooth: np.ndarray


def shifted(run: Simulated, shift: np.ndarray) -> Simulated:
    """Return a run with its readings shifted by so much, shape (n,). [m]"""
    return replace(run, position=run.position + shift, smooth=run.smooth + shift)


def simulate_rows(
    experiment: Experiment,
    rows: np.ndarray,
    *,
    tolerance: float,
    anchors: np.ndarray = runs.FREE,
    with_pressure: bool = False,
    in_closed_form: bool = False,
) -> Simulated:
    """Run each row of numbers over an experiment, exactly or at a search's stated tolerance.

    Each step of a loop is settled in closed form where the model allows it, else its current is held for some seconds.
    Rows with the same pressures share them in a search, laid as the first of them needs it.
    """
    if experiment.is_loop and in_closed_form:
        return _settled(experiment, rows)
    time, drive = experiment.drive
    anchors = experiment.spread(anchors)
    shape = (len(rows), len(time))
    smooth = np.empty(shape)
    noted = shape if with_pressure else (len(rows), 0)
    pressure, mode = np.empty(noted), np.empty(noted)
    step, offset = _without_steps(experiment, rows)
    order, follows = by_pressure(rows) if tolerance >= COARSE else one_by_one(len(rows))
    states, firsts = np.zeros(len(rows), STATE), np.append(np.flatnonzero(~follows), len(rows))

    def run(groups: slice) -> None:
        turns = slice(firsts[groups.start], firsts[groups.stop])
        runs.run_in_order(
            rows, states, _own.memory, time, drive, anchors, chain.CURRENT, tolerance,
            smooth, pressure, mode, order[turns], follows[turns],
        )  # fmt: skip

    in_parts(run, len(firsts) - 1)
    if experiment.parts > 1:
        smooth, pressure, mode = (each[:, :: experiment.parts] for each in (smooth, pressure, mode))
    position = smooth if step == 0.0 else offset + step * np.floor((smooth - offset) / step + 0.5)
    return Simulated(position, pressure, mode, step, smooth)


def are_loops(experiments: Sequence[Experiment]) -> bool:
    """Return whether all experiments are settled loops, which show nothing that acts in time."""
    return all(experiment.is_loop for experiment in experiments)


def _without_steps(experiment: Experiment, rows: np.ndarray) -> tuple[float, float]:
    """Make rows of numbers ready to run, without the steps of a coarse reading that the record has as well.

    Returns the step, 0 where the record has no such steps, and a reading on its grid. [m] All rows of a search have the
    same, which no fit moves.
    """
    step, offset = float(rows["resolution"][0]), float(rows["resolution_offset"][0])
    if not experiment.comes_in_steps(step, offset):
        step = 0.0
    else:
        rows["resolution"] = 0.0
    rows["anchor_tolerance"] = ANCHOR_TOLERANCE * experiment.noise + HALF_A_STEP * step
    return step, offset


def _settled(experiment: Experiment, rows: np.ndarray) -> Simulated:
    """Settle each row of numbers along a loop; a row of the experiment holds where the current before it led."""
    shape = (len(rows), len(experiment.time))
    position, pressure, mode = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    found = [np.empty((len(rows), shape[1] - 1)) for _ in range(3)]
    loops.settle_rows(rows, np.zeros(1, STATE), experiment.current[:-1], experiment.is_ramped, *found)
    for whole, part in zip((position, pressure, mode), found, strict=True):
        whole[:, 1:] = part
        whole[:, 0] = part[:, 0]
    return Simulated(position, pressure, mode, 0.0, position)


def score_rows(
    experiment: Experiment,
    used: np.ndarray,
    rows: np.ndarray,
    *,
    tolerance: float,
    anchors: np.ndarray = runs.FREE,
    in_closed_form: bool = False,
    within: float = HALF_A_STEP,
    most: np.ndarray | float = np.inf,
) -> np.ndarray:
    """Return the sum of the squared errors that count of each row of numbers, shape (rows,). [noise^2]

    Infinite where a run was not ended because it comes to more than `most`, of one or of all rows.
    """
    if experiment.is_loop and in_closed_form:
        return np.nansum(np.where(used, experiment.errors_of(_settled(experiment, rows)), np.nan) ** 2, axis=1)
    time, drive = experiment.drive
    anchors = experiment.spread(anchors)
    measured = experiment.spread(np.where(used, experiment.position, np.nan))
    sums, noise_square = np.empty(len(rows)), experiment.noise**2
    most = noise_square * np.asarray(most) * np.ones(len(rows))
    step, _ = _without_steps(experiment, rows)

    def score(part: slice) -> None:
        runs.score_rows(
            rows[part], np.zeros(1, STATE), _own.memory, time, drive, measured, within * step,
            experiment.reach * experiment.noise, anchors, chain.CURRENT, tolerance,
            np.empty(len(measured)), most[part], sums[part],
        )  # fmt: skip

    in_parts(score, len(rows))
    return sums / noise_square
