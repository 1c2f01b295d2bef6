"""Breakaways: where rests of the stem end, and the line of spring, gap and breakaway force through them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from identification.experiment import Experiment, simulate_rows
from identification.problem import DIFFERENCE, Problem

SHORTEST = 6
"""Samples that a rest has at least."""

QUIET, LEFT = 6.0, 5.0
"""Range of the readings within which a stem rests, and change of the reading that ends the rest. [noise]"""

RAMPED = 0.02
"""Change of the pressure within a period, over its range, below which the force at breakaway is known."""

CREEPING = 3.0
"""Drift of the readings from which a stem creeps. [noise of the drift]"""

GRAIN = 0.14
"""Noise of a rest's mean that is not averaged out: the step of the display, a bend of the stem. [noise]"""

FAR = 3.0
"""Error beyond which a breakaway counts less: one that is none. [noise]"""

TO_THE_MIDDLE = 0.02
"""Weight of the middle between the pressures that enclose a breakaway: where all is enclosed, it decides."""

LINE = ("spring_rate", "coulomb_friction", "gap_offset", "gap_gain")
"""Unknowns that the line determines; the Coulomb friction stands for the breakaway force."""


@dataclass(frozen=True)
class Rest:
    """A rest that ends on the way: first and last sample, mean reading [m], side to which the stem leaves."""

    first: int
    last: int
    position: float
    side: float


def rests_of(position: np.ndarray, noise: float) -> Iterator[Rest]:
    """Yield the rests of a stem that end while it is looked at.

    Parameters
    ----------
    position : array, shape (n,) [m]
        NaN where nothing counts.
    noise : float [m]
    """
    if len(position) < SHORTEST:
        return
    windows = np.lib.stride_tricks.sliding_window_view(position, SHORTEST)
    is_quiet = np.ptp(windows, axis=1) < QUIET * noise
    first = 0
    while first < len(is_quiet):
        if not is_quiet[first]:
            first += 1
            continue
        last, total = first + SHORTEST - 1, float(windows[first].sum())
        while last + 1 < len(position) and abs(position[last + 1] - total / (last + 1 - first)) < LEFT * noise:
            last += 1
            total += position[last]
        mean = total / (last + 1 - first)
        away = position[last + 1 : last + 3] - mean
        has_left = len(away) == 2 and away[0] * away[1] > 0.0 and abs(away[1]) > LEFT * noise
        if has_left and abs(drift_of(position[first : last + 1])) < CREEPING * noise:
            yield Rest(first, last, mean, float(np.sign(away[0])))
        first = last + 1


def drift_of(readings: np.ndarray) -> float:
    """Return the drift of readings, scaled so that its noise is that of a reading. [m]"""
    places = np.arange(len(readings)) - 0.5 * (len(readings) - 1)
    return float(places @ readings / np.sqrt(places @ places))


class RestedExperiment(Experiment):
    """An experiment whose runs are put anew on each rest, just before it ends: each slip is judged by itself."""

    @cached_property
    def anchors(self) -> np.ndarray:
        """Mean readings of the rests, at their last sample but one, NaN elsewhere, shape (n,). [m]"""
        anchors = np.full(len(self.time), np.nan)
        for rest in rests_of(self.position, self.noise):
            anchors[rest.last - 1] = rest.position
        return anchors


def put_on_rests(experiment: Experiment, reach: float) -> RestedExperiment:
    """Return an experiment whose runs are put anew on each rest, and whose large errors count by the logarithm."""
    given = {field.name: getattr(experiment, field.name) for field in fields(Experiment)}
    return RestedExperiment(**{**given, "reach": reach})


@dataclass(frozen=True)
class Breakaways:
    """The ends of all rests of a problem's experiments that count.

    Attributes
    ----------
    rests : list of lists of Rest
        One list for each experiment.
    problem : Problem
        Gives the pressures: those of the base valve and of what acts before the stem.
    """

    problem: Problem
    rests: Sequence[Sequence[Rest]]

    @cached_property
    def position(self) -> np.ndarray:
        """Mean readings of the rests. [m]"""
        return np.array([rest.position for rests in self.rests for rest in rests])

    @cached_property
    def side(self) -> np.ndarray:
        """Sides to which the stem leaves, -1 or 1."""
        return np.array([rest.side for rests in self.rests for rest in rests])

    @cached_property
    def spread(self) -> np.ndarray:
        """Standard deviations of the positions. [m]"""
        pairs = zip(self.problem.experiments, self.rests, strict=True)
        counts = [(each.noise, rest.last + 1 - rest.first) for each, rests in pairs for rest in rests]
        return np.array([noise * np.sqrt(1.0 / count + GRAIN**2) for noise, count in counts])

    def pressures(self, points: np.ndarray) -> np.ndarray:
        """Return the pressures before and at the end of the period of each breakaway, shape (2, p, breakaways). [Pa]"""
        found = []
        for number, (experiment, rests) in enumerate(zip(self.problem.experiments, self.rests, strict=True)):
            rows = self.problem.rows(points, number)
            run = simulate_rows(experiment, rows, tolerance=self.problem.tolerance, with_pressure=True)
            last = np.array([rest.last for rest in rests], int)
            found.append(np.stack([run.pressure[:, last], run.pressure[:, last + 1]]))
        return np.concatenate(found, axis=2)

    def positions(self, points: np.ndarray) -> np.ndarray:
        """Return the positions that the two pressures would just break away from, shape (2, p, breakaways). [m]"""
        rows = self.problem.rows(points, 0)
        area, preload, stiffness, force = (
            rows[name][:, None] for name in ("diaphragm_area", "spring_preload", "spring_rate", "coulomb_friction")
        )
        return (area * self.pressures(points) - preload - self.side * force) / stiffness

    def enclosed(self, points: np.ndarray) -> np.ndarray:
        """Return by how much each position lies outside what encloses it, shape (p, breakaways). [spread]"""
        ends = self.positions(points)
        below = np.minimum(self.position - ends.min(axis=0), 0.0)
        above = np.maximum(self.position - ends.max(axis=0), 0.0)
        return (below + above) / self.spread

    def centred(self, points: np.ndarray) -> np.ndarray:
        """Return by how much each position lies off the middle of what encloses it, shape (p, breakaways). [spread]"""
        return (self.position - self.positions(points).mean(axis=0)) / self.spread

    def is_ramped(self, point: np.ndarray) -> np.ndarray:
        """Return of which breakaways the force is known well, the pressure changing little within a period."""
        before, after = self.pressures(point[None, :])[:, 0]
        span = max(float(np.ptp(np.concatenate([before, after]))), 1e-9)
        return np.abs(after - before) < RAMPED * span

    def slack(self, point: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Return how far some unknowns are open, one standard deviation in each column, shape (m, m).

        A breakaway lies anywhere between the two pressures that enclose it.
        """
        is_ramped = self.is_ramped(point)
        within = np.abs(np.diff(self.positions(point[None, :]), axis=0))[0, 0] / np.sqrt(12.0) + self.spread
        slopes = slopes_of(self.centred, point, columns) * (self.spread / within)[:, None]
        _, sizes, directions = np.linalg.svd(slopes[is_ramped], full_matrices=False)
        return directions.T / np.maximum(sizes, 1e-9 * sizes[0])

    def on_the_way(self, point: np.ndarray) -> int:
        """Count the breakaways on ramps that follow one to the same side: the steps of stairs."""
        is_again = np.concatenate([[False], self.side[1:] == self.side[:-1]])
        return int((is_again & self.is_ramped(point)).sum())


def breakaways_of(problem: Problem) -> Breakaways:
    """Return the breakaways in the samples of a problem that count."""
    rests = []
    for experiment, used in zip(problem.experiments, problem.used, strict=True):
        rests.append(list(rests_of(np.where(used, experiment.position, np.nan), experiment.noise)))
    return Breakaways(problem, rests)


@dataclass(frozen=True)
class Line:
    """The line through breakaways: a scaled point of the base valve, and what the line leaves open.

    Attributes
    ----------
    point : array, shape (unknowns,)
        Its Coulomb friction is the breakaway force.
    columns : array of int, shape (m,)
        The unknowns that the line determines.
    slack : array, shape (m, m)
        Changes of them by a standard deviation each, one in a column.
    """

    point: np.ndarray
    columns: np.ndarray
    slack: np.ndarray


def line_through(breakaways: Breakaways, point: np.ndarray) -> Line:
    """Lay the line of spring, gap and breakaway force through breakaways, from a scaled point on.

    At breakaway S_1 P - k y is the breakaway force, under a pressure that two samples enclose. That needs no run of the
    stem and has one minimum, however jagged the error of the stem's run is.
    """
    names = [unknown.name for unknown in breakaways.problem.unknowns]
    columns = np.array([names.index(name) for name in LINE if name in names])
    is_ramped = breakaways.is_ramped(point)

    def middles(points: np.ndarray) -> np.ndarray:
        return breakaways.centred(points)[:, is_ramped]

    def all_of(points: np.ndarray) -> np.ndarray:
        return np.concatenate([breakaways.enclosed(points), TO_THE_MIDDLE * middles(points)], axis=1)

    begun = _laid(middles, breakaways.problem, point, columns)
    found = _laid(all_of, breakaways.problem, begun, columns)
    return Line(found, columns, breakaways.slack(found, columns))


def _laid(
    residuals: Callable[[np.ndarray], np.ndarray], problem: Problem, point: np.ndarray, columns: np.ndarray
) -> np.ndarray:
    from scipy.optimize import least_squares

    def moved(move: np.ndarray) -> np.ndarray:
        there = point.copy()
        there[columns] = move
        return there

    low, high = problem.bounds
    result = least_squares(
        lambda move: residuals(moved(move)[None, :])[0],
        np.clip(point[columns], low[columns] + 1e-9, high[columns] - 1e-9),
        jac=lambda move: slopes_of(residuals, moved(move), columns),
        bounds=(low[columns], high[columns]),
        loss="soft_l1",
        f_scale=FAR,
        x_scale="jac",
        ftol=1e-6,
        max_nfev=60,
    )
    return moved(result.x)


def slopes_of(residuals: Callable[[np.ndarray], np.ndarray], point: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return the derivatives of residuals by some unknowns, by differences, shape (r, m)."""
    points = np.repeat(point[None, :], 1 + len(columns), axis=0)
    points[1 + np.arange(len(columns)), columns] += DIFFERENCE
    there = residuals(points)
    return ((there[1:] - there[0]) / DIFFERENCE).T
