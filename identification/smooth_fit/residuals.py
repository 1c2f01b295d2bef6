"""Residuals of the smooth chain with their exact derivatives, run through from the start position."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from identification.experiment import Experiment
from identification.problem import LOST, Problem
from identification.unknowns import Unknown
from valvemodel.model import Model
from valvemodel.periods import finer
from valvemodel.smooth.chain import WIDTH, SmoothChain, parts_for
from valvemodel.smooth.delay import delayed_current
from valvemodel.smooth.rounding import Expression


class SmoothResiduals:
    """Weighted residuals of a problem on the smooth chain and their Jacobian, at any smoothing width.

    The states and their derivatives by the unknowns advance together, as one recursion.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self._spread = np.array([unknown.prior_spread for unknown in problem.unknowns])
        self._runs = [_Run(problem, number) for number in range(len(problem.experiments))]

    def residuals(self, point: np.ndarray, width: float) -> np.ndarray:
        """Return measured less simulated at a scaled point and a width [N], then the priors, shape (r,). [noise]"""
        parts = [run.residuals(point, width) for run in self._runs]
        return np.concatenate([*parts, point / self._spread])

    def jacobian(self, point: np.ndarray, width: float) -> np.ndarray:
        """Return their derivative at a scaled point, shape (r, unknowns)."""
        parts = [run.jacobian(point, width) for run in self._runs]
        return np.vstack([*parts, np.diag(1.0 / self._spread)])


class _Run:
    """One experiment on the smooth chain."""

    def __init__(self, problem: Problem, number: int) -> None:
        self._experiment, self._used = problem.experiments[number], np.flatnonzero(problem.used[number])
        columns = [column for column, each in enumerate(problem.unknowns) if each.experiment in (-1, number)]
        self._columns, self._count = columns, len(problem.unknowns)
        self._unknowns = [problem.unknowns[column] for column in columns]
        chain = chain_for(problem.model, self._experiment)
        self._parts, self._delay = chain.parts, chain.model.numbers.get("transport_delay", 0.0)
        self._durations = np.diff(finer(self._experiment.time, chain.parts))
        self._compose(chain, len(self._experiment.time))
        self._arriving = arriving_function(self._experiment, chain)

    def _compose(self, chain: SmoothChain, count: int) -> None:
        """Make the recursions: of the state, and of the state with its derivatives by the unknowns."""
        q, width = ca.SX.sym("q", len(self._unknowns)), ca.SX.sym("width")
        p = parameters_of(chain, self._unknowns, q, width)
        x, u = ca.SX.sym("x", len(chain.states)), ca.SX.sym("u", 3)
        s = ca.SX.sym("s", len(chain.states), len(self._unknowns))
        after = chain.part(x, u[:2], p)
        by_all = ca.jacobian(after, ca.vertcat(x, q, u[0]))
        by_state, by_unknown, by_current = ca.horzsplit(
            by_all, [0, len(chain.states), by_all.size2() - 1, by_all.size2()]
        )
        moved = ca.mtimes(by_state, s) + by_unknown
        for column, unknown in enumerate(self._unknowns):
            if unknown.name == "transport_delay":
                moved[:, column] += by_current * u[2]
        given, stacked = ca.vertcat(q, width), ca.vertcat(x, ca.vec(s))
        plain = ca.Function("plain", [x, u, given], [after])
        both = ca.Function("both", [stacked, u, given], [ca.vertcat(after, ca.vec(moved))])
        self._plain, self._both = (each.mapaccum((count - 1) * chain.parts) for each in (plain, both))
        first, current = ca.SX.sym("first"), ca.SX.sym("current")
        start = chain.start(first, current, p)
        where = [each.experiment >= 0 for each in self._unknowns].index(True)
        placed = ca.substitute(start, first, q[where])
        self._start = ca.Function("start", [current, given], [placed, ca.vec(ca.jacobian(placed, q))])
        outputs = ca.vertcat(chain.reading(x, p), chain.pressure(x, p))
        slopes = ca.mtimes(ca.jacobian(outputs, x), s) + ca.jacobian(outputs, q)
        self._read = ca.Function("read", [x, given], [outputs]).map(count)
        self._slopes = ca.Function("slopes", [stacked, given], [ca.vec(slopes)]).map(count)

    def _given(self, point: np.ndarray, width: float) -> np.ndarray:
        own = point[self._columns]
        values = [float(unknown.value(x)) for unknown, x in zip(self._unknowns, own, strict=True)]
        return np.array([*values, width])

    def _held(self, given: np.ndarray) -> np.ndarray:
        names = [unknown.name for unknown in self._unknowns]
        delay = given[names.index("transport_delay")] if "transport_delay" in names else self._delay
        arriving, slope = self._arriving(delay)
        return np.vstack([arriving.full(), self._durations, slope.full()])

    def _at_rows(self, states: ca.DM) -> ca.DM:
        """Return the states at the ends of periods out of those at the ends of parts."""
        return states[:, self._parts - 1 :: self._parts]

    def _weighted(self, outputs: np.ndarray) -> np.ndarray:
        """Weight rows of readings and pressures, shape (2, n, ...), as residuals that count."""
        experiment = self._experiment
        parts = [outputs[0][self._used] / experiment.noise]
        if experiment.pressure is not None:
            pressures = outputs[1][self._used] / experiment.pressure_noise
            pressures[~np.isfinite(experiment.pressure[self._used])] = 0.0
            parts.append(pressures)
        return np.concatenate(parts)

    def residuals(self, point: np.ndarray, width: float) -> np.ndarray:
        given = self._given(point, width)
        start, _ = self._start(self._experiment.current[0], given)
        states = self._at_rows(self._plain(start, self._held(given), given))
        outputs = self._read(ca.horzcat(start, states), given).full()
        measured = np.zeros_like(outputs)
        measured[0] = self._experiment.position
        if self._experiment.pressure is not None:
            measured[1] = self._experiment.pressure
        residuals = self._weighted(measured - outputs)
        return np.where(np.isfinite(residuals), residuals, LOST)

    def jacobian(self, point: np.ndarray, width: float) -> np.ndarray:
        given = self._given(point, width)
        start = ca.vertcat(*self._start(self._experiment.current[0], given))
        states = self._at_rows(self._both(start, self._held(given), given))
        slopes = self._slopes(ca.horzcat(start, states), given).full()
        scale = [unknown.slope(value) for unknown, value in zip(self._unknowns, given[:-1], strict=True)]
        by_output = slopes.reshape(len(scale), 2, -1).transpose(1, 2, 0) * np.array(scale)
        rows = -self._weighted(by_output)
        jacobian = np.zeros((len(rows), self._count))
        jacobian[:, self._columns] = np.where(np.isfinite(rows), rows, 0.0)
        return jacobian


def chain_for(model: Model, experiment: Experiment) -> SmoothChain:
    """Return the smooth chain of a model, its periods cut as the experiment's sampling asks for."""
    return SmoothChain(model, parts=experiment.parts * parts_for(model, experiment.period / experiment.parts))


def parameters_of(chain: SmoothChain, unknowns: list[Unknown], q: Expression, width: Expression) -> Expression:
    """Return the chain's p with values of unknowns and the width put in; the rest are the model's numbers."""
    names = [unknown.name for unknown in unknowns]
    numbers: dict[str, Any] = {**chain.model.numbers, WIDTH: width}
    values: list[Any] = [q[names.index(name)] if name in names else numbers[name] for name in chain.parameters]
    return ca.vertcat(*values)


def arriving_function(experiment: Experiment, chain: SmoothChain) -> ca.Function:
    """Return the function from a delay [s] to the current that arrives in each part, and its derivative."""
    delay = ca.MX.sym("delay")
    (time, current), parts = experiment.drive, chain.parts // experiment.parts
    if "transport_delay" in chain.parameters:
        arriving = delayed_current(time, current, delay, parts)
    else:
        arriving = ca.MX(ca.DM(np.repeat(current[:-1], parts)).T)
    return ca.Function("arriving", [delay], [arriving, ca.jacobian(arriving, delay).T])
