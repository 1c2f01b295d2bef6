"""How well a fit determines its parameters: block-robust covariance, and what the record cannot say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from identification.experiment import Experiment
from identification.fit import Fit
from valvemodel.effects import effect_of_key

UNDETERMINED_SHARE = 0.5
"""A parameter that the record narrows to no less than this share of its prior is not determined by it."""

AT_BOUND = 1e-3
"""Scaled distance within which a parameter is at its bound."""


@dataclass(frozen=True)
class Estimate:
    """One fitted parameter with its uncertainty; `std` is None where the record does not determine it. [SI]"""

    name: str
    value: float
    unit: str
    std: float | None
    is_at_bound: bool


def estimates(fit: Fit) -> list[Estimate]:
    """Return the fitted parameters of valve and effects, start positions left out.

    The covariance is the sandwich of the Jacobian and of the scores summed by block in time, so that neighbouring
    errors that go together widen it. The parameters of an effect whose error has many minima have no standard
    deviation: the error has no slope that a record could be trusted to show.
    """
    jacobian = fit.problem.jacobian(fit.found.point)
    residual = fit.problem.residuals(fit.found.point[None, :])[0]
    spread = np.sqrt(np.diag(covariance(jacobian, residual, blocks_of(fit))))
    with_prior = np.sqrt(np.diag(np.linalg.pinv(jacobian.T @ jacobian, hermitian=True)))
    jagged = {
        parameter.name
        for key in fit.model.effects
        if effect_of_key(key).is_jagged
        for parameter in effect_of_key(key).parameters
    }
    found = []
    for unknown, x, deviation, left_open in zip(fit.unknowns, fit.found.point, spread, with_prior, strict=True):
        if unknown.experiment >= 0:
            continue
        value = float(unknown.value(x))
        low, high = unknown.bounds
        is_at_bound = bool(min(x - low, high - x) < AT_BOUND)
        widest = UNDETERMINED_SHARE * unknown.prior_spread
        is_determined = left_open < widest and (deviation < widest or not unknown.is_logarithmic)
        is_smooth = unknown.name not in jagged
        std = float(deviation * unknown.slope(value)) if is_determined and is_smooth and not is_at_bound else None
        found.append(Estimate(unknown.name, value, unknown.unit, std, is_at_bound))
    return found


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
    """Return the block in time of each residual of a fit, -1 for the priors, shape (r,)."""
    parts: list[np.ndarray] = []
    first = 0
    for experiment, used in zip(fit.problem.experiments, fit.problem.used, strict=True):
        numbers = first + experiment.block[used]
        parts += [numbers] * signals_of(experiment)
        first += int(experiment.block.max()) + 1
    parts.append(np.full(len(fit.unknowns), -1))
    return np.concatenate(parts)


def signals_of(experiment: Experiment) -> int:
    """Return how many signals of an experiment are compared: position, and pressure where it was measured."""
    return 1 if experiment.pressure is None else 2


def rms_of(fit: Fit, experiments: Sequence[Experiment], masks: Sequence[np.ndarray]) -> float:
    """Return the root mean square of measured less simulated position on masks of samples. [m]"""
    errors = [
        (experiment.position - fit.simulated_on(experiment).position[0])[mask]
        for experiment, mask in zip(experiments, masks, strict=True)
    ]
    return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))
