"""The exact valve as a system of python-control's, in steps of a controller's period."""

from __future__ import annotations

import math
from typing import Any

import control as ct
import numpy as np

from valvemodel import stepping
from valvemodel.model import Model
from valvemodel.parameters import MEMORY, STATE
from valvemodel.stages.line import enter_line, rest_line
from valvemodel.stages.sensor import read_sensor
from valvemodel.trajectory import TOLERANCE

OUTPUTS = ("reading", "position", "pressure")


def exact_system(model: Model, *, period: float, current: float, start_position: float = math.nan) -> Any:
    """Return the whole valve, with all effects, for `control.input_output_response` and `control.interconnect`.

    Its state is the simulator's own with the currents under way in the line, so that it can be stepped from any
    instant again; its start is in the system's attribute `start`.

    Parameters
    ----------
    model : Model
    period : float
        For which each current is held. [s]
    current : float
        Under which the valve rests at the start. [A]
    start_position : float
        Reading at the start; by default at rest in the middle of the stuck band. [m]

    Returns
    -------
    control.NonlinearIOSystem
        Discrete in time; input `current` [A], outputs `reading` [m], `position` [m] and `pressure` [Pa].
    """
    rows = model.rows(start_position=start_position)
    memories = np.zeros(1, MEMORY)
    under_way = _under_way(model, period)
    start = np.zeros(1, STATE)
    stepping._start(rows, start, memories, current, 0.0, TOLERANCE)

    def update(time: float, states: np.ndarray, drives: np.ndarray, parameters: dict) -> np.ndarray:
        state, line = _split(states, under_way)
        line = np.append(line, drives)
        rest_line(memories[0], line[0])
        for number in range(under_way):
            enter_line(memories[0], time - (under_way - number) * period, line[number])
        stepping._advance(rows, state, memories, line[-1], time, time + period, TOLERANCE)
        return np.concatenate((state.view(float), line[1:]))

    def output(time: float, states: np.ndarray, drives: np.ndarray, parameters: dict) -> np.ndarray:
        state, _ = _split(states, under_way)
        return np.array([read_sensor(rows[0], state[0], time), state["position"][0], state["pressure"][0]])

    system = ct.nlsys(
        update, output, name=model.name, dt=period, inputs=["current"], outputs=list(OUTPUTS),
        states=[*_names_of_states(), *(f"current_{number}" for number in range(under_way))],
    )  # fmt: skip
    system.start = np.concatenate((start.view(float), np.full(under_way, current)))
    return system


def _names_of_states() -> list[str]:
    """Return the names of the simulator's states, numbered where there are several of a name."""
    names = []
    for name in STATE.names or ():
        count = math.prod(STATE[name].shape)
        names += [name] if STATE[name].shape == () else [f"{name}_{number}" for number in range(count)]
    return names


def _under_way(model: Model, period: float) -> int:
    """Return how many currents are at most under way in the line besides the one that enters."""
    delay = model.numbers.get("transport_delay", 0.0)
    return math.ceil(delay / period) if delay > 0.0 else 0


def _split(states: np.ndarray, under_way: int) -> tuple[np.ndarray, np.ndarray]:
    count = len(states) - under_way
    return np.array(states[:count], float).view(STATE), np.array(states[count:], float)
