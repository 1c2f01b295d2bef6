"""A glance at an effect on top of a fit: a few points down from its most promising start."""

from __future__ import annotations

from dataclasses import dataclass

from threadpoolctl import threadpool_limits

from identification.extending.following import (
    at_neutral,
    near_neutral,
    nearest_descended,
    starts_traded,
)
from identification.extending.forms import first_plain
from identification.fit import Fit, finished
from identification.problem import Problem
from identification.search import Found
from identification.starting.pressures import makes_pressure, with_pressures_of
from identification.starting.screening import LITTLE_LEFT, Trial, screened
from identification.stick_slip.slip_search import form_of
from valvemodel.declarations import Effect
from valvemodel.effects import effect_of_key

GLANCE = 5
"""Points of a search that only shows which effects are worth it."""


@dataclass(frozen=True)
class Glance:
    """What a glance at an effect on top of a fit shows.

    Attributes
    ----------
    fit : Fit
        With the effect, a few points down; no worse than without.
    promised, taken_in : float
        Shares of the error without it that the start promises to explain by slopes, and that the fit has taken in.
    """

    fit: Fit
    promised: float
    taken_in: float

    @property
    def share(self) -> float:
        """The share that it shows in either way."""
        return max(self.promised, self.taken_in)


@threadpool_limits.wrap(limits=1)
def glanced(fit: Fit, key: str) -> Glance:
    """Add an effect to a fit and follow its most promising start a few points down.

    Where the fit leaves little slopes tell all: the effect is at a value that changes nothing.
    """
    effect = effect_of_key(key)
    trials = screened(fit, effect)
    seen = at_neutral(fit, effect)
    if fit.found.error >= LITTLE_LEFT * fit.problem.noise_error:
        seen = glanced_down(fit, effect, trials)
    return Glance(finished(*seen), 0.5 * trials[0].gain / fit.found.error, 1.0 - seen[1].error / fit.found.error)


def glanced_down(fit: Fit, effect: Effect, trials: list[Trial]) -> tuple[Problem, Found]:
    """Follow the most promising start a few points down, and what else it may begin as; no worse than without."""
    plain = first_plain(fit, trials)
    starts = [(plain.problem, plain.point)]
    starts += starts_traded(fit, effect, form_of(effect, plain.problem))
    if makes_pressure(effect):
        starts.append((plain.problem, with_pressures_of(fit.problem, fit.found.point, *starts[0])))
    problem, best = nearest_descended(starts, evaluations=GLANCE)
    if best.error < fit.found.error:
        return problem, best
    if any(each.is_lag for each in effect.fitted):
        # One that is small shows nothing, and its runs are dear.
        return at_neutral(fit, effect)
    return near_neutral(fit, effect, trials, evaluations=GLANCE)
