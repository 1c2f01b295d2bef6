"""Pairs: which two effects promise most together on what a fit leaves, told by what each of them changes by itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from threadpoolctl import threadpool_limits

from identification.extending.sluggishness import traded
from identification.fit import Fit
from identification.problem import Problem
from identification.starting.hints import begins_at_periods, resized
from identification.starting.joining import joined
from identification.starting.screening import answered, beside_own, change_of, starts_on, waves
from valvemodel.declarations import Effect, Form
from valvemodel.effects import effect_of_key

SMALLER = 0.3
"""Share of its starts at which an effect's change is taken as well: what is large may bend it."""

SMALLEST, LARGEST = 0.02, 3.0
"""Factors by which an effect may differ in size from where its change was taken."""

COLLINEAR = 1e-4
"""Squared sine of the angle between two changes from which they count as one."""

NOTHING = 1e-6
"""Share of what is left below which a change is none."""

FORMS = 4
"""Starts of two effects that are followed, of which each must have another form."""


@dataclass(frozen=True, eq=False)
class Trace:
    """What an effect changes of the residuals of a fit.

    Attributes
    ----------
    key : str
        The effect.
    values : dict
        Of its parameters. [SI]
    move : array, shape (unknowns,)
        By how much the fit's own unknowns move with it, scaled.
    change : array, shape (r,)
        Beside whatever the fit's own unknowns can do.
    """

    key: str
    values: dict[str, float]
    move: np.ndarray
    change: np.ndarray

    @cached_property
    def form(self) -> tuple[Form, frozenset[str]]:
        """What of the effect acts: the values of those numbers that no fit moves, and which others are neutral."""
        effect, values = effect_of_key(self.key), self.values
        idle = (each.name for each in effect.free_at(values) if values[each.name] == each.neutral)
        return effect.form_at(values), frozenset(idle)


@dataclass(frozen=True)
class Pair:
    """Two effects, where a search for both begins: a trace of each, its size, and what they promise to explain."""

    traces: tuple[Trace, Trace]
    sizes: tuple[float, float]
    gain: float

    @property
    def keys(self) -> tuple[str, str]:
        """The two effects."""
        first, second = self.traces
        return first.key, second.key


@threadpool_limits.wrap(limits=1)
def traces_of(fit: Fit, effect: Effect, alone: Fit | None = None) -> list[Trace]:
    """Return what an effect changes of a fit's residuals: at its starts, at a part of them, and as fitted alone."""
    residual, basis, _ = fit.own_slopes
    left = beside_own(residual, basis)
    starts = starts_on(fit, effect)
    if begins_at_periods(effect):
        starts = waves(fit, effect, starts, left, basis)
    known = len(fit.found.point)
    tried = [(resized(effect, start, size), np.zeros(known)) for start in starts for size in (1.0, SMALLER)]
    if alone is not None:
        tried.append((dict(alone.model.effects[effect.key]), alone.found.point[:known] - fit.found.point))
    tried += traded(fit, effect, dict.fromkeys(map(effect.form_at, starts)))
    traces: dict[tuple[float, bytes], Trace] = {}
    for values, move in tried:
        problem, point = joined(fit.problem, fit.found.point, effect, values)
        point[:known] += move
        change = change_of(problem.residuals(point[None, :])[0], left, basis)
        size = float(change @ change)
        if size > NOTHING * float(left @ left):
            # Laws that make no difference by themselves are one.
            traces.setdefault((size, point.tobytes()), Trace(effect.key, values, move, change.astype(np.float32)))
    return list(traces.values())


def promising_pairs(fit: Fit, traces: Sequence[Trace], count: int) -> list[Pair]:
    """Return the pairs of effects whose changes together, each at any size, explain most of what a fit leaves.

    Parameters
    ----------
    fit : Fit
    traces : sequence of Trace
        Of all effects.
    count : int
        Starts that are returned, the most promising first.
    """
    if not traces:
        return []
    residual, basis, _ = fit.own_slopes
    left = beside_own(residual, basis)
    changes = np.array([each.change for each in traces], float)
    products, wanted = changes @ changes.T, -(changes @ left)
    squares = np.diag(products)
    alike = squares[:, None] * squares
    apart = np.maximum(alike - products**2, COLLINEAR * alike)
    sizes = np.clip((wanted[:, None] * squares - products * wanted) / apart, 0.0, LARGEST)
    others = sizes.T
    gains = 2.0 * (sizes * wanted[:, None] + others * wanted)
    gains -= sizes**2 * squares[:, None] + 2.0 * sizes * others * products + others**2 * squares
    keys = np.array([each.key for each in traces])
    is_pair = (np.minimum(sizes, others) > SMALLEST) & (keys[:, None] != keys) & (gains > 0.0)
    ones, twos = np.nonzero(np.triu(is_pair))
    found: list[Pair] = []
    forms: dict[frozenset[str], set[tuple[object, ...]]] = {}
    for place in np.argsort(-gains[ones, twos]):
        one, two = int(ones[place]), int(twos[place])
        known = forms.setdefault(frozenset((keys[one], keys[two])), set())
        form = (*traces[one].form, *traces[two].form)
        if len(known) == FORMS or form in known:
            continue
        known.add(form)
        size, other = float(sizes[one, two]), float(sizes[two, one])
        found.append(Pair((traces[one], traces[two]), (size, other), float(gains[one, two])))
        if len(found) == count:
            break
    return found


def begun(fit: Fit, pair: Pair) -> tuple[Problem, np.ndarray]:
    """Return the problem with both effects of a pair, and the scaled point where a search for them begins."""
    _, basis, triangle = fit.own_slopes
    moves = [size * trace.move for size, trace in zip(pair.sizes, pair.traces, strict=True)]
    problem, point = fit.problem, np.clip(fit.found.point + sum(moves), *fit.problem.bounds)
    for size, trace in zip(pair.sizes, pair.traces, strict=True):
        effect = effect_of_key(trace.key)
        problem, point = joined(problem, point, effect, resized(effect, trace.values, size))
    start, _ = answered(problem, point, problem.residuals(point[None, :])[0], basis, triangle)
    return problem, start
