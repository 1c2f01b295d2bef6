"""Laws of slips: what an effect that makes the stem jump makes of the slips of stairs, each judged by itself."""

from __future__ import annotations

import numpy as np
from threadpoolctl import threadpool_limits

from identification.fit import Fit
from identification.problem import Problem
from identification.starting.joining import joined
from identification.starting.screening import starts_on
from identification.stick_slip.breakaway import Line
from identification.stick_slip.slip_search import (
    SlipSearch,
    error_at_rests,
    line_of_stairs,
    search_beside_other,
    search_slips,
)
from valvemodel.declarations import Effect, Form
from valvemodel.effects import effect_of_key

EXPLAINED, NEAR_KIN = 0.8, 1.5
"""Share of a fit's error at the slips below which an effect must come for the search to go on from there, and of the
error of another law of stick-slip: on a line that is held the right law may leave more than a wrong one that is not."""


@threadpool_limits.wrap(limits=1)
def slips_by(fit: Fit, effect: Effect, kin: Fit | None = None, line: Line | None = None) -> list[SlipSearch]:
    """Return what the forms of an effect that makes the stem jump make of the slips of stairs, the best first.

    Parameters
    ----------
    fit : Fit
    effect : Effect
    kin : Fit or None
        The fit extended by a kindred effect.
    line : Line or None
        Through the breakaways of the fit, if it was laid.

    Returns
    -------
    list of SlipSearch
        Empty where there are no stairs, or where the slips are not explained much better than without the effect or by
        its kin, or nearly as well as by another law.
    """
    line = line or line_of_stairs(fit.problem, fit.found.point)
    if line is None:
        return []
    begun = search_slips(effect, line, forms_of(fit, effect))
    far = EXPLAINED * error_at_rests(fit.problem, fit.found.point)
    if kin is not None:
        share = EXPLAINED if breakaway_of(kin) is None else NEAR_KIN
        far = min(far, share * error_at_rests(kin.problem, kin.found.point))
    return begun if begun[0].found.error < far else []


@threadpool_limits.wrap(limits=1)
def slips_beside(begun: SlipSearch, fit: Fit, effect: Effect, line: Line) -> list[SlipSearch]:
    """Return what a law of the slips that was found beside one effect makes of them beside another, that of a fit.

    Parameters
    ----------
    begun : SlipSearch
    fit : Fit
        On a line through the breakaways with the other effect.
    effect : Effect
        The law.
    line : Line
    """
    return search_beside_other(begun, effect, line, [problem for problem, _ in forms_of(fit, effect)])


def forms_of(fit: Fit, effect: Effect) -> list[tuple[Problem, np.ndarray]]:
    """Return the problem with an effect in each of its forms, and the scaled points where searches for it begin."""
    forms: dict[Form, list[tuple[Problem, np.ndarray]]] = {}
    for start in starts_on(fit, effect):
        pair = joined(fit.problem, fit.found.point, effect, start)
        forms.setdefault(effect.form_at(start), []).append(pair)
    return [(pairs[0][0], np.array([point for _, point in pairs])) for pairs in forms.values()]


def breakaway_of(fit: Fit) -> float | None:
    """Return the breakaway force of a fit over Coulomb friction; None where no effect sets it."""
    names = {key: effect_of_key(key).breakaway for key in fit.model.effects}
    return next((fit.model.effects[key][name] for key, name in names.items() if name), None)
