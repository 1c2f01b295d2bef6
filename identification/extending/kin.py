"""Kin: an effect followed down from the base valve that was fitted with a kindred one."""

from __future__ import annotations

import numpy as np

from identification.extending.following import KEPT_STARTS, best_descended
from identification.fit import Fit
from identification.problem import Problem
from identification.search import Found, errors
from identification.starting.joining import joined
from identification.starting.screening import starts_on
from identification.stick_slip.slip_laws import breakaway_of
from valvemodel.declarations import Effect

FIRST_LOOK_AT_LAWS = 25
"""Points of a search while laws of stick-slip are compared beside another effect."""


def beside(fit: Fit, effect: Effect, kin: Fit, known: dict[str, float] | None = None) -> tuple[Problem, Found]:
    """Follow the best starts of an effect down from the base valve that was fitted with a kindred one.

    Beside another effect a law of stick-slip starts from where the stem breaks away by the kindred law, and all starts
    are followed far: which comes nearest shows late.
    """
    valve = taken_over(fit, kin)
    starts = [*starts_on(fit, effect), *([known] if known else [])]
    ratio = breakaway_of(kin) if effect.breakaway and fit.model.effects else None
    if ratio is not None:
        at_ratio = [{**start, effect.breakaway: ratio} for start in starts]
        starts = list({tuple(start.values()): start for start in at_ratio}.values())
    begun = [joined(fit.problem, valve, effect, start) for start in starts]
    if ratio is not None:
        return best_descended(begun, first=FIRST_LOOK_AT_LAWS, further=15, precision=1e-4)
    begun.sort(key=lambda pair: float(errors(pair[0], pair[1][None, :])[0]))
    return best_descended(begun[:KEPT_STARTS], first=8, further=15, precision=1e-4)


def taken_over(fit: Fit, kin: Fit) -> np.ndarray:
    """Return the scaled point of a fit with what a kindred one, in whatever order of adding, made of its unknowns."""
    made = {(each.name, each.experiment): at for each, at in zip(kin.unknowns, kin.found.point, strict=True)}
    own = zip(fit.unknowns, fit.found.point, strict=True)
    return np.array([made.get((each.name, each.experiment), at) for each, at in own])
