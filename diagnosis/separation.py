"""Separation: by how much two rival models would differ under an input when either is refitted to the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from diagnosis.score import persistence_of
from identification.experiment import Experiment
from identification.fit import Fit, fitted_to_all, simulate_model
from identification.problem import Problem

REFITTED_PAIRS = 3
"""Pairs of rivals whose separation is found by a refit, those that are closest to first order."""


@dataclass(frozen=True, eq=False)
class Rival:
    """A fitted model and what the records so far know of its parameters.

    Attributes
    ----------
    effects : tuple of str
    fit : Fit
    point : array, shape (unknowns,)
        Scaled parameters, start positions left out.
    information : array, shape (unknowns, unknowns)
        Of the records so far; samples whose errors go together count as one.
    """

    effects: tuple[str, ...]
    fit: Fit
    point: np.ndarray
    information: np.ndarray

    def problem_on(self, experiment: Experiment) -> Problem:
        """Return the problem of its parameters under another input."""
        unknowns = [unknown for unknown in self.fit.unknowns if unknown.experiment < 0]
        return Problem(self.fit.model, [experiment], unknowns, [np.ones(len(experiment.time), bool)])


def rival_of(effects: tuple[str, ...], fit: Fit) -> Rival:
    """Make a rival of a fit to the records so far."""
    is_start = np.array([unknown.experiment >= 0 for unknown in fit.unknowns])
    jacobian = fit.problem.jacobian(fit.found.point)
    lasting = persistence_of(fit.problem.residuals(fit.found.point[None, :])[0][: -len(is_start)])
    whole = jacobian.T @ jacobian
    kept, nuisance = np.flatnonzero(~is_start), np.flatnonzero(is_start)
    cross = whole[np.ix_(kept, nuisance)]
    information = whole[np.ix_(kept, kept)] - cross @ np.linalg.pinv(whole[np.ix_(nuisance, nuisance)]) @ cross.T
    return Rival(effects, fit, fit.found.point[~is_start], information / lasting)


def blank_experiment(
    time: np.ndarray, current: np.ndarray, *, noise: float, pressure_noise: float | None = None
) -> Experiment:
    """Return an input to which nothing has been measured yet, its position and pressure zero.

    Parameters
    ----------
    time : array, shape (n,) [s]
    current : array, shape (n,) [A]
    noise : float [m]
    pressure_noise : float or None [Pa]
        None where the pressure is not going to be measured.
    """
    nothing = np.zeros(len(time))
    pressure = None if pressure_noise is None else nothing
    return Experiment("next", time, current, nothing, pressure, noise, pressure_noise or 0.0, np.zeros(len(time), int))


def separations(rivals: Sequence[Rival], experiment: Experiment) -> dict[tuple[int, int], float]:
    """Return the difference of each pair of rivals, the first being true and the second refitted, by their numbers.

    The refit is to first order: the second's parameters follow the difference as far as the records so far let them.
    The difference is the root mean square over the samples, the signals' squares summed, in standard deviations of the
    noise.
    """
    runs, slopes = [], []
    for rival in rivals:
        problem = rival.problem_on(experiment)
        count = len(experiment.time) * (1 if experiment.pressure is None else 2)
        runs.append(problem.residuals(rival.point[None, :])[0][:count])
        slopes.append(problem.jacobian(rival.point)[:count])
    found = {}
    for true, other in permutations(range(len(rivals)), 2):
        difference = runs[true] - runs[other]
        moved = slopes[other].T @ difference
        reach = slopes[other].T @ slopes[other] + rivals[other].information
        left = float(difference @ difference - moved @ np.linalg.lstsq(reach, moved)[0])
        found[true, other] = float(np.sqrt(max(left, 0.0) / len(experiment.time)))
    return found


def least_separation(
    rivals: Sequence[Rival], present: Sequence[Experiment], experiment: Experiment
) -> tuple[float, tuple[tuple[str, ...], tuple[str, ...]]]:
    """Return the smallest separation of all pairs, and the pair, by refits of those that come first to first order.

    Where a refit has far to go, first order promises too much: a delay follows a lag farther than its slope says.
    """
    first_order = separations(rivals, experiment)
    closest = sorted(first_order, key=lambda pair: first_order[pair])[:REFITTED_PAIRS]
    refitted = {
        pair: refitted_separation(rivals[pair[0]].fit, rivals[pair[1]].fit, present, experiment) for pair in closest
    }
    one, other = min(refitted, key=lambda pair: refitted[pair])
    return refitted[one, other], (rivals[one].effects, rivals[other].effects)


def refitted_separation(true: Fit, other: Fit, present: Sequence[Experiment], experiment: Experiment) -> float:
    """Return what the other model leaves of the true one's answer to an input, fitted to it and to the records so far.

    Root mean square over the samples, the signals' squares summed, in standard deviations of the noise.
    """
    answer = simulate_model(true.model, experiment, start_position=np.nan)
    pressure = None if experiment.pressure is None else answer.pressure[0]
    taken = replace(experiment, position=answer.position[0], pressure=pressure)
    run = fitted_to_all(other, [*present, taken]).simulated_on(taken)
    squares = ((taken.position - run.position[0]) / taken.noise) ** 2
    if taken.pressure is not None:
        squares = squares + ((taken.pressure - run.pressure[0]) / taken.pressure_noise) ** 2
    return float(np.sqrt(np.mean(squares)))
