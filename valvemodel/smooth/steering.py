"""Steering: currents that bring the smooth chain to a reading and keep it there, as a nonlinear program."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from valvemodel.smooth.chain import SmoothChain

CURRENT_SCALE, LENGTH_SCALE = 1e-3, 1e-3
"""Currents and readings are of the size of 1 in the program. [A], [m]"""

HASTE, LEISURE = (0.1, 0.01), (1e-4, 1.0)
"""Prices of a millimetre that is still to go for a period, and of a milliampere of travel: soonest, or least travel."""

MISS_PRICE = 1000.0
"""Price of a millimetre outside the band: neither haste nor travel is worth a miss."""

MISSED = 2e-5
"""A band that is missed by less is reached. [m]"""

CURVATURE = 1e-2
"""What stands in for all curvature: the program is linear but for the chain, and its solution a corner."""

GAP = 1e-4
"""Greatest violation of a scaled constraint of a solution, that is 0.1 um: IPOPT ends between 1e-6 and 2e-5."""

IPOPT = {
    "print_time": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.tol": 1e-6,
    "ipopt.max_iter": 150,
    "ipopt.acceptable_tol": 1e-2,
    "ipopt.acceptable_constr_viol_tol": 1e-5,
    "ipopt.acceptable_compl_inf_tol": 1e-4,
    "ipopt.acceptable_iter": 5,
}
"""Libraries do not print. A program with a solution takes some 40 iterations, one far from any goes on for ever."""


@dataclass(frozen=True)
class Steered:
    """Currents of a program, shape (periods,) [A]; by how much they miss the band [m] and violate the chain [1].

    `arrival` is the number of periods after which the readings are in the band to stay.
    """

    current: np.ndarray
    arrival: int
    miss: float
    violation: float
    unknowns: np.ndarray

    @property
    def is_sound(self) -> bool:
        """Whether the currents and states are a run of the chain."""
        return self.violation < GAP

    @property
    def reaches(self) -> bool:
        """Whether the readings are in the band when they should be."""
        return self.is_sound and self.miss < MISSED


class SteeringProgram:
    """Soonest arrival, or least travel of the current, to a band of readings that is entered in time and never passed.

    Parameters
    ----------
    chain : SmoothChain
    period : float [s]
        Of the controller: each current is held for it.
    periods : int
        Horizon; the current stands still over the last `hold` of them.
    hold : int
    start_reading, start_current : float [m], [A]
        At rest there before the first period.
    band : (float, float)
        Lowest and highest reading at the end. [m]
    current_range : (float, float) [A]
    rate : float
        Greatest rate of the current, or infinite. [A/s]
    """

    def __init__(
        self,
        chain: SmoothChain,
        *,
        period: float,
        periods: int,
        hold: int,
        start_reading: float,
        start_current: float,
        band: tuple[float, float],
        current_range: tuple[float, float],
        rate: float,
    ) -> None:
        self._chain, self._period, self._periods, self._hold = chain, period, periods, hold
        self._start_reading, self._start_current, self._band = start_reading, start_current, band
        self._range, self._rate = current_range, rate
        self._rises = 0.5 * sum(band) > start_reading
        self._scale = chain.scales
        self._solver = self._make_solver()

    def _make_solver(self) -> ca.Function:
        """Make the program in currents, travels, states and the miss of the band; numbers and prices are given."""
        n, chain = self._periods, self._chain
        current, travel = ca.MX.sym("current", n), ca.MX.sym("travel", n)
        states, miss = ca.MX.sym("states", len(chain.states), n), ca.MX.sym("miss")
        p, prices = ca.MX.sym("p", len(chain.parameters)), ca.MX.sym("prices", 2)
        gaps, readings = self._chained(current, states, p)
        change = current - ca.vertcat(self._start_current / CURRENT_SCALE, current[:-1])
        constraints = ca.vertcat(gaps, travel - change, travel + change, readings + miss, readings - miss)
        unknowns, given = ca.vertcat(current, travel, ca.vec(states), miss), ca.vertcat(p, prices)
        to_go = (-1.0 if self._rises else 1.0) * ca.sum1(readings)
        price = prices[0] * to_go + prices[1] * ca.sum1(travel) + MISS_PRICE * miss
        program: Any = {"x": unknowns, "p": given, "f": price, "g": constraints}
        options: Any = {**IPOPT, "hess_lag": _flat(unknowns, given, constraints)}
        return ca.nlpsol("steer", "ipopt", program, options)

    def _chained(self, current: ca.MX, states: ca.MX, p: ca.MX) -> tuple[ca.MX, ca.MX]:
        """Return the scaled gaps between the states and where the chain goes, and the scaled readings."""
        n, chain, scale = self._periods, self._chain, ca.DM(self._scale)
        start = chain.start(self._start_reading, self._start_current, p)
        whole = ca.horzcat(start, states * scale)
        held = ca.vertcat(self._arriving(current).T * CURRENT_SCALE, self._period * ca.DM.ones(1, n))
        reached = chain.step.map(n)(whole[:, :-1], held, ca.repmat(p, 1, n))
        readings = chain.reading.map(n)(whole[:, 1:], ca.repmat(p, 1, n)).T / LENGTH_SCALE
        return ca.vec((reached - whole[:, 1:]) / scale), readings

    def _arriving(self, current: ca.MX) -> ca.MX:
        """Return the currents behind the line's delay, the mean of each period."""
        delay = self._chain.model.numbers.get("transport_delay", 0.0) / self._period
        whole, part = math.floor(delay), delay % 1.0
        first = ca.DM.ones(whole + 1) * self._start_current / CURRENT_SCALE
        late = ca.vertcat(first, current)
        count = current.size1()
        return (1.0 - part) * late[1 : count + 1] + part * late[:count]

    def solve(self, arrival: int, width: float, guess: np.ndarray, prices: tuple[float, float] = HASTE) -> Steered:
        """Solve for readings in the band from the end of a period on, at a smoothing width [N].

        Parameters
        ----------
        arrival : int
            Periods until then; with `HASTE` the readings come there sooner where they can.
        width : float [N]
        prices : (float, float)
            `HASTE` or `LEISURE`.
        guess : array, shape (periods,) of currents [A], or the unknowns of an earlier solution
        """
        n, states = self._periods, len(self._chain.states)
        p = self._chain.values(width)
        begin = guess if len(guess) > n else self._guessed(guess, p)
        low_current, high_current = (each / CURRENT_SCALE for each in self._range)
        most = min(self._rate * self._period / CURRENT_SCALE, 1e3)
        still = np.where(np.arange(n) > n - self._hold, 0.0, most)
        free = np.full(states * n, np.inf)
        limits = self._limits(arrival)
        result = self._solver(
            x0=begin,
            p=np.append(p, prices),
            lbx=np.concatenate([np.full(n, low_current), np.zeros(n), -free, [0.0]]),
            ubx=np.concatenate([np.full(n, high_current), still, free, [1e3]]),
            **limits,
        )
        unknowns = result["x"].full().ravel()
        reached = result["g"].full().ravel()
        violation = float(np.maximum(limits["lbg"] - reached, reached - limits["ubg"]).max())
        miss = float(unknowns[-1])
        readings = (reached[-n:] + miss) * LENGTH_SCALE
        outside = np.flatnonzero((readings < self._band[0] - MISSED) | (readings > self._band[1] + MISSED))
        soonest = int(outside[-1]) + 2 if len(outside) else 1
        return Steered(unknowns[:n] * CURRENT_SCALE, soonest, miss * LENGTH_SCALE, violation, unknowns)

    def _limits(self, arrival: int) -> dict[str, np.ndarray]:
        """Return the bounds of the constraints: no gaps, travel above change, inside the band from the arrival on."""
        n, gaps = self._periods, np.zeros(len(self._chain.states) * self._periods)
        low, high = (each / LENGTH_SCALE for each in self._band)
        inside = np.arange(1, n + 1) >= arrival
        infinite = np.full(n, np.inf)
        lowest = np.where(inside | (not self._rises), low, -np.inf)
        highest = np.where(inside | self._rises, high, np.inf)
        return {
            "lbg": np.concatenate([gaps, np.zeros(2 * n), lowest, -infinite]),
            "ubg": np.concatenate([gaps, infinite, infinite, infinite, highest]),
        }

    def _guessed(self, current: np.ndarray, p: np.ndarray) -> np.ndarray:
        """Return the unknowns at a guess of the currents, the states those of a run."""
        start = self._chain.start(self._start_reading, self._start_current, p)
        scaled = ca.MX.sym("current", len(current))
        arriving = ca.Function("arriving", [scaled], [self._arriving(scaled)])(current / CURRENT_SCALE)
        held = np.vstack([arriving.full().ravel() * CURRENT_SCALE, np.full(len(current), self._period)])
        states = self._chain.step.mapaccum(len(current))(start, held, p).full() / self._scale[:, None]
        travel = np.abs(np.diff(current, prepend=self._start_current))
        return np.concatenate([current / CURRENT_SCALE, travel / CURRENT_SCALE, states.T.ravel(), [0.0]])


def _flat(unknowns: ca.MX, p: ca.MX, constraints: ca.MX) -> ca.Function:
    """Return a Hessian that leaves all curvature out; the exact one costs a hundred times the time and more steps."""
    weight, multipliers = ca.MX.sym("weight"), ca.MX.sym("multipliers", constraints.size1())
    hessian = ca.MX(CURVATURE * ca.DM.eye(unknowns.size1()))
    names = (["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"])
    return ca.Function("hess_lag", [unknowns, p, weight, multipliers], [hessian], *names)
