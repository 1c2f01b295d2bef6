"""Valves, scenarios and controllers that the tests of closed loops share."""

import numpy as np

from valvemodel.control.branches import Branches
from valvemodel.control.calibration import Calibration
from valvemodel.control.kinds import KINDS
from valvemodel.model import Model
from valvemodel.valves import read_valve

START = 12e-3


def valve_of(name: str = "calibrated", ratio: float = 1.0) -> Model:
    valve = read_valve(name)
    model = Model(valve.name, valve.values)
    return model if ratio == 1.0 else model.with_effect("static_friction", static_friction_ratio=ratio)


def made_up_calibration() -> Calibration:
    """A line of 16 mm/mA with a loop of 3 mA."""
    currents = np.array([13e-3, 16e-3, 19e-3])
    rising = np.column_stack((currents, 16.0 * currents - 0.07))
    falling = np.column_stack((currents[::-1], 16.0 * currents[::-1] - 0.022))
    return Calibration(rising, falling)


def made_up_branches() -> Branches:
    """Two straight branches, 3 mA apart, with a slip jump of 5 mm."""
    currents = np.linspace(4e-3, 20e-3, 33)
    return Branches(
        np.column_stack((currents, 16.0 * currents - 0.07)), np.column_stack((currents, 16.0 * currents - 0.022)), 5e-3
    )


def middle_controllers():
    """Every kind, with each tunable setting in the middle of its box."""
    branches, calibration = made_up_branches(), made_up_calibration()
    for kind in KINDS:
        tuned = {each.name: float(np.sqrt(each.low * each.high)) * each.scale(branches) for each in kind.tunables}
        yield kind.controller(tuned, start_current=START, calibration=calibration, branches=branches)


CONTROLLERS = {controller.name: controller for controller in middle_controllers()}
