"""Bootstrap by blocks in time: refits to the fitted trajectory with blocks of its residuals drawn anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from identification.determined.neighbourhood import Neighbourhood
from identification.determined.uncertainty import CONFIDENCE
from identification.experiment import Experiment
from valvemodel.progress import Progress, tell_nobody


def bootstrap(
    near: Neighbourhood, repetitions: int, progress: Progress = tell_nobody, *, seed: int = 0
) -> dict[str, tuple[float, float, float]]:
    """Return standard deviation, low and high end of the 95 % interval of each parameter by name. [SI]

    Residuals are drawn in blocks of some seconds from anywhere in the record, so that errors that belong together stay
    together, laid on the fitted trajectory, and refitted from the solution.

    References
    ----------
    Kuensch, Annals of Statistics 17 (1989): the moving-block bootstrap.
    """
    generator = np.random.default_rng(seed)
    experiments = near.problem.experiments
    simulated = [_trajectory(near, number) for number in range(len(experiments))]
    points = []
    for repetition in range(repetitions):
        progress(f"bootstrap {repetition + 1} of {repetitions}", repetition / repetitions)
        drawn = [_drawn(each, *run, generator) for each, run in zip(experiments, simulated, strict=True)]
        problem = replace(near.problem, experiments=drawn)
        points.append(near.refit(problem, near.point, list(range(len(near.point)))).point)
    tails = 0.5 * (1.0 + CONFIDENCE * np.array([-1.0, 1.0]))
    found = {}
    for unknown, column in zip(near.problem.unknowns, np.array(points).T, strict=True):
        if unknown.experiment < 0:
            values = unknown.value(column)
            low, high = np.quantile(values, tails)
            found[unknown.name] = (float(np.std(values, ddof=1)), float(low), float(high))
    return found


def _trajectory(near: Neighbourhood, number: int) -> tuple[np.ndarray, np.ndarray]:
    """Return position and, where it was measured, pressure of the solution on one experiment, run as it was fitted."""
    run = near.problem.simulated(near.point[None, :], number)
    return run.position[0], run.pressure[0]


def _drawn(
    experiment: Experiment, position: np.ndarray, pressure: np.ndarray, generator: np.random.Generator
) -> Experiment:
    """Return the experiment with residuals of other times on the simulated signals."""
    measured = np.flatnonzero(np.isfinite(experiment.position))
    count = len(measured)
    length = max(int(np.median(np.bincount(experiment.block))), 1)
    firsts = generator.integers(0, count, -(-count // length))
    source = measured[(firsts[:, None] + np.arange(length)).ravel()[:count] % count]
    drawn = experiment.position.copy()
    drawn[measured] = position[measured] + (experiment.position - position)[source]
    if experiment.pressure is None:
        return replace(experiment, position=drawn)
    pressed = experiment.pressure.copy()
    pressed[measured] = pressure[measured] + (experiment.pressure - pressure)[source]
    return replace(experiment, position=drawn, pressure=pressed)
