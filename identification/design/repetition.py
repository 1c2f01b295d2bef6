"""A designed test repeated in simulation: noise on the readings, a refit, and how far the refits scatter."""

from __future__ import annotations

import numpy as np

from identification.design.information import Prospect
from identification.determined.neighbourhood import Neighbourhood
from valvemodel.progress import Progress

START = 3.0
"""A refit starts so many expected standard deviations off the truth."""


def observed_deviations(
    found: Prospect, matrix: np.ndarray, repetitions: int, progress: Progress, seed: int
) -> np.ndarray:
    """Return the standard deviations of the refitted scaled unknowns about the truth, shape (unknowns,)."""
    generator = np.random.default_rng([seed, 1])
    covariance = np.linalg.inv(matrix)
    near = Neighbourhood(found.problem, found.point, covariance, found.problem.is_anchored)
    root = np.linalg.cholesky(covariance)
    low, high = found.problem.bounds
    errors = []
    for repetition in range(repetitions):
        progress(f"repetition {repetition + 1} of {repetitions}", 0.8 + 0.2 * repetition / repetitions)
        problem = found.with_noise(generator)
        start = np.clip(found.point + START * root @ generator.standard_normal(len(found.point)), low, high)
        errors.append(near.refit(problem, start, range(len(found.point))).point - found.point)
    return np.sqrt(np.mean(np.array(errors) ** 2, axis=0))
