"""A measured current: its noise, which the stem does not answer, is taken out, and what remains of that is counted."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from identification.determined.adequacy import NOISELESS
from identification.determined.uncertainty import rms_of
from identification.driving.between_rows import COUNTS, SLOW, without_doubtful
from identification.driving.smoothing import smoothed
from identification.experiment import Experiment, Simulated
from identification.fit import Fit, fitted_to_all, measured, simulate_model
from identification.noise import noise_level, reading_step

SURE = 1.0
"""Readings that depend by more than this on what is left of the noise of a current are left out. [noise]"""

STEEPEST = 20.0
"""No stem goes further with its current than so many times its travel over the range of the current."""

ANSWERED = 0.5
"""Share of what the noise of a current does to the stem by the model, from one row to the next, from which the stem
answers it. Of six blind valves it was -0.6 to 0 where the current of a record was measured with noise of 2 to 16 uA,
and 0.5 to 1.2 where the same noise drove the valve, wherever it mattered."""

NO_FARTHER = 1.1
"""Error with a smooth current over that with the recorded one up to which that may be smoothed: a staircase of set
currents looks as if it were rounded, but nothing comes near its record without the steps."""

DRAWS = 4
"""Currents with such noise that are drawn and smoothed to see what remains of it."""


def as_set(experiments: Sequence[Experiment], base: Fit) -> list[Experiment]:
    """Return experiments with the currents that drove the valve, without the noise that they were measured with.

    A current that is recorded as it was set drives the valve with all its noise, if it has any, as that of a controller
    which answers a noisy position does: the stem answers it. One that was measured, or rounded for a display, has
    noise that the stem knows nothing of; its jumps, corners and curves stay.

    Parameters
    ----------
    experiments : sequence of Experiment
    base : Fit
        Of the base to them or some of them.
    """
    return [_as_set(each, base) for each in experiments]


def may_be_noisy(experiment: Experiment) -> bool:
    """Return whether the noise of a current, if it is any, may shift a stem so far that it matters."""
    if experiment.is_loop:
        return False
    slope = STEEPEST * _travel(experiment) / max(np.ptp(experiment.current), 1e-30)
    return bool(slope * _whole(*_noise_of(experiment)) > _least(experiment))


def said_of_current(experiments: Sequence[Experiment]) -> list[str]:
    """Return what is said of records whose currents were measured with noise, or rounded."""
    return [
        f"{each.name}: its current was {_how(each)}, which the stem does not answer; it is smoothed: record the current"
        " as it was set"
        for each in experiments
        if each.current_noise > 0.0
    ]


def _how(experiment: Experiment) -> str:
    if experiment.current_step > experiment.current_noise:
        return f"rounded to steps of {1e3 * experiment.current_step:.2g} mA"
    return f"measured with noise of {1e3 * experiment.current_noise:.2g} mA"


def error_of_current(experiment: Experiment, base: Fit) -> tuple[float, float]:
    """Return what the noise left in a current does to the readings of position and pressure, if any. [m], [Pa]"""
    if experiment.current_noise == 0.0:
        return 0.0, 0.0
    known = np.isfinite(experiment.position)
    position, pressure = doubts_of_current(experiment, base)
    return _rms(position[known]), 0.0 if experiment.pressure is None else _rms(pressure[known])


def doubts_of_current(experiment: Experiment, base: Fit) -> tuple[np.ndarray, np.ndarray]:
    """Return what the noise left in a current does to position and pressure, shape (n,). [m], [Pa]

    The smooth current with noise of the same kind is smoothed again, some times: what then drives the valve otherwise,
    root mean square.
    """
    generator, through = np.random.default_rng(0), base.simulated_on(experiment)
    white, step = experiment.current_noise, experiment.current_step
    shifts = []
    for _ in range(DRAWS):
        current = experiment.current + white * generator.standard_normal(len(experiment.current))
        if step > 0.0:
            shift = step * generator.uniform(-0.5, 0.5)
            current = step * np.round((current + shift) / step) - shift
        again = replace(experiment, current=smoothed(current, _whole(white, step)))
        shifts.append(_shifts(base, again, through))
    position, pressure = np.sqrt(np.mean(np.square(shifts), axis=0))
    return position, pressure


def _as_set(experiment: Experiment, base: Fit) -> Experiment:
    """Return an experiment without the noise of its current where the stem does not answer that."""
    if not may_be_noisy(experiment):
        return experiment
    white, step = _noise_of(experiment)
    smooth = smoothed(experiment.current, _whole(white, step))
    found = replace(experiment, current=smooth, current_noise=white, current_step=step)
    if _rms(_shifts(base, experiment, base.simulated_on(found))[0]) < _least(experiment):
        return experiment
    near = fitted_to_all(base, [found], starts_anew=True)
    missed, missed_before = (rms_of(fit, [each], measured([each])) for fit, each in ((near, found), (base, experiment)))
    if missed > NO_FARTHER * missed_before:
        return experiment
    through = near.simulated_on(found)
    left, shift = np.diff(found.position - through.smooth[0]), np.diff(_shifts(near, experiment, through)[0])
    known = np.isfinite(left)
    if np.sum(left[known] * shift[known]) > ANSWERED * np.sum(shift[known] ** 2):
        return experiment
    return without_doubtful(found, doubts_of_current(found, near), SURE)


def _least(experiment: Experiment) -> float:
    """Return from which root mean square on a shift of the stem matters, also where readings have no noise. [m]"""
    return COUNTS * max(experiment.noise, NOISELESS * _travel(experiment))


def _travel(experiment: Experiment) -> float:
    return float(np.ptp(experiment.position[np.isfinite(experiment.position)]))


def _noise_of(experiment: Experiment) -> tuple[float, float]:
    """Return the white noise of a current as it is recorded and the step to which it is rounded. [A]

    Of slow rows nobody knows the noise: a current that goes its way from one to the next looks like that.
    """
    white = noise_level(experiment.current) if experiment.period < SLOW else 0.0
    return white, reading_step(experiment.current)


def _whole(white: float, step: float) -> float:
    """Return the noise of a current with white noise and in steps."""
    return math.hypot(white, step / math.sqrt(12.0))


def _shifts(near: Fit, experiment: Experiment, through: Simulated) -> tuple[np.ndarray, np.ndarray]:
    """Return how far a model goes otherwise than in another run, from the same start, shape (n,). [m], [Pa]"""
    run = simulate_model(near.model, experiment, start_position=through.smooth[0][0])
    return run.smooth[0] - through.smooth[0], run.pressure[0] - through.pressure[0]


def _rms(shift: np.ndarray) -> float:
    return float(np.sqrt(np.mean(shift**2)))
