"""Fit a valve, and effects on top of it, on the smooth chain; then once more on the exact one, to see the bias."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from identification.experiment import Experiment
from identification.extending.following import KEPT_STARTS
from identification.extending.forms import alike
from identification.fit import Fit, Masks, base_and_start_unknowns, finished, measured
from identification.problem import Problem
from identification.search import Found, descend
from identification.smooth_fit.descent import WIDTHS, descend_smooth, narrowed, narrowed_by_shooting
from identification.smooth_fit.guess import guessed
from identification.smooth_fit.residuals import SmoothResiduals
from identification.smooth_fit.smoothing import Smoothing, smoothing_of
from identification.starting.joining import released
from identification.starting.screening import screened
from valvemodel.effects import effect_of_key
from valvemodel.model import Model
from valvemodel.progress import Progress, tell_nobody

TRIAL_EVALUATIONS, TRIAL_PRECISION = 8, 1e-3
"""A start is followed this far before the best is taken."""

TRIAL_WIDTH = 10.0
"""Smoothing width at which starts of an effect are compared. [N]"""

COMPARED = 2
"""Widths through which both starts of the base valve are followed."""

REFIT_EVALUATIONS, REFIT_PRECISION = 15, 1e-8
"""The exact refit begins next to its minimum."""


Path = list[tuple[float, Found]]
"""What is found by smoothing width. [N]"""


@dataclass(frozen=True)
class SmoothFit:
    """A fit by the smooth route.

    Attributes
    ----------
    fit : Fit
        The exact refit, started at the narrowest width's point: free of the smoothing's bias.
    smooth : Fit
        At the narrowest width, before that.
    smoothing : tuple of Smoothing
        What smoothing did, from wide to narrow.
    """

    fit: Fit
    smooth: Fit
    smoothing: tuple[Smoothing, ...]


def fit_smooth(
    experiments: Sequence[Experiment],
    model: Model,
    *,
    effects: Sequence[str] = (),
    used: Masks | None = None,
    widths: Sequence[float] = WIDTHS,
    is_multiple: bool = False,
    progress: Progress = tell_nobody,
) -> SmoothFit:
    """Fit the base parameters, those of effects and the start positions on the smooth chain.

    Parameters
    ----------
    experiments : sequence of Experiment
    model : Model
        Where the search begins, beside a guess from the readings, and what gives the numbers that are not fitted.
    effects : sequence of str
        Keys of effects to switch on and fit, in this order.
    used : sequence of arrays of bool, or None for all that was measured
    widths : sequence of float
        Smoothing widths, from wide to narrow. [N]
    is_multiple : bool
        Whether the last descent is by multiple shooting with IPOPT instead of one run through each record: slower.
    progress : callable
        Called with what is being done and a share of it from 0 to 1.

    Returns
    -------
    SmoothFit
    """
    progress("base valve", 0.0)
    steps = len(effects) + 3
    unknowns = base_and_start_unknowns(model, experiments)
    problem = Problem(model, experiments, unknowns, used or measured(experiments))
    residuals = SmoothResiduals(problem)
    path = _best_path(residuals, widths)
    for number, key in enumerate(effects, 1):
        progress(key, number / steps)
        residuals, point = _extended(finished(residuals.problem, path[-1][1]), key)
        path = list(narrowed(residuals, point, widths))
    problem, point = released(residuals.problem, path[-1][1].point)
    if problem is not residuals.problem:
        path = list(narrowed(SmoothResiduals(problem), point, widths))
    if is_multiple:
        progress("multiple shooting", (steps - 2) / steps)
        path = list(narrowed_by_shooting(problem, path[-1][1].point, widths))
    progress("exact refit", (steps - 1) / steps)
    last = path[-1][1].point
    refit = finished(problem, descend(problem, last, evaluations=REFIT_EVALUATIONS, precision=REFIT_PRECISION))
    return SmoothFit(refit, finished(problem, path[-1][1]), smoothing_of(problem, path, refit))


def _best_path(residuals: SmoothResiduals, widths: Sequence[float]) -> Path:
    """Return what is found by width from the guess or from the model's values, whichever leads further down.

    They are compared at the second width: the first hides what the stem does between stops.
    """
    starts = (guessed(residuals.problem), np.zeros(len(residuals.problem.unknowns)))
    wide, narrow = widths[:COMPARED], widths[COMPARED:]
    paths = [list(narrowed(residuals, start, wide, has_more=bool(narrow))) for start in starts]
    best = min(paths, key=lambda path: path[-1][1].error)
    return best + list(narrowed(residuals, best[-1][1].point, narrow))


def _extended(fit: Fit, key: str) -> tuple[SmoothResiduals, np.ndarray]:
    """Return the residuals with an effect added, and the point to which the best of its starts leads."""
    effect = effect_of_key(key)
    tried = []
    for group in alike(effect, screened(fit, effect)):
        for trial in group[:KEPT_STARTS]:
            residuals = SmoothResiduals(trial.problem)
            tried.append((residuals, _tried(residuals, trial.point, TRIAL_WIDTH)))
    residuals, best = min(tried, key=lambda pair: pair[1].error)
    return residuals, best.point


def _tried(residuals: SmoothResiduals, start: np.ndarray, width: float) -> Found:
    return descend_smooth(residuals, start, width, evaluations=TRIAL_EVALUATIONS, precision=TRIAL_PRECISION)
