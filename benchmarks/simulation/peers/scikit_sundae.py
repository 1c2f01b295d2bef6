"""SUNDIALS by scikit-sundae: CVODE over each slip, its stop as a root function."""

from __future__ import annotations

import numpy as np
from sksundae.cvode import CVODE

from benchmarks.simulation.workload import PERIOD, Stem

TITLE = "SUNDIALS CVODE with roots (scikit-sundae)"
SETTINGS = (("Adams", 1e-6), ("Adams", 1e-7), ("Adams", 1e-8), ("BDF", 1e-8), ("Adams", 1e-10))


def run(stem: Stem, pressures: np.ndarray, setting: tuple[str, float]) -> np.ndarray:
    """Return the positions just before each pressure acts. [m]"""
    method, tolerance = setting
    mass, rate, damping, coulomb = stem.mass, stem.rate, stem.damping, stem.coulomb
    force, side = 0.0, 0.0

    def slope(_: float, state: np.ndarray, derivative: np.ndarray) -> None:
        derivative[0] = state[1]
        derivative[1] = (force - rate * state[0] - damping * state[1]) / mass

    def speed(_: float, state: np.ndarray, events: np.ndarray) -> None:
        events[0] = side * state[1]

    speed.terminal = [True]  # type: ignore[attr-defined]
    speed.direction = [-1]  # type: ignore[attr-defined]
    solver = CVODE(
        slope, method=method, rtol=tolerance, atol=1e-3 * tolerance, eventsfn=speed, num_events=1, max_num_steps=100_000
    )
    y, v = stem.rest(pressures[0]), 0.0
    positions = np.empty(len(pressures))
    for sample, pressure in enumerate(pressures.tolist()):
        positions[sample] = y
        time = 0.0
        while time < PERIOD:
            if stem.is_stuck(y, v, pressure):
                v, side = 0.0, 0.0
                break
            side = side or float(np.sign(stem.net(y, pressure)))
            force = stem.area * pressure - side * coulomb
            solver.init_step(time, np.array([y, v]))
            found = solver.step(PERIOD, tstop=PERIOD)
            y, v, time = float(found.y[0]), float(found.y[1]), float(found.t)
            if time < PERIOD:
                v, side = 0.0, 0.0
    return positions
