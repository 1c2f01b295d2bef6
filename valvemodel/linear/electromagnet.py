"""The electromagnet linearised: current to the current that the flux stands for."""

from __future__ import annotations

from collections.abc import Mapping

import control as ct
import numpy as np

from valvemodel.equations import numeric
from valvemodel.linear.block import Treatment, block, gain, lag
from valvemodel.linear.point import OperatingPoint, evaluate

TREATMENTS = {
    "magnetic_hysteresis": Treatment(
        True, "in slip on the branch of its side, with slope 1; stuck: the slope of the initial curve"
    ),
    "magnetic_saturation": Treatment(True, "its slope at the current"),
    "coil_lag": Treatment(True, "a first-order lag, or two in series"),
    "gap_drift": Treatment(False, "a disturbance: the point is taken at the start"),
}


def blocks(numbers: Mapping[str, float], point: OperatingPoint, pade_order: int) -> list[ct.StateSpace]:
    """Return the blocks from `current` to `effective_current`; the line's delay comes first, as in the chain."""
    is_tanh = numbers["saturation_law"] > 0.0 and numbers["saturation_reach"] > 0.0
    law = numeric.current_saturated_as_tanh_by_current if is_tanh else numeric.saturated_current_by_current
    slope = evaluate(law, numbers, current=point.current)
    return [
        delay("line", numbers["transport_delay"], pade_order, "current", "arrived_current"),
        lag("coil", numbers["coil_time_constant"], "current", "arrived_current", "coil_current"),
        lag("eddies", numbers["eddy_time_constant"], "flux", "coil_current", "flux_current"),
        gain("core", slope * hysteresis_slope(numbers, point), "flux_current", "effective_current"),
    ]


def hysteresis_slope(numbers: Mapping[str, float], point: OperatingPoint) -> float:
    """Return the slope from the middle of the loop, where no play moves.

    dz/di is 1 / (2 h (1 - gamma) (1 + roundness)), of plays 1 / (h (1 + roundness)).
    """
    if numbers["hysteresis_half_width"] == 0.0 or point.side != 0.0:
        return 1.0
    curve, plays = 0.5 / (1.0 - numbers["bouc_wen_gamma"]), 1.0
    behind = curve + numbers["return_point_memory"] * (plays - curve)
    return 1.0 - behind / (1.0 + numbers["hysteresis_roundness"])


def delay(name: str, dead_time: float, order: int, source: str, target: str) -> ct.StateSpace:
    """Return a dead time as Pade's approximation of an order; the identity without one. [s]"""
    if dead_time == 0.0:
        return gain(name, 1.0, source, target)
    # In units of the dead time: its powers would spoil the scaling of the states.
    system = ct.tf2ss(*ct.pade(1.0, order))
    states = [f"pade_{number}" for number in range(1, order + 1)]
    return block(
        name, system.A / dead_time, system.B / dead_time, system.C, np.asarray(system.D), states, source, target
    )
