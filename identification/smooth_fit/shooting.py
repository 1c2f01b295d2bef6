"""Multiple shooting: the fit as a sparse nonlinear program, a state at the start of each segment, solved by IPOPT."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from identification.problem import Problem
from identification.search import Found
from identification.smooth_fit.residuals import arriving_function, chain_for, parameters_of
from identification.unknowns import Unknown
from valvemodel.periods import finer

SEGMENT_TIME = 2.0
"""Usual length of a segment. [s]"""

IPOPT = {
    "print_time": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.max_iter": 60,
    "ipopt.tol": 1e-4,
    "ipopt.acceptable_iter": 3,
}
"""Libraries do not print."""


class ShootingProgram:
    """A fit problem as a nonlinear program in the scaled unknowns and the states at the nodes.

    IPOPT is given the Hessian of Gauss and Newton, which is cheaper than the exact one of the Lagrangian.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        theta, self._width = ca.MX.sym("theta", len(problem.unknowns)), ca.MX.sym("width")
        segments = [_Segments(problem, number, theta, self._width) for number in range(len(problem.experiments))]
        spread = ca.DM([unknown.prior_spread for unknown in problem.unknowns])
        residuals = ca.vertcat(*(each.residuals for each in segments), theta / spread)
        unknowns = ca.vertcat(theta, *(ca.vec(each.nodes) for each in segments))
        jumps = ca.vertcat(*(each.jumps for each in segments))
        self._program: Any = {"x": unknowns, "p": self._width, "f": 0.5 * ca.sumsqr(residuals), "g": jumps}
        hessian = _gauss_newton(unknowns, self._width, residuals, jumps)
        self._options: dict[str, Any] = {**IPOPT, "hess_lag": hessian}
        self._first = ca.Function("first", [theta, self._width], [ca.vertcat(*(each.guess for each in segments))])
        self._count = len(problem.unknowns)

    def solve(self, start: np.ndarray, width: float, nodes: np.ndarray | None = None) -> tuple[Found, np.ndarray]:
        """Solve the program at a width [N] from a scaled point; the nodes begin at the readings, or where given.

        Returns
        -------
        (Found, array)
            The scaled point with half its sum of squared residuals, and the scaled nodes for the next width.
        """
        solver = ca.nlpsol("fit", "ipopt", self._program, self._options)
        low, high = self.problem.bounds
        if nodes is None:
            nodes = self._first(start, width).full().ravel()
        free = np.full(len(nodes), np.inf)
        result = solver(
            x0=np.concatenate([np.clip(start, low, high), nodes]),
            p=width,
            lbx=np.concatenate([low, -free]),
            ubx=np.concatenate([high, free]),
            lbg=0.0,
            ubg=0.0,
        )
        solution = result["x"].full().ravel()
        return Found(solution[: self._count], float(result["f"])), solution[self._count :]


class _Segments:
    """One experiment cut into segments: `nodes`, scaled, `jumps` between them, `residuals`, and a `guess` of the nodes.

    The guess is the chain at rest at the readings.
    """

    def __init__(self, problem: Problem, number: int, theta: ca.MX, width: ca.MX) -> None:
        self._experiment, self._used = problem.experiments[number], np.flatnonzero(problem.used[number])
        self._chain = chain_for(problem.model, self._experiment)
        columns = [column for column, each in enumerate(problem.unknowns) if each.experiment in (-1, number)]
        unknowns = [problem.unknowns[column] for column in columns]
        values = ca.vertcat(*(_value(problem.unknowns[column], theta[column]) for column in columns))
        self._values = dict(zip((unknown.name for unknown in unknowns), ca.vertsplit(values), strict=True))
        self._p = parameters_of(self._chain, unknowns, values, width)
        self._rows = len(self._experiment.time) - 1
        usual = max(round(SEGMENT_TIME / self._experiment.period), 1)
        self._length = min(usual, -(-self._rows // 2))
        self._count = -(-self._rows // self._length)
        self._run()

    def _run(self) -> None:
        """Run all segments at once, each from its node."""
        chain, p, length = self._chain, self._p, self._length
        scale = ca.DM(chain.scales)
        start = chain.start(self._values["start_position"], self._experiment.current[0], p)
        self.nodes = ca.MX.sym("nodes", len(chain.states), self._count - 1)
        begins = ca.horzcat(start, self.nodes * scale)
        through = chain.part.mapaccum(length * chain.parts).map(self._count)
        held = self._held()
        states = through(begins, held, ca.repmat(p, 1, held.size2()))[:, chain.parts - 1 :: chain.parts]
        ends = states[:, length - 1 : (self._count - 1) * length : length]
        self.jumps = ca.vec((ends - begins[:, 1:]) / scale)
        self.residuals = self._left_over(ca.horzcat(start, states[:, : self._rows]))
        at = np.arange(1, self._count) * length
        readings, before = (
            ca.DM(each).T for each in (_filled(self._experiment.position)[at], self._experiment.current[at - 1])
        )
        self.guess = ca.vec(chain.start.map(self._count - 1)(readings, before, p) / scale)

    def _held(self) -> ca.MX:
        """Return current and duration of each part, the last one repeated to fill the last segment."""
        chain = self._chain
        delay = self._values.get("transport_delay", chain.model.numbers.get("transport_delay", 0.0))
        arriving = arriving_function(self._experiment, chain)(delay)[0]
        held = ca.vertcat(arriving, ca.DM(np.diff(finer(self._experiment.time, chain.parts))).T)
        missing = self._count * self._length - self._rows
        return ca.horzcat(held, ca.repmat(held[:, -1], 1, missing * chain.parts))

    def _left_over(self, states: ca.MX) -> ca.MX:
        """Return the weighted residuals of states at all rows."""
        experiment, index = self._experiment, self._used.tolist()
        readings = self._chain.reading.map(self._rows + 1)(states, self._p).T
        residuals = (ca.DM(experiment.position[self._used]) - readings[index]) / experiment.noise
        if experiment.pressure is None:
            return residuals
        pressures = self._chain.pressure.map(self._rows + 1)(states, self._p).T
        read = self._used[np.isfinite(experiment.pressure[self._used])]
        left = (ca.DM(experiment.pressure[read]) - pressures[read.tolist()]) / experiment.pressure_noise
        return ca.vertcat(residuals, left)


def _gauss_newton(unknowns: ca.MX, width: ca.MX, residuals: ca.MX, gaps: ca.MX) -> ca.Function:
    """Return the Hessian of the squares without the residuals' own curvature, in the form that IPOPT takes."""
    jacobian = ca.jacobian(residuals, unknowns)
    weight, multipliers = ca.MX.sym("weight"), ca.MX.sym("multipliers", gaps.size1())
    hessian = ca.triu(weight * ca.mtimes(jacobian.T, jacobian))
    names = (["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"])
    return ca.Function("hess_lag", [unknowns, width, weight, multipliers], [hessian], *names)


def _value(unknown: Unknown, scaled: ca.MX) -> ca.MX:
    if unknown.is_logarithmic:
        return unknown.centre * ca.exp(scaled)
    return unknown.centre + unknown.spread * scaled


def _filled(position: np.ndarray) -> np.ndarray:
    """Return readings with gaps filled from their neighbours."""
    there = np.isfinite(position)
    return np.interp(np.arange(len(position)), np.flatnonzero(there), position[there])
