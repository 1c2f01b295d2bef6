"""Unbroken: stretches of rows that share something, one after the other."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt


def unbroken(has: npt.NDArray[np.bool_]) -> npt.NDArray[np.intp]:
    """Return the first row of each unbroken stretch of rows that have something, and the row behind it, shape (k, 2).

    Parameters
    ----------
    has : array of bool, shape (n,)

    Examples
    --------
    >>> unbroken(np.array([True, False, True, True])).tolist()
    [[0, 1], [2, 4]]
    """
    return np.flatnonzero(np.diff(has.astype(np.int8), prepend=0, append=0)).reshape(-1, 2)
