"""The trivial baseline: least squares from the nominal valve with one effect at a time, the smallest error wins."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from diagnosis.score import errors_of
from identification.driving.timing import experiments_of
from identification.fit import Fit, base_and_start_unknowns, finished
from identification.holdout import Holdout, hold_out
from identification.problem import Problem
from identification.search import descend
from identification.starting.hints import starts_of
from identification.unknowns import effect_unknowns
from valvemodel.effects import effect_of_key
from valvemodel.model import Model
from valvemodel.records import Record

EVALUATIONS = 15


def name_by_least_squares(record: Record, model: Model, candidates: Sequence[str]) -> dict[str, Any]:
    """Fit base and one effect, from the nominal values and the effect's first start, and name the best on unseen data.

    Returns
    -------
    dict
        `effects` that it names, `gap_after` of the position [m], and `seconds`.
    """
    began = time.perf_counter()
    holdout = hold_out(experiments_of([record])[0])
    fits = {key: _fit_from_nominal(model, key, holdout) for key in (None, *candidates)}
    gaps = {key: errors_of(holdout, [fit.simulated_on(holdout.scored_experiments[0])]) for key, fit in fits.items()}
    best = min(gaps, key=lambda key: gaps[key].mean)
    return {
        "effects": [] if best is None else [best],
        "gap_after": gaps[best].rms,
        "seconds": time.perf_counter() - began,
    }


def _fit_from_nominal(model: Model, key: str | None, holdout: Holdout) -> Fit:
    experiment = holdout.experiments[0]
    unknowns = base_and_start_unknowns(model, [experiment])
    point = np.zeros(len(unknowns))
    if key is not None:
        start = next(starts_of(effect_of_key(key), [experiment], [experiment.position]))
        added = effect_unknowns(key, start)
        model = model.with_effect(key, **start)
        unknowns += added
        point = np.append(point, [unknown.scaled(start[unknown.name]) for unknown in added])
    problem = Problem(model, holdout.experiments, unknowns, holdout.fitted)
    return finished(problem, descend(problem, point, evaluations=EVALUATIONS, precision=1e-6))
