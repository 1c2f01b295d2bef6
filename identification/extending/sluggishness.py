"""Sluggishness: what viscous friction and mass of a base valve make up for that is a lag, and how one takes it over."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from identification.fit import Fit
from valvemodel.declarations import Effect, Form

TOO_MUCH = 1.5
"""Viscous friction of a fit, over that which was given, from which it may stand in for a lag."""

LIVELY = {"viscous_friction": -0.4, "stem_mass": 0.3}
"""Powers of e by which viscous friction and mass are off what was given in a stem that overshoots."""


def traded(fit: Fit, effect: Effect, forms: Iterable[Form]) -> list[tuple[dict[str, float], np.ndarray]]:
    """Return where an effect that lags, in each of some forms, takes over what the base valve has too much of.

    A fit without the lag has viscous friction and mass in its place: a lag of time T delays a stem as T k more viscous
    friction does. From such a base valve a search ends beside a lag that is too short, and from one so sluggish that it
    overshoots nowhere beside a mass that is too small: the start is `LIVELY`.

    Returns
    -------
    list of (values, move)
        Values of the effect's parameters, of which what is neither a lag nor of the form is neutral [SI]; and by how
        much the fit's unknowns move with it, scaled, shape (unknowns,): viscous friction and mass to about what was
        given. Empty where the effect does not lag, or the fit has no such friction to spare.
    """
    lags = [each for each in effect.fitted if each.is_lag]
    numbers = {unknown.name: number for number, unknown in enumerate(fit.unknowns)}
    if not lags or "spring_rate" not in numbers or not is_sluggish(fit, TOO_MUCH):
        return []
    friction, stiffness = numbers["viscous_friction"], numbers["spring_rate"]
    excess, unknown = fit.found.point[friction], fit.unknowns[friction]
    rate = fit.unknowns[stiffness].value(fit.found.point[stiffness])
    time = float((unknown.value(excess) - unknown.value(LIVELY["viscous_friction"])) / rate)
    values = {each.name: each.neutral for each in effect.parameters}
    values |= {each.name: min(max(time, each.low), each.high) for each in lags}
    move = np.zeros(len(fit.found.point))
    for name, number in numbers.items():
        if name in LIVELY:
            move[number] = LIVELY[name] - fit.found.point[number]
    return [(values | dict(form), move) for form in forms]


def is_sluggish(fit: Fit, times: float) -> bool:
    """Return whether a fit has so many times the viscous friction that was given, or more."""
    found = zip(fit.found.point, fit.unknowns, strict=True)
    return any(unknown.name == "viscous_friction" and at >= math.log(times) for at, unknown in found)
