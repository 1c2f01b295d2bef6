"""How well a fit determines its parameters: block-robust covariance, and what the record cannot say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from identification.determined.adequacy import undetermined_by
from identification.experiment import Experiment
from identification.fit import Fit
from valvemodel.effects import is_jagged

UNDETERMINED_SHARE = 0.5
"""A parameter that the record narrows to no less than this share of its prior is not determined by it."""

CONFIDENCE = 0.95

AT_A_BOUND = "it ended at a bound of its search"
HARDLY_SEEN = "the records hardly depend on it"
MANY_MINIMA = "the error has many minima, whose slopes say little: ask for the profile"
"""Why a parameter has no standard deviation."""

AT_BOUND = 1e-3
"""Scaled distance within which a parameter is at its bound."""


@dataclass(frozen=True)
class Estimate:
    """One fitted parameter with its uncertainty, in SI units.

    `std` and the 95 % `interval` are None where the record does not determine it, or where the slopes of its error say
    nothing of it; `reason` then says why.
    """

    name: str
    value: float
    unit: str
    std: float | None
    is_at_bound: bool
    interval: tuple[float, float] | None = None
    reason: str | None = None


def estimates(fit: Fit) -> list[Estimate]:
    """Return the fitted parameters of valve and effects, start positions left out.

    The covariance is the sandwich of the Jacobian and of the scores summed by block in time, so that neighbouring
    errors that go together widen it. With an effect whose error has many minima no parameter has a standard deviation:
    the slope in one minimum was measured to understate the errors by a factor of up to 40.
    """
    jacobian = fit.problem.jacobian(fit.found.point)
    residual = fit.problem.residuals(fit.found.point[None, :])[0]
    block = blocks_of(fit)
    spread = np.sqrt(np.diag(covariance(jacobian, residual, block)))
    quantile = interval_quantile(len(np.unique(block[block >= 0])))
    with_prior = np.sqrt(np.diag(np.linalg.pinv(jacobian.T @ jacobian, hermitian=True)))
    of_slopes = MANY_MINIMA if is_jagged(fit.model.effects) else None
    lacking = undetermined_by(fit.problem.experiments)
    found = []
    for unknown, x, deviation, left_open in zip(fit.unknowns, fit.found.point, spread, with_prior, strict=True):
        if unknown.experiment >= 0:
            continue
        value = float(unknown.value(x))
        low, high = unknown.bounds
        is_at_bound = bool(min(x - low, high - x) < AT_BOUND)
        widest = UNDETERMINED_SHARE * unknown.prior_spread
        is_determined = left_open < widest and (deviation < widest or not unknown.is_logarithmic)
        reason = AT_A_BOUND if is_at_bound else HARDLY_SEEN if not is_determined else of_slopes
        reason = lacking.get(unknown.name, reason)
        std = float(deviation * unknown.slope(value)) if reason is None else None
        ends = unknown.value(np.clip(x + quantile * deviation * np.array([-1.0, 1.0]), low, high))
        interval = None if std is None else (float(ends[0]), float(ends[1]))
        found.append(Estimate(unknown.name, value, unknown.unit, std, is_at_bound, interval, reason))
    return found


def interval_quantile(blocks: int) -> float:
    """Return how many standard deviations a 95 % interval reaches to either side (Student's t, blocks less one)."""
    from scipy.special import stdtrit

    return float(stdtrit(max(blocks - 1, 1), 0.5 * (1.0 + CONFIDENCE)))


def covariance(jacobian: np.ndarray, residual: np.ndarray, block: np.ndarray) -> np.ndarray:
    """Return the covariance of scaled unknowns, robust against errors that go together within blocks.

    Parameters
    ----------
    jacobian : array, shape (r, unknowns)
    residual : array, shape (r,) [noise]
    block : array of int, shape (r,)
        Negative for the priors.

    Returns
    -------
    array, shape (unknowns, unknowns)
        Never smaller than that of white residuals of their own size.
    """
    information = jacobian.T @ jacobian
    inverse = np.linalg.pinv(information, hermitian=True)
    data = block >= 0
    scores = jacobian[data] * residual[data, None]
    sums = np.zeros((block.max() + 1, jacobian.shape[1]))
    np.add.at(sums, block[data], scores)
    count = max(len(np.unique(block[data])), 2)
    robust = inverse @ (sums.T @ sums * count / (count - 1.0)) @ inverse
    white = inverse * max(float(residual[data] @ residual[data]) / max(data.sum() - jacobian.shape[1], 1), 1e-12)
    ratio = np.sqrt(np.maximum(np.diag(white) / np.maximum(np.diag(robust), 1e-300), 1.0))
    return robust * np.outer(ratio, ratio)


def blocks_of(fit: Fit) -> np.ndarray:
    """Return the block in time of each residual of a fit, -1 for the priors and what counts for nothing, shape (r,)."""
    experiments, masks = fit.problem.experiments, fit.problem.used
    parts: list[np.ndarray] = []
    for experiment, used, numbers in zip(experiments, masks, blocks_within(experiments, masks), strict=True):
        parts.append(numbers)
        if experiment.pressure is not None:
            parts.append(np.where(experiment.pressures_in(used)[used], numbers, -1))
    return np.concatenate([*parts, np.full(len(fit.unknowns), -1)])


def blocks_within(experiments: Sequence[Experiment], masks: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return the block in time of each sample within masks, by experiment, counted on through the experiments."""
    numbers, first = [], 0
    for experiment, mask in zip(experiments, masks, strict=True):
        numbers.append(first + experiment.block[mask])
        first += int(experiment.block.max()) + 1
    return numbers


def rms_of(fit: Fit, experiments: Sequence[Experiment], masks: Sequence[np.ndarray]) -> float:
    """Return the root mean square of measured less simulated position on masks of samples. [m]"""
    errors = [
        (experiment.position - fit.simulated_on(experiment).position[0])[mask]
        for experiment, mask in zip(experiments, masks, strict=True)
    ]
    return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))
