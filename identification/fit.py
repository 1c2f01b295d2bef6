"""Fits of the base valve and of effects on top of it, robust to where they start."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from threadpoolctl import threadpool_limits

from identification.experiment import Experiment, Simulated, simulate_rows
from identification.problem import SEARCH_TOLERANCE, Problem
from identification.search import Found, descend
from identification.unknowns import Unknown, base_unknowns, start_unknown
from identification.wide import search_wide
from valvemodel import runs
from valvemodel.loops import settles_in_closed_form
from valvemodel.model import Model

REFIT_EVALUATIONS, REFIT_PRECISION = 15, 1e-7
"""The last descent, over all data: it begins at the fit to a part of them and is short."""

WIDE = 1.2
"""A base parameter is searched for within this many of its prior's powers of e: from a third to three times."""

START_REACH = 4.0
"""A start position is searched for within this many times the noise of the first readings' median."""

Masks = Sequence[np.ndarray]


@dataclass(frozen=True)
class Fit:
    """A model fitted to experiments, with all that later steps need of it."""

    model: Model
    starts: tuple[float, ...]
    problem: Problem
    found: Found

    @property
    def unknowns(self) -> Sequence[Unknown]:
        """The unknowns of the fit, in the order of the point."""
        return self.problem.unknowns

    @cached_property
    def own_slopes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Residuals of the fit, shape (r,), and its Jacobian as basis, shape (r, unknowns), and triangle."""
        residual = self.problem.residuals(self.found.point[None, :])[0]
        basis, triangle = np.linalg.qr(self.problem.jacobian(self.found.point, residual))
        return residual, basis, triangle

    def simulated_on(self, experiment: Experiment, *, is_anchored: bool = False) -> Simulated:
        """Run the fitted model over an experiment, free or re-anchored on its readings.

        An experiment that was not fitted starts at its first readings, and all else where it usually does.
        """
        numbers = [number for number, each in enumerate(self.problem.experiments) if each.is_same(experiment)]
        model = self.model if numbers else self.model.without_starts()
        start = self.starts[numbers[0]] if numbers else experiment.first_reading
        return simulate_model(model, experiment, start_position=start, is_anchored=is_anchored)


def simulate_model(
    model: Model, experiment: Experiment, *, start_position: float, is_anchored: bool = False
) -> Simulated:
    """Run one model over an experiment at the search's tolerance, free or re-anchored, one row of each signal."""
    return simulate_rows(
        experiment,
        model.rows(start_position=start_position),
        tolerance=SEARCH_TOLERANCE,
        anchors=experiment.anchors if is_anchored else runs.FREE,
        with_pressure=True,
        in_closed_form=settles_in_closed_form(model),
    )


def measured(experiments: Sequence[Experiment]) -> list[np.ndarray]:
    """Return all samples that were measured, as masks."""
    return [np.isfinite(experiment.position) for experiment in experiments]


def fit_base(model: Model, experiments: Sequence[Experiment], used: Masks | None = None) -> Fit:
    """Fit the base parameters k, F_c, f_v, c0, E and the start positions, from no good start.

    Parameters
    ----------
    model : Model
        Gives the numbers that are not fitted; the search reaches from a third to three times its fitted ones.
    experiments : sequence of Experiment
    used : sequence of arrays of bool, or None for all that was measured
    """
    unknowns = base_and_start_unknowns(model, experiments)
    problem = Problem(model, experiments, unknowns, used or measured(experiments))
    return finished(problem, search_wide(problem, base_box(unknowns, experiments)))


def base_and_start_unknowns(model: Model, experiments: Sequence[Experiment]) -> list[Unknown]:
    """Return the free base parameters and the start position of each experiment."""
    with_pressure = any(experiment.pressure is not None for experiment in experiments)
    return base_unknowns(model, with_pressure=with_pressure) + [
        start_unknown(experiment.first_reading, number) for number, experiment in enumerate(experiments)
    ]


def base_box(unknowns: Sequence[Unknown], experiments: Sequence[Experiment]) -> list[tuple[float, float]]:
    """Return how far a search looks for base parameters and start positions, scaled."""
    box = []
    for unknown in unknowns:
        reach = min(unknown.prior_spread, 1.0) * WIDE
        if unknown.experiment >= 0:
            reach = START_REACH * experiments[unknown.experiment].noise / unknown.spread
        box.append((-reach, reach))
    return box


def finished(problem: Problem, found: Found) -> Fit:
    """Put what a search found into a model."""
    values = problem.values(found.point)
    base = {name: value for name, value in values.items() if name in problem.model.values}
    effects = {
        key: {name: values.get(name, value) for name, value in given.items()}
        for key, given in problem.model.effects.items()
    }
    model = Model(problem.model.name, {**problem.model.values, **base}, effects)
    return Fit(model, tuple(problem.starts(found.point)), problem, found)


@threadpool_limits.wrap(limits=1)
def fitted_to_all(
    fit: Fit, experiments: Sequence[Experiment], used: Masks | None = None, *, starts_anew: bool = False
) -> Fit:
    """Fit the unknowns of a fit once more, to all that was measured or what is used, from where they are.

    The start positions are those of its own experiments, in their order, or begin anew at the first readings.
    """
    pairs = list(zip(fit.unknowns, fit.found.point, strict=True))
    kept = [pair for pair in pairs if pair[0].experiment < 0]
    starts = {unknown.experiment: (unknown, x) for unknown, x in pairs if unknown.experiment >= 0 and not starts_anew}
    for number, experiment in enumerate(experiments):
        kept.append(starts.get(number) or (start_unknown(experiment.first_reading, number), 0.0))
    problem = replace(
        fit.problem,
        experiments=experiments,
        unknowns=[unknown for unknown, _ in kept],
        used=used or measured(experiments),
    )
    point = np.array([x for _, x in kept])
    return finished(problem, descend(problem, point, evaluations=REFIT_EVALUATIONS, precision=REFIT_PRECISION))
