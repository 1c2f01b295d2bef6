"""The sensor linearised: position to reading."""

from __future__ import annotations

from collections.abc import Callable, Mapping

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
    slope = evaluate(reading_slope(numbers), numbers, position=point.position - point.side * play)
    if point.side == 0.0 and play > 0.0:
        slope *= 0.5 if numbers["backlash_wear"] == 1.0 else 0.0
    return [
        gain("linkage", slope, "position", "indicated_position"),
        lag("transmitter", numbers["sensor_time_constant"], "reading", "indicated_position", "unfiltered_reading"),
        lag("filter", numbers["sensor_second_time_constant"], "filtered_reading", "unfiltered_reading", "reading"),
    ]


def reading_slope(numbers: Mapping[str, float]) -> Callable[..., float]:
    """Return the slope of the reading in the position of the linkage: of a bow to third order, or of a whole arm."""
    if numbers["linkage_arm"] == 0.0 or numbers["linkage_skew"] == 0.0:
        return numeric.reading_by_position
    with_slot, with_rod = numeric.reading_by_position_with_slot, numeric.reading_by_position_with_rod
    return with_slot if numbers["linkage_skew"] < 0.0 else with_rod
