"""Ridge regression over blocks in time, held back by what unseen blocks say of it."""

from __future__ import annotations

import numpy as np

FOLDS = 5
"""Parts of the blocks, each of which is foretold from the others."""


def ridge(columns: np.ndarray, wanted: np.ndarray, block: np.ndarray, penalties: np.ndarray) -> np.ndarray:
    """Return the weights of a ridge regression, its penalty the one by which unseen blocks come out best.

    Parameters
    ----------
    columns : array, shape (r, m)
    wanted : array, shape (r,)
    block : array of int, shape (r,)
        Number of the block that each row belongs to.
    penalties : array, shape (p, m)
        What is tried: penalties on the squares of the weights.
    """
    from scipy.linalg import solve

    fold = np.unique(block, return_inverse=True)[1] % FOLDS
    parts = [(columns[fold == each], wanted[fold == each]) for each in range(FOLDS)]
    grams = [part.T @ part for part, _ in parts]
    moments = [part.T @ its for part, its in parts]
    gram, moment = np.sum(grams, axis=0), np.sum(moments, axis=0)

    def missed(penalty: np.ndarray) -> float:
        total = 0.0
        for own, its in zip(grams, moments, strict=True):
            weights = solve(gram - own + np.diag(penalty), moment - its, assume_a="pos")
            total += float(weights @ own @ weights - 2.0 * weights @ its)
        return total

    return np.asarray(solve(gram + np.diag(min(penalties, key=missed)), moment, assume_a="pos"))
