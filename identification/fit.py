"""Fits of the base valve and of effects on top of it, robust to where they start."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from identification.experiment import Experiment, Simulated, simulate_rows
from identification.problem import SEARCH_SUBSTEP, SEARCH_TOLERANCE, Problem
from identification.search import Found, descend
from identification.unknowns import Unknown, base_unknowns, start_unknown
from valvemodel import runs
from valvemodel.model import Model

REFIT_EVALUATIONS, REFIT_PRECISION = 15, 1e-7
"""The last descent, over all data: it begins at the fit to a part of them and is short."""

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

    def simulated_on(self, experiment: Experiment, *, is_anchored: bool = False) -> Simulated:
        """Run the fitted model over an experiment, free or re-anchored on its readings.

        An experiment that was not fitted starts at its first readings.
        """
        numbers = [number for number, each in enumerate(self.problem.experiments) if each is experiment]
        start = self.starts[numbers[0]] if numbers else experiment.first_reading
        return simulate_model(self.model, experiment, start_position=start, is_anchored=is_anchored)


def simulate_model(
    model: Model, experiment: Experiment, *, start_position: float, is_anchored: bool = False
) -> Simulated:
    """Run one model over an experiment at the search's tolerance, free or re-anchored, one row of each signal."""
    return simulate_rows(
        experiment,
        model.rows(start_position=start_position),
        substep=SEARCH_SUBSTEP,
        tolerance=SEARCH_TOLERANCE,
        anchors=experiment.anchors if is_anchored else runs.FREE,
        with_pressure=True,
    )


def measured(experiments: Sequence[Experiment]) -> list[np.ndarray]:
    """Return all samples that were measured, as masks."""
    return [np.isfinite(experiment.position) for experiment in experiments]


def fit_base(model: Model, experiments: Sequence[Experiment], used: Masks | None = None) -> Fit:
    """Fit the base parameters k, F_c, f_v, c0, E and the start positions.

    Several starts about the model's values, a short descent from each, and a long one from the best.

    Parameters
    ----------
    model : Model
        Where the search begins, and what gives the numbers that are not fitted.
    experiments : sequence of Experiment
    used : sequence of arrays of bool, or None for all that was measured
    """
    unknowns = base_unknowns(model) + [
        start_unknown(experiment.first_reading, number) for number, experiment in enumerate(experiments)
    ]
    problem = Problem(model, experiments, unknowns, used or measured(experiments))
    names = [unknown.name for unknown in unknowns]
    starts = []
    for spring, friction, gap in ((0.0, 0.0, 0.0), (0.0, -0.7, 0.0), (0.3, 0.4, 0.1), (-0.3, 0.0, -0.1)):
        start = np.zeros(len(unknowns))
        for name, x in (("spring_rate", spring), ("coulomb_friction", friction)):
            start[names.index(name)] = x
        if "gap_offset" in names:
            start[names.index("gap_offset")] = gap
            start[names.index("gap_gain")] = gap
        starts.append(start)
    trials = [descend(problem, start, evaluations=8, precision=1e-3) for start in starts]
    best = min(trials, key=lambda trial: trial.error)
    return finished(problem, descend(problem, best.point, evaluations=40, precision=1e-8))


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


def fitted_to_all(fit: Fit, experiments: Sequence[Experiment]) -> Fit:
    """Fit the unknowns of a fit once more, to all that was measured, from where they are."""
    pairs = list(zip(fit.unknowns, fit.found.point, strict=True))
    kept = [pair for pair in pairs if pair[0].experiment < 0]
    starts = {unknown.experiment: (unknown, x) for unknown, x in pairs if unknown.experiment >= 0}
    for number, experiment in enumerate(experiments):
        kept.append(starts.get(number) or (start_unknown(experiment.first_reading, number), 0.0))
    problem = replace(
        fit.problem,
        experiments=experiments,
        unknowns=[unknown for unknown, _ in kept],
        used=measured(experiments),
    )
    point = np.array([x for _, x in kept])
    return finished(problem, descend(problem, point, evaluations=REFIT_EVALUATIONS, precision=REFIT_PRECISION))
