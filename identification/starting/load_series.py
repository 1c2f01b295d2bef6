"""A load that varies at will: a Fourier series over the record."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from identification.experiment import Experiment
from identification.starting.ridge import ridge
from valvemodel.declarations import Effect
from valvemodel.stages.load import HIGHER_COSINES, HIGHER_SINES, MOST_WAVES

LENGTH = 1.1
"""Period of a series over the record's length: its two ends need not meet."""

FASTEST, FEWEST = 0.12, 3
"""Frequency up to which a load is said to vary slowly [Hz], and the waves that a series has at least."""

PENALTIES = 10.0 ** np.arange(-6.0, 1.0)
"""Penalties that are tried, over the mean square of a column."""


def series_over(experiments: Sequence[Experiment], effect: Effect) -> tuple[dict[str, float], list[str]]:
    """Return a load without a size as a series over the longest record, and the names of its waves' sizes."""
    period = LENGTH * max(float(each.time[-1] - each.time[0]) for each in experiments)
    count = min(max(round(period * FASTEST), FEWEST), MOST_WAVES)
    lull = {each.name: each.neutral for each in effect.parameters}
    higher = [name for pair in zip(HIGHER_SINES, HIGHER_COSINES, strict=True) for name in pair]
    names = ["load_sine", "load_cosine", *higher[: 2 * (count - 1)]]
    return lull | {"load_period": period, "load_waves": float(count)}, names


def sizes_of(changes: np.ndarray, wanted: np.ndarray, block: np.ndarray) -> np.ndarray:
    """Return the shares of waves that make up what is wanted, as large as unseen blocks bear out, shape (m,).

    Parameters
    ----------
    changes : array, shape (r, m)
        Of the residuals, by each wave.
    wanted : array, shape (r,)
    block : array of int, shape (r,)
    """
    count = changes.shape[1]
    mean_square = float(np.sum(changes**2)) / count
    return ridge(changes, wanted, block, np.outer(mean_square * PENALTIES, np.ones(count)))
