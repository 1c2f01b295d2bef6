"""Force and position made fit for regression: low-pass, central differences, parallel decimation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from valvemodel.errors import InputError
from valvemodel.records.record import Record

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

CUTOFF_FREQUENCY = 100.0
"""Of the position filter in the EMPS benchmark, and at most a tenth of the sampling rate. [Hz]"""

FILTER_ORDER = 4
BORDERS_OF_CUTOFF = 5.0
"""Both ends are cut by this many periods of the cutoff, where filter and differences lack neighbours (50 ms
in EMPS)."""

NOISES_AT_REST = 4.0
"""A speed below this many standard deviations of its own noise has no sign."""

SHARE_AT_REST = 0.05
"""A decimated sample with more rest than this in its filter window is left out: friction has no value
there."""

FEWEST_ROWS = 100
FEWEST_ROWS_A_DIRECTION = 20
JITTER = 0.5
"""A time may lie this share of an interval off the regular grid (rounding of the file)."""


@dataclass(frozen=True)
class Preprocessing:
    """Filter and decimation; None where the sampling rate decides.

    Parameters
    ----------
    cutoff_frequency : float or None
        Of the fourth-order Butterworth low-pass on position, run forward and backward. [Hz]
        None: 100 Hz, at most a tenth of the sampling rate.
    factor : int or None
        Of the zero-phase decimation of the force and of every regressor. None: sampling rate over cutoff.

    References
    ----------
    EMPS benchmark (Janot, Gautier, Brunot), IDIM-LS: 100 Hz, factor 10, 50 samples cut. The decimation
    filter here is a finite one (linear phase, 20 taps a factor) where the benchmark's is a Chebyshev run
    both ways: a finite memory is what lets blocks in time be held out.
    """

    cutoff_frequency: float | None = None
    factor: int | None = None

    def __post_init__(self) -> None:
        if self.cutoff_frequency is not None and not self.cutoff_frequency > 0.0:
            raise InputError("the cutoff is positive", f"got {self.cutoff_frequency} Hz", "leave it out")
        if self.factor is not None and self.factor < 1:
            raise InputError("the decimation factor is 1 or more", f"got {self.factor}", "leave it out")


@dataclass(frozen=True, eq=False)
class StemSignals:
    """Signals of the stem at the full rate, borders cut, and the way to decimate any of them.

    Parameters
    ----------
    time, force, position, velocity, acceleration : array, shape (n,)
        Time since the start of the record [s], force along the position [N], filtered position [m] and its
        central differences [m/s], [m/s^2].
    direction : array, shape (n,)
        sign(v), and 0 where the speed is within its noise.
    interval : float
        [s]
    factor : int
        Of the decimation.
    cutoff_frequency : float
        [Hz]
    rest_speed : float
        Below this a speed has no sign. [m/s]
    position_noise : float
        Standard deviation of the reading, from what the low-pass takes away. [m]
    """

    time: Array
    force: Array
    position: Array
    velocity: Array
    acceleration: Array
    direction: Array
    interval: float
    factor: int
    cutoff_frequency: float
    rest_speed: float
    position_noise: float

    def decimate(self, column: Array) -> Array:
        """Return a full-rate column low-passed and thinned with no shift in time, rows at rest left out.

        Parameters
        ----------
        column : array, shape (n,)

        Returns
        -------
        array, shape (rows,)
        """
        return self._thin(column)[self._kept]

    @cached_property
    def rows(self) -> int:
        """The number of decimated samples in use."""
        return int(self._kept.sum())

    @cached_property
    def rows_left_out(self) -> int:
        """The number of decimated samples left out because the stem rests in them."""
        return int((~self._kept).sum())

    @cached_property
    def row_time(self) -> Array:
        """Time since the start of the record, shape (rows,). [s]"""
        return self.time[:: self.factor][self._kept]

    @cached_property
    def row_force(self) -> Array:
        """Decimated force, shape (rows,). [N]"""
        return self.decimate(self.force)

    @cached_property
    def row_interval(self) -> float:
        """[s]"""
        return self.interval * self.factor

    @cached_property
    def _kept(self) -> Mask:
        return self._thin((self.direction == 0.0).astype(np.float64)) <= SHARE_AT_REST

    def _thin(self, column: Array) -> Array:
        from scipy.signal import decimate

        if self.factor == 1:
            return np.asarray(column, dtype=np.float64)
        return decimate(column, self.factor, ftype="fir", zero_phase=True)


def prepare_signals(record: Record, preprocessing: Preprocessing | None = None) -> StemSignals:
    """Check a stem record and prepare its signals.

    Parameters
    ----------
    record : Record
        With time [s], force [N], position [m].
    preprocessing : Preprocessing, optional

    Returns
    -------
    StemSignals

    Raises
    ------
    InputError
        If a signal is missing, not finite or constant, the sampling is irregular, the record too short, the
        noise larger than the travel, the stem never moves, or moves one way only.
    """
    from scipy.signal import butter, filtfilt

    preprocessing = preprocessing or Preprocessing()
    time, force, position = _checked(record)
    interval = (time[-1] - time[0]) / (time.size - 1)
    rate = 1.0 / interval
    cutoff = preprocessing.cutoff_frequency or min(CUTOFF_FREQUENCY, rate / 10.0)
    if cutoff >= 0.5 * rate:
        raise InputError(
            "the cutoff lies below half the sampling rate",
            f"got {cutoff:g} Hz at {rate:g} Hz",
            "lower the cutoff",
        )
    factor = preprocessing.factor or max(1, math.floor(rate / cutoff + 1e-6))
    border = math.ceil(BORDERS_OF_CUTOFF / cutoff / interval)
    rows = (time.size - 2 * border) // factor
    if rows < FEWEST_ROWS:
        raise InputError(
            f"inverse dynamics takes at least {FEWEST_ROWS} samples after decimation",
            f"{record.name} has {max(rows, 0)} ({time.size} samples, factor {factor})",
            "record longer, or faster",
        )
    numerator, denominator = butter(FILTER_ORDER, cutoff / (0.5 * rate))
    smooth = filtfilt(numerator, denominator, position)
    noise = _position_noise(position - smooth, cutoff / (0.5 * rate))
    if np.ptp(smooth) <= 6.0 * noise or np.ptp(smooth) == 0.0:
        raise InputError(
            "the stem moves by more than the noise of its position",
            f"{record.name} moves {np.ptp(smooth):.3g} m with a noise of {noise:.3g} m",
            "record strokes both ways through a good part of the travel",
        )
    velocity = np.gradient(smooth, interval)
    acceleration = np.gradient(velocity, interval)
    rest_speed = NOISES_AT_REST * noise * 2.0 * math.pi * cutoff * math.sqrt(cutoff / (1.5 * rate))
    direction = np.where(np.abs(velocity) > rest_speed, np.sign(velocity), 0.0)
    inside = slice(border, time.size - border)
    signals = StemSignals(
        time=(time - time[0])[inside],
        force=force[inside],
        position=smooth[inside],
        velocity=velocity[inside],
        acceleration=acceleration[inside],
        direction=direction[inside],
        interval=float(interval),
        factor=factor,
        cutoff_frequency=float(cutoff),
        rest_speed=rest_speed,
        position_noise=noise,
    )
    _require_both_directions(record.name, signals)
    return signals


def _checked(record: Record) -> tuple[Array, Array, Array]:
    """Return time, force, position of a record, all finite, the time regular."""
    found = {"time": record.time, "force": record.force, "position": record.position}
    missing = [name for name, values in found.items() if values is None]
    if missing or record.time is None or record.force is None or record.position is None:
        raise InputError(
            "inverse dynamics takes time, force and position",
            f"{record.name} lacks {', '.join(missing)}",
            "add the column; force [N] is pressure times area where only the pressure was measured",
        )
    if record.position_unit != "m":
        raise InputError(
            "inverse dynamics takes position in a length",
            f"{record.name} has it in {record.position_unit}",
            "give the valve's rated_travel",
        )
    time, force, position = record.time, record.force, record.position
    for name, values in (("time", time), ("force", force), ("position", position)):
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            raise InputError(
                "every sample is a finite number",
                f"{name} of {record.name} has {values[bad[0]]} in sample {bad[0] + 1}",
                "cut or fill the gap",
            )
    if time.size < FEWEST_ROWS:
        raise InputError(
            f"inverse dynamics takes at least {FEWEST_ROWS} samples",
            f"{record.name} has {time.size}",
            "record longer, or faster",
        )
    _require_regular(record.name, time)
    for name, values in (("force", force), ("position", position)):
        if np.ptp(values) == 0.0:
            raise InputError(
                f"the {name} varies",
                f"it is {values[0]:g} throughout {record.name}",
                "record strokes both ways",
            )
    return time, force, position


def _require_regular(name: str, time: Array) -> None:
    grid = np.linspace(time[0], time[-1], time.size)
    interval = (time[-1] - time[0]) / (time.size - 1)
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if back.size:
        raise InputError(
            "time increases",
            f"sample {back[0] + 2} of {name} has {time[back[0] + 1]:g} s after {time[back[0]]:g} s",
            "sort the record or drop the sample",
        )
    off = np.abs(time - grid)
    if off.max() > JITTER * interval:
        step = int(np.argmax(np.diff(time)))
        raise InputError(
            "inverse dynamics differentiates twice and takes a regular sampling",
            f"{name} has {time[step + 1] - time[step]:g} s after sample {step + 1}, else {interval:g} s",
            "resample the record, or cut it at the gap",
        )


def _position_noise(rejected: Array, share: float) -> float:
    """Return the white noise of a reading from what a low-pass that keeps `share` of the band takes away. [m]

    The median keeps the few samples out where the motion itself is faster than the filter.
    """
    deviation = 1.4826 * float(np.median(np.abs(rejected - np.median(rejected))))
    return deviation / math.sqrt(max(1.0 - share, 0.1))


def _require_both_directions(name: str, signals: StemSignals) -> None:
    """Raise where the rows in motion cannot tell friction from a constant force."""
    if signals.rows < FEWEST_ROWS_A_DIRECTION:
        raise InputError(
            "the stem moves",
            f"{name} has {signals.rows} samples in motion, {signals.rows_left_out} at rest",
            "record strokes both ways through a good part of the travel",
        )
    sense = signals.decimate(signals.direction)
    for sign, word in ((1.0, "rising"), (-1.0, "falling")):
        rows = int((sign * sense > 0.5).sum())
        if rows < FEWEST_ROWS_A_DIRECTION:
            raise InputError(
                "friction is told from a constant force by motion both ways",
                f"{name} has {rows} samples {word}, {sense.size} in motion",
                "record strokes both ways",
            )
