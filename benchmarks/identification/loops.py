"""Settled loops of 57 points: width and slope of the fit, over repetitions with noise."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.identification.plants import HELD

UP, DOWN = np.arange(4.0, 18.01, 0.5), np.arange(17.5, 3.99, -0.5)
CURRENT = np.concatenate([UP, DOWN]) * 1e-3
"""57 currents in steps of 0.5 mA, as in the paper's Fig. 7. [A]"""

HOLD = 0.5
"""Each current is held so long: 20 time constants of the slowest plant. [s]"""

NOISE = 0.005
"""Noise of a reading over the range of the loop."""

HIGHEST = 0.026
"""The branches are crossed below this: the gap is still open. [A]"""

ASKED = 0.01
"""Share within which width and slope are asked for."""

NAMES = ("width", "slope", "height")


def settled(base: dict[str, float]) -> npt.NDArray[np.float64]:
    """Return where an independent plant has settled under each current, shape (57,). [m]"""
    from diagnosis.blindtest.plants import integrate

    time = HOLD * np.arange(len(CURRENT) + 1.0)
    return integrate(base, time, np.append(CURRENT, CURRENT[-1]))["position"][1:]


def true_shape(base: dict[str, float], position: float) -> dict[str, float]:
    """Return width [A], slope [m/A] and height [m] of a plant's loop at a position, from its own static pressure."""
    from scipy.optimize import brentq

    from diagnosis.blindtest.chain.nozzle import static_pressure

    def thrust(current: float) -> float:
        gap = np.array(base["gap_offset"] - base["gap_gain"] * np.sqrt(current))
        return base["diaphragm_area"] * float(static_pressure(gap, base)) - base["spring_preload"]

    friction, rate = base["coulomb_friction"], base["spring_rate"]
    branches = (rate * position + friction, rate * position - friction)
    crossed = [brentq(lambda i, aim=aim: thrust(i) - aim, 0.0, HIGHEST, xtol=1e-12) for aim in branches]
    step = 1e-6
    slopes = [(thrust(current + step) - thrust(current - step)) / (2.0 * step * rate) for current in crossed]
    return {"width": crossed[0] - crossed[1], "slope": float(np.mean(slopes)), "height": 2.0 * friction / rate}


def score_loops(repetitions: int, tick: Callable[[], None]) -> dict[str, Any]:
    """Fit noisy loops of independent plants; return by name rms and greatest error, and how many are within 1 %."""
    from diagnosis.blindtest.valve import NOMINAL, draw_base
    from identification.fitting import fit_records
    from valvemodel.model import Model
    from valvemodel.records import Record
    from valvemodel.valves import read_valve

    valve = read_valve("calibrated")
    off: dict[str, list[float]] = {name: [] for name in NAMES}
    scaled: dict[str, list[float]] = {name: [] for name in NAMES}
    for seed in range(repetitions):
        generator = np.random.default_rng([seed, 57])
        base = {**draw_base(generator), **{name: NOMINAL[name] for name in HELD}}
        position = settled(base)
        position = position + NOISE * np.ptp(position) * generator.standard_normal(len(position))
        record = Record.from_arrays(f"loop {seed}", current=CURRENT, position=position)
        loop = fit_records([record], Model(valve.name, valve.values)).loop
        assert loop is not None
        truth = true_shape(base, loop.shape.position)
        for name in NAMES:
            error = getattr(loop.shape, name) - truth[name]
            off[name].append(error / truth[name])
            scaled[name].append(error / loop.std[name])
        tick()
    return {
        name: {
            "rms": float(np.sqrt(np.mean(np.square(off[name])))),
            "largest": float(np.abs(off[name]).max()),
            "within 1 %": int(np.sum(np.abs(off[name]) <= ASKED)),
            "error over its deviation, rms": float(np.sqrt(np.mean(np.square(scaled[name])))),
            "repetitions": repetitions,
        }
        for name in NAMES
    }
