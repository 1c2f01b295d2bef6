"""What makes an answer from a record meaningless: each check raises with cell, value and remedy."""

from __future__ import annotations

import numpy as np

from valvemodel.errors import InputError
from valvemodel.records.measurement import Measurement

LEAST_SAMPLES = 20
"""Fewer samples cannot show a stem stick and slip."""
LEAST_PAIRS = 6
"""A loop takes three currents each way, as the paper's eqs. (35), (36)."""
LEAST_INPUTS = 2
"""A simulation takes one held period."""

_AMPERES_AT_MOST = 0.05  # [mA]: a 20 mA signal in amperes is 0.02
_CURRENT_AT_MOST = 0.25  # [A]: ten times a current loop's full scale; Table 2 as printed needs 160 mA
_POSITION_AT_MOST = 10.0  # [m]: the bounds of the base valve's travel
_VACUUM = -101_325.0  # [Pa] gauge
_NOISE_ONLY = 0.7  # von Neumann's ratio over 2: 1 for white noise, near 0 for a signal that moves
_SMOOTH = 0.3
_DAY = 86400.0  # [s]
_LEAST_FOR_NOISE = 100


def check_length(measurement: Measurement, *, is_moving: bool) -> None:
    """Raise if the record is too short for its purpose."""
    kind, least = "samples", LEAST_SAMPLES
    if not is_moving:
        kind, least = "rows", LEAST_INPUTS
    elif "time" not in measurement.columns:
        kind, least = "pairs", LEAST_PAIRS
    if len(measurement) < least:
        raise InputError(
            f"a record of this kind has at least {least} {kind}",
            f"{measurement.sheet.name} has {len(measurement)}",
            "record for longer, or export all rows",
        )


def check_column(measurement: Measurement, name: str) -> None:
    """Raise if the values of a column are impossible."""
    if check := _CHECKS.get(name):
        check(measurement)


def check_motion(measurement: Measurement) -> None:
    """Raise if a signal that a fit needs is constant, or nothing moves."""
    for name in ("current", "force", "pressure"):
        if name in measurement.columns and np.ptp(measurement.values(name)) == 0:
            remedy = "delete the column or repair the transmitter" if name == "pressure" else _DRIVE
            raise InputError(
                f"{name} changes over a record",
                f"{measurement.sheet.name}: it is {measurement.given(name, 0)} in all {len(measurement)} rows",
                remedy,
            )
    if np.ptp(measurement.values("position")) == 0:
        raise InputError(
            "the stem moves in a record",
            f"{measurement.sheet.name}: position is {measurement.given('position', 0)} in all {len(measurement)} rows",
            f"check the position transmitter; {_DRIVE}",
        )
    _check_not_noise(measurement)


_DRIVE = "drive the valve up and down over at least a quarter of its travel and record that"


def _check_not_noise(measurement: Measurement) -> None:
    drive = "current" if "current" in measurement.columns else "force"
    if len(measurement) < _LEAST_FOR_NOISE or "time" not in measurement.columns:
        return
    position = measurement.values("position")
    if _roughness(position) > _NOISE_ONLY and _roughness(measurement.values(drive)) < _SMOOTH:
        spread = np.ptp(measurement.columns["position"].given)
        raise InputError(
            "the stem moves in a record",
            f"{measurement.sheet.name}: position is noise alone,"
            f" {measurement.amount('position', float(spread))} from lowest to highest",
            f"check the position transmitter; {_DRIVE}",
        )


def _roughness(values: np.ndarray) -> float:
    """Return the mean square of the differences over twice the variance: 1 for white noise."""
    variance = float(np.var(values))
    return float(np.mean(np.square(np.diff(values)))) / (2 * variance) if variance > 0 else 0.0


def _check_time(measurement: Measurement) -> None:
    steps = np.diff(measurement.values("time"))
    rows = np.flatnonzero(steps <= 0)
    if not rows.size:
        return
    row = int(rows[0]) + 1
    given = measurement.columns["time"].given
    more = f" (and {rows.size - 1} more times)" if rows.size > 1 else ""
    remedy = "sort the file or drop the row"
    if np.all(steps >= 0) and np.all(given == np.round(given)):
        remedy = "export the time with fractions of a second, or drop repeated rows"
    if abs(steps[row - 1] + _DAY) < _DAY / 10:
        remedy = "export the date with the time, which starts anew at midnight; else sort the file"
    raise InputError(
        "time must increase",
        f"{measurement.at('time', row)}: {measurement.given('time', row)} after"
        f" {measurement.given('time', row - 1)}{more}",
        remedy,
    )


def _check_current(measurement: Measurement) -> None:
    current, column = measurement.values("current"), measurement.columns["current"]
    unit = column.unit
    highest = float(np.max(np.abs(column.given)))
    if unit == "mA" and 0 < highest < _AMPERES_AT_MOST:
        raise InputError(
            "current in mA runs from 4 to 20",
            f"{measurement.sheet.name}: the highest in column {column.header.text!r} is {highest:g} mA",
            "if it is in amperes, name the column 'current [A]'",
        )
    row = int(np.argmax(current))
    if current[row] > _CURRENT_AT_MOST:
        looks = unit == "A" and current[row] <= 1000 * _CURRENT_AT_MOST
        raise InputError(
            f"current is at most {_CURRENT_AT_MOST * 1e3:g} mA in a 4..20 mA loop",
            f"{measurement.at('current', row)}: {measurement.given('current', row)}",
            "if it is in mA, name the column 'current [mA]'" if looks else "check the unit and the row",
        )
    rows = np.flatnonzero(current < 0)
    if rows.size:
        row = int(rows[0])
        more = f" (and {rows.size - 1} more rows)" if rows.size > 1 else ""
        raise InputError(
            "current is not negative: the gap follows its root",
            f"{measurement.at('current', row)}: {measurement.given('current', row)}{more}",
            "swap the wires, or cut the part in which the loop was off",
        )


def _check_pressure(measurement: Measurement) -> None:
    pressure = measurement.values("pressure")
    row = int(np.argmin(pressure))
    if pressure[row] < _VACUUM:
        raise InputError(
            "gauge pressure is above that of a vacuum, -101.3 kPa",
            f"{measurement.at('pressure', row)}: {measurement.given('pressure', row)}",
            "check the unit and the row, or delete the column",
        )


def _check_position(measurement: Measurement) -> None:
    position, column = measurement.values("position"), measurement.columns["position"]
    row = int(np.argmax(np.abs(position)))
    if abs(position[row]) > _POSITION_AT_MOST:
        remedy = "if it is in mm, name the column 'position [mm]'" if column.unit == "m" else "check unit and row"
        raise InputError(
            f"position is within {_POSITION_AT_MOST:g} m"
            if not column.is_percent
            else f"position is within {_POSITION_AT_MOST * 100:g} % of the rated travel",
            f"{measurement.at('position', row)}: {measurement.given('position', row)}",
            remedy,
        )


_CHECKS = {
    "time": _check_time,
    "current": _check_current,
    "pressure": _check_pressure,
    "position": _check_position,
}
