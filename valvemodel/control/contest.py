"""A contest: every kind of controller tuned alike, then run on the same set points and measured."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from valvemodel.control.branches import branches_of
from valvemodel.control.calibration import self_calibrate
from valvemodel.control.controller import Controller
from valvemodel.control.kinds import KINDS, Kind
from valvemodel.control.laws.settings import CHOICES, SETTING_PARAMETERS
from valvemodel.control.loop import Run
from valvemodel.control.measures import BAND_SHARE, UNITS, Measures, measures_of, overall
from valvemodel.control.scenario import Scenario, check_conditions, held_levels
from valvemodel.control.tuning import AGEING, BUDGET, WEAR, Bench, cost, tune
from valvemodel.errors import InputError
from valvemodel.model import Model

SCHEMA = "valvemodel.control/1"

JUDGED = (0.50, 0.75, 0.71, 0.40, 0.45, 0.90, 0.20)
"""Set points of the contest as shares of the reach: long and short steps, with and against the last one."""

TRAINED = (0.30, 0.70, 0.62, 0.25, 0.33, 0.80, 0.55, 0.15, 0.35, 0.95, 0.88, 0.65)
"""Set points of the tuning as shares of the reach."""

START_CURRENT = 12e-3
"""The valve rests at mid-range, from which (34) counts. [A]"""

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Entry:
    """A controller in a contest: what it was tuned to, how it ran and how it measured."""

    kind: Kind
    controller: Controller
    training_cost: float
    cost: float
    run: Run
    steps: list[Measures]
    overall: dict[str, float]


@dataclass(frozen=True)
class Contest:
    """A contest that was held."""

    bench: Bench
    scenario: Scenario
    training: Scenario
    budget: int
    entries: list[Entry]

    def entry(self, key: str) -> Entry:
        """Return the entry of a kind."""
        return next(entry for entry in self.entries if entry.kind.key == key)

    @property
    def has_one_friction(self) -> bool:
        """Whether the valve's static friction is its sliding one, so that a slip can be as short as one likes."""
        return self.bench.branches.slip_jump == 0.0

    def as_json(self) -> dict[str, Any]:
        """Return the content of control.json."""
        return {
            "schema": SCHEMA,
            "model": self.bench.model.as_json(),
            "scenario": scenario_json(self.scenario),
            "training": scenario_json(self.training),
            "tuning": {
                "cost": "mean absolute error + 1 s x mean speed of travel beyond what the set points ask for",
                "wear": {"value": WEAR, "unit": "s"},
                "valves": f"as it is, and with friction grown by {100 * AGEING:g} %; the mean of both counts",
                "settings_tried": self.budget,
                "method": "differential evolution, then Nelder-Mead, over the logarithms of the settings",
            },
            "settling_band": {"value": BAND_SHARE * self.bench.model.values["rated_travel"], "unit": "m"},
            "calibration": calibration_json(self.bench),
            "units": UNITS,
            "controllers": [_entry_json(entry) for entry in self.entries],
        }


def hold_contest(
    model: Model,
    *,
    levels: Sequence[float] | None = None,
    duration: float = 20.0,
    period: float = 0.01,
    noise: float = 1e-4,
    resolution: float = 0.0,
    load: float = 0.0,
    seed: int = 0,
    budget: int = BUDGET,
    kinds: Sequence[Kind] = KINDS,
    progress: Progress = lambda what, share: None,
) -> Contest:
    """Calibrate and tune on a valve, then run every kind of controller on the same set points.

    Parameters
    ----------
    model : Model
    levels : sequence of float, optional
        Set points; by default shares of what the valve can reach from both sides. [m]
    duration : float
        For which each is held, in the tuning too. [s]
    period : float
        Of the controllers. [s]
    noise, resolution : float
        Standard deviation of the reading's noise; its step. [m]
    load : float
        Force that acts in the second half of each set point, also in the tuning. [N]
    seed : int
        Of the noise; tuning, calibration and contest draw different noise.
    budget : int
        Runs for the tuning of each kind.

    Returns
    -------
    Contest

    Raises
    ------
    InputError
        If the valve cannot be calibrated, or a set point is out of its reach.
    """
    check_conditions(period=period, noise=noise, resolution=resolution)
    bench = make_bench(model, noise=noise, resolution=resolution, seed=seed)
    low, high = bench.branches.reach

    def held(levels: Sequence[float], seed: int) -> Scenario:
        return held_levels(
            levels, duration=duration, period=period, noise=noise, resolution=resolution, load=load, seed=seed
        )

    check_levels(levels or (), low, high)
    scenario = held(levels or [low + share * (high - low) for share in JUDGED], 3 * seed + 2)
    training = held([low + share * (high - low) for share in TRAINED], 3 * seed + 1)
    entries: list[Entry] = []
    for index, kind in enumerate(kinds):
        progress(f"tuning {kind.title}", index / len(kinds))
        entries.append(_enter(bench, kind, scenario, training, budget, entries))
    progress("done", 1.0)
    return Contest(bench, scenario, training, budget, entries)


def make_bench(model: Model, *, noise: float, resolution: float, seed: int) -> Bench:
    """Return a valve with its calibration and its model's branches."""
    calibration = self_calibrate(model, noise=noise, resolution=resolution, seed=3 * seed)
    return Bench(model, calibration, branches_of(model), START_CURRENT)


def check_levels(levels: Sequence[float], low: float, high: float) -> None:
    """Refuse set points that the valve cannot reach from both sides within 4..20 mA."""
    for level in levels:
        if not low <= level <= high:
            raise InputError(
                f"a set point lies within the valve's reach from both sides, {1e3 * low:.4g}..{1e3 * high:.4g} mm",
                f"got {1e3 * level:.4g} mm",
                "choose one within it",
            )


def measure(run: Run, scenario: Scenario, model: Model) -> list[Measures]:
    """Measure each step of a run, on the stem's true position."""
    return [
        measures_of(
            run.position[part],
            float(run.setpoint[part.start]),
            period=scenario.period,
            rated_travel=model.values["rated_travel"],
        )
        for part in scenario.steps
    ]


def _enter(
    bench: Bench, kind: Kind, scenario: Scenario, training: Scenario, budget: int, before: Sequence[Entry]
) -> Entry:
    model_entry = next((entry for entry in before if entry.kind.key == kind.tuned_as), None)
    if model_entry is None:
        tuned, least = tune(bench, kind, training, budget=budget)
    else:
        tuned = {each.name: model_entry.controller.settings[each.name] for each in kind.tunables}
        least = model_entry.training_cost
    controller = bench.controller(kind, tuned)
    run = bench.run(controller, scenario)
    steps = measure(run, scenario, bench.model)
    return Entry(kind, controller, least, cost(run), run, steps, overall(steps))


def scenario_json(scenario: Scenario) -> dict[str, Any]:
    """Return set points and conditions with their units."""
    levels = [float(scenario.setpoint[part.start]) for part in scenario.steps]
    return {
        "setpoints": {"value": levels, "unit": "m"},
        "duration": {"value": scenario.period * len(scenario.setpoint), "unit": "s"},
        "period": {"value": scenario.period, "unit": "s"},
        "noise": {"value": float(np.std(scenario.noise)), "unit": "m"},
        "resolution": {"value": scenario.resolution, "unit": "m"},
        "load": {"value": float(np.max(np.abs(scenario.load))), "unit": "N"},
    }


def calibration_json(bench: Bench) -> dict[str, Any]:
    """Return what self-calibration found, beside the true widths of the loop."""
    found = bench.calibration
    low, high = bench.branches.reach
    places = {"low": low, "middle": 0.5 * (low + high), "high": high}
    return {
        "records": {
            "current": {"value": [*found.rising[:, 0], *found.falling[:, 0]], "unit": "A"},
            "position": {"value": [*found.rising[:, 1], *found.falling[:, 1]], "unit": "m"},
        },
        "slope": {"value": found.slope, "unit": "m/A"},
        "rising_intercept": {"value": found.rising_intercept, "unit": "m"},
        "falling_intercept": {"value": found.falling_intercept, "unit": "m"},
        "threshold": {"value": found.threshold, "unit": "A"},
        "true_width": [
            {
                "where": name,
                "position": {"value": place, "unit": "m"},
                "value": (width := float(bench.branches.width(place))),
                "unit": "A",
                "error_of_threshold": found.threshold / width - 1.0,
            }
            for name, place in places.items()
        ],
    }


_UNITS_OF_SETTINGS = {name: "1" for name in CHOICES} | {each.name: each.unit for each in SETTING_PARAMETERS}


def _entry_json(entry: Entry) -> dict[str, Any]:
    return {
        "key": entry.kind.key,
        "title": entry.kind.title,
        "source": entry.kind.source,
        "knows": entry.kind.knows,
        "tuned": [tunable.name for tunable in entry.kind.tunables],
        "tuned_as": entry.kind.tuned_as or entry.kind.key,
        "settings": {
            name: {"value": value, "unit": _UNITS_OF_SETTINGS[name]}
            for name, value in entry.controller.settings.items()
        },
        "training_cost": {"value": entry.training_cost, "unit": "m"},
        "cost": {"value": entry.cost, "unit": "m"},
        "steps": [asdict(step) for step in entry.steps],
        "overall": entry.overall,
    }
