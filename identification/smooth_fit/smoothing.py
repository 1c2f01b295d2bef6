"""What smoothing does to a fit, by width: against the exact refit that starts there, and against the exact run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from identification.fit import Fit, finished
from identification.problem import Problem
from identification.search import Found
from identification.smooth_fit.residuals import chain_for
from valvemodel.simulation import simulate
from valvemodel.smooth.chain import SmoothChain, run_smooth


@dataclass(frozen=True)
class Smoothing:
    """A fit at one smoothing width.

    Attributes
    ----------
    width : float [N]
    error : float
        Half the sum of squared residuals there. [noise^2]
    values, shifts : dict of float
        The parameters by name, and how far they are from the exact refit's. [SI]
    rms, largest : float [m]
        Smooth less exact run with the parameters of this width.
    """

    width: float
    error: float
    values: dict[str, float]
    shifts: dict[str, float]
    rms: float
    largest: float

    def as_json(self) -> dict[str, Any]:
        """Return its entry in fit.json."""
        return {
            "width": {"value": self.width, "unit": "N"},
            "objective": self.error,
            "parameters": {name: {"value": value, "shift": self.shifts[name]} for name, value in self.values.items()},
            "trajectory": {"rms": self.rms, "max": self.largest, "unit": "m"},
        }


def smoothing_of(problem: Problem, path: Sequence[tuple[float, Found]], refit: Fit) -> tuple[Smoothing, ...]:
    """Return what smoothing did at each width of a path."""
    exact = problem.values(refit.found.point)
    made = []
    for width, found in path:
        values = problem.values(found.point)
        shifts = {name: value - exact[name] for name, value in values.items()}
        apart = np.concatenate(_apart(finished(problem, found), width))
        made.append(
            Smoothing(width, found.error, values, shifts, float(np.sqrt(np.mean(apart**2))), float(np.abs(apart).max()))
        )
    return tuple(made)


def _apart(fit: Fit, width: float) -> list[np.ndarray]:
    """Return smooth less exact readings of the same numbers on each experiment. [m]"""
    apart = []
    for experiment, start in zip(fit.problem.experiments, fit.starts, strict=True):
        time, current = experiment.drive
        given: dict[str, Any] = {"time": time, "current": current, "start_position": start}
        chain = SmoothChain(fit.model, parts=chain_for(fit.model, experiment).parts // experiment.parts)
        apart.append(run_smooth(chain, width=width, **given) - simulate(fit.model, **given).position)
    return apart
