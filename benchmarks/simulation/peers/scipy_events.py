"""SciPy: `solve_ivp` over each slip, its stop as a terminal event."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.simulation.workload import PERIOD, Stem

TITLE = "SciPy solve_ivp with events"
SETTINGS = (("DOP853", 1e-4), ("DOP853", 1e-6), ("LSODA", 1e-7), ("DOP853", 1e-8), ("DOP853", 1e-10))


def run(stem: Stem, pressures: np.ndarray, setting: tuple[str, float]) -> np.ndarray:
    """Return the positions just before each pressure acts. [m]"""
    method, tolerance = setting
    mass, rate, damping, coulomb = stem.mass, stem.rate, stem.damping, stem.coulomb

    def slope(_: float, state: np.ndarray, force: float) -> tuple[float, float]:
        position, velocity = state
        return velocity, (force - rate * position - damping * velocity) / mass

    def velocity(_: float, state: np.ndarray, __: float) -> float:
        return state[1]

    velocity.terminal = True  # type: ignore[attr-defined]
    y, v, side = stem.rest(pressures[0]), 0.0, 0.0
    positions = np.empty(len(pressures))
    for sample, pressure in enumerate(pressures.tolist()):
        positions[sample] = y
        time = 0.0
        while time < PERIOD:
            if stem.is_stuck(y, v, pressure):
                v, side = 0.0, 0.0
                break
            side = side or float(np.sign(stem.net(y, pressure)))
            velocity.direction = -side  # type: ignore[attr-defined]
            force = stem.area * pressure - side * coulomb
            found = solve_ivp(
                slope,
                (time, PERIOD),
                (y, v),
                method,
                args=(force,),
                events=velocity,
                rtol=tolerance,
                atol=1e-3 * tolerance,
            )
            y, v, time = float(found.y[0, -1]), float(found.y[1, -1]), float(found.t[-1])
            if found.status == 1:
                v, side = 0.0, 0.0
    return positions
