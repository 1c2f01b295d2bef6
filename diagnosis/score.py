"""Scores: how far a fitted model is from data that it has not seen, block by block, running free and re-anchored."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from identification.experiment import Experiment, Simulated
from identification.fit import Fit
from identification.holdout import Holdout

LOST = 1.0
"""Error that counts where a run breaks off. [m]"""

RESAMPLES = 1000
"""Resamples of the block bootstrap."""


@dataclass(frozen=True, eq=False)
class Errors:
    """Squared errors of one run on the scored samples, summed by block.

    Attributes
    ----------
    squares : array, shape (blocks,) [m^2]
        Of the position.
    weighted : array, shape (blocks,)
        Of position and pressure, in units of the noise.
    counts : array, shape (blocks,)
        Samples of position.
    readings : array, shape (blocks,)
        Readings of position, and of pressure where it was measured.
    persistence : float
        Samples that count as one: twice the sum of the error's autocorrelation, and 1.
    """

    squares: np.ndarray
    weighted: np.ndarray
    counts: np.ndarray
    readings: np.ndarray
    persistence: float

    @property
    def rms(self) -> float:
        """Root of the mean squared error of the position. [m]"""
        return float(np.sqrt(self.squares.sum() / self.counts.sum()))

    @property
    def mean(self) -> float:
        """Mean weighted square: 1 where the noise is reached."""
        return float(self.weighted.sum() / self.readings.sum())


@dataclass(frozen=True, eq=False)
class Score:
    """Errors of one model on unseen samples: of the free run, and of the run re-anchored every so often.

    Where the stem goes in stairs, also of the run that is put anew on each rest: each slip by itself. `whole` has the
    same runs on all samples, the fitted ones among them.
    """

    free: Errors
    anchored: Errors
    at_rests: Errors | None = None
    whole: Score | None = None

    @property
    def judged(self) -> tuple[Errors, Errors]:
        """The two runs by which a cause is judged: a free one loses the phase of stairs though the cause is right."""
        return (self.free, self.anchored) if self.at_rests is None else (self.anchored, self.at_rests)

    @property
    def misfit(self) -> float:
        """Geometric mean of the mean weighted squares of the two runs that are judged: 1 where the noise is reached.

        What is left of the whole record counts where it is more: a fit can only have made it less, and a gap that shows
        itself in a few places, as a lag does at steps, may lie among the fitted samples.
        """
        one, other = self.judged
        unseen = float(np.sqrt(one.mean * other.mean))
        return unseen if self.whole is None else max(unseen, self.whole.misfit)


def score_fit(fit: Fit, holdout: Holdout) -> Score:
    """Score a fit on the samples that were kept back, and on all."""
    whole = holdout.whole
    runs = [(whole.scored_experiments, False), (whole.scored_experiments, True)]
    if any(each.has_stairs for each in holdout.scored_experiments):
        runs.append((whole.scored_on_rests, True))
    simulated = [
        [fit.simulated_on(each, is_anchored=is_anchored) for each in experiments] for experiments, is_anchored in runs
    ]
    unseen = len(holdout.scored_experiments)
    return replace(
        score_of([errors_of(holdout, rows[-unseen:]) for rows in simulated]),
        whole=score_of([errors_of(whole, rows) for rows in simulated]),
    )


def score_of(errors: Sequence[Errors]) -> Score:
    """Return the score of the runs in their order."""
    free, anchored, *at_rests = errors
    return Score(free, anchored, at_rests[0] if at_rests else None)


def errors_of(holdout: Holdout, simulated: Sequence[Simulated]) -> Errors:
    """Compare simulated positions and pressures, one row each, with the samples that were kept back."""
    squares, weighted, counts, readings, persistence = [], [], [], [], [1.0]
    for experiment, one, mask in zip(holdout.scored_experiments, simulated, holdout.scored, strict=True):
        error = np.where(mask, experiment.position - one.position[0], 0.0)
        error = np.where(np.isfinite(error), error, LOST)
        blocks = np.unique(experiment.block[mask])
        last = experiment.block.max() + 1
        counted = np.where(mask, squares_of(experiment, one), 0.0)
        counted = np.where(np.isfinite(counted), counted, (LOST / experiment.noise) ** 2)
        total = np.bincount(experiment.block, counted, last)[blocks]
        count = np.bincount(experiment.block, mask, last)[blocks]
        read = count
        if experiment.pressure is not None:
            is_read = experiment.pressures_in(mask)
            off = np.where(is_read, (experiment.pressure - one.pressure[0]) / experiment.pressure_noise, 0.0)
            total = total + np.bincount(experiment.block, off**2, last)[blocks]
            read = count + np.bincount(experiment.block, is_read, last)[blocks]
        squares.append(np.bincount(experiment.block, error**2, last)[blocks])
        weighted.append(total)
        counts.append(count)
        readings.append(read)
        persistence.append(persistence_of(error[mask]))
    of_position, of_all, samples, read = map(np.concatenate, (squares, weighted, counts, readings))
    return Errors(of_position, of_all, samples, read, max(persistence))


def squares_of(experiment: Experiment, simulated: Simulated) -> np.ndarray:
    """Return the squared errors of one row's positions, shape (n,): 1 in the mean where the noise is reached. [noise^2]

    A reading in coarse steps s tells of an error d only where it lies beyond half a step of the model's: by v, of which
    the mean over all places between two steps is d^2/(2 s), noise in the same way. So 2 s v is the squared error that a
    sample tells of, up to a whole step; beyond that v (s + v), as the mean of v is then |d| - s/2. All stays on a step
    count alike.
    """
    beyond, step = np.abs(experiment.beyond(simulated)[0]), simulated.step
    told = np.sqrt(beyond * (step + np.maximum(beyond, step)))
    squares: np.ndarray = experiment.worth_in_steps(step) * experiment.tempered(told / experiment.noise) ** 2
    return squares


def persistence_of(error: np.ndarray) -> float:
    """Return how many neighbouring samples of an error count as one: 1 for white noise.

    Twice the sum of the autocorrelation up to its first fall below 0.1, plus 1.
    """
    error = error - error.mean()
    variance = float(error @ error)
    if variance <= 0.0 or len(error) < 16:
        return 1.0
    size = 1 << (2 * len(error) - 1).bit_length()
    spectrum = np.abs(np.fft.rfft(error, size)) ** 2
    correlation = np.fft.irfft(spectrum, size)[: len(error) // 4] / variance
    ends = np.flatnonzero(correlation < 0.1)
    until = int(ends[0]) if len(ends) else len(correlation)
    return float(1.0 + 2.0 * correlation[1:until].sum())


def closed_share(refitted: float, after: float, floor: float) -> float | None:
    """Return the share of the reducible gap that is closed, or None where nothing is reducible."""
    reducible = refitted - floor
    return (refitted - after) / reducible if reducible > 0.0 else None


def closed_interval(base: Errors, after: Errors, floor: float, *, seed: int = 0) -> tuple[float, float] | None:
    """Return the 95 % interval of the share closed, by resampling the scored blocks."""
    draws = np.random.default_rng(seed).integers(0, len(base.squares), (RESAMPLES, len(base.squares)))
    counts = base.counts[draws].sum(axis=1)
    refitted = np.sqrt(base.squares[draws].sum(axis=1) / counts)
    left = np.sqrt(after.squares[draws].sum(axis=1) / counts)
    reducible = refitted - floor
    usable = reducible > 0.02 * floor
    if usable.mean() < 0.5:
        return None
    low, high = np.quantile(((refitted - left) / np.where(usable, reducible, 1.0))[usable], [0.025, 0.975])
    return float(low), float(high)
