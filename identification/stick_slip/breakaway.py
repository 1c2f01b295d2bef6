"""Breakaways: where rests of the stem end, and the line of spring, gap and breakaway force through them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from identification.experiment import simulate_rows
from identification.problem import DIFFERENCE, Problem
from identification.search import Slopes, roam_over
from identification.starting.hints import coarse_step
from identification.starting.pressures import seen_by_pressure, told_by_pressure
from identification.stick_slip.rests import Rest, rests_in
from identification.unknowns import GAP
from valvemodel.breakaways import ways_to_breakaway
from valvemodel.effects import effect_of_key
from valvemodel.parameters import ACT_ON_PRESSURE

RAMPED = 0.02
"""Change of the pressure within a period, over its range, below which the force at breakaway is known."""

GRAIN = 0.14
"""Noise of a rest's mean that is not averaged out: the step of the display, a bend of the stem. [noise]"""

FAR = 3.0
"""Error beyond which a breakaway counts less: one that is none. [noise]"""

COARSE, HOPELESS = 20.0, 80.0
"""Twice the median error from which most are far, and after the coarse rounds, from which no line is laid. [spread]"""

COARSE_ROUNDS, COARSE_EVALUATIONS, NEAR_EVALUATIONS = 2, 10, 20
"""Rounds of a search in which what counts as far is told by how far most are, points of each, and of the last one."""

RENEWED = 2
"""Steps of that search on which its derivatives serve."""

TO_THE_MIDDLE = 0.02
"""Weight of the middle between the pressures that enclose a breakaway: where all is enclosed, it decides."""

LINE = ("spring_rate", "coulomb_friction", *GAP)
"""Unknowns that the line determines; the Coulomb friction stands for the breakaway force."""

OFF_THE_LINE = 0.3
"""Squared error of a breakaway from which a line does not explain it. [spread^2]"""

LIES_ON, WORTH_ROAMING = 0.15, 3.0
"""The same at which a search along a line's slack ends, and from which none brings it there."""

ALONG, SIZE, GENERATIONS = 2.0, 6, 25
"""How far a search along a line's slack goes, in its standard deviations; its points for each number, and generations.
"""

LOST_WAY = 1.0
"""Way to a breakaway that counts where numbers lead to no pressure. [m]"""

WIDEST_SLACK = 1.0
"""Change of the unknowns, scaled, beyond which what the line leaves open is not searched."""

HELD_FAST = 1e9
"""Coulomb friction of a stem that never moves. [N]"""


@dataclass(frozen=True)
class Breakaways:
    """The ends of all rests of a problem's experiments that count.

    Attributes
    ----------
    rests : list of lists of Rest
        One list for each experiment.
    problem : Problem
        Gives the pressures: those of the base valve and of what acts before the stem.
    late : int
        Samples by which a reading that lags may show a breakaway late.
    """

    problem: Problem
    rests: Sequence[Sequence[Rest]]
    late: int = 0

    @cached_property
    def position(self) -> np.ndarray:
        """Mean readings of the rests. [m]"""
        return np.array([rest.position for rests in self.rests for rest in rests])

    @cached_property
    def side(self) -> np.ndarray:
        """Sides to which the stem leaves, -1 or 1."""
        return np.array([rest.side for rests in self.rests for rest in rests])

    @cached_property
    def before(self) -> np.ndarray:
        """Sides to which the stem went before, -1 or 1, 0 if it did not; on the first as it leaves."""
        found = []
        for rests in self.rests:
            went = np.sign(np.diff([rest.position for rest in rests]))
            found += [rest.side for rest in rests[:1]] + [float(side) for side in went]
        return np.array(found)

    @cached_property
    def spread(self) -> np.ndarray:
        """Standard deviations of the positions. [m]"""
        pairs = zip(self.problem.experiments, self.rests, strict=True)
        squares = [
            each.noise**2 * (1.0 / (rest.last + 1 - rest.first) + GRAIN**2) + coarse_step(each) ** 2 / 12.0
            for each, rests in pairs
            for rest in rests
        ]
        return np.sqrt(squares)

    @cached_property
    def time(self) -> np.ndarray:
        """Start of the period of each breakaway and its end, shape (2, breakaways). [s]"""
        pairs = zip(self.problem.experiments, self.rests, strict=True)
        last = [(each.time[rest.last], each.time[rest.last + 1]) for each, rests in pairs for rest in rests]
        return np.array(last).reshape(-1, 2).T

    def pressures(self, points: np.ndarray) -> np.ndarray:
        """Return the pressures before and at the end of the period of each breakaway, shape (2, p, breakaways). [Pa]

        They do not depend on the stem, which is held so that no time goes into its motion.
        """
        found = []
        _, which, places = np.unique(points[:, self.acting], axis=0, return_index=True, return_inverse=True)
        for number, (experiment, rests) in enumerate(zip(self.problem.experiments, self.rests, strict=True)):
            rows = self.problem.rows_without(lambda effect: not effect.acts_on_pressure, points[which], number)
            rows["coulomb_friction"] = HELD_FAST
            run = simulate_rows(experiment, rows, tolerance=self.problem.tolerance, with_pressure=True)
            last = np.array([rest.last for rest in rests], int)
            found.append(np.stack([run.pressure[:, np.maximum(last - self.late, 0)], run.pressure[:, last + 1]]))
        return np.concatenate(found, axis=2)[:, places.reshape(-1)]

    @cached_property
    def acting(self) -> list[int]:
        """Numbers of the unknowns that act on the pressure."""
        return [n for n, unknown in enumerate(self.problem.unknowns) if unknown.name in ACT_ON_PRESSURE]

    def positions(self, points: np.ndarray) -> np.ndarray:
        """Return the positions that the two pressures would just break away from, shape (2, p, breakaways). [m]

        Far off where numbers lead to no pressure.
        """
        rows, ways = self.problem.rows(points, 0), np.empty((2, len(points), len(self.position)))
        for way, pressures, times in zip(ways, self.pressures(points), self.time, strict=True):
            ways_to_breakaway(rows, self.position, self.before, self.side, pressures, times, way)
        return self.position + np.where(np.isfinite(ways), ways, LOST_WAY)

    def enclosed(self, points: np.ndarray) -> np.ndarray:
        """Return by how much each position lies outside what encloses it, shape (p, breakaways). [spread]"""
        return self.outside(self.positions(points))

    def centred(self, points: np.ndarray) -> np.ndarray:
        """Return by how much each position lies off the middle of what encloses it, shape (p, breakaways). [spread]"""
        return self.off_the_middle(self.positions(points))

    def outside(self, ends: np.ndarray) -> np.ndarray:
        """Return by how much each position lies outside two ends, shape (2, p, breakaways). [spread]"""
        below = np.minimum(self.position - ends.min(axis=0), 0.0)
        above = np.maximum(self.position - ends.max(axis=0), 0.0)
        return (below + above) / self.spread

    def off_the_middle(self, ends: np.ndarray) -> np.ndarray:
        """Return by how much each position lies off the middle of two ends, shape (2, p, breakaways). [spread]"""
        return (self.position - ends.mean(axis=0)) / self.spread

    def is_ramped(self, point: np.ndarray) -> np.ndarray:
        """Return of which breakaways the force is known well, the pressure changing little within a period."""
        before, after = replace(self, late=0).pressures(point[None, :])[:, 0]
        span = max(float(np.ptp(np.concatenate([before, after]))), 1e-9)
        return np.abs(after - before) < RAMPED * span

    def slack(self, point: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Return how far some unknowns are open, one standard deviation in each column, shape (m, m).

        A breakaway lies anywhere between the two pressures that enclose it.
        """
        is_ramped = self.is_ramped(point)
        within = np.abs(np.diff(self.positions(point[None, :]), axis=0))[0, 0] / np.sqrt(12.0) + self.spread
        slopes = slopes_of(self.centred, point, columns) * (self.spread / within)[:, None]
        _, sizes, directions = np.linalg.svd(slopes[is_ramped])
        # What fewer breakaways than unknowns do not tell is open.
        sizes = np.pad(sizes, (0, len(columns) - len(sizes)))
        return directions.T / np.maximum(sizes, 1.0 / WIDEST_SLACK)

    def on_the_way(self, point: np.ndarray) -> int:
        """Count the breakaways on ramps that follow one of their record to the same side: the steps of stairs."""
        record = np.repeat(np.arange(len(self.rests)), [len(rests) for rests in self.rests])
        is_again = np.concatenate([[False], (np.diff(self.side) == 0.0) & (np.diff(record) == 0)])
        return int((is_again & self.is_ramped(point)).sum())


def breakaways_of(problem: Problem) -> Breakaways:
    """Return the breakaways in the samples of a problem that count.

    There are none of a coarse reading, whose rests are its own, unless the model reads in its steps: then slips of
    several steps show when the stem breaks away, and within a step where.
    """
    rests = []
    for experiment, used in zip(problem.experiments, problem.used, strict=True):
        readings = np.where(used, experiment.position, np.nan)
        step = coarse_step(experiment)
        is_told = step == 0.0 or problem.comes_in_steps(experiment)
        rests.append(rests_in(readings, experiment.noise, step) if is_told else [])
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
    error : float
        Half the sum of the squares by which breakaways lie off the line, far ones counted less. [spread^2]
    breakaways : Breakaways
        What it was laid through.
    """

    point: np.ndarray
    columns: np.ndarray
    slack: np.ndarray
    error: float
    breakaways: Breakaways

    @property
    def count(self) -> int:
        """Number of breakaways."""
        return len(self.breakaways.position)

    @property
    def is_explained(self) -> bool:
        """Whether the breakaways lie on the line as well as can be told."""
        return self.error <= OFF_THE_LINE * self.count

    @property
    def is_in_reach(self) -> bool:
        """Whether a search along what it leaves open may bring the breakaways onto it."""
        return self.error <= WORTH_ROAMING * self.count


def line_through(breakaways: Breakaways, point: np.ndarray) -> Line:
    """Lay the line of spring, gap and breakaway force through breakaways, from a scaled point on.

    At breakaway S_1 P - k y is the breakaway force, under a pressure that two samples enclose. That needs no run of the
    stem and has one minimum, however jagged the error of the stem's run is. The gap stays where a pressure tells it.
    Effects of the problem's model bend the line: their unknowns are among its own.
    """
    problem = breakaways.problem
    names, told = [unknown.name for unknown in problem.unknowns], told_by_pressure(problem)
    bends = [each.name for key in problem.model.effects for each in effect_of_key(key).fitted]
    columns = np.array(
        [names.index(name) for name in (*LINE, *bends) if name in names and names.index(name) not in told]
    )
    if told:
        point = point.copy()
        point[told] = seen_by_pressure(problem, point, told)[1].point
    is_ramped = breakaways.is_ramped(point)

    def middles(points: np.ndarray) -> np.ndarray:
        return breakaways.centred(points)[:, is_ramped]

    def all_of(points: np.ndarray) -> np.ndarray:
        ends = breakaways.positions(points)
        middle = breakaways.off_the_middle(ends)[:, is_ramped]
        return np.concatenate([breakaways.outside(ends), TO_THE_MIDDLE * middle], axis=1)

    begun = _laid(middles, breakaways.problem, point, columns)[0] if is_ramped.any() else point
    found, error = _laid(all_of, breakaways.problem, begun, columns)
    return Line(found, columns, breakaways.slack(found, columns), error, breakaways)


def roamed(line: Line) -> Line:
    """Search globally along what a line leaves open for where its breakaways are enclosed best, where that is worth it.

    What lies within its bounds says nothing of the way: a descent ends in a bend of the narrow valley between them.
    """
    if line.is_explained or not line.is_in_reach:
        return line

    def points_of(moves: np.ndarray) -> np.ndarray:
        points = np.repeat(line.point[None, :], len(moves), axis=0)
        points[:, line.columns] += moves @ line.slack.T
        return np.clip(points, *line.breakaways.problem.bounds)

    def off_by(moves: np.ndarray, _: np.ndarray) -> np.ndarray:
        return counted(line.breakaways.enclosed(points_of(moves)))

    box = [(-ALONG, ALONG)] * len(line.columns)
    moves, error = roam_over(off_by, box, size=SIZE, generations=GENERATIONS, enough=LIES_ON * line.count)
    if error >= line.error:
        return line
    point = points_of(moves[None, :])[0]
    return Line(point, line.columns, line.breakaways.slack(point, line.columns), error, line.breakaways)


def _laid(
    residuals: Callable[[np.ndarray], np.ndarray], problem: Problem, point: np.ndarray, columns: np.ndarray
) -> tuple[np.ndarray, float]:
    """Move some unknowns to where residuals are least, far ones counting less; return the point and half their sum.

    From a bad start all are far, and would all count less: what is far is told by how far most are then.
    """
    from scipy.optimize import least_squares

    def moved(move: np.ndarray) -> np.ndarray:
        there = point.copy()
        there[columns] = move
        return there

    low, high = problem.bounds[0][columns], problem.bounds[1][columns]
    move = np.clip(point[columns], low + 1e-9, high - 1e-9)
    off = residuals(moved(move)[None, :])[0]
    for last in (*[False] * COARSE_ROUNDS, True):
        far = 2.0 * float(np.median(np.abs(off)))
        if last and far > HOPELESS:
            break
        is_near = last or far < COARSE
        slopes = Slopes(
            lambda move: residuals(moved(move)[None, :])[0],
            lambda move, _: slopes_of(residuals, moved(move), columns),
            RENEWED,
        )
        result = least_squares(
            slopes.residuals,
            move,
            jac=slopes.jacobian,
            bounds=(low, high),
            loss="soft_l1",
            f_scale=FAR if is_near else far,
            x_scale="jac",
            ftol=1e-6 if is_near else 1e-2,
            max_nfev=NEAR_EVALUATIONS if is_near else COARSE_EVALUATIONS,
        )
        move, off = result.x, result.fun
        if is_near:
            break
    return moved(move), float(counted(off))


def counted(off: np.ndarray) -> np.ndarray:
    """Return half the sums of the squares by which breakaways lie off a line, far ones counted less. [spread^2]

    Parameters
    ----------
    off : array, shape (..., breakaways) [spread]

    Returns
    -------
    array, shape (...)
    """
    return np.asarray(FAR**2 * (np.sqrt(1.0 + (off / FAR) ** 2) - 1.0).sum(axis=-1))


def slopes_of(residuals: Callable[[np.ndarray], np.ndarray], point: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return the derivatives of residuals by some unknowns, by differences, shape (r, m)."""
    points = np.repeat(point[None, :], 1 + len(columns), axis=0)
    points[1 + np.arange(len(columns)), columns] += DIFFERENCE
    there = residuals(points)
    return ((there[1:] - there[0]) / DIFFERENCE).T
