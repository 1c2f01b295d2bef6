"""Tuning: every kind by the same budget of runs, on the same cost, on set points other than those judged."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from valvemodel.control.branches import Branches
from valvemodel.control.calibration import Calibration
from valvemodel.control.controller import Controller
from valvemodel.control.kinds import Kind
from valvemodel.control.loop import Run, run_compiled
from valvemodel.control.scenario import Scenario
from valvemodel.model import Model

BUDGET = 400
"""Runs that each kind may use."""

GLOBAL_SHARE = 0.8
"""Share of them for the search over the whole box; the rest polish its best."""

POPULATION = 32
"""Members of a generation, a power of two as Sobol's sequence wants it."""

SEED = 0
"""Of the search, so that a contest can be repeated."""

AGEING = 0.2
"""Growth of the friction on the second of the two valves that a tuning must suit; the first is the fresh one."""

WEAR = 1.0
"""Weight of needless travel: seconds by which a mean speed counts as a mean error. [s]"""


def cost(run: Run) -> float:
    """Return the mean absolute error, plus a second of the mean speed of travel that the set points did not ask for.

    [m]; of the stem's true position.
    """
    error = np.mean(np.abs(run.position - run.setpoint))
    asked = np.abs(np.diff(run.setpoint)).sum() + abs(run.setpoint[0] - run.position[0])
    needless = max(np.abs(np.diff(run.position)).sum() - asked, 0.0)
    return float(error + WEAR * needless / (run.time[-1] - run.time[0]))


def aged(model: Model, growth: float) -> Model:
    """Return the model with its friction grown by a share, static as well as sliding."""
    return model.with_values(coulomb_friction=model.values["coulomb_friction"] * (1.0 + growth))


@dataclass(frozen=True)
class Bench:
    """What kinds are tuned and judged on: a valve, what its calibration and its model say, where it starts.

    Parameters
    ----------
    model : Model
        The valve.
    calibration : Calibration
    branches : Branches
    start_current : float
        At which the valve rests and from which (34) counts. [A]
    """

    model: Model
    calibration: Calibration
    branches: Branches
    start_current: float

    def controller(self, kind: Kind, tuned: Mapping[str, float]) -> Controller:
        """Return a kind with tuned settings."""
        return kind.controller(
            tuned, start_current=self.start_current, calibration=self.calibration, branches=self.branches
        )

    def training_cost(self, controller: Controller, scenario: Scenario) -> float:
        """Return the mean cost on the fresh and on the aged valve. [m]"""
        valves = (self.model, aged(self.model, AGEING))
        return 0.5 * sum(cost(self.run(controller, scenario, valve)) for valve in valves)

    def run(self, controller: Controller, scenario: Scenario, model: Model | None = None) -> Run:
        """Run a controller on the bench's valve, or on another in its place."""
        return run_compiled(model or self.model, controller, scenario, start_current=self.start_current)


def tune(
    bench: Bench,
    kind: Kind,
    scenario: Scenario,
    *,
    budget: int = BUDGET,
    go_on: Callable[[], None] = lambda: None,
) -> tuple[dict[str, float], float]:
    """Return the settings of least cost that a budget of runs finds, and that cost [m]; the same at every call.

    Differential evolution (Storn and Price 1997) over the box of the logarithms, then Nelder and Mead's simplex.
    `go_on` is called before each run and may raise.
    """
    if not kind.tunables:
        return {}, bench.training_cost(bench.controller(kind, {}), scenario)
    from scipy.optimize import differential_evolution, minimize
    from scipy.stats import qmc

    scales = np.array([tunable.scale(bench.branches) for tunable in kind.tunables])
    low, high = (np.log(scales * [getattr(each, side) for each in kind.tunables]) for side in ("low", "high"))
    tried: list[tuple[float, np.ndarray]] = []

    def try_out(place: np.ndarray) -> float:
        if len(tried) >= budget:
            return np.inf
        go_on()
        place = np.clip(place, low, high)
        tried.append((bench.training_cost(bench.controller(kind, _named(kind, place)), scenario), place))
        return tried[-1][0]

    population = low + (high - low) * qmc.Sobol(len(low), seed=SEED).random(POPULATION)
    generations = max(round(GLOBAL_SHARE * budget / POPULATION) - 1, 1)
    box = list(zip(low, high, strict=True))
    differential_evolution(try_out, box, init=population, maxiter=generations, polish=False, tol=0.0, seed=SEED)
    if len(tried) < budget:
        minimize(try_out, _best(tried)[1], method="Nelder-Mead", options={"maxfev": budget - len(tried)})
    least, place = _best(tried)
    return _named(kind, place), least


def _best(tried: list[tuple[float, np.ndarray]]) -> tuple[float, np.ndarray]:
    return min(tried, key=lambda each: each[0])


def _named(kind: Kind, place: np.ndarray) -> dict[str, float]:
    return {tunable.name: float(value) for tunable, value in zip(kind.tunables, np.exp(place), strict=True)}
