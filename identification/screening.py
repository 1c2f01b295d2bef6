"""Screening: the starts of a search for one more effect, the most promising first."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from identification.fit import Fit
from identification.hints import is_periodic, nearby, starts_of
from identification.problem import Problem
from identification.search import errors
from identification.unknowns import effect_unknowns
from valvemodel.declarations import Effect

ANSWER = 0.5
"""Farthest that an unknown of the fit moves in answer to a start of an effect, scaled."""

TRIED_FORCE = 0.25
"""Share of its declared start at which each wave of a periodic effect is tried."""

KEPT_PERIODS = 3
"""Periods at which a periodic effect promises most alone."""


@dataclass(frozen=True)
class Trial:
    """One start of a search: the problem with the effect's unknowns, the scaled start, what it promises to explain."""

    problem: Problem
    point: np.ndarray
    gain: float


def screened(fit: Fit, effect: Effect, known: dict[str, float] | None = None) -> list[Trial]:
    """Return the starts of an effect, the most promising first.

    Each is run once, and once more after the unknowns of the fit have answered it (linearised). Its promise is how
    much less error that leaves, or how much of the residual the change of the trajectory explains at any size.
    """
    problem, point = fit.problem, fit.found.point
    residual = problem.residuals(point[None, :])[0]
    basis, triangle = np.linalg.qr(problem.jacobian(point, residual))
    left = residual - basis @ (basis.T @ residual)
    starts = list(starts_of(effect, list(problem.experiments), residual_positions(fit)))
    if any(is_periodic(each) for each in effect.parameters):
        starts += waves(fit, effect, starts, left, basis)
    trials = [promise(fit, effect, start, left, basis, triangle) for start in [*starts, *([known] if known else [])]]
    return sorted(trials, key=lambda trial: -trial.gain)


def waves(
    fit: Fit, effect: Effect, starts: list[dict[str, float]], left: np.ndarray, basis: np.ndarray
) -> list[dict[str, float]]:
    """Return starts of a periodic effect at the periods at which it explains most, sine and cosine solved for.

    What a load does to a stem with friction is no wave: the strongest period of the residual may be another. Each
    period about those, and of the lowest waves of the record, is tried by a small sine and a small cosine; what the
    changes of the readings explain of the residual, whatever their sizes, is the promise of that period.
    """
    period = next(each.name for each in effect.parameters if is_periodic(each))
    sizes = [each.name for each in effect.parameters if each.name != period]
    longest = max(float(each.time[-1] - each.time[0]) for each in fit.problem.experiments)
    found = []
    for each in nearby([start[period] for start in starts], longest):
        changes = []
        for name in sizes:
            tried = {other: 0.0 for other in sizes} | {name: TRIED_FORCE * starts[0][name], period: each}
            problem, point = joined(fit.problem, fit.found.point, effect, tried)
            changes.append(change_of(problem.residuals(point[None, :])[0], left, basis))
        columns = np.array(changes).T
        shares, *_ = np.linalg.lstsq(columns, -left, rcond=None)
        remaining = left + columns @ shares
        values = [float(TRIED_FORCE * starts[0][name] * share) for name, share in zip(sizes, shares, strict=True)]
        found.append((float(remaining @ remaining), dict(zip(sizes, values, strict=True)) | {period: each}))
    return [start for _, start in sorted(found, key=lambda pair: pair[0])[:KEPT_PERIODS]]


def promise(
    fit: Fit, effect: Effect, start: dict[str, float], left: np.ndarray, basis: np.ndarray, triangle: np.ndarray
) -> Trial:
    """Try a start of an effect on what a fit leaves over, beside whatever the fit's own unknowns can do."""
    problem, point = joined(fit.problem, fit.found.point, effect, start)
    known, residual = len(fit.found.point), problem.residuals(point[None, :])[0]
    change = change_of(residual, left, basis)
    size = float(change @ change)
    linear = float(left @ change) ** 2 / size if size > 0.0 else 0.0
    answered = point.copy()
    answered[:known] -= np.clip(np.linalg.solve(triangle, basis.T @ residual[: len(left)]), -ANSWER, ANSWER)
    answered = np.clip(answered, *problem.bounds)
    before, after = 0.5 * float(residual @ residual), float(errors(problem, answered[None, :])[0])
    gained = 2.0 * (fit.found.error - min(before, after))
    return Trial(problem, answered if after < before else point, max(linear, gained))


def change_of(residual: np.ndarray, left: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """Return how an effect changes the residuals of a fit, beside whatever the fit's own unknowns can do."""
    change = residual[: len(left)] - left
    return np.asarray(change - basis @ (basis.T @ change))


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
