"""When something begins to hold: bisection."""

from __future__ import annotations

from collections.abc import Callable


def first_instant(holds: Callable[[float], bool], high: float) -> float:
    """Return the first instant at which something holds that does not at 0, does at `high`, and never ceases to."""
    low = 0.0
    while low < (middle := 0.5 * (low + high)) < high:
        if holds(middle):
            high = middle
        else:
            low = middle
    return high
