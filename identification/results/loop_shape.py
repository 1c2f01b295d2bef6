"""Width, slope and height of a fitted loop, with what their uncertainty is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from identification.determined.uncertainty import blocks_of, covariance
from identification.experiment import Experiment, are_loops
from identification.fit import Fit, finished
from identification.search import Found
from valvemodel.loops import LoopShape, settles_in_closed_form, shape_of_loop

STEP = 1e-3
"""Of the central differences in scaled unknowns: the shape is smooth in them."""

CURRENT_MARGIN = 1.5
"""The branches are looked for up to this many times the highest current of the loop."""

UNITS = {"width": "A", "slope": "m/A", "height": "m"}

SAYS_NOTHING_OF_TIME = (
    "a settled loop holds no time: viscous friction and mass show only by the overshoot of a stem with less than "
    "critical damping, and then only their ratio; record the same steps with time"
)


@dataclass(frozen=True)
class FittedShape:
    """The shape of the major loop of a fit, each number with its standard deviation.

    Attributes
    ----------
    shape : LoopShape
    std : dict of float
        By the names of `UNITS`. [SI]
    is_ramped : bool
        How the current was taken to go from value to value.
    """

    shape: LoopShape
    std: dict[str, float]
    is_ramped: bool

    def as_json(self) -> dict[str, Any]:
        """Return the `loop` of fit.json."""
        numbers = {
            name: {"value": getattr(self.shape, name), "unit": unit, "std": self.std[name]}
            for name, unit in UNITS.items()
        }
        return {
            "driven": "ramped" if self.is_ramped else "stepped",
            "position": {"value": self.shape.position, "unit": "m"},
            **numbers,
        }


def usual_step(experiments: Sequence[Experiment]) -> float:
    """Return the middle size of the steps of the current. [A]"""
    steps = np.abs(np.concatenate([np.diff(experiment.current) for experiment in experiments]))
    return float(np.median(steps[steps > 0.0]))


def shape_of_fit(fit: Fit) -> FittedShape | None:
    """Return the shape in the middle of the readings, or None where it is no loop or has no closed form."""
    experiments = fit.problem.experiments
    if not are_loops(experiments) or not settles_in_closed_form(fit.model):
        return None
    readings = np.concatenate([experiment.position[np.isfinite(experiment.position)] for experiment in experiments])
    middle = 0.5 * float(readings.max() + readings.min())
    highest = CURRENT_MARGIN * max(float(experiment.current.max()) for experiment in experiments)
    step = 0.0 if experiments[0].is_ramped else usual_step(experiments)

    def shape_at(point: np.ndarray) -> LoopShape:
        model = finished(fit.problem, Found(point, 0.0)).model
        return shape_of_loop(model, position=middle, highest_current=highest, step=step)

    point = fit.found.point
    # At a bound of an unknown the difference is one-sided.
    above, below = (np.clip(point + side * STEP * np.eye(len(point)), *fit.problem.bounds) for side in (1.0, -1.0))
    pairs = [(shape_at(up), shape_at(down)) for up, down in zip(above, below, strict=True)]
    widths = np.diag(above - below)
    jacobian = fit.problem.jacobian(point)
    spread = covariance(jacobian, fit.problem.residuals(point[None, :])[0], blocks_of(fit))
    std = {}
    for name in UNITS:
        slope = np.array([getattr(up, name) - getattr(down, name) for up, down in pairs]) / widths
        std[name] = float(np.sqrt(slope @ spread @ slope))
    return FittedShape(shape_at(point), std, experiments[0].is_ramped)
