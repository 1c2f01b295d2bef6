"""The ceiling: how much of the gap a black-box correction of the base would close."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import polars

from diagnosis.score import Errors, errors_of
from identification.determined.uncertainty import blocks_within
from identification.experiment import Experiment, Simulated, shifted
from identification.fit import Fit
from identification.holdout import Holdout
from identification.results.regimes import time_since_reversal
from identification.starting.ridge import ridge

PLACES = 12
"""Places along each input at which the correction's curve bends; more close no more."""

PENALTIES = 10.0 ** np.arange(-5.0, 3.0)
"""Ridge penalties, over the samples of a block."""

FILTERS = (0.05, 0.2, 0.7, 2.0)
"""Time constants of the low-pass filters through which the black box sees the position's past. [s]"""


@dataclass(frozen=True)
class Curves:
    """Piecewise linear curves of each input, and one more for each way of moving of those that come first.

    Attributes
    ----------
    centre, spread : arrays, shape (inputs,)
        Of the fitted samples.
    places : list of arrays
        Where each input's curve bends, in units of its spread.
    """

    centre: np.ndarray
    spread: np.ndarray
    places: list[np.ndarray]

    def __call__(self, inputs: np.ndarray) -> np.ndarray:
        """Return the curves' parts at each sample, shape (n, parts), the constant one first."""
        scaled = (inputs - self.centre) / self.spread
        bumps = [hats(scaled[:, number], places) for number, places in enumerate(self.places)]
        by_direction = [bumps[number] * scaled[:, DIRECTION, None] for number in range(DIRECTION)]
        return np.column_stack([np.ones(len(scaled)), scaled, *bumps, *by_direction])


def ceiling_of(base: Fit, holdout: Holdout, *, is_anchored: bool) -> Errors:
    """Correct the base by smooth curves that were learnt from its residual, and score it on unseen samples.

    The correction is a sum of curves of what the base's own run shows: position and current (each way of moving apart),
    direction, time since reversal, time, and the position's past; a ridge regression, its penalty chosen by
    cross-validation over blocks in time. It sees only the samples that were fitted. No physics is in it: it says what
    part of the gap such a correction reaches.

    Parameters
    ----------
    base : Fit
    holdout : Holdout
    is_anchored : bool
        Whether the base's run is put anew on the readings every so often, or runs free.
    """
    seen = [base.simulated_on(each, is_anchored=is_anchored) for each in holdout.experiments]
    unseen = [base.simulated_on(each, is_anchored=is_anchored) for each in holdout.scored_experiments]
    inputs = [inputs_of(*pair) for pair in zip(holdout.experiments, seen, strict=True)]
    known = np.concatenate([each[mask] for each, mask in zip(inputs, holdout.fitted, strict=True)])
    residual = np.concatenate(
        [
            (each.position - run.position[0])[mask]
            for each, run, mask in zip(holdout.experiments, seen, holdout.fitted, strict=True)
        ]
    )
    curves = curves_over(known)
    weights = learnt(curves(known), residual, np.concatenate(blocks_within(holdout.experiments, holdout.fitted)))
    corrected = [
        shifted(run, curves(inputs_of(each, run)) @ weights)
        for each, run in zip(holdout.scored_experiments, unseen, strict=True)
    ]
    return errors_of(holdout, corrected)


DIRECTION = 2
"""Column of the inputs that has the direction of the last motion; the curves before it are learnt for each."""


def inputs_of(experiment: Experiment, run: Simulated) -> np.ndarray:
    """Return what the black box sees of each sample, shape (n, inputs): nothing that was measured but the current."""
    position, mode = run.position[0], run.mode[0]
    last_moved = np.maximum.accumulate(np.where(mode != 0.0, np.arange(len(mode)), 0))
    since = np.minimum(time_since_reversal(experiment.time, mode), experiment.time[-1])
    past = [lowpass(position, experiment.time, constant) - position for constant in FILTERS]
    return np.column_stack(
        [position, experiment.current, mode[last_moved], mode, np.log1p(since / FILTERS[0]), experiment.time, *past]
    )


def lowpass(signal: np.ndarray, time: np.ndarray, constant: float) -> np.ndarray:
    """Return a signal through a first-order filter, started at rest."""
    share = 1.0 - math.exp(-float(np.median(np.diff(time))) / constant)
    return polars.Series(signal).ewm_mean(alpha=share, adjust=False).to_numpy()


def curves_over(known: np.ndarray) -> Curves:
    """Return curves that bend where the fitted samples are, shape (n, inputs)."""
    centre, spread = known.mean(axis=0), np.maximum(known.std(axis=0), 1e-12)
    quantiles = np.quantile((known - centre) / spread, np.linspace(0.0, 1.0, PLACES), axis=0)
    return Curves(centre, spread, [np.unique(column) for column in quantiles.T])


def hats(values: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return triangles about each place, shape (n, places), half as wide again as the places are apart."""
    if len(places) < 2:
        return np.empty((len(values), 0))
    widths = 1.5 * np.gradient(places)
    return np.maximum(0.0, 1.0 - np.abs(values[:, None] - places) / widths)


def learnt(features: np.ndarray, residual: np.ndarray, block: np.ndarray) -> np.ndarray:
    """Return the ridge regression's weights, whose first one, the mean, is free, shape (features,)."""
    samples = len(residual) / len(np.unique(block))
    held = np.ones(features.shape[1])
    held[0] = 1e-9
    return ridge(features, residual, block, np.outer(samples * PENALTIES, held))
