"""Parts: which blocks in time of a record are kept back to score on, and which are fitted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.score import squares_of
from identification.experiment import Experiment
from identification.fit import Fit, fit_base
from identification.holdout import EVERY, Holdout, hold_out
from valvemodel.model import Model

UNEVEN, LEAST_SHOWN = 20.0, 0.3
"""Gap of the samples that are kept back, over that of the fitted ones, both beyond noise, from which others are kept
back, and what the fitted ones are taken to show at least. What is not fitted leaves more: of 143 blind records up to 8
times as much, and one 110 times, in which a stem stuck in a tight spot in kept blocks alone: the right cause, fitted
where little of it shows, was far off there. So it was where one long stroke alone showed unequal filling."""


def parted(experiments: Sequence[Experiment], model: Model, kept: int = EVERY - 1) -> tuple[Holdout, Fit]:
    """Return what is fitted and what is scored of experiments, as `hold_out` does, and the base fitted to it."""
    holdout = hold_out(experiments, kept)
    return holdout, fit_base(model, holdout.experiments, holdout.fitted)


def evenly_parted(holdout: Holdout, base: Fit, model: Model) -> tuple[Holdout, Fit]:
    """Return what is fitted and what is scored, so that the gap shows where it is fitted, and the base fitted to it.

    Where nearly all of the gap lies in blocks that are kept back, a cause that is fitted to the others is not
    determined by them: other blocks are kept back, those with more of the gap.

    Parameters
    ----------
    holdout : Holdout
    base : Fit
        The base valve as fitted to it.
    model : Model
        The valve as given.
    """
    if not holdout.has_blocks:
        return holdout, base
    gaps = gaps_of_blocks(holdout, base)
    others = [number for number in range(EVERY) if number != holdout.kept]
    if not gaps[holdout.kept] - 1.0 > UNEVEN * max(np.mean(gaps[others]) - 1.0, LEAST_SHOWN):
        return holdout, base
    return parted(holdout.experiments, model, max(others, key=lambda number: gaps[number]))


def gaps_of_blocks(holdout: Holdout, base: Fit) -> np.ndarray:
    """Return the mean squared gap of every so many blocks in time, by which of them it is, shape (EVERY,). [noise^2]"""
    (experiment,) = holdout.experiments
    squares = squares_of(experiment, base.simulated_on(experiment))
    measured = np.isfinite(experiment.position)
    which = experiment.block[measured] % EVERY
    return np.bincount(which, squares[measured], EVERY) / np.maximum(np.bincount(which, minlength=EVERY), 1)
