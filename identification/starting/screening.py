"""Screening: the starts of a search for one more effect, the most promising first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from identification.determined.uncertainty import blocks_of
from identification.fit import Fit
from identification.problem import Problem
from identification.search import errors, roam_over
from identification.starting.hints import begins_at_periods, is_periodic, nearby, starts_of
from identification.starting.joining import joined
from identification.starting.load_series import series_over, sizes_of
from valvemodel.declarations import Effect

LITTLE_LEFT = 1.1
"""Error of a fit, over that of the noise, below which what starts promise by slopes is all that they can gain."""

ANSWER = 0.5
"""Farthest that an unknown of the fit moves in answer to a start of an effect, scaled."""

TRIED_FORCE = 0.25
"""Share of its declared start at which each wave of a periodic effect is tried."""

SIZE, GENERATIONS = 8, 25
"""Points of a global search for each number of an effect, and generations."""

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
    residual, basis, triangle = fit.own_slopes
    left = beside_own(residual, basis)
    starts = starts_on(fit, effect)
    if begins_at_periods(effect):
        starts += waves(fit, effect, starts, left, basis)
        if fit.found.error > LITTLE_LEFT * fit.problem.noise_error and not fit.problem.has_series:
            starts.append(waves_together(fit, effect, starts[0], left, basis))
    trials = [promise(fit, effect, start, left, basis, triangle) for start in [*starts, *([known] if known else [])]]
    # Laws that make no difference beside the fit's effects are one.
    unlike = {(trial.gain, trial.point.tobytes()): trial for trial in reversed(trials)}
    return sorted(reversed(unlike.values()), key=lambda trial: -trial.gain)


def waves(
    fit: Fit, effect: Effect, starts: list[dict[str, float]], left: np.ndarray, basis: np.ndarray
) -> list[dict[str, float]]:
    """Return starts of a periodic effect at the periods at which it explains most, sine and cosine solved for.

    What a load does to a stem with friction is no wave: the strongest period of the residual may be another. Each
    period about those, and of the lowest waves of the record, is tried by a small sine and a small cosine; what the
    changes of the readings explain of the residual, whatever their sizes, is the promise of that period.
    """
    period = next(each.name for each in effect.parameters if is_periodic(each))
    sizes = [each.name for each in effect.fitted if each.name != period and not each.is_higher]
    longest = max(float(each.time[-1] - each.time[0]) for each in fit.problem.experiments)
    found = []
    for each in nearby([start[period] for start in starts], longest):
        lull = starts[0] | {other: 0.0 for other in sizes} | {period: each}
        tried = [lull | {name: TRIED_FORCE * starts[0][name]} for name in sizes]
        columns = changes_by(fit, effect, tried, left, basis)
        shares, *_ = np.linalg.lstsq(columns, -left, rcond=None)
        remaining = left + columns @ shares
        values = [float(TRIED_FORCE * starts[0][name] * share) for name, share in zip(sizes, shares, strict=True)]
        found.append((float(remaining @ remaining), starts[0] | dict(zip(sizes, values, strict=True)) | {period: each}))
    return [start for _, start in sorted(found, key=lambda pair: pair[0])[:KEPT_PERIODS]]


def waves_together(
    fit: Fit, effect: Effect, start: dict[str, float], left: np.ndarray, basis: np.ndarray
) -> dict[str, float]:
    """Return the start of a load that varies at will: all waves of a series over the record, solved for together."""
    lull, names = series_over(fit.problem.experiments, effect)
    size = TRIED_FORCE * start[names[0]]
    changes = changes_by(fit, effect, [lull | {name: size} for name in names], left, basis)
    shares = sizes_of(changes, -left, blocks_of(fit))
    return lull | {name: float(size * share) for name, share in zip(names, shares, strict=True)}


def placed(fit: Fit, effect: Effect, trials: Sequence[Trial]) -> Trial:
    """Return the start of an effect that leaves least, searched globally between neutral and the starts at hand.

    Whatever the fit's own unknowns can do (linearised) is taken out of what is left, so that they need no search.
    """
    problem, point = trials[0].problem, fit.found.point
    residual, basis, triangle = fit.own_slopes

    def left_by(values: np.ndarray, _: np.ndarray) -> np.ndarray:
        points = np.hstack([np.repeat(point[None, :], len(values), axis=0), values])
        left = problem.residuals(points)[:, : len(residual)]
        left = left - (left @ basis) @ basis.T
        return np.asarray(0.5 * np.einsum("ij,ij->i", left, left))

    values, _ = roam_over(left_by, box_of(effect, trials), size=SIZE, generations=GENERATIONS)
    found = np.concatenate([point, values])
    begun, error = answered(problem, found, problem.residuals(found[None, :])[0], basis, triangle)
    return Trial(problem, begun, 2.0 * (fit.found.error - error))


def box_of(effect: Effect, trials: Sequence[Trial]) -> list[tuple[float, float]]:
    """Return the least and the greatest scaled value of each unknown of an effect, of neutral and some starts."""
    unknowns = trials[0].problem.unknowns
    added = [number for number, unknown in enumerate(unknowns) if unknown.name in {each.name for each in effect.fitted}]
    neutral = [unknowns[number].scaled(effect.parameter(unknowns[number].name).neutral) for number in added]
    corners = np.vstack([neutral, *[trial.point[added] for trial in trials]])
    return list(zip(corners.min(axis=0), corners.max(axis=0), strict=True))


def promise(
    fit: Fit, effect: Effect, start: dict[str, float], left: np.ndarray, basis: np.ndarray, triangle: np.ndarray
) -> Trial:
    """Try a start of an effect on what a fit leaves over, beside whatever the fit's own unknowns can do."""
    problem, point = joined(fit.problem, fit.found.point, effect, start)
    residual = problem.residuals(point[None, :])[0]
    change = change_of(residual, left, basis)
    size = float(change @ change)
    linear = float(left @ change) ** 2 / size if size > 0.0 else 0.0
    begun, error = answered(problem, point, residual, basis, triangle)
    return Trial(problem, begun, max(linear, 2.0 * (fit.found.error - error)))


def answered(
    problem: Problem, point: np.ndarray, residual: np.ndarray, basis: np.ndarray, triangle: np.ndarray
) -> tuple[np.ndarray, float]:
    """Return a scaled point after the fit's own unknowns have answered its residual, where that helps, and its error.

    Parameters
    ----------
    residual : array, shape (r,)
        There.
    basis, triangle : arrays, shape (r, known), (known, known)
        Of the fit's own Jacobian.
    """
    moved = point.copy()
    moved[: len(triangle)] -= np.clip(np.linalg.solve(triangle, basis.T @ residual[: len(basis)]), -ANSWER, ANSWER)
    moved = np.clip(moved, *problem.bounds)
    before, after = 0.5 * float(residual @ residual), float(errors(problem, moved[None, :])[0])
    return (moved, after) if after < before else (point, before)


def change_of(residual: np.ndarray, left: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """Return how an effect changes the residuals of a fit, beside whatever the fit's own unknowns can do."""
    return beside_own(residual[: len(left)] - left, basis)


def beside_own(residual: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """Return what residuals, shape (r,) or (r, m), are beside whatever a fit's own unknowns do, by a basis of that."""
    return np.asarray(residual - basis @ (basis.T @ residual))


def changes_by(
    fit: Fit, effect: Effect, starts: Sequence[dict[str, float]], left: np.ndarray, basis: np.ndarray
) -> np.ndarray:
    """Return how an effect at each of some starts changes the residuals of a fit, shape (r, starts)."""
    begun = [joined(fit.problem, fit.found.point, effect, start) for start in starts]
    return np.array([change_of(each.residuals(point[None, :])[0], left, basis) for each, point in begun]).T


def starts_on(fit: Fit, effect: Effect) -> list[dict[str, float]]:
    """Return the starts of an effect on top of a fit, by what that leaves over."""
    return list(starts_of(effect, list(fit.problem.experiments), residual_positions(fit)))


def residual_positions(fit: Fit) -> list[np.ndarray]:
    """Return measured less simulated position of each experiment, NaN where a sample does not count. [m]"""
    residuals = []
    for experiment, used in zip(fit.problem.experiments, fit.problem.used, strict=True):
        residual = experiment.position - fit.simulated_on(experiment).position[0]
        residuals.append(np.where(used, residual, np.nan))
    return residuals
