"""A fit as a problem: unknowns in, weighted residuals out, over one or several experiments."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from identification.experiment import HALF_A_STEP, Experiment, Simulated, simulate_rows
from identification.unknowns import Unknown
from valvemodel import runs
from valvemodel.declarations import Effect
from valvemodel.effects import effect_of_key, takes_long
from valvemodel.loops import settles_in_closed_form
from valvemodel.model import Model

SEARCH_TOLERANCE = 1e-5
"""Coarser than the simulator's default: within 0.05 mm of it, a part of the noise, and several times faster. [m]"""

FINE_TOLERANCE = 1e-7
"""Of runs that are differenced: far below any noise, and several times faster than the simulator's default. [m]"""

BEYOND_STEPS = 2.0 / 3.0 * math.sqrt(2.0 / math.pi)
"""Mean square beyond half a step of a coarse reading, over the cube of the noise by the step, of the right model."""

LOST = 1e6
"""What counts in place of a residual that is no number. [noise]"""

DIFFERENCE = 2e-4
"""Step of the forward differences in scaled unknowns; wide against the tolerance, narrow against the bends. Where runs
are rougher than those of a search it is so much wider."""

NEAR_BOUND, OFF_BOUND = 1e-3, 5e-2
"""Distance from its lower bound within which an unknown that acts on the pressure in time stands on it, scaled, and the
step there."""

ROUGH_TOLERANCE = 1e-4
"""Of runs that only show which of many starts are worth it, at most: up to three times as fast. [m]"""


@dataclass(frozen=True)
class Problem:
    """Residuals of a model on experiments, in units of the noise.

    Attributes
    ----------
    model : Model
        Gives all numbers that are not unknown.
    experiments : sequence of Experiment
    unknowns : sequence of Unknown
    used : sequence of arrays of bool, each of shape (n,)
        Which samples of each experiment count.
    is_anchored : bool
        Whether each run is put anew on its experiment's anchors, else it runs free.
    tolerance : float [m]
        Of the simulator.
    within : float
        Steps of a coarse reading within which an error does not count: none while a search comes nearer.
    """

    model: Model
    experiments: Sequence[Experiment]
    unknowns: Sequence[Unknown]
    used: Sequence[np.ndarray]
    is_anchored: bool = False
    tolerance: float = SEARCH_TOLERANCE
    within: float = HALF_A_STEP
    _rows: np.ndarray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_rows", self.model.rows())

    def rows(self, points: np.ndarray, experiment: int) -> np.ndarray:
        """Return the rows of numbers at scaled points, shape (p, unknowns), for one experiment."""
        rows = np.repeat(self._rows, len(points))
        for column, unknown in enumerate(self.unknowns):
            if unknown.experiment in (-1, experiment):
                rows[unknown.name] = unknown.value(points[:, column])
        return rows

    def rows_without(self, is_left_out: Callable[[Effect], bool], points: np.ndarray, experiment: int) -> np.ndarray:
        """Return rows as `rows` does, with the effects that are left out at their neutral values."""
        rows = self.rows(points, experiment)
        for effect in filter(is_left_out, map(effect_of_key, self.model.effects)):
            for parameter in effect.parameters:
                rows[parameter.name] = parameter.neutral
        return rows

    def residuals(self, points: np.ndarray) -> np.ndarray:
        """Return the weighted residuals, measured less simulated, at scaled points.

        Parameters
        ----------
        points : array, shape (p, unknowns)

        Returns
        -------
        array, shape (p, r)
            Position and, where measured, pressure of the samples that count, then the weak priors. [noise]
        """
        signals = [1 + (experiment.pressure is not None) for experiment in self.experiments]
        counts = [count * len(places) for count, places in zip(signals, self.places, strict=True)]
        residuals, first = np.empty((len(points), sum(counts) + points.shape[1])), 0
        for number, (experiment, places) in enumerate(zip(self.experiments, self.places, strict=True)):
            simulated = self.simulated(points, number)
            experiment.fill_errors(residuals, first, simulated, places, within=self.within, lost=LOST)
            if experiment.pressure is not None:
                measured = experiment.pressure[places]
                missed = (measured - simulated.pressure[:, places]) / experiment.pressure_noise
                missed[~np.isfinite(missed)] = LOST
                # A pressure that was not measured where the position was counts for nothing.
                missed[:, ~np.isfinite(measured)] = 0.0
                residuals[:, first + len(places) : first + counts[number]] = missed
            first += counts[number]
        residuals[:, first:] = points / self.prior_spreads
        return residuals

    @cached_property
    def places(self) -> list[np.ndarray]:
        """Which samples of each experiment count, by their numbers."""
        return [np.flatnonzero(used) for used in self.used]

    def simulated(self, points: np.ndarray, number: int) -> Simulated:
        """Run scaled points, shape (p, unknowns), over the experiment of that number."""
        experiment = self.experiments[number]
        return simulate_rows(
            experiment,
            self.rows(points, number),
            tolerance=self.tolerance,
            anchors=experiment.anchors if self.is_anchored else runs.FREE,
            with_pressure=experiment.pressure is not None,
            in_closed_form=self.settles,
        )

    @cached_property
    def is_in_steps(self) -> bool:
        """Whether the model reads in coarse steps of an experiment's readings, and what lies within does not count."""
        return self.within > 0.0 and self.reads_in_steps

    @cached_property
    def reads_in_steps(self) -> bool:
        """Whether the model reads in coarse steps of an experiment's readings."""
        return any(self.comes_in_steps(each) for each in self.experiments)

    @cached_property
    def is_smooth(self) -> bool:
        """Whether a derivative of the residuals serves on some way: it does not in coarse steps and on bristles."""
        return not self.reads_in_steps and not takes_long(self.model.effects)

    def comes_in_steps(self, experiment: Experiment) -> bool:
        """Return whether an experiment's readings come in the model's coarse steps."""
        return experiment.comes_in_steps(self.step, float(self._rows["resolution_offset"][0]))

    @property
    def step(self) -> float:
        """Step in which the model reads, 0 where it reads in none. [m]"""
        return float(self._rows["resolution"][0])

    @property
    def rough_tolerance(self) -> float:
        """Tolerance of runs that only show which of many starts are worth it: no more than the noise. [m]

        A search among a series of unknowns, which follows the same slopes for long, goes astray by rough ones.
        """
        if self.has_series:
            return self.tolerance
        return max(min([ROUGH_TOLERANCE, *(each.noise for each in self.experiments)]), self.tolerance)

    @cached_property
    def settles(self) -> bool:
        """Whether a step of a settled loop of the model has a closed form, wherever its unknowns go."""
        may_yield = any(unknown.name == "stop_compliance" for unknown in self.unknowns)
        return not may_yield and settles_in_closed_form(self.model)

    @property
    def has_pressure(self) -> bool:
        """Whether a pressure was measured in any of the experiments."""
        return any(experiment.pressure is not None for experiment in self.experiments)

    @property
    def has_loop(self) -> bool:
        """Whether any of the experiments is a settled loop, whose time is made up."""
        return any(experiment.is_loop for experiment in self.experiments)

    @property
    def has_series(self) -> bool:
        """Whether a series of like numbers is among the unknowns, each of which costs a run."""
        return any(unknown.is_higher for unknown in self.unknowns)

    @property
    def prior_spreads(self) -> np.ndarray:
        """Standard deviations of the weak priors, scaled."""
        return np.array([unknown.prior_spread for unknown in self.unknowns])

    @property
    def noise_error(self) -> float:
        """Half the sum of squares that noise alone leaves of the samples that count.

        Of readings in coarse steps it leaves what lies beyond half a step: of noise that is small beside a step, and of
        places that lie anywhere between two steps, noise over step of it.
        """
        squares = 0.0
        for experiment, used in zip(self.experiments, self.used, strict=True):
            squares += float(used.sum()) * self.left_by_noise(experiment) + float(experiment.pressures_in(used).sum())
        return 0.5 * squares

    def left_by_noise(self, experiment: Experiment) -> float:
        """Return the mean square that noise leaves of a reading: in coarse steps with these, or beyond half a step."""
        if not self.comes_in_steps(experiment):
            return 1.0
        steps = self.step / experiment.noise
        return 1.0 + steps**2 / 12.0 if self.within == 0.0 else min(BEYOND_STEPS / steps, 1.0)

    def jacobian(self, point: np.ndarray, known: np.ndarray | None = None) -> np.ndarray:
        """Return the derivative of the residuals at a scaled point by differences, shape (r, unknowns).

        Where the residuals there are known, shape (r,), they are not computed again. Of a coarse reading what lies
        within the step does not move, the rest as if all of it counted.
        """
        steps = np.full(len(point), DIFFERENCE * max(self.tolerance / SEARCH_TOLERANCE, 1.0))
        low, high = self.bounds
        moves = np.array([unknown.moves_pressure for unknown in self.unknowns])
        if self.tolerance >= SEARCH_TOLERANCE:
            # Once the pressure moves a run goes another way, and is off by a part of the tolerance.
            steps[moves & (point - low < NEAR_BOUND)] = OFF_BOUND
        steps[point + steps > high] *= -1.0
        here = self.residuals(point[None, :])[0] if known is None else known
        smooth = self._smooth
        changes = smooth.residuals(point + np.diag(steps))
        changes -= here if smooth is self else smooth.residuals(point[None, :])[0]
        changes /= steps[:, None]
        if smooth is not self:
            samples = slice(None, -len(point))
            changes[:, samples] *= here[samples] != 0.0
        return changes.T

    @cached_property
    def _smooth(self) -> Problem:
        """Itself, but with an error that counts wherever it lies in a coarse reading's step, so that nothing bends.

        A difference across the bend at half a step is the slope on neither side of it: a search along such slopes ends
        early, where none of them leads down.
        """
        return replace(self, within=0.0) if self.is_in_steps else self

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Scaled bounds of all unknowns."""
        pairs = [unknown.bounds for unknown in self.unknowns]
        return np.array([low for low, _ in pairs]), np.array([high for _, high in pairs])

    def values(self, point: np.ndarray) -> dict[str, float]:
        """Return the parameters at a scaled point by name, start positions left out. [SI]"""
        return {
            unknown.name: float(unknown.value(x))
            for unknown, x in zip(self.unknowns, point, strict=True)
            if unknown.experiment < 0
        }

    def starts(self, point: np.ndarray) -> list[float]:
        """Return the start position of each experiment. [m]"""
        found = {
            unknown.experiment: float(unknown.value(x))
            for unknown, x in zip(self.unknowns, point, strict=True)
            if unknown.experiment >= 0
        }
        return [found.get(number, float("nan")) for number in range(len(self.experiments))]
