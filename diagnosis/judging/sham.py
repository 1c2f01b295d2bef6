"""Sham effects: random regressors that cannot be in a valve, judged as if they were effects. None must win."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.judging.judgement import judge
from diagnosis.score import Errors, Score, errors_of
from diagnosis.trying.candidates import Candidate
from identification.experiment import Experiment, shifted
from identification.fit import Fit
from identification.holdout import Holdout
from identification.problem import Problem

SHAMS = 12
MOST_FREEDOM = 3
"""Shams have one to so many free parameters, as the effects have."""

SCALES = (0.5, 30.0)
"""Between these a sham's time scale is drawn. [s]"""

SHAM = "sham"

WINS_FROM = 0.5
"""Probability of all shams together from which the judgement cannot be trusted."""


@dataclass(frozen=True)
class Control:
    """How sham effects fare beside the real ones.

    Attributes
    ----------
    shams : int
    probability : float
        Of all shams together, were they candidates.
    gap_after : float [m]
        What the best of them leaves on unseen data.
    """

    shams: int
    probability: float
    gap_after: float

    @property
    def notes(self) -> list[str]:
        """What a reader must know where a sham effect wins."""
        if self.probability < WINS_FROM:
            return []
        return [
            "a random regressor that cannot be in a valve was judged as good as the best effect: "
            "this record says too little for a cause to be named"
        ]


def control_of(tried: Sequence[Candidate], shams: Sequence[Candidate], yardstick: str) -> Control:
    """Judge sham effects beside the candidates that were tried."""
    judgement = judge([*tried, *shams])
    weights = judgement.probabilities / judgement.probabilities.sum()
    gaps: list[Errors] = [getattr(each.score, yardstick) for each in shams]
    return Control(len(shams), float(weights[len(tried) :].sum()), min(each.rms for each in gaps))


def shams_on(base: Candidate, holdout: Holdout, *, count: int = SHAMS, seed: int = 0) -> list[Candidate]:
    """Fit sham effects on top of the base: smooth random functions of time, added to the reading.

    Each sham's amplitudes are fitted by least squares to the fitted samples, together with the base parameters (to
    first order), and scored on the others, as an effect is.
    """
    generator = np.random.default_rng(seed)
    experiments = [*holdout.experiments, *(e for e in holdout.scored_experiments if e not in holdout.experiments)]
    slopes = [slopes_on(base.fit, experiment) for experiment in experiments]
    found = []
    for number in range(count):
        freedom = 1 + number % MOST_FREEDOM
        scale = float(np.exp(generator.uniform(*np.log(SCALES))))
        waves = [smooth_noise(generator, experiment.time, scale, freedom) for experiment in experiments]
        free, anchored = (
            corrected_errors(base.fit, holdout, experiments, columns, is_anchored=is_anchored)
            for is_anchored, columns in (
                (False, [np.hstack(pair) for pair in zip(waves, slopes, strict=True)]),
                (True, waves),
            )
        )
        found.append(Candidate((SHAM,), base.fit, Score(free, anchored), freedom=freedom))
    return found


def smooth_noise(generator: np.random.Generator, time: np.ndarray, scale: float, count: int) -> np.ndarray:
    """Return Gaussian noise with a time scale, each column of variance 1, shape (n, count); its end meets its start."""
    turns = 2.0 * np.pi * np.fft.rfftfreq(len(time), float(np.median(np.diff(time))))
    waves = np.fft.rfft(generator.standard_normal((len(time), count)), axis=0)
    noise = np.fft.irfft(waves * np.exp(-0.5 * (turns * scale) ** 2)[:, None], len(time), axis=0)
    return (noise - noise.mean(axis=0)) / np.maximum(noise.std(axis=0), 1e-12)


def slopes_on(fit: Fit, experiment: Experiment) -> np.ndarray:
    """Return how the reading of an experiment moves with the base parameters, shape (n, parameters). [m]"""
    unknowns = [unknown for unknown in fit.unknowns if unknown.experiment < 0]
    point = np.array([x for unknown, x in zip(fit.unknowns, fit.found.point, strict=True) if unknown.experiment < 0])
    problem = Problem(fit.model, [experiment], unknowns, [np.ones(len(experiment.time), bool)])
    blind = replace(problem, experiments=[replace(experiment, position=np.zeros(len(experiment.time)), pressure=None)])
    return -experiment.noise * blind.jacobian(point)[: len(experiment.time)]


def corrected_errors(
    fit: Fit, holdout: Holdout, experiments: Sequence[Experiment], columns: Sequence[np.ndarray], *, is_anchored: bool
) -> Errors:
    """Fit the amplitudes of columns to the residual of a run on the fitted samples, and score it on the others."""
    runs = [fit.simulated_on(experiment, is_anchored=is_anchored) for experiment in experiments]
    masks = holdout.fitted
    design = np.concatenate([column[mask] for column, mask in zip(columns, masks, strict=False)])
    residual = np.concatenate(
        [(e.position - run.position[0])[mask] for e, run, mask in zip(experiments, runs, masks, strict=False)]
    )
    amplitudes = np.linalg.lstsq(design, residual)[0]
    corrected = {
        id(experiment): shifted(run, column @ amplitudes)
        for experiment, run, column in zip(experiments, runs, columns, strict=True)
    }
    return errors_of(holdout, [corrected[id(experiment)] for experiment in holdout.scored_experiments])
