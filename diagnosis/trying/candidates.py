"""Trying: one cause after another fitted and scored, on all cores."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import repeat

import numpy as np

from diagnosis.score import Score, score_fit
from diagnosis.trying.workshop import Workshop
from identification.cores import begun
from identification.extending.extension import Extension, continued, extend, extend_from, slips_asked
from identification.extending.glance import Glance, glanced
from identification.extending.reduction import reduced
from identification.extending.restart import begun_again
from identification.fit import Fit
from identification.holdout import Holdout
from identification.sharpening import sharpened, steadied
from identification.starting.screening import screened
from identification.stick_slip.slip_search import SlipSearch
from identification.unknowns import freed_by
from valvemodel.declarations import Parameter
from valvemodel.effects import effect_of_key, jumps
from valvemodel.model import Model

SERIES = 2
"""Free parameters that a series of like numbers counts as."""

AT_ONCE = 4
"""Extensions of which none waits for what came out of another: so many that two cores always have work."""

HAIR_LEFT, HAIR_UNSEEN = 2.0, 1.2
"""Error over that of the noise up to which a fit is right but for a hair, and what is unseen over it from which it is
not."""


@dataclass(frozen=True)
class Candidate:
    """A cause that was tried.

    Attributes
    ----------
    effects : tuple of str
        In the order of adding; none for the base.
    fit : Fit
    score : Score
        On unseen data.
    trace : float [noise]
        Change of the reading, root mean square, when the least of the effects is taken out; infinite for the base.
    freedom : int
        Number of the effects' free parameters; a series of like numbers, held by its prior, counts as few.
    has_series : bool
        Whether one of the effects is a whole series of waves, which has no other form than ours.
    is_sharpened : bool
        Whether it was searched about, which takes long and is done once.
    orders : frozenset of tuple of str
        The orders in which its last effect was tried on top of the others; none of what was followed down together.
    slips : list of SlipSearch or None
        What the forms of a law of stick-slip alone make of the slips of stairs; None where that shows nothing, or was
        not asked.
    """

    effects: tuple[str, ...]
    fit: Fit
    score: Score
    trace: float = math.inf
    freedom: int = 0
    has_series: bool = False
    is_sharpened: bool = False
    orders: frozenset[tuple[str, ...]] = frozenset()
    slips: list[SlipSearch] | None = None


@dataclass(frozen=True)
class Work(Extension):
    """One extension to be tried; how is said as for any `Extension`.

    Attributes
    ----------
    fit : Fit
        Of the cause without its last effect.
    effects : tuple of str
        The cause.
    is_known : bool
        Whether the values that are known are the only start.
    begun : Fit or None
        The fit with the effect, as far as a glance at it went; it is followed from there alone.
    """

    fit: Fit
    effects: tuple[str, ...]
    is_known: bool = field(default=False, kw_only=True)
    begun: Fit | None = field(default=None, kw_only=True)


def try_effect(work: Work, holdout: Holdout) -> Candidate:
    """Extend a fit by the last of a cause's effects and score it."""
    key, slips = work.effects[-1], work.slips
    if work.begun is not None:
        extended = continued(work.begun) if work.begun.found.error < work.worth else work.begun
    elif work.is_known and work.known is not None:
        extended = extend_from(work.fit, key, work.known, worth=work.worth)
    else:
        slips = slips_asked(work.fit, effect_of_key(key), work)
        extended = extend(work.fit, key, replace(work, slips=slips))
    shown = slips if slips and len(work.effects) == 1 else None
    return replace(scored(work.effects, extended, holdout), orders=frozenset({work.effects}), slips=shown)


def scored(effects: tuple[str, ...], fit: Fit, holdout: Holdout) -> Candidate:
    """Score a fit with some effects, as a cause."""
    score = score_fit(fit, holdout)
    if hangs_by_a_hair(fit, score):
        fit = steadied(fit, holdout.whole.scored_experiments)
        score = score_fit(fit, holdout)
    trace = trace_of(fit, holdout)
    return Candidate(effects, fit, score, trace, freedom_of(fit), fit.problem.has_series)


def hangs_by_a_hair(fit: Fit, score: Score) -> bool:
    """Return whether a fit whose stem jumps leaves far more of what it did not see than of what it was fitted to.

    In stairs each slip is judged by itself: there a hair is no matter.
    """
    if not jumps(fit.model.effects) or score.at_rests is not None:
        return False
    left = fit.found.error / fit.problem.noise_error
    return left < HAIR_LEFT and score.misfit > HAIR_UNSEEN * left


def take_out(candidate: Candidate, key: str, holdout: Holdout) -> Candidate:
    """Take an effect out of a cause, fit the others from where they are, and score that."""
    fit = reduced(candidate.fit, key)
    effects = tuple(each for each in candidate.effects if each != key)
    return scored(effects, fit, holdout)


def try_anew(candidate: Candidate, key: str, holdout: Holdout) -> Candidate:
    """Take an effect out of a cause, fit the others from where they are, and search for it on top of them again.

    Beside others that are fitted well another form of it may be the right one.
    """
    known = dict(candidate.fit.model.effects[key])
    others = tuple(each for each in candidate.effects if each != key)
    return try_effect(Work(reduced(candidate.fit, key), (*others, key), is_global=False, known=known), holdout)


def freedom_of(fit: Fit) -> int:
    """Return how many free parameters of the valve a fit's effects bring; a series, held by its prior, is few."""
    own = sum(each.is_own for moved in moved_in(fit.model).values() for each in moved)
    freed = freed_by(fit.model.effects, with_pressure=fit.problem.has_pressure)
    return own + len(freed) + (SERIES if fit.problem.has_series else 0)


def moved_in(model: Model) -> dict[str, tuple[Parameter, ...]]:
    """Return the parameters of each effect of a fitted model that the fit moved."""
    return {key: effect_of_key(key).free_at(values) for key, values in model.effects.items()}


def sharpen(candidate: Candidate, holdout: Holdout) -> Candidate:
    """Search about the fit of a cause whose error is jagged; return what comes nearer, that or the cause as it was."""
    found = scored(candidate.effects, sharpened(candidate.fit), holdout)
    nearer = min(candidate, found, key=lambda each: each.score.misfit)
    return replace(nearer, is_sharpened=True, slips=candidate.slips)


def begin_again(candidate: Candidate, holdout: Holdout) -> Candidate:
    """Fit a cause again from the given valve's numbers, and score it anew; as it was where that is in vain."""
    fit = begun_again(candidate.fit)
    return candidate if fit is candidate.fit else scored(candidate.effects, fit, holdout)


def trace_of(fit: Fit, holdout: Holdout) -> float:
    """Return by how much the readings change when the least of a fit's effects is taken out. [noise]

    Of an effect that is a difference that is taken out: what fills as it vents, however slowly, fills not unequally.
    """
    changes = []
    for key, values in fit.model.effects.items():
        alike = effect_of_key(key).without_difference(values)
        model = fit.model.without_effect(key) if alike is None else fit.model.with_effect(key, **alike)
        without = replace(fit, model=model)
        squares = [
            np.nanmean((fit.simulated_on(each).position - without.simulated_on(each).position) ** 2) / each.noise**2
            for each in holdout.scored_experiments
        ]
        changes.append(float(np.sqrt(np.mean(squares))))
    return min(changes)


def never(candidate: Candidate) -> bool:
    """Return that a cause is not all that is wanted."""
    return False


def try_all(
    work: Sequence[Work], workshop: Workshop, what: str, until: Callable[[Candidate], bool] = never
) -> list[Candidate]:
    """Try a list of extensions in turn, on all cores where there is a pool, up to one that is all that is wanted."""
    done: list[Candidate] = []
    jobs: list[Future[Candidate]] = []
    if workshop.pool is not None:
        jobs = [workshop.pool.submit(try_effect, each, workshop.holdout) for each in work]
    for number, each in enumerate(work):
        workshop.progress(f"{what}: {' + '.join(each.effects)}", number / len(work))
        done.append(jobs[number].result() if jobs else try_effect(each, workshop.holdout))
        if until(done[-1]):
            break
    for job in jobs[len(done) :]:
        job.cancel()
    return done


def try_in_turn(
    work: Sequence[Work], called_for: Callable[[Work, Sequence[Candidate]], Work], workshop: Workshop, what: str
) -> list[Candidate]:
    """Try a list of extensions in turn, on all cores where there is a pool, each as far as those before it call for.

    What is called for is asked of all but the last few before it, however many cores there are: the result is the same.

    Parameters
    ----------
    called_for : callable
        Takes a work and what came out of those before it, and returns the work to be done.
    """
    done: list[Candidate] = []
    jobs: deque[Callable[[], Candidate]] = deque()
    for number, each in enumerate(work):
        while len(done) < number + 1 - AT_ONCE:
            done.append(jobs.popleft()())
        workshop.progress(f"{what}: {' + '.join(each.effects)}", number / len(work))
        jobs.append(begun(workshop.pool, try_effect, called_for(each, done), workshop.holdout))
    return [*done, *(job() for job in jobs)]


def glances(fit: Fit, keys: Sequence[str], workshop: Workshop) -> dict[str, Glance]:
    """Return what a glance at each of some effects on top of a fit shows, on all cores where there is a pool."""
    # Taken here, not once in each process.
    _ = fit.own_slopes
    return dict(zip(keys, workshop.map(partial(glanced, fit), keys), strict=True))


def promises(fit: Fit, starts: dict[str, dict[str, float]], workshop: Workshop) -> dict[str, float]:
    """Return what each of some effects promises to explain of what a fit leaves, on all cores where there is a pool.

    Parameters
    ----------
    fit : Fit
    starts : dict of dict
        Values of each effect as fitted alone, one more start of it. [SI]
    workshop : Workshop
    """
    if not starts:
        return {}
    # Taken here, not once in each process.
    _ = fit.own_slopes
    gains = workshop.map(partial(promise_of, fit), starts, starts.values())
    return dict(zip(starts, gains, strict=True))


def promise_of(fit: Fit, key: str, known: dict[str, float]) -> float:
    """Return what the best start of an effect promises on what a fit leaves."""
    return screened(fit, effect_of_key(key), known)[0].gain


def sharpen_all(candidates: Sequence[Candidate], workshop: Workshop) -> list[Candidate]:
    """Search about the fits of some causes, on all cores where there is a pool."""
    return change_all(sharpen, candidates, workshop, "searching about")


def change_all(
    change: Callable[[Candidate, Holdout], Candidate], candidates: Sequence[Candidate], workshop: Workshop, what: str
) -> list[Candidate]:
    """Return what becomes of some causes by a change, on all cores where there is a pool.

    Parameters
    ----------
    change : callable
        `sharpen` or `begin_again`.
    """
    if not candidates:
        return []
    workshop.progress(f"{what} {' + '.join(candidates[0].effects)}", 0.0)
    return list(workshop.map(change, candidates, repeat(workshop.holdout)))


def each_in_turn(
    change: Callable[[Candidate, str, Holdout], Candidate], candidates: Sequence[Candidate], workshop: Workshop
) -> list[Candidate]:
    """Return what becomes of some causes by a change to each of their effects in turn, on all cores with a pool.

    Parameters
    ----------
    change : callable
        `take_out` or `try_anew`.
    """
    pairs = [(each, key) for each in candidates for key in each.effects]
    if not pairs:
        return []
    workshop.progress(f"looking back from {' + '.join(candidates[0].effects)}", 0.0)
    causes, keys = zip(*pairs, strict=True)
    return list(workshop.map(change, causes, keys, repeat(workshop.holdout)))
