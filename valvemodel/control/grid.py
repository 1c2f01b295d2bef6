"""A grid of friction, gains, period, noise and ageing, over which controllers are run."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from valvemodel.control.contest import TRAINED, make_bench
from valvemodel.control.kinds import GAINS, kind_of
from valvemodel.control.loop import run_compiled
from valvemodel.control.measures import BAND_SHARE, measures_of, overall
from valvemodel.control.scenario import Scenario, check_conditions, held_levels
from valvemodel.control.side_by_side import side_by_side
from valvemodel.control.tuning import BUDGET, Bench, aged, tune
from valvemodel.model import Model
from valvemodel.progress import Progress, tell_nobody

FACTORS: dict[str, tuple[float, ...]] = {
    "friction_ratio": (1.0, 1.1, 1.2, 1.4, 1.7, 2.0),
    "gain_factor": (0.5, 0.71, 1.0, 1.41, 2.0),
    "period_factor": (0.5, 1.0, 2.0, 5.0),
    "noise_factor": (0.0, 1.0, 5.0),
    "friction_growth": (0.0, 0.2, 0.4, 0.6),
}
"""F_s/F_c; tuned gains times; tuned period times; noise times; growth of friction since calibration and fit."""

COARSE = {name: (levels[0], levels[-1]) for name, levels in FACTORS.items()}
"""The ends of each factor, for a first look."""

NOMINAL = {"friction_ratio": 1.2, "period_factor": 1.0, "noise_factor": 1.0, "friction_growth": 0.0}
"""Where everything is tuned."""

LEVELS = (0.65, 0.55)
"""Set points as shares of the reach: a long step and a short one back."""

HOLD = 60.0
"""For how long each is held: the tail holds two limit cycles of up to 15 s. [s]"""

TRAINING_HOLD = 20.0
"""For how long each set point of the tuning is held. [s]"""

KEYS = ("pid", "sc", "sc_pid_mean", "sc_pid_misread", "sc_pid_dead_band", "dead_band", "inverse", "landing")
READ = ("settling_time", "settled_share", "overshoot", "steady_error", "limit_cycle_amplitude", "reversals")
"""Measures that are kept of each run."""


@dataclass(frozen=True)
class Grid:
    """What was run: for each controller and measure an array over the levels of all factors.

    Parameters
    ----------
    model : Model
    slip_jumps : mapping
        Shortest slip by friction ratio. [m]
    tuned : mapping of controller to settings
    measured : mapping of controller to mapping of measure to array, shape by `FACTORS`
    band : float
        Within which a position counts as settled. [m]
    """

    model: Model
    slip_jumps: Mapping[float, float]
    tuned: Mapping[str, Mapping[str, float]]
    measured: Mapping[str, Mapping[str, np.ndarray]]
    period: float
    noise: float
    band: float
    factors: Mapping[str, tuple[float, ...]]

    def is_well(self, key: str) -> np.ndarray:
        """Return where a controller settles at every set point, without a cycle beyond the band."""
        measured = self.measured[key]
        return (measured["settled_share"] == 1.0) & (measured["limit_cycle_amplitude"] <= self.band)


def run_grid(
    model: Model,
    *,
    period: float = 0.01,
    noise: float = 1e-4,
    resolution: float = 0.0,
    seed: int = 0,
    budget: int = BUDGET,
    factors: Mapping[str, tuple[float, ...]] = FACTORS,
    progress: Progress = tell_nobody,
) -> Grid:
    """Tune at the nominal point, then run every controller at every point of the grid.

    Parameters
    ----------
    model : Model
        Its static friction is set by the grid.
    period, noise, resolution : float [s], [m], [m]
    seed, budget : int
    factors : mapping
        Levels of each factor, by default `FACTORS`.
    """
    check_conditions(period=period, noise=noise, resolution=resolution)
    benches = {
        ratio: make_bench(_with_ratio(model, ratio), noise=noise, resolution=resolution, seed=seed)
        for ratio in {*factors["friction_ratio"], NOMINAL["friction_ratio"]}
    }
    nominal = benches[NOMINAL["friction_ratio"]]
    training = _scenario(nominal, TRAINED, TRAINING_HOLD, period, noise, resolution, 3 * seed + 1)
    tuned = dict(
        zip(
            KEYS,
            side_by_side(
                lambda key, go_on: tune(nominal, kind_of(key), training, budget=budget, go_on=go_on)[0],
                KEYS,
                lambda done: progress("tuning", 0.4 * done),
            ),
            strict=True,
        )
    )

    def at(point: tuple[float, ...], go_on: Callable[[], None]) -> list[dict[str, float]]:
        ratio, gain, slower, louder, growth = point
        go_on()
        bench = benches[ratio]
        scenario = _scenario(bench, LEVELS, HOLD, slower * period, louder * noise, resolution, 3 * seed + 2)
        old = aged(bench.model, growth)
        return [_measured(bench, old, key, tuned[key], gain, scenario) for key in KEYS]

    points = list(itertools.product(*factors.values()))
    found = side_by_side(at, points, lambda done: progress("running the grid", 0.4 + 0.6 * done))
    shape = tuple(len(levels) for levels in factors.values())
    measured = {
        key: {name: np.array([row[column][name] for row in found]).reshape(shape) for name in READ}
        for column, key in enumerate(KEYS)
    }
    band = BAND_SHARE * model.values["rated_travel"]
    jumps = {ratio: bench.branches.slip_jump for ratio, bench in sorted(benches.items())}
    return Grid(model, jumps, tuned, measured, period, noise, band, factors)


def _scenario(
    bench: Bench, shares: Sequence[float], hold: float, period: float, noise: float, resolution: float, seed: int
) -> Scenario:
    low, high = bench.branches.reach
    levels = [low + share * (high - low) for share in shares]
    return held_levels(levels, duration=hold, period=period, noise=noise, resolution=resolution, seed=seed)


def _measured(
    bench: Bench, valve: Model, key: str, tuned: Mapping[str, float], gain: float, scenario: Scenario
) -> dict[str, float]:
    names = {each.name for each in GAINS}
    scaled = {name: value * (gain if name in names else 1.0) for name, value in tuned.items()}
    run = run_compiled(valve, bench.controller(kind_of(key), scaled), scenario, start_current=bench.start_current)
    travel = valve.values["rated_travel"]
    steps = [
        measures_of(run.position[part], run.setpoint[part.start], period=scenario.period, rated_travel=travel)
        for part in scenario.steps
    ]
    together = overall(steps)
    return {name: together[name] for name in READ}


def _with_ratio(model: Model, ratio: float) -> Model:
    return model.with_effect("static_friction", static_friction_ratio=ratio)
