"""A PI that closes the loop period by period: compiled around the chain, and in Python around a stepped valve."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.simulation.ours import DEFAULT
from benchmarks.simulation.stopwatch import shortest_time
from benchmarks.simulation.workload import PERIOD, set_point
from valvemodel.chain import CURRENT, advance_period, start_chain
from valvemodel.compiled import compiled
from valvemodel.model import Model
from valvemodel.parameters import MEMORY, STATE
from valvemodel.stages.sensor import read_sensor
from valvemodel.stepping import SteppedValve
from valvemodel.valves import read_valve

START, LOWEST, HIGHEST = 12e-3, 4e-3, 20e-3
"""Currents. [A]"""

GAIN, RATE = 0.02, 0.04
"""Proportional [A/m] and integral [A/(m s)]."""

REPEATS = 5


@compiled
def run_loop(rows, states, memories, set_points, tolerance, readings):
    """Close the loop around the compiled chain."""
    p, state, memory = rows[0], states[0], memories[0]
    start_chain(p, state, memory, START, CURRENT, 0.0, tolerance)
    integral = START
    for sample in range(set_points.shape[0]):
        reading = read_sensor(p, state, sample * PERIOD)
        readings[sample] = reading
        error = set_points[sample] - reading
        integral = min(max(integral + RATE * PERIOD * error, LOWEST), HIGHEST)
        current = min(max(integral + GAIN * error, LOWEST), HIGHEST)
        advance_period(p, state, memory, current, sample * PERIOD, PERIOD, tolerance)


def step_loop(model: Model, set_points: list[float]) -> list[float]:
    """Close the same loop in Python."""
    valve = SteppedValve(model, current=START)
    integral = START
    readings = []
    for target in set_points:
        readings.append(valve.reading)
        error = target - valve.reading
        integral = min(max(integral + RATE * PERIOD * error, LOWEST), HIGHEST)
        valve.step(min(max(integral + GAIN * error, LOWEST), HIGHEST), PERIOD)
    return readings


def time_loop(periods: int) -> dict[str, Any]:
    """Return the time a period of both, and by how much their readings differ."""
    valve = read_valve("calibrated")
    model = Model(valve.name, valve.values).with_effect("static_friction")
    rows, states, memories = model.rows(), np.zeros(1, STATE), np.zeros(1, MEMORY)
    targets = [set_point(sample) for sample in range(periods)]
    set_points, readings = np.array(targets), np.empty(periods)

    def compiled_loop() -> None:
        run_loop(rows, states, memories, set_points, DEFAULT.tolerance, readings)

    compiled_loop()
    stepped = step_loop(model, targets)
    return {
        "periods": periods,
        "ns_per_period_compiled": 1e9 * shortest_time(compiled_loop, 4 * REPEATS) / periods,
        "ns_per_period_stepped_from_python": 1e9 * shortest_time(lambda: step_loop(model, targets), REPEATS) / periods,
        "m_between_them": float(np.abs(readings - stepped).max()),
    }
