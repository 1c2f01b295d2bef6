"""A closed loop on the exact valve, period by period: compiled, or with any controller in plain Python."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from valvemodel.chain import CURRENT, advance_period, start_chain
from valvemodel.compiled import compiled
from valvemodel.control.controller import Controller
from valvemodel.control.laws.law import step, within_limits
from valvemodel.control.laws.settings import RECOLLECTION
from valvemodel.control.scenario import Scenario
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.parameters import MEMORY, STATE
from valvemodel.simulation import TOLERANCE
from valvemodel.stages.sensor import read_sensor
from valvemodel.stepping import SteppedValve


@dataclass(frozen=True)
class Run:
    """A closed loop's course; row k is the state just before current k acts.

    Parameters
    ----------
    time, setpoint, current, reading, position : arrays, shape (n,) [s], [m], [A], [m], [m]
        The reading is what the controller received, noise and resolution in it; the position is the stem's own.
    """

    time: np.ndarray
    setpoint: np.ndarray
    current: np.ndarray
    reading: np.ndarray
    position: np.ndarray


@compiled
def coarse(reading, resolution):
    """Return a reading in steps of the resolution. [m]"""
    if resolution <= 0.0:
        return reading
    return resolution * math.floor(reading / resolution + 0.5)


@compiled
def _run(
    rows, states, memories, settings, recollections, start_current, period, setpoint, load, noise, resolution,
    tolerance, time, current, reading, position,
):  # fmt: skip
    """Run a closed loop; the last four arrays are overwritten."""
    p, state, memory, s, m = rows[0], states[0], memories[0], settings[0], recollections[0]
    start_chain(p, state, memory, start_current, CURRENT, 0.0, tolerance)
    preload = p.spring_preload
    now = 0.0
    for sample in range(setpoint.shape[0]):
        received = coarse(read_sensor(p, state, now) + noise[sample], resolution)
        drive = within_limits(step(s, m, setpoint[sample], received))
        time[sample], current[sample], reading[sample], position[sample] = now, drive, received, state.position
        p.spring_preload = preload + load[sample]
        following = now + period
        advance_period(p, state, memory, drive, now, following - now, tolerance)
        now = following


def run_compiled(model: Model, controller: Controller, scenario: Scenario, *, start_current: float) -> Run:
    """Run a controller of this package on a valve that rests under a current at the start.

    Parameters
    ----------
    model : Model
    controller : Controller
        Its period is set to the scenario's.
    scenario : Scenario
    start_current : float
        Under which the valve is at rest in the middle of its stuck band. [A]

    Returns
    -------
    Run
    """
    settings = controller.record.copy()
    settings["period"] = scenario.period
    time, current, reading, position = (np.empty(len(scenario.setpoint)) for _ in range(4))
    _run(
        model.rows(), np.zeros(1, STATE), np.zeros(1, MEMORY), settings, np.zeros(1, RECOLLECTION), start_current,
        scenario.period, scenario.setpoint, scenario.load, scenario.noise, scenario.resolution, TOLERANCE,
        time, current, reading, position,
    )  # fmt: skip
    return Run(time, scenario.setpoint, current, reading, position)


def run_stepped(
    model: Model, controller: Callable[[float, float], float], scenario: Scenario, *, start_current: float
) -> Run:
    """Run any controller, called once a period with set point and reading [m] for a current [A], held within 4..20 mA.

    With a controller of this package, `controller.started()`, it gives what `run_compiled` gives, to the last bit.

    Raises
    ------
    InputError
        If the controller returns no number.
    """
    valve = SteppedValve(model, current=start_current)
    period, resolution = scenario.period, scenario.resolution
    rows = []
    setpoints, loads, noises = scenario.setpoint.tolist(), scenario.load.tolist(), scenario.noise.tolist()
    for setpoint, load, noise in zip(setpoints, loads, noises, strict=True):
        received = coarse(valve.reading + noise, resolution)
        current = controller(setpoint, received)
        if not -math.inf < current < math.inf:
            raise InputError("a controller returns a current", f"got {current} at {valve.time:g} s", "correct it")
        current = within_limits(current)
        rows.append((valve.time, setpoint, current, received, valve.position))
        valve.load = load
        valve.step(current, period)
    return Run(*np.ascontiguousarray(np.array(rows).T))
