"""What is doubtful about a record though it can be worked with: each doubt is a sentence for the user."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from valvemodel.records.header import misspelt
from valvemodel.records.measurement import Measurement
from valvemodel.records.unbroken import unbroken

_GAP = 3.0  # times the median interval
_IRREGULAR = 0.2  # spread of the middle nine tenths of the intervals over their median
_SLOW, _FAST = 10.0, 1e-5  # [s]: median intervals beyond which the unit of time is doubtful
_SHORT, _SHORT_ROWS = 1.0, 20  # [s]: a record of more rows that ends sooner has a doubtful unit of time
_LIVE_ZERO, _LIVE_END = 3.8e-3, 20.5e-3  # [A]: the measuring range of NAMUR NE 43
_MANY_ROWS = 2_000_000
_COARSE_LEVELS = 50  # different readings over the whole range
_REPEATS = 5  # samples a reading, from which on it is the transmitter that repeats and not the record that is short
_AT_REST = 0.8  # share of the record within 2 % of the range
_CLIPPED = 0.01  # share of the record at one extreme value
_BAR_AT_MOST = 3e3  # [Pa]: 0.4..2.1 bar read as kPa stays below 3 kPa
_ABSOLUTE_FROM, _ABSOLUTE_TO = 95e3, 180e3  # [Pa]: atmosphere to atmosphere and a converter's lower end
_HALF_METRE = 0.5  # [mm]: a travel in metres in a column of millimetres
_AGAINST = -0.5  # correlation of position and input from which the valve is taken to act in reverse
_REVERSAL = 0.05  # of the range: smaller turns are not counted


def doubts(measurement: Measurement, *, is_moving: bool) -> list[str]:
    """Return the warnings about a record.

    Parameters
    ----------
    measurement : Measurement
        Columns that passed the checks.
    is_moving : bool
        Whether the record is to show how the valve moves, or is the input of a simulation.
    """
    columns = measurement.columns
    found = _names(measurement) + _length(measurement)
    if "time" in columns:
        found += _time(measurement, is_moving=is_moving)
    if "current" in columns:
        found += _current(measurement)
    if "pressure" in columns and is_moving:
        found += _pressure(measurement)
    if "position" in columns and is_moving:
        found += _position(measurement)
    if is_moving:
        for name in ("position", "pressure"):
            if name in columns:
                found += _reading(measurement, name)
        drive = "current" if "current" in columns else "force"
        found += _direction(measurement, drive)
        if drive == "current" and "position" in columns:
            found += _sense(measurement)
    return found


def _names(measurement: Measurement) -> list[str]:
    found = []
    for name in ("pressure", "position", "force"):
        if name in measurement.columns:
            continue
        others = tuple(header for header in measurement.sheet.headers if header.unit is not None)
        if nearest := misspelt(name, others):
            found.append(f"column {nearest!r} is not read; if it is the {name}, rename it")
    return found


def _length(measurement: Measurement) -> list[str]:
    if len(measurement) <= _MANY_ROWS:
        return []
    return [f"{len(measurement)} rows take long; a tenth of them may say as much"]


def _time(measurement: Measurement, *, is_moving: bool) -> list[str]:
    steps = np.diff(measurement.values("time"))
    median = float(np.median(steps))
    found = []
    unit = measurement.columns["time"].unit
    if median > _SLOW and is_moving:
        found.append(f"samples are {median:.4g} s apart: is time really in {unit}?")
    duration = float(np.ptp(measurement.values("time")))
    if median < _FAST:
        found.append(f"samples are {median:.3g} s apart: is time really in {unit}?")
    elif duration < _SHORT and len(measurement) > _SHORT_ROWS:
        found.append(f"the record lasts {duration:.3g} s; is the unit of time right?")
    gaps = np.flatnonzero(steps > _GAP * median * (1 + 1e-9))
    if gaps.size:
        row = int(gaps[0]) + 1
        share = float(np.sum(steps[gaps]) / np.sum(steps))
        found.append(
            f"{gaps.size} gap(s) in time, {share:.0%} of the record; the first before"
            f" {measurement.place(row)}: {measurement.given('time', row)} after"
            f" {measurement.given('time', row - 1)}"
        )
    whole = np.delete(steps, gaps)
    if is_moving and whole.size >= 10:
        low, high = np.quantile(whole, (0.05, 0.95))
        if high - low > _IRREGULAR * median:
            found.append(f"sampling is irregular: intervals from {low:.3g} to {high:.3g} s")
    return found


def _current(measurement: Measurement) -> list[str]:
    current = measurement.values("current")
    outside = np.flatnonzero((current < _LIVE_ZERO) | (current > _LIVE_END))
    found = []
    if outside.size:
        row = int(outside[0])
        found.append(
            f"current is outside 4..20 mA in {outside.size} row(s), the first at {measurement.place(row)}:"
            f" {measurement.given('current', row)}"
        )
    if measurement.columns["current"].is_percent and 0 < measurement.columns["current"].given.max() <= 1:
        found.append("current stays below 1 %: is it a fraction instead of percent?")
    return found


def _pressure(measurement: Measurement) -> list[str]:
    pressure = measurement.values("pressure")
    negative = np.flatnonzero(pressure < 0)
    found = []
    if negative.size:
        row = int(negative[0])
        found.append(
            f"gauge pressure is negative in {negative.size} row(s), the first at {measurement.place(row)}:"
            f" {measurement.given('pressure', row)}"
        )
    unit = measurement.columns["pressure"].unit
    if unit == "kPa" and 0 < pressure.max() < _BAR_AT_MOST:
        found.append(f"pressure stays below {pressure.max() / 1e3:.3g} kPa: is it in bar?")
    if "current" in measurement.columns:
        lowest = float(pressure.min())
        if _ABSOLUTE_FROM < lowest < _ABSOLUTE_TO and measurement.values("current").min() < 6e-3:
            found.append(
                f"pressure does not fall below {lowest / 1e3:.4g} kPa at low current: is it absolute? gauge is needed"
            )
    return found


def _position(measurement: Measurement) -> list[str]:
    column = measurement.columns["position"]
    found = []
    highest = float(np.max(np.abs(column.given)))
    if column.unit == "mm" and highest < _HALF_METRE:
        found.append(f"position stays below {highest:.3g} mm: is it in metres?")
    if column.is_percent and highest <= 1:
        found.append("position stays below 1 %: is it a fraction instead of percent?")
    counts, _ = np.histogram(column.given, bins=100)
    share = float(np.max(counts[:-1] + counts[1:])) / len(measurement)
    if share > _AT_REST:
        found.append(f"position is nearly unchanged over {share:.0%} of the record")
    return found


def _reading(measurement: Measurement, name: str) -> list[str]:
    given = measurement.columns[name].given
    levels = np.unique(given)
    found = []
    if levels.size < _COARSE_LEVELS and len(measurement) >= _REPEATS * levels.size:
        step = measurement.amount(name, float(np.median(np.diff(levels))))
        found.append(f"{name} is coarse: {levels.size} different readings, {step} apart")
    for what, extreme in (("highest", levels[-1]), ("lowest", levels[0])):
        share, is_quiet = _share_at(given, extreme)
        if share > _CLIPPED and not is_quiet:
            value = measurement.amount(name, float(extreme))
            found.append(f"{name} holds its {what} value {value} over {share:.0%} of the record: is it clipped?")
    return found


def _share_at(given: npt.NDArray[np.float64], extreme: float) -> tuple[float, bool]:
    """Return the share of samples at a value in runs of five or more, and whether others repeat too."""
    is_at = given == extreme
    runs = np.ptp(unbroken(is_at), axis=1)
    share = float(runs[runs >= 5].sum()) / given.size
    elsewhere = ~(is_at[1:] | is_at[:-1])
    repeats = np.diff(given) == 0
    is_quiet = not elsewhere.any() or float(np.mean(repeats[elsewhere])) > 0.3
    return share, is_quiet


def _direction(measurement: Measurement, name: str) -> list[str]:
    reversals = count_reversals(measurement.values(name))
    if reversals == 0:
        return [f"{name} runs one way only: friction and the zero of the spring cannot be told apart"]
    if reversals == 1:
        return [f"{name} turns only once: one loop says little about scatter"]
    return []


def _sense(measurement: Measurement) -> list[str]:
    current, position = measurement.values("current"), measurement.values("position")
    if min(np.ptp(current), np.ptp(position)) == 0.0 or np.corrcoef(current, position)[0, 1] > _AGAINST:
        return []
    end = "100 %" if measurement.columns["position"].is_percent else "the end of the travel"
    return [
        "position falls while current rises, and the model's stem rises: of a reverse-acting valve, count the position"
        f" from the other end ({end} less the reading)"
    ]


def count_reversals(values: npt.NDArray[np.float64]) -> int:
    """Return how often a signal, shape (n,), turns by more than a twentieth of its range.

    Examples
    --------
    >>> count_reversals(np.array([4.0, 12.0, 20.0, 12.0, 4.0, 12.0]))
    2
    """
    band = _REVERSAL * float(np.ptp(values))
    if band == 0:
        return 0
    # a turning point is where the sign of the steps changes; only those are walked through
    steps = np.sign(np.diff(values))
    moving = np.flatnonzero(steps)
    turns = moving[1:][steps[moving[1:]] != steps[moving[:-1]]]
    reversals, direction, extreme = 0, 0, float(values[0])
    for value in (*values[turns], values[-1]):
        if direction == 0:
            if abs(value - extreme) > band:
                direction, extreme = (1 if value > extreme else -1), float(value)
        elif (value - extreme) * direction > 0:
            extreme = float(value)
        elif (extreme - value) * direction > band:
            reversals, direction, extreme = reversals + 1, -direction, float(value)
    return reversals
