"""What a current would tell: the standard deviations that a fit to its record should reach."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from identification.determined.sensitivity import differences
from identification.experiment import BLOCK_TIME, Experiment, simulate_rows
from identification.problem import FINE_TOLERANCE, Problem
from identification.unknowns import Unknown, base_unknowns, effect_unknowns, start_unknown
from valvemodel.effects import is_jagged
from valvemodel.model import Model


@dataclass(frozen=True, eq=False)
class Prospect:
    """A record that a model would give under a current, as a problem whose solution is known.

    Attributes
    ----------
    problem : Problem
        With the noiseless readings.
    point : array, shape (unknowns,)
        The truth, scaled.
    """

    problem: Problem
    point: np.ndarray

    @property
    def unknowns(self) -> Sequence[Unknown]:
        """The unknowns that a fit would have, the start position last."""
        return self.problem.unknowns

    def with_noise(self, generator: np.random.Generator) -> Problem:
        """Return the problem with white noise on the readings."""
        (experiment,) = self.problem.experiments
        noise = experiment.noise * generator.standard_normal(len(experiment.time))
        return replace(self.problem, experiments=[replace(experiment, position=experiment.position + noise)])


def prospect(model: Model, *, time: np.ndarray, current: np.ndarray, noise: float) -> Prospect:
    """Return what a model would give under a current.

    Parameters
    ----------
    model : Model
    time, current : arrays, shape (n,) [s], [A]
    noise : float
        White noise of the reading. [m]
    """
    block = (time // BLOCK_TIME).astype(int)
    blank = Experiment("design", time, current, np.zeros(len(time)), None, noise, 0.0, block)
    run = simulate_rows(blank, model.rows(), tolerance=FINE_TOLERANCE)
    experiment = replace(blank, position=run.position[0])
    unknowns = base_unknowns(model)
    for key, values in model.effects.items():
        unknowns += effect_unknowns(key, dict(values))
    start = float(run.position[0, 0])
    unknowns.append(start_unknown(start, 0))
    truth = {**model.numbers, "start_position": start}
    point = np.array([unknown.scaled(truth[unknown.name]) for unknown in unknowns])
    used, is_anchored = [np.ones(len(time), bool)], is_jagged(model.effects)
    problem = Problem(model, [experiment], unknowns, used, is_anchored, tolerance=FINE_TOLERANCE)
    return Prospect(problem, point)


def information(found: Prospect, steps: np.ndarray | None = None) -> np.ndarray:
    """Return the Fisher information on the scaled unknowns, the weak priors in it, shape (unknowns, unknowns).

    Parameters
    ----------
    found : Prospect
    steps : array, shape (unknowns,), optional
        Of the differences; by default found for this record, each as wide as the noise asks for.
    """
    prior = np.array([unknown.prior_spread for unknown in found.unknowns])
    if steps is None:
        columns, _ = differences(found.problem, found.point)
    else:
        points = np.vstack([found.point + np.diag(steps), found.point - np.diag(steps)])
        residuals = found.problem.residuals(points)
        columns = ((residuals[: len(steps)] - residuals[len(steps) :]) / (2.0 * steps[:, None])).T
    columns = columns[: -len(prior)]
    return columns.T @ columns + np.diag(prior**-2.0)


def deviations(matrix: np.ndarray) -> np.ndarray:
    """Return the standard deviations of scaled unknowns that an information matrix stands for, shape (unknowns,)."""
    return np.sqrt(np.diag(np.linalg.inv(matrix)))
