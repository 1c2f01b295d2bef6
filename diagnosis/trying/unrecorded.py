"""What a record does not have of its current, between two rows or below noise, adds to the noise of its readings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from identification.driving.between_rows import COUNTS, unknown_if_held
from identification.driving.measured_current import error_of_current
from identification.experiment import Experiment
from identification.fit import Fit

SLOW_ROWS = (
    "what the current does between two rows shifts the stem by {error} and is not recorded; that counts as noise, and"
    " small effects hide in it: log ten times faster"
)
"""What is said of slow rows."""

NOISY_CURRENT = (
    "what is left of the noise of the measured current shifts the stem by {error}; that counts as noise, and small"
    " effects hide in it: record the current as it was set"
)
"""What is said of a current that was measured with noise."""


def with_unrecorded(experiments: Sequence[Experiment], base: Fit) -> tuple[list[Experiment], list[str]]:
    """Return experiments whose noise has in it what they do not have of their currents, and say where and why.

    Parameters
    ----------
    experiments : sequence of Experiment
    base : Fit
        Of the base to them or some of them.
    """
    found, notes = [], []
    for experiment in experiments:
        noisy, of_pressure = error_of_current(experiment, base)
        errors = {SLOW_ROWS: sampling_error(experiment, base), NOISY_CURRENT: noisy}
        counted = {why: error for why, error in errors.items() if error > COUNTS * experiment.noise}
        notes += [f"{experiment.name}: {why.format(error=f'{1e3 * error:.2g} mm')}" for why, error in counted.items()]
        if counted or of_pressure > COUNTS * experiment.pressure_noise:
            noise = math.hypot(experiment.noise, *counted.values())
            experiment = replace(
                experiment, noise=noise, pressure_noise=math.hypot(experiment.pressure_noise, of_pressure)
            )
        found.append(experiment)
    return found, notes


def largest_error(blurred: Sequence[Experiment], as_read: Sequence[Experiment]) -> float:
    """Return what counts as noise in some experiments beside that of the readings, in that with most of it. [m]"""
    pairs = zip(blurred, as_read, strict=True)
    return max(math.sqrt(max(each.noise**2 - before.noise**2, 0.0)) for each, before in pairs)


def sampling_error(experiment: Experiment, base: Fit) -> float:
    """Return by how much a reading differs where the current goes another way from row to row than is taken. [m]

    A current that moves on goes straight instead, or jumps earlier or later: what hangs on that was left out, but for
    what was not known to, a tenth of the readings at most. How much that is was told by the fit by which they were left
    out: the base alone, fitted to what remains, may be so lively that it tells far more. One that is held ramps.
    """
    return experiment.sampling_error if experiment.parts > 1 else unknown_if_held(experiment, base)
