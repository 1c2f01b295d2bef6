"""The smallest correction at each stage's output that would explain a record of current and position.

Only two places differ: before the friction of the stem a gap, a pressure and a force are one correction in three units,
which static maps turn into each other; after it there is the reading. Each correction goes through knots in time and is
found by regularised Gauss-Newton on the exact chain of the refitted base.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from identification.experiment import Experiment
from identification.fit import Fit, simulate_model
from identification.problem import SEARCH_TOLERANCE
from valvemodel import chain, runs
from valvemodel.parameters import MEMORY, STATE

KNOT_INTERVAL, MOST_KNOTS, SAMPLES_OF_KNOT = 0.75, 128, 3
"""Usual time between the knots of a correction, which is linear between them [s]; the most it has; fewest samples of
one."""

MOST_SAMPLES = 12_000
"""A longer record is looked at in the stretch of so many samples in which the base misses most."""

MOST_MEANS = 1_500
"""Errors of neighbouring samples are averaged into so many means."""

WITHIN = 0.3
"""What a mean may miss beside its own noise. [noise]"""

REACHED = 1.1
"""Where the noise is out of reach, a correction comes within this factor of the least mean square."""

ROUNDS, STEPS, ENOUGH = 3, (1.0, 0.5, 0.2), 0.95
"""Gauss-Newton rounds, the parts of a step that are tried, and the share of the square beyond which it hardly falls."""

LIGHTEST, HEAVIEST, HALVINGS = -6.0, 4.0, 12
"""Powers of ten between which the weight of a correction is looked for, over the mean sensitivity to a knot."""

SIZE, BEND = 0.02, 4.0
"""What weighs in a correction: its square, and that of its bends from knot to knot."""

NUDGE = 0.5
"""Step of a knot by which the chain's answer to it is found. [noise of the reading]"""

PLACES = ("before the friction", "after the friction")


@dataclass(frozen=True, eq=False)
class Correction:
    """What would have to be added at one place of the chain.

    Attributes
    ----------
    place : str
        Of `PLACES`.
    values : array, shape (n,) [m]
        As the shift of the reading at rest that each makes.
    left : float [m]
        Root mean square of what the corrected chain still misses.
    freedom : float
        Independent numbers that the correction takes: few for a regular one, many for an erratic one.
    """

    place: str
    values: np.ndarray
    left: float
    freedom: float


@dataclass(frozen=True, eq=False)
class Corrected:
    """The refitted base, corrected at a place, over an experiment; knots are in noises of the reading.

    Attributes
    ----------
    rows : array, shape (1,), dtype PARAMETERS
    pressure, reading : arrays, shape (n,) [Pa], [m]
        Without a correction: held in each period, and at its start.
    pressure_of_noise : float [Pa]
        Moves the stem at rest by the noise of the reading.
    hats : array, shape (n, knots)
        Part of each knot in each sample.
    """

    experiment: Experiment
    rows: np.ndarray
    pressure: np.ndarray
    reading: np.ndarray
    pressure_of_noise: float
    hats: np.ndarray
    place: str

    @property
    def width(self) -> int:
        """Samples of a mean."""
        return width_of_means(len(self.experiment.time))

    def readings(self, knots: np.ndarray) -> np.ndarray:
        """Return the readings for knots, shape (k, knots), as an array, shape (k, n). [m]"""
        shifts = knots @ self.hats.T
        if self.place != PLACES[0]:
            return self.reading + self.experiment.noise * shifts
        rows = np.repeat(self.rows, len(shifts))
        return run_with_pressures(rows, self.experiment, self.pressure + self.pressure_of_noise * shifts)

    def missed(self, knots: np.ndarray) -> np.ndarray:
        """Return what is missed of the readings, in means of neighbouring samples, shape (k, means). [noise]"""
        return in_means((self.experiment.position - self.readings(knots)) / self.experiment.noise)[0]

    def jacobian(self, knots: np.ndarray, missed: np.ndarray) -> np.ndarray:
        """Return by how much the means of the readings move with each knot, shape (means, knots). [noise]"""
        return (missed - self.missed(knots + NUDGE * np.eye(len(knots)))).T / NUDGE


def run_with_pressures(rows: np.ndarray, experiment: Experiment, pressures: np.ndarray) -> np.ndarray:
    """Return the readings of an experiment that each row of numbers makes of its own pressures, shape (p, n). [m]"""
    time = experiment.drive[0]
    readings = np.empty((len(pressures), len(time)))
    states, memories = np.zeros(1, STATE), np.zeros(1, MEMORY)
    for number, drive in enumerate(pressures):
        part = slice(number, number + 1)
        runs.run_chain(
            rows[part], states, memories, time, experiment.moving(drive), runs.FREE, chain.PRESSURE, SEARCH_TOLERANCE,
            readings[part], runs.NONE, runs.NONE,
        )  # fmt: skip
    return readings[:, :: experiment.parts]


def closed_of(missed: float, left: float, noise: float) -> float | None:
    """Return the share of the squared gap above the noise that a correction closes, or None where there is none."""
    reducible = missed**2 - noise**2
    return float(np.clip((missed**2 - left**2) / reducible, 0.0, 1.0)) if reducible > 0.0 else None


def width_of_means(count: int) -> int:
    """Return how many neighbouring samples of so many go into a mean."""
    return -(-count // MOST_MEANS)


def in_means(errors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the means of neighbouring errors, shape (p, n), and how many were known of each, both (p, means)."""
    starts = np.arange(0, errors.shape[1], width_of_means(errors.shape[1]))
    known = np.isfinite(errors)
    counts = np.maximum(np.add.reduceat(known, starts, axis=1, dtype=int), 1)
    return np.add.reduceat(np.where(known, errors, 0.0), starts, axis=1) / counts, counts


def smallest_correction(stretch: Experiment, base: Fit, start: float, place: str) -> Correction:
    """Find the smallest and smoothest correction at a place that brings a record down to its noise, and not further.

    The weight of the correction is the greatest with which the means of the errors come down to their noise (Morozov's
    discrepancy principle), or as far as a correction hardly weighed comes.

    Parameters
    ----------
    stretch : Experiment
    base : Fit
        Of the base; its parameters stay.
    start : float [m]
        First reading of the base.
    place : str
        Of `PLACES`.
    """
    chain_with = corrected_at(stretch, base, start, place)
    aim = 1.0 / chain_with.width + WITHIN**2
    knots, freedom = np.zeros(chain_with.hats.shape[1]), 0.0
    missed = chain_with.missed(knots[None, :])[0]
    square, before = float(np.mean(missed**2)), np.inf
    for _ in range(ROUNDS):
        if square <= aim or square > ENOUGH * before:
            break
        jacobian = chain_with.jacobian(knots, missed)
        found, new_freedom = lightest(jacobian, missed + jacobian @ knots, aim)
        trials = [knots + step * (found - knots) for step in STEPS]
        left = chain_with.missed(np.array(trials))
        squares = np.mean(left**2, axis=1)
        best = int(np.argmin(squares))
        if squares[best] >= square:
            break
        before, square = square, float(squares[best])
        knots, missed, freedom = trials[best], left[best], new_freedom
    left_over = stretch.position - chain_with.readings(knots[None, :])[0]
    values = stretch.noise * chain_with.hats @ knots
    return Correction(place, values, float(np.sqrt(np.nanmean(left_over**2))), freedom)


def corrected_at(stretch: Experiment, base: Fit, start: float, place: str) -> Corrected:
    """Make the chain ready to be corrected."""
    simulated = simulate_model(base.model, stretch, start_position=start)
    values = base.model.values
    return Corrected(
        experiment=stretch,
        rows=base.model.rows(start_position=start),
        pressure=stretch.held_from(simulated.pressure[0]),
        reading=simulated.position[0],
        pressure_of_noise=stretch.noise * values["spring_rate"] / values["diaphragm_area"],
        hats=hats_of(stretch.time),
        place=place,
    )


def stretch_of(experiment: Experiment, error: np.ndarray) -> tuple[Experiment, int]:
    """Return the part of a record that is looked at, position alone, and its first sample."""
    count, first = len(experiment.time), 0
    if count > MOST_SAMPLES:
        sums = np.concatenate(([0.0], np.cumsum(np.nan_to_num(error) ** 2)))
        starts = np.arange(0, count - MOST_SAMPLES + 1, MOST_SAMPLES // 4)
        first = int(starts[np.argmax(sums[starts + MOST_SAMPLES] - sums[starts])])
    part = slice(first, first + MOST_SAMPLES)
    parts = {name: getattr(experiment, name)[part] for name in ("time", "current", "position", "block")}
    began = float(parts["time"][0])
    start = experiment.start + began
    return replace(experiment, **{**parts, "time": parts["time"] - began}, start=start, pressure=None), first


def hats_of(time: np.ndarray) -> np.ndarray:
    """Return the part of each knot in each sample, shape (n, knots)."""
    count = min(time[-1] / KNOT_INTERVAL, MOST_KNOTS, len(time) / SAMPLES_OF_KNOT)
    knots = np.linspace(0.0, time[-1], max(int(count), 3))
    return np.stack([np.interp(time, knots, each) for each in np.eye(len(knots))], axis=1)


def lightest(jacobian: np.ndarray, error: np.ndarray, aim: float) -> tuple[np.ndarray, float]:
    """Return the knots of the least correction that reaches a mean square, and its freedom.

    Parameters
    ----------
    jacobian : array, shape (means, knots)
    error : array, shape (means,)
        What the correction has to explain.
    aim : float
        Mean square that may be left.
    """
    from scipy.linalg import solve

    gram, moment = jacobian.T @ jacobian, jacobian.T @ error
    bends = np.diff(np.eye(len(gram)), n=2, axis=0)
    weight = (float(np.mean(np.diag(gram))) or 1.0) * (SIZE * np.eye(len(gram)) + BEND * bends.T @ bends)

    def at(power: float) -> tuple[np.ndarray, float]:
        found = solve(gram + 10.0**power * weight, moment, assume_a="pos")
        return found, float(error @ error - 2.0 * found @ moment + found @ gram @ found) / len(error)

    light, heavy = LIGHTEST, HEAVIEST
    aim = max(aim, REACHED * at(light)[1])
    for _ in range(HALVINGS):
        middle = 0.5 * (light + heavy)
        light, heavy = (middle, heavy) if at(middle)[1] <= aim else (light, middle)
    freedom = float(np.trace(solve(gram + 10.0**light * weight, gram, assume_a="pos")))
    return at(light)[0], freedom
