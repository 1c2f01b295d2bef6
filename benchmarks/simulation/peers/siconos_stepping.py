"""Siconos: Moreau's time stepping of the stem with a relay for its friction, whose bounds are F_s at rest."""

from __future__ import annotations

import numpy as np
from siconos import kernel

from benchmarks.simulation.workload import PERIOD, Stem

TITLE = "Siconos, Moreau time stepping"
SETTINGS = ((10,), (100,))
"""Steps a period; the method is of first order, six digits would take a hundred times as many."""


def run(stem: Stem, pressures: np.ndarray, setting: tuple[int]) -> np.ndarray:
    """Return the positions just before each pressure acts. [m]"""
    (steps,) = setting
    matrix = np.array([[0.0, 1.0], [-stem.rate / stem.mass, -stem.damping / stem.mass]])
    held = pressures.tolist()
    start = np.array([stem.rest(held[0]), 0.0])
    body = kernel.FirstOrderLinearTIDS(start, matrix, np.array([0.0, stem.area * held[0] / stem.mass]))
    speed = kernel.FirstOrderLinearTIR(np.array([[0.0, 1.0]]), np.array([[0.0], [1.0 / stem.mass]]))
    friction = kernel.RelayNSL(1, -stem.static, stem.static)
    duration = (len(held) - 0.5) * PERIOD
    valve = kernel.NonSmoothDynamicalSystem(0.0, duration)
    valve.insertDynamicalSystem(body)
    valve.link(kernel.Interaction(friction, speed), body)
    clock = kernel.TimeDiscretisation(0.0, PERIOD / steps)
    simulation = kernel.TimeStepping(valve, clock, kernel.EulerMoreauOSI(0.5), kernel.Relay())
    positions = np.empty(len(held))
    state = body.x()
    for sample, pressure in enumerate(held):
        positions[sample] = state[0]
        body.setbPtr(np.array([0.0, stem.area * pressure / stem.mass]))
        if sample + 1 == len(held):
            break
        for _ in range(steps):
            bound = stem.static if abs(state[1]) < 1e-9 else stem.coulomb
            friction.setLb(-bound)
            friction.setUb(bound)
            simulation.computeOneStep()
            simulation.nextStep()
    return positions
