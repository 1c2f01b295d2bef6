"""Rests: where a stem rests on its way, and runs that are put anew on each rest."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from identification.experiment import Experiment
from identification.starting.hints import coarse_step

SHORTEST = 6
"""Samples that a rest has at least."""

QUIET, LEFT = 6.0, 5.0
"""Range of the readings within which a stem rests, and change of the reading that ends the rest. [noise]"""

OF_A_STEP = 0.25
"""Share of a coarse reading's step that counts as its noise: a stem that rests flickers between two steps, and has left
when it is two away, as by a slip. One that moves on slowly rests nowhere."""

CREEPING = 3.0
"""Drift of the readings from which a stem creeps. [noise of the drift]"""


@dataclass(frozen=True)
class Rest:
    """A rest that ends on the way: first and last sample, mean reading [m], side to which the stem leaves."""

    first: int
    last: int
    position: float
    side: float


def rests_of(position: np.ndarray, noise: float) -> Iterator[Rest]:
    """Yield the rests of a stem that end while it is looked at.

    Parameters
    ----------
    position : array, shape (n,) [m]
        NaN where nothing counts.
    noise : float [m]
    """
    if len(position) < SHORTEST:
        return
    windows = np.lib.stride_tricks.sliding_window_view(position, SHORTEST)
    is_quiet = np.ptp(windows, axis=1) < QUIET * noise
    first = 0
    while first < len(is_quiet):
        if not is_quiet[first]:
            first += 1
            continue
        last, total = first + SHORTEST - 1, float(windows[first].sum())
        while last + 1 < len(position) and abs(position[last + 1] - total / (last + 1 - first)) < LEFT * noise:
            last += 1
            total += position[last]
        mean = total / (last + 1 - first)
        away = position[last + 1 : last + 3] - mean
        has_left = len(away) == 2 and away[0] * away[1] > 0.0 and abs(away[1]) > LEFT * noise
        if has_left and abs(drift_of(position[first : last + 1])) < CREEPING * noise:
            yield Rest(first, last, mean, float(np.sign(away[0])))
        first = last + 1


def rests_in(readings: np.ndarray, noise: float, step: float) -> list[Rest]:
    """Return the rests of a stem that end while it is looked at, of readings that may come in coarse steps, else 0. [m]

    Parameters are those of `rests_of`.
    """
    return list(rests_of(readings, max(noise, OF_A_STEP * step)))


def drift_of(readings: np.ndarray) -> float:
    """Return the drift of readings, scaled so that its noise is that of a reading. [m]"""
    places = np.arange(len(readings)) - 0.5 * (len(readings) - 1)
    return float(places @ readings / np.sqrt(places @ places))


@dataclass(frozen=True, eq=False)
class RestedExperiment(Experiment):
    """An experiment whose runs are put anew on each rest, just before it ends: each slip is judged by itself.

    Attributes
    ----------
    step : float [m]
        Coarse step in which its readings come, 0 where they come in none.
    """

    step: float = 0.0

    @cached_property
    def anchors(self) -> np.ndarray:
        """Mean readings of the rests, at their last sample but one, NaN elsewhere, shape (n,). [m]"""
        anchors = np.full(len(self.time), np.nan)
        for rest in rests_in(self.position, self.noise, self.step):
            anchors[rest.last - 1] = rest.position
        return anchors


def put_on_rests(experiment: Experiment, reach: float) -> RestedExperiment:
    """Return an experiment whose runs are put anew on each rest, and whose large errors count by the logarithm."""
    given = {field.name: getattr(experiment, field.name) for field in fields(Experiment)}
    return RestedExperiment(**{**given, "reach": reach}, step=coarse_step(experiment))
