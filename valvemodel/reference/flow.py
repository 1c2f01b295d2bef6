"""A flow of a differential equation until something ends it: DOP853 at a tolerance near rounding."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence

import numpy as np

from valvemodel.reference.instant import first_instant

TOLERANCE = 1e-12
"""Relative error of a step."""

LOOKS = 4
"""In how many places of a step it is looked whether the flow has ended."""

State = list[float]


class Flow:
    """States along a flow, from 0 to its end."""

    def __init__(self) -> None:
        self.ends: list[float] = []
        self.pieces: list[Callable[[float], np.ndarray]] = []

    def __call__(self, instant: float) -> State:
        """Return the state at an instant."""
        piece = self.pieces[min(bisect_left(self.ends, instant), len(self.pieces) - 1)]
        return piece(instant).tolist()


def flow(
    slope: Callable[[float, State], State],
    start: State,
    duration: float,
    finest: Sequence[float],
    has_ended: Callable[[float, State], bool] = lambda _, __: False,
) -> tuple[Flow, float, bool]:
    """Follow a slope from a start for a duration, or until it has ended; return the flow, its end, and whether it did.

    `finest` is the absolute error of each state below which none is resolved.
    """
    from scipy.integrate import DOP853

    def rates(instant: float, state: np.ndarray) -> State:
        return slope(float(instant), state.tolist())

    solver = DOP853(rates, 0.0, np.array(start), duration, rtol=TOLERANCE, atol=np.array(finest))
    found = Flow()
    while solver.status == "running":
        solver.step()
        if solver.status == "failed":
            raise ArithmeticError(f"no step is short enough at {solver.t} s")
        begin, end = float(solver.t_old), float(solver.t)
        found.ends.append(end)
        found.pieces.append(solver.dense_output())
        looked = begin
        for look in range(1, LOOKS + 1):
            instant = begin + look / LOOKS * (end - begin)
            if has_ended(instant, found(instant)):
                since = looked
                lasted = first_instant(lambda t: has_ended(since + t, found(since + t)), instant - since)  # noqa: B023
                return found, since + lasted, True
            looked = instant
    return found, duration, False
