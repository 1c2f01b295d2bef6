"""Slips of the exact simulator from a given point, for central differences."""

from __future__ import annotations

import numpy as np

from valvemodel.linear import OperatingPoint
from valvemodel.model import Model
from valvemodel.stepping import SteppedValve


def slip_response(model: Model, point: OperatingPoint, time: np.ndarray, change: float) -> dict[str, np.ndarray]:
    """Central difference about a step by a change; both slips go on in their direction, as loops and sags need it."""
    farther, nearer = (slip(model, point, time, point.side * steps * change) for steps in (2.0, 0.0))
    return {name: 0.5 * point.side * (farther[name] - nearer[name]) for name in farther}


def slip(model: Model, point: OperatingPoint, time: np.ndarray, change: float) -> dict[str, np.ndarray]:
    """Pressure, position and reading of a stem that passes the point as the current is stepped."""
    valve = SteppedValve(model, current=point.current, tolerance=1e-9)
    state = valve._states[0]
    friction = point.side * point.friction
    state["hysteresis"] = point.side
    state["position"], state["velocity"], state["mode"] = point.position, point.side * point.speed, point.side
    play, wear = (model.numbers.get(name, 0.0) for name in ("backlash_half_width", "backlash_wear"))
    for name, width in [("linkage", 1.0), ("tight_linkage", 1.0 - wear), ("loose_linkage", 1.0 + wear)]:
        state[name] = point.position - point.side * play * width
    state["lagged_reading"] = state["less_lagged_reading"] = point.reading
    state["bristle"] = friction
    rows = [(valve.pressure, valve.position, point.reading)]
    for duration in np.diff(time):
        reading = valve.step(point.current + change, float(duration))
        assert valve.mode == point.side, "the slip has ended"
        rows.append((valve.pressure, valve.position, reading))
    return dict(zip(("pressure", "position", "reading"), np.array(rows).T, strict=True))
