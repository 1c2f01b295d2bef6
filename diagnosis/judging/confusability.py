"""Confusability: which effects would leave the same trace under the input of these records."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from identification.fit import Fit
from identification.starting.joining import joined
from valvemodel.declarations import Effect, Parameter
from valvemodel.stages import EFFECTS

LEAST_VISIBLE = 0.05
"""Trace, root mean square over the noise, below which nothing can be said of its shape."""

ALIKE = 0.98
"""Similarity from which two traces cannot be told apart in practice: a fifth is left of the one beside the other."""

OWN_STEP = 0.1
"""Step of an effect's own scaled parameters by which its trace is let change its shape."""

_PLACES = {"lowest_reading": 0.1, "travel_place": 0.5, "highest_reading": 0.9}
"""Where along the readings an effect is put that acts at a place which a search would read off the record."""


@dataclass(frozen=True, eq=False)
class Confusability:
    """What the input of some records can show.

    Attributes
    ----------
    effects : tuple of str
    visibility : array, shape (e,) [noise]
        Root mean square of the trace that each effect at typical size leaves when the base is refitted.
    similarity : array, shape (e, e)
        Cosine between the trace of an effect (row) and the nearest one that another (column) could leave in its place,
        its own parameters and the base's fitted; NaN where the trace of either is not visible.
    """

    effects: tuple[str, ...]
    visibility: np.ndarray
    similarity: np.ndarray

    def as_json(self) -> dict[str, Any]:
        """Return what diagnosis.json has of it."""
        return {
            "effects": list(self.effects),
            "visibility": self.visibility.tolist(),
            "similarity": self.similarity.tolist(),
            "alike_from": ALIKE,
        }


def confusability(base_fit: Fit, library: Sequence[Effect] = EFFECTS) -> Confusability:
    """Compare the traces that effects would leave under the input of the records that a base was fitted to.

    Each effect is put into the fitted base at its typical size. What small changes of the base parameters could imitate
    is taken out of its trace (to first order), in units of the noise, of all signals that were measured.

    Parameters
    ----------
    base_fit : Fit
        Of the base to all records, without an effect.
    library : sequence of Effect

    Returns
    -------
    Confusability
    """
    problem, point = base_fit.problem, base_fit.found.point
    base = np.linalg.qr(problem.jacobian(point))[0]
    before = problem.residuals(point[None, :])[0]
    left = [traces_left(base_fit, effect, before, base) for effect in library]
    traces = [columns[:, 0] for columns in left]
    read = zip(problem.experiments, problem.used, strict=True)
    count = sum(int(used.sum() + experiment.pressures_in(used).sum()) for experiment, used in read)
    visibility = np.array([np.linalg.norm(trace) for trace in traces]) / np.sqrt(count)
    is_visible = visibility >= LEAST_VISIBLE
    similarity = np.full((len(library), len(library)), np.nan)
    for column in np.flatnonzero(is_visible):
        reach = span_of(left[column])
        for row in np.flatnonzero(is_visible):
            similarity[row, column] = np.linalg.norm(reach.T @ traces[row]) / np.linalg.norm(traces[row])
    return Confusability(tuple(effect.key for effect in library), visibility, np.minimum(similarity, 1.0))


def traces_left(base_fit: Fit, effect: Effect, before: np.ndarray, base: np.ndarray) -> np.ndarray:
    """Return what is left of an effect's trace, and of its change with each of the effect's parameters, by column.

    Parameters
    ----------
    base_fit : Fit
    effect : Effect
    before : array, shape (r,) [noise]
        Residuals of the base.
    base : array, shape (r, b)
        Orthonormal directions in which the base parameters move the residuals.

    Returns
    -------
    array, shape (r, 1 + parameters) [noise]
    """
    known = base_fit.found.point
    problem, point = joined(base_fit.problem, known, effect, typical_in(effect, base_fit))
    points = np.vstack([point, point + OWN_STEP * np.eye(len(point))[len(known) :]])
    moved = problem.residuals(np.clip(points, *problem.bounds))
    count = len(before) - len(known)
    changes = np.zeros((len(before), len(points)))
    changes[:count] = (before[:count] - moved[:, :count]).T
    changes[:, 1:] -= changes[:, :1]
    return changes - base @ (base.T @ changes)


def typical_in(effect: Effect, base_fit: Fit) -> dict[str, float]:
    """Return an effect's typical values, at a place where the readings are."""
    readings = np.concatenate([each.position[np.isfinite(each.position)] for each in base_fit.problem.experiments])
    return {each.name: _typical_among(each, readings) for each in effect.parameters}


def _typical_among(parameter: Parameter, readings: np.ndarray) -> float:
    typical = float(parameter.typical or 0.0)
    hints = [start for start in parameter.starts if start in _PLACES]
    if not hints or not np.isfinite(typical):
        return typical
    low, high = np.quantile(readings, [0.001, 0.999])
    return float(np.clip(low + _PLACES[str(hints[0])] * (high - low), parameter.low, parameter.high))


def span_of(columns: np.ndarray) -> np.ndarray:
    """Return an orthonormal basis of the space that columns span."""
    directions, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    return directions[:, sizes > 1e-3 * sizes[0]]
