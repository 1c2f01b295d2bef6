"""A flow of a differential equation until something ends it: DOP853 at a tolerance near rounding."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence

import numpy as np

from valvemodel.reference.instant import first_instant

TOLERANCE = 1e-12
"""Relative error of a step."""

LOOKS = 6
"""In how many places of a step it is looked whether the flow has ended."""

Slope = Callable[[float, np.ndarray], Sequence[float]]


class Flow:
    """States along a flow, from 0 to its end."""

    def __init__(self) -> None:
        self.ends: list[float] = []
        self.pieces: list[Callable[[float], np.ndarray]] = []

    def __call__(self, instant: float) -> np.ndarray:
        """Return the state at an instant."""
        return self.pieces[min(bisect_left(self.ends, instant), len(self.pieces) - 1)](instant)


def flow(
    slope: Slope,
    start: Sequence[float],
    duration: float,
    finest: Sequence[float],
    has_ended: Callable[[float, np.ndarray], bool] = lambda _, __: False,
) -> tuple[Flow, float, bool]:
    """Follow a slope from a start for a duration, or until it has ended; return the flow, its end, and whether it did.

    `finest` is the absolute error of each state below which none is resolved.
    """
    from scipy.integrate import DOP853

    solver = DOP853(slope, 0.0, np.array(start, float), duration, rtol=TOLERANCE, atol=np.array(finest))
    found = Flow()
    while solver.status == "running":
        solver.step()
        piece = solver.dense_output()
        found.ends.append(solver.t)
        found.pieces.append(piece)
        looked = solver.t_old
        for look in range(1, LOOKS + 1):
            instant = solver.t_old + look / LOOKS * (solver.t - solver.t_old)
            if has_ended(instant, piece(instant)):
                since = looked
                lasted = first_instant(lambda t: has_ended(since + t, piece(since + t)), instant - since)  # noqa: B023
                return found, since + lasted, True
            looked = instant
    return found, duration, False
