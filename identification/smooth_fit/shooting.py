"""Multiple shooting: the fit as a sparse nonlinear program, a state at the start of each segment, solved by IPOPT."""

from __future__ import annotations

import casadi as ca
import numpy as np

from identification.problem import Problem
from identification.search import Found
from identification.smooth_fit.residuals import arriving_function, chain_for, parameters_of
from identification.unknowns import Unknown

SEGMENT_TIME = 2.0
"""Usual length of a segment. [s]"""

SCALES = {"position": 1e-2, "linkage": 1e-2, "lagged_reading": 1e-2, "velocity": 1e-2, "time": 1.0, "hysteresis": 1.0}
"""Size of a change of a state that counts; pressures and currents by their endings. [SI]"""

IPOPT = {"print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes"}
"""Libraries do not print."""


class ShootingProgram:
    """A fit problem as a nonlinear program in the scaled unknowns and the states at the nodes.

    Parameters
    ----------
    problem : Problem
    has_exact_curvature : bool
        Whether IPOPT is given the exact Hessian of the Lagrangian; else that of Gauss and Newton, which is cheaper.
    """

    def __init__(self, problem: Problem, *, has_exact_curvature: bool = False) -> None:
        self.problem = problem
        theta, self._width = ca.MX.sym("theta", len(problem.unknowns)), ca.MX.sym("width")
        nodes, residuals, gaps, self._guess = [], [], [], []
        for number in range(len(problem.experiments)):
            own, left, jumps, first = self._segments(number, theta)
            nodes.append(ca.vec(own))
            residuals.append(left)
            gaps.append(ca.vec(jumps))
            self._guess.append(first)
        spread = ca.DM([unknown.prior_spread for unknown in problem.unknowns])
        left_over = ca.vertcat(*residuals, theta / spread)
        self._count = theta.size1()
        unknowns = ca.vertcat(theta, *nodes)
        program = {"x": unknowns, "p": self._width, "f": 0.5 * ca.sumsqr(left_over), "g": ca.vertcat(*gaps)}
        options = dict(IPOPT)
        if not has_exact_curvature:
            options["hess_lag"] = _gauss_newton(unknowns, self._width, left_over, program["g"])
        self._options, self._program = options, program
        self._first = ca.Function("first", [theta, self._width], [ca.vertcat(*self._guess)])

    def _segments(self, number: int, theta: ca.MX) -> tuple[ca.MX, ca.MX, ca.MX, ca.MX]:
        """Return scaled node states, weighted residuals, scaled jumps and the nodes' guess of one experiment."""
        experiment, used = self.problem.experiments[number], self.problem.used[number]
        chain = chain_for(self.problem.model, experiment)
        columns = [column for column, each in enumerate(self.problem.unknowns) if each.experiment in (-1, number)]
        unknowns = [self.problem.unknowns[column] for column in columns]
        values = ca.vertcat(*(_value(self.problem.unknowns[column], theta[column]) for column in columns))
        names = [unknown.name for unknown in unknowns]
        p = parameters_of(chain, unknowns, values, self._width)
        count = len(experiment.time) - 1
        length = max(round(SEGMENT_TIME / float(np.median(np.diff(experiment.time)))), 1)
        segments = -(-count // length)
        delay = values[names.index("transport_delay")] if "transport_delay" in names else 0.0
        arriving = arriving_function(experiment, "transport_delay" in names)(delay)[0]
        held = ca.vertcat(arriving, ca.DM(np.diff(experiment.time)).T)
        held = ca.horzcat(held, ca.repmat(held[:, -1], 1, segments * length - count))
        scale = ca.DM([_scale(name) for name in chain.states])
        start = chain.start(values[names.index("start_position")], experiment.current[0], p)
        nodes = ca.MX.sym("nodes", len(chain.states), segments - 1)
        begins = ca.horzcat(start, nodes * scale)
        through = chain.step.mapaccum(length).map(segments)
        states = through(begins, held, ca.repmat(p, 1, segments * length))
        ends = states[:, length - 1 : (segments - 1) * length : length]
        jumps = (ends - begins[:, 1:]) / scale
        whole = ca.horzcat(start, states[:, :count])
        index = np.flatnonzero(used).tolist()
        readings = chain.reading.map(count + 1)(whole, p).T
        residuals = (ca.DM(experiment.position[used]) - readings[index]) / experiment.noise
        if experiment.pressure is not None:
            pressures = chain.pressure.map(count + 1)(whole, p).T
            left = (ca.DM(experiment.pressure[used]) - pressures[index]) / experiment.pressure_noise
            residuals = ca.vertcat(residuals, left)
        at = np.arange(1, segments) * length
        held_before = ca.DM(experiment.current[at - 1]).T
        guess = chain.start.map(segments - 1)(ca.DM(_filled(experiment.position)[at]).T, held_before, p) / scale
        return nodes, residuals, jumps, ca.vec(guess)

    def solve(
        self, start: np.ndarray, width: float, nodes: np.ndarray | None = None, *, iterations: int = 60
    ) -> tuple[Found, np.ndarray]:
        """Solve the program at a width [N] from a scaled point; the nodes begin at the readings, or where given.

        Returns
        -------
        (Found, array)
            The scaled point with half its sum of squared residuals, and the scaled nodes for the next width.
        """
        options = {**self._options, "ipopt.max_iter": iterations, "ipopt.tol": 1e-4, "ipopt.acceptable_iter": 3}
        solver = ca.nlpsol("fit", "ipopt", self._program, options)
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


def _scale(name: str) -> float:
    if name.endswith("pressure") or name == "droop":
        return 1e4
    if name.endswith(("current", "input")):
        return 1e-3
    return SCALES.get(name, 1e2)


def _filled(position: np.ndarray) -> np.ndarray:
    """Return readings with gaps filled from their neighbours."""
    there = np.isfinite(position)
    return np.interp(np.arange(len(position)), np.flatnonzero(there), position[there])
