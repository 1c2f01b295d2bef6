"""The paper's claims on its three controllers, tested over a grid of friction, tuning, period, noise and ageing."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from valvemodel.control.contest import TRAINED, Progress, make_bench
from valvemodel.control.kinds import GAINS, kind_of
from valvemodel.control.loop import run_compiled
from valvemodel.control.measures import BAND_SHARE, measures_of, overall
from valvemodel.control.scenario import Scenario, check_conditions, held_levels
from valvemodel.control.tuning import BUDGET, Bench, aged, tune
from valvemodel.model import Model

SCHEMA = "valvemodel.claims/1"

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
MENDS = ("sc_pid_dead_band", "dead_band", "inverse", "landing")
"""What may mend SC-PID: a dead band, giving up the feedforward, the model's branches, landing on them."""

READ = ("settling_time", "settled_share", "overshoot", "steady_error", "limit_cycle_amplitude", "reversals")
"""Measures that are kept of each run."""

WORKERS = 2


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


def claims_of(grid: Grid) -> dict[str, tuple[str, np.ndarray]]:
    """Return each claim's wording as tested, and where it holds."""
    pid, sc, sc_pid = (grid.measured[key] for key in ("pid", "sc", "sc_pid_mean"))
    band = f"{1e3 * grid.band:g} mm"
    # a set point that was not settled counts as held to its end
    times = [
        np.where(each["settled_share"] > 0.0, each["settling_time"], 0.0) * each["settled_share"]
        + HOLD * (1.0 - each["settled_share"])
        for each in (pid, sc_pid)
    ]
    return {
        "pid_oscillates": (
            f"PID oscillates: a limit cycle of up to {0.25 * HOLD:g} s lasts",
            pid["limit_cycle_amplitude"] > 0.0,
        ),
        "sc_deviates": (
            f"SC leaves a fixed deviation: steady error beyond {band}, no cycle",
            (sc["steady_error"] > grid.band) & (sc["limit_cycle_amplitude"] == 0.0),
        ),
        "sc_pid_is_faster": ("SC-PID is faster than PID", times[1] < times[0]),
        "sc_pid_oscillates_little": (
            f"SC-PID oscillates little: no cycle beyond {band}",
            sc_pid["limit_cycle_amplitude"] <= grid.band,
        ),
        "sc_pid_overshoots_less": ("SC-PID overshoots less than PID", sc_pid["overshoot"] < pid["overshoot"]),
    }


def run_grid(
    model: Model,
    *,
    period: float = 0.01,
    noise: float = 1e-4,
    resolution: float = 0.0,
    seed: int = 0,
    budget: int = BUDGET,
    factors: Mapping[str, tuple[float, ...]] = FACTORS,
    progress: Progress = lambda what, share: None,
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
    tuned = {}
    for index, key in enumerate(KEYS):
        progress(f"tuning {kind_of(key).title}", 0.3 * index / len(KEYS))
        tuned[key] = tune(nominal, kind_of(key), training, budget=budget)[0]

    def at(ratio: float, gain: float, slower: float, louder: float, growth: float) -> list[dict[str, float]]:
        bench = benches[ratio]
        scenario = _scenario(bench, LEVELS, HOLD, slower * period, louder * noise, resolution, 3 * seed + 2)
        old = aged(bench.model, growth)
        return [_measured(bench, old, key, tuned[key], gain, scenario) for key in KEYS]

    points = list(itertools.product(*factors.values()))
    found = _mapped(at, points, lambda done: progress("running the grid", 0.3 + 0.7 * done))
    shape = tuple(len(levels) for levels in factors.values())
    measured = {
        key: {name: np.array([row[column][name] for row in found]).reshape(shape) for name in READ}
        for column, key in enumerate(KEYS)
    }
    band = BAND_SHARE * model.values["rated_travel"]
    jumps = {ratio: bench.branches.slip_jump for ratio, bench in sorted(benches.items())}
    return Grid(model, jumps, tuned, measured, period, noise, band, factors)


def _mapped(
    work: Callable[..., Any], points: Sequence[tuple[float, ...]], report: Callable[[float], None]
) -> list[Any]:
    """Do a work at every point in threads, which the compiled loop lets run side by side."""
    found = []
    executor = ThreadPoolExecutor(WORKERS)
    try:
        for done, result in enumerate(executor.map(lambda point: work(*point), points)):
            found.append(result)
            report((done + 1) / len(points))
    finally:
        executor.shutdown(cancel_futures=True)
    return found


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


def findings_of(grid: Grid) -> list[str]:
    """Say in words, from the grid alone, where each claim holds, where SC-PID fails and what mends it."""
    texts = [_where(grid, text, holds) for text, holds in claims_of(grid).values()]
    fails = ~grid.is_well("sc_pid_mean")
    texts.append(_where(grid, "SC-PID fails (a set point not settled, or a cycle beyond the band)", fails))
    texts.append(_slips(grid))
    misread = ~grid.is_well("sc_pid_misread")
    texts.append(
        f"Read as the full width each way from the mean line, it fails in {_percent(misread)} instead of "
        f"{_percent(fails)} of the cases."
    )
    if not fails.any():
        return texts
    for key in sorted(MENDS, key=lambda key: -grid.is_well(key)[fails].mean()):
        well = grid.is_well(key)
        calm = grid.measured[key]["limit_cycle_amplitude"] == 0.0
        texts.append(
            f"{kind_of(key).title} mends {_percent(well[fails])} of these failures, leaves no cycle at all in "
            f"{_percent(calm[fails])} of them, and fails in {_percent(~well)} of all cases."
        )
    return texts


def _slips(grid: Grid) -> str:
    """Say at which friction a stem that is crept upon must miss the band."""
    slips = ", ".join(f"{1e3 * jump:.1f} mm at {ratio:g}" for ratio, jump in grid.slip_jumps.items())
    over = [ratio for ratio, jump in grid.slip_jumps.items() if jump > 2.0 * grid.band]
    said = f"The shortest slip from rest, by friction ratio: {slips}"
    if not over:
        return f"{said}; it fits into the band of +-{1e3 * grid.band:g} mm."
    return (
        f"{said}. From {min(over):g} on it is longer than the whole band of +-{1e3 * grid.band:g} mm: a controller "
        "that raises the current until the stem lets go cannot stop in the band but by luck."
    )


def _where(grid: Grid, text: str, holds: np.ndarray) -> str:
    """Say in how many cases something holds, and along which factor that changes most."""
    shares = {name: shares_along(grid, holds, axis) for axis, name in enumerate(grid.factors)}
    name = max(shares, key=lambda each: np.ptp(shares[each]))
    along = ", ".join(
        f"{_percent(share)} at {level:g}" for level, share in zip(grid.factors[name], shares[name], strict=True)
    )
    said = f"{text}: {_percent(holds)} of {holds.size} cases"
    return f"{said}." if np.ptp(shares[name]) == 0.0 else f"{said}; most by {name.replace('_', ' ')}: {along}."


def shares_along(grid: Grid, holds: np.ndarray, *axes: int) -> np.ndarray:
    """Return the share of cases in which something holds, for each level of one or two factors."""
    others = tuple(axis for axis in range(len(grid.factors)) if axis not in axes)
    return holds.mean(axis=others)


def _percent(holds: np.ndarray | float) -> str:
    return f"{100.0 * float(np.mean(holds)):.0f} %"


def as_json(grid: Grid) -> dict[str, Any]:
    """Return the content of claims.json."""
    return {
        "schema": SCHEMA,
        "model": grid.model.as_json(),
        "period": {"value": grid.period, "unit": "s"},
        "noise": {"value": grid.noise, "unit": "m"},
        "band": {"value": grid.band, "unit": "m"},
        "hold": {"value": HOLD, "unit": "s"},
        "factors": {name: list(levels) for name, levels in grid.factors.items()},
        "nominal": NOMINAL,
        "slip_jumps": {"value": {f"{ratio:g}": jump for ratio, jump in grid.slip_jumps.items()}, "unit": "m"},
        "tuned": {key: dict(values) for key, values in grid.tuned.items()},
        "claims": {
            key: {
                "as_tested": text,
                "share": float(holds.mean()),
                "share_by": {name: shares_along(grid, holds, axis) for axis, name in enumerate(grid.factors)},
            }
            for key, (text, holds) in claims_of(grid).items()
        },
        "fails": {
            key: {
                "share": float((~grid.is_well(key)).mean()),
                "share_by": {
                    name: shares_along(grid, ~grid.is_well(key), axis) for axis, name in enumerate(grid.factors)
                },
            }
            for key in KEYS
        },
        "findings": findings_of(grid),
        "measured": {key: dict(measures) for key, measures in grid.measured.items()},
    }
