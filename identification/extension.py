"""A fit extended by one more effect: screened starts, a local search from the best, a global one where it is needed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from identification.fit import Fit, finished
from identification.hints import starts_of
from identification.problem import Problem
from identification.search import Found, descend, errors, roam
from identification.unknowns import effect_unknowns
from valvemodel.declarations import Effect
from valvemodel.effects import effect_of_key

KEPT_STARTS = 2
"""Starts that are followed down in each group, after all were screened."""

WIDEST = 2.0
"""How far a global search goes along a principal direction, in changes of the residual over the residual."""

SEARCH_SIZE = 3
SEARCH_GENERATIONS = 70
"""Points of a global search for each unknown, and generations."""


@dataclass(frozen=True)
class Trial:
    """One start of a search: the problem with the effect's unknowns, the scaled start, what it promises to explain."""

    problem: Problem
    point: np.ndarray
    gain: float


@threadpool_limits.wrap(limits=1)
def extend(fit: Fit, key: str) -> Fit:
    """Add an effect to a fit and fit all unknowns anew.

    Parameters
    ----------
    fit : Fit
        Of the model without the effect; its unknowns stay free.
    key : str
        The effect.

    Returns
    -------
    Fit
        The best found; it may be the model with the effect at a value that changes nothing.
    """
    effect = effect_of_key(key)
    trials = screened(fit, effect)
    if effect.is_jagged and trials[0].gain > 0.0:
        searched = [search_jagged(fit, effect, group) for group in alike(effect, trials)]
        problem, best = min(searched, key=lambda pair: pair[1].error)
    else:
        followed = [
            (trial.problem, descend(trial.problem, trial.point, evaluations=12, precision=1e-3))
            for group in alike(effect, trials)
            for trial in group[:KEPT_STARTS]
        ]
        problem, best = min(followed, key=lambda pair: pair[1].error)
    return finished(problem, descend(problem, best.point, evaluations=20, precision=1e-6))


def alike(effect: Effect, trials: list[Trial]) -> list[list[Trial]]:
    """Return the trials in groups that differ in fitted parameters only; each group is searched on its own."""
    held = [parameter.name for parameter in effect.parameters if not parameter.is_fitted]
    groups: dict[tuple[float, ...], list[Trial]] = {}
    for trial in trials:
        values = trial.problem.model.effects[effect.key]
        groups.setdefault(tuple(values[name] for name in held), []).append(trial)
    return list(groups.values())


def search_jagged(fit: Fit, effect: Effect, trials: list[Trial]) -> tuple[Problem, Found]:
    """Search globally where the error has many minima.

    The fit's unknowns move along the principal directions of their Jacobian, each by up to twice what changes the
    residual as much as it is large; the effect's parameters move between the outermost of neutral and starts. One
    search looks at the re-anchored run and, unless that is lost at once, one at the free run; the point that does best
    by both together wins.
    """
    problem, centre = trials[0].problem, fit.found.point
    known, added = len(centre), len(problem.unknowns) - len(centre)
    _, sizes, directions = np.linalg.svd(fit.problem.jacobian(centre), full_matrices=False)
    reach = np.sqrt(2.0 * fit.found.error)
    shape = np.zeros((known + added, known + added))
    shape[:known, :known] = directions.T * (reach / np.maximum(sizes, 1e-9 * sizes[0]))
    shape[known:, known:] = np.eye(added)
    origin = np.concatenate([centre, np.zeros(added)])
    neutral = [unknown.scaled(effect.parameter(unknown.name).neutral) for unknown in problem.unknowns[known:]]
    corners = np.vstack([neutral, *[trial.point[known:] for trial in trials]])
    box = [(-WIDEST, WIDEST)] * known + list(zip(corners.min(axis=0), corners.max(axis=0), strict=True))
    yardsticks = [replace(problem, is_anchored=is_anchored) for is_anchored in (True, False)]
    found = []
    for each in yardsticks[:1] if effect.is_chaotic else yardsticks:
        best = roam(each, origin, shape, box, size=SEARCH_SIZE, generations=SEARCH_GENERATIONS)
        found.append(descend(each, best.point, evaluations=10, precision=1e-4).point)

    def misfit(point: np.ndarray) -> float:
        return float(np.prod([errors(each, point[None, :])[0] for each in yardsticks]))

    point = min(found, key=misfit)
    return problem, Found(point, float(errors(problem, point[None, :])[0]))


def screened(fit: Fit, effect: Effect) -> list[Trial]:
    """Return the starts of an effect, the most promising first.

    Each is run once; its promise is how much of the residual the change of the trajectory explains, at any size and
    beside whatever the unknowns of the fit could do (linearised).
    """
    problem, point = fit.problem, fit.found.point
    residual = problem.residuals(point[None, :])[0]
    basis, _ = np.linalg.qr(problem.jacobian(point))
    left = residual - basis @ (basis.T @ residual)
    trials = []
    for start in starts_of(effect, list(problem.experiments), residual_positions(fit)):
        trial_problem, trial_point = joined(problem, point, effect, start)
        change = trial_problem.residuals(trial_point[None, :])[0][: len(residual) - len(point)]
        change = np.append(change, np.zeros(len(point))) - np.append(residual[: len(change)], np.zeros(len(point)))
        change -= basis @ (basis.T @ change)
        size = float(change @ change)
        gain = float(left @ change) ** 2 / size if size > 0.0 else 0.0
        trials.append(Trial(trial_problem, trial_point, gain))
    return sorted(trials, key=lambda trial: -trial.gain)


def joined(problem: Problem, point: np.ndarray, effect: Effect, start: dict[str, float]) -> tuple[Problem, np.ndarray]:
    """Return the problem with an effect's unknowns added, and its scaled point at a start of theirs."""
    added = effect_unknowns(effect.key, start)
    extended = replace(
        problem,
        model=problem.model.with_effect(effect.key, **start),
        is_anchored=problem.is_anchored or effect.is_chaotic,
        unknowns=[*problem.unknowns, *added],
    )
    scaled = np.array([unknown.scaled(start[unknown.name]) for unknown in added])
    return extended, np.concatenate([point, scaled])


def residual_positions(fit: Fit) -> list[np.ndarray]:
    """Return measured less simulated position of each experiment, NaN where a sample does not count. [m]"""
    residuals = []
    for experiment, used in zip(fit.problem.experiments, fit.problem.used, strict=True):
        residual = experiment.position - fit.simulated_on(experiment).position[0]
        residuals.append(np.where(used, residual, np.nan))
    return residuals
