"""A load that varies at will: a Fourier series over the record, held back by what unseen blocks say of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from identification.experiment import Experiment
from identification.problem import Problem
from valvemodel.declarations import Effect
from valvemodel.stages.load import HIGHER_COSINES, HIGHER_SINES, MOST_WAVES

LENGTH = 1.1
"""Period of a series over the record's length: its two ends need not meet."""

FASTEST, FEWEST = 0.12, 3
"""Frequency up to which a load is said to vary slowly [Hz], and the waves that a series has at least."""

FOLDS = 5
"""Parts of the blocks, each of which is foretold from the others."""

PENALTIES = tuple(10.0**power for power in range(-6, 1))
"""Penalties that are tried, over the mean square of a column."""


def series_over(experiments: Sequence[Experiment], effect: Effect) -> tuple[dict[str, float], list[str]]:
    """Return a load without a size as a series over the longest record, and the names of its waves' sizes."""
    period = LENGTH * max(float(each.time[-1] - each.time[0]) for each in experiments)
    count = min(max(round(period * FASTEST), FEWEST), MOST_WAVES)
    lull = {each.name: each.neutral for each in effect.parameters}
    higher = [name for pair in zip(HIGHER_SINES, HIGHER_COSINES, strict=True) for name in pair]
    names = ["load_sine", "load_cosine", *higher[: 2 * (count - 1)]]
    return lull | {"load_period": period, "load_waves": float(count)}, names


def ridge(columns: np.ndarray, wanted: np.ndarray, block: np.ndarray) -> np.ndarray:
    """Return the weights of a ridge regression, its penalty the one by which unseen blocks come out best.

    Parameters
    ----------
    columns : array, shape (r, m)
    wanted : array, shape (r,)
    block : array of int, shape (r,)
        Number of the block that each row belongs to.
    """
    fold = np.unique(block, return_inverse=True)[1] % FOLDS
    parts = [(columns[fold == each], wanted[fold == each]) for each in range(FOLDS)]
    grams = np.array([part.T @ part for part, _ in parts])
    moments = np.array([part.T @ its for part, its in parts])
    gram, moment = grams.sum(axis=0), moments.sum(axis=0)
    unit = np.trace(gram) / len(gram) * np.eye(len(gram))

    def missed(penalty: float) -> float:
        weights = [
            np.linalg.solve(gram - own + penalty * unit, moment - its) for own, its in zip(grams, moments, strict=True)
        ]
        return sum(
            float(each @ own @ each - 2.0 * each @ its) for each, own, its in zip(weights, grams, moments, strict=True)
        )

    return np.asarray(np.linalg.solve(gram + min(PENALTIES, key=missed) * unit, moment))


def block_numbers(problem: Problem) -> np.ndarray:
    """Return the number of the block in time of each residual, shape (r,); the priors are a block of their own."""
    numbers, first = [], 0
    for experiment, used in zip(problem.experiments, problem.used, strict=True):
        numbers += [first + experiment.block[used]] * (1 if experiment.pressure is None else 2)
        first += int(experiment.block.max()) + 1
    return np.concatenate([*numbers, np.full(len(problem.unknowns), first)])
