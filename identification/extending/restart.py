"""A fit begun again: the stem's mass, or the whole base valve, back at what was given, all else from where it is."""

from __future__ import annotations

import math

from threadpoolctl import threadpool_limits

from identification.fit import Fit, finished
from identification.search import descend_to_end
from identification.starting.joining import as_given

MASS = "stem_mass"

FAR_OFF = math.log(1.5)
"""Logarithm of the ratio to the given valve's mass from which a fitted one is far off."""


def is_far_off(fit: Fit) -> bool:
    """Return whether a fit moved the mass far from the given valve's."""
    return any(abs(at) > FAR_OFF for each, at in zip(fit.unknowns, fit.found.point, strict=True) if each.name == MASS)


@threadpool_limits.wrap(limits=1)
def begun_again(fit: Fit) -> Fit:
    """Fit all unknowns anew from where they are, but the mass, or the whole base valve, as it was given; the best fit.

    A valve that lacks an effect may make up for it by a mass many times too small. One that is added there ends in
    a side minimum: between it and the right one lie swings that the readings do not show. Where all its forces are
    many times too small with it, no change of the mass alone leads out.
    """
    with_mass = fit.found.point.copy()
    with_mass[[each.name == MASS for each in fit.unknowns]] = 0.0
    best = fit.found
    for point in (with_mass, as_given(fit, fit.found.point)):
        best = min(best, descend_to_end(fit.problem, point), key=lambda each: each.error)
    return fit if best is fit.found else finished(fit.problem, best)
