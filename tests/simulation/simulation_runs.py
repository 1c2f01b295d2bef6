"""Runs of the compiled chain that the simulation's tests share."""

from __future__ import annotations

import numpy as np

from valvemodel import chain, runs
from valvemodel.model import Model
from valvemodel.parameters import MEMORY, STATE
from valvemodel.simulation import simulate
from valvemodel.smooth.chain import SmoothChain, parts_for, run_smooth
from valvemodel.stages import EFFECTS
from valvemodel.stepping import SteppedValve
from valvemodel.trajectory import TOLERANCE
from valvemodel.valves import read_valve

FINE_TOLERANCE = 1e-11

NEEDED = {
    "end_stop": {"upper_stop": 0.19},
    "quantisation": {"resolution": 1e-3},
    "load_force": {"load_sine": 200.0, "load_cosine": 100.0, "load_period": 5.0},
    "position_dependent_friction": {
        "tight_spot_excess": 0.6,
        "tight_spot_position": 0.12,
        "tight_spot_exponent": 2.6,
        "tight_spot_closure": 0.4,
    },
}
"""Values of effects whose typical ones come from a record."""


def base_model(**values: float) -> Model:
    """The calibrated valve, changed."""
    valve = read_valve("calibrated")
    return Model(valve.name, {**valve.values, **values})


def with_effects(model: Model, *keys: str) -> Model:
    """The model with effects at typical values."""
    for key in keys:
        model = model.with_effect(key, **NEEDED.get(key, {}))
    return model


def with_values(model: Model, **effects: dict[str, float]) -> Model:
    """The model with effects at some values."""
    for key, values in effects.items():
        model = model.with_effect(key, **values)
    return model


def flux_current(current: np.ndarray, **effects: dict[str, float]) -> np.ndarray:
    """Current that the flux stands for at the end of each period, by a valve with pressures proportional to it. [A]"""
    valve = read_valve("linear")
    model = with_values(Model(valve.name, valve.values), **effects)
    time = 0.02 * np.arange(len(current) + 1)
    pressure = simulate(model, time=time, current=np.append(current, current[-1])).pressure[1:]
    return (pressure - valve.values["pressure_at_zero_current"]) / valve.values["pressure_per_current"]


def off_the_exact_run(model: Model, time: np.ndarray, current: np.ndarray) -> list[float]:
    """Standard deviation of the smooth chain from the exact run at a wide and a narrow smoothing. [m]"""
    exact = simulate(model, time=time, current=current, start_position=0.02).position
    chain = SmoothChain(model, parts=parts_for(model, 0.01))
    return [
        float(np.std(run_smooth(chain, time=time, current=current, start_position=0.02, width=width) - exact))
        for width in (30.0, 0.01)
    ]


def stepped_readings(model: Model, time: np.ndarray, current: np.ndarray) -> np.ndarray:
    """Readings of a valve that goes on period by period, shape (n,). [m]"""
    valve = SteppedValve(model, current=current[0])
    readings = [valve.reading]
    for sample in range(len(time) - 1):
        valve.time = time[sample]
        readings.append(valve.step(current[sample], time[sample + 1] - time[sample]))
    return np.array(readings)


EFFECT_KEYS = [effect.key for effect in EFFECTS]


def ramps_and_steps(seconds: float = 20.0, rate: float = 50.0, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """A triangle between 5 and 19 mA, then random steps. [s], [A]"""
    count = int(seconds * rate) + 1
    time = np.arange(count) / rate
    phase = time / (0.4 * seconds)
    triangle = 12e-3 + 7e-3 * (2.0 * np.abs(2.0 * (phase - np.floor(phase)) - 1.0) - 1.0)
    generator = np.random.default_rng(seed)
    steps = np.repeat(generator.uniform(5e-3, 19e-3, count // 25 + 1), 25)[:count]
    return time, np.where(phase < 1.5, triangle, steps)


def run(
    model: Model,
    time: np.ndarray,
    drive: np.ndarray,
    *,
    driven_by: int = chain.CURRENT,
    start: float = float("nan"),
    tolerance: float = TOLERANCE,
) -> np.ndarray:
    """Readings of one run, shape (n,). [m]"""
    readings = np.empty((1, len(time)))
    runs.run_chain(
        model.rows(start_position=start), np.zeros(1, STATE), np.zeros(1, MEMORY),
        np.asarray(time, float), np.asarray(drive, float),
        runs.FREE, driven_by, tolerance, readings, runs.NONE, runs.NONE,
    )  # fmt: skip
    return readings[0]
