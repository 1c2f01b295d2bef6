"""PathSim: one ODE block, the pressures as a schedule, the stop as a zero crossing."""

from __future__ import annotations

import numpy as np
import pathsim
from pathsim.blocks import ODE
from pathsim.events import Schedule, ZeroCrossingDown

from benchmarks.simulation.workload import PERIOD, Stem

TITLE = "PathSim"
SETTINGS = (("RKDP54", 1e-4), ("RKDP87", 1e-4), ("RKDP54", 1e-6), ("RKDP87", 1e-6), ("RKDP87", 1e-8))

NUDGE = 1e-13
"""Speed of a stem that breaks away: the zero crossing is not seen from a speed of exactly 0. [m/s]"""


def run(stem: Stem, pressures: np.ndarray, setting: tuple[str, float]) -> np.ndarray:
    """Return the positions just before each pressure acts. [m]"""
    solver, tolerance = setting
    mass, rate, damping, coulomb = stem.mass, stem.rate, stem.damping, stem.coulomb
    held = pressures.tolist()
    positions = [stem.rest(held[0])]
    force, side = 0.0, 0.0

    def slope(state: np.ndarray, _: np.ndarray, __: float) -> np.ndarray:
        if side == 0.0:
            return np.zeros(2)
        return np.array([state[1], (force - rate * state[0] - damping * state[1]) / mass])

    def hold(y: float, v: float, pressure: float) -> None:
        nonlocal force, side
        if stem.is_stuck(y, v, pressure):
            v, side = 0.0, 0.0
        elif side == 0.0:
            side = float(np.sign(stem.net(y, pressure)))
            v = side * NUDGE
        force = stem.area * pressure - side * coulomb
        stem_block.engine.set(np.array([y, v]))

    def switch(_: float) -> None:
        y, v = stem_block.engine.get()
        positions.append(float(y))
        if len(positions) <= len(held):
            hold(float(y), float(v), held[len(positions) - 1])

    def stop(_: float) -> None:
        nonlocal side
        side = 0.0
        hold(float(stem_block.engine.get()[0]), 0.0, held[len(positions) - 1])

    stem_block = ODE(slope, np.array([positions[0], 0.0]))
    switches = Schedule(t_start=PERIOD, t_period=PERIOD, func_act=switch)
    stops = ZeroCrossingDown(func_evt=lambda _: side * stem_block.engine.get()[1], func_act=stop, tolerance=tolerance)
    simulation = pathsim.Simulation(
        [stem_block], [], [switches, stops], dt=PERIOD, dt_max=PERIOD, log=False,
        Solver=getattr(pathsim.solvers, solver), tolerance_lte_abs=1e-3 * tolerance, tolerance_lte_rel=tolerance,
    )  # fmt: skip
    hold(positions[0], 0.0, held[0])
    simulation.run((len(held) - 0.5) * PERIOD)
    return np.array(positions[: len(held)])
