"""A contest: every kind of controller tuned alike, then run on the same set points and measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from valvemodel.control.branches import branches_of
from valvemodel.control.calibration import self_calibrate
from valvemodel.control.controller import Controller
from valvemodel.control.kinds import KINDS, Kind
from valvemodel.control.loop import Run
from valvemodel.control.measures import Measures, measures_of, overall
from valvemodel.control.scenario import Scenario, check_conditions, held_levels
from valvemodel.control.side_by_side import side_by_side
from valvemodel.control.tuning import BUDGET, Bench, cost, tune
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.progress import Progress, tell_nobody

JUDGED = (0.50, 0.75, 0.71, 0.40, 0.45, 0.90, 0.20)
"""Set points of the contest as shares of the reach: long and short steps, with and against the last one."""

TRAINED = (0.30, 0.70, 0.62, 0.25, 0.33, 0.80, 0.55, 0.15)
"""Set points of the tuning as shares of the reach."""

START_CURRENT = 12e-3
"""The valve rests at mid-range, from which (34) counts. [A]"""


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
    progress: Progress = tell_nobody,
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
    tuned_kinds = [kind for kind in kinds if not kind.tuned_as]
    tunings = side_by_side(
        lambda kind, go_on: tune(bench, kind, training, budget=budget, go_on=go_on),
        tuned_kinds,
        lambda done: progress(f"tuning {len(kinds)} controllers", done),
    )
    found = {kind.key: tuning for kind, tuning in zip(tuned_kinds, tunings, strict=True)}
    entries = [_enter(bench, kind, scenario, *found[kind.tuned_as or kind.key]) for kind in kinds]
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


def _enter(bench: Bench, kind: Kind, scenario: Scenario, tuned: Mapping[str, float], least: float) -> Entry:
    controller = bench.controller(kind, tuned)
    run = bench.run(controller, scenario)
    steps = measure(run, scenario, bench.model)
    return Entry(kind, controller, least, cost(run), run, steps, overall(steps))
