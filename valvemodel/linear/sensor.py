"""The sensor linearised: position to reading."""

from __future__ import annotations

from collections.abc import Mapping

import control as ct

from valvemodel.equations import numeric
from valvemodel.linear.block import Treatment, gain, lag
from valvemodel.linear.point import OperatingPoint, evaluate

TREATMENTS = {
    "linkage_backlash": Treatment(
        False,
        "in slip all play is taken up; stuck, the reading does not move within it, or within the least of a worn "
        "joint; the describing function is that of a play, or the mean of two",
    ),
    "quantisation": Treatment(False, "a rounding has no slope: the reading is taken before it"),
    "sensor_drift": Treatment(False, "a disturbance: the point is taken at the start"),
    "sensor_lag": Treatment(True, "a first-order lag, or two in series"),
    "linkage_nonlinearity": Treatment(True, "its slope at the position"),
}


def blocks(numbers: Mapping[str, float], point: OperatingPoint) -> list[ct.StateSpace]:
    """Return the blocks from `position` to `reading`."""
    play = numbers["backlash_half_width"]
    slope = evaluate(numeric.reading_by_position, numbers, position=point.position - point.side * play)
    if point.side == 0.0 and play > 0.0:
        slope *= 0.5 if numbers["backlash_wear"] == 1.0 else 0.0
    return [
        gain("linkage", slope, "position", "indicated_position"),
        lag("transmitter", numbers["sensor_time_constant"], "reading", "indicated_position", "unfiltered_reading"),
        lag("filter", numbers["sensor_second_time_constant"], "filtered_reading", "unfiltered_reading", "reading"),
    ]
