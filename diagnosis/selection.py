"""Which effects: every effect alone, then more on top of the best, as long as unseen data gain from it."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from multiprocessing import get_context

import numpy as np

from diagnosis.score import Score, score_fit
from identification.extension import extend, screened
from identification.fit import Fit
from identification.holdout import Holdout
from valvemodel.declarations import Effect
from valvemodel.effects import effect_of_key
from valvemodel.stages import EFFECTS

LEADERS = 2
"""Best causes that are tried with one more effect."""

SHORTLIST = 5
"""Effects that are tried on top of each leader, by what they promise on its residual."""

MOST_EFFECTS = 3
"""Effects that a cause may have."""

GOOD_ENOUGH = 1.06
"""Mean weighted square at which the noise is reached and no further effect is looked for."""

FORM_SHARE = 0.2
"""Share of the base's error, in root mean square, that the right effect may leave for another form than ours."""

NEAR_THE_BEST = 1.6
"""Causes whose squared error is within this factor of the best of their size are tried with one more effect."""

WORTH_ANOTHER = 0.3
"""Share by which one more effect must lower the error for yet another to be looked for."""

Progress = Callable[[str, float], None]


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
        Number of the effects' free parameters.
    """

    effects: tuple[str, ...]
    fit: Fit
    score: Score
    trace: float = math.inf
    freedom: int = 0


@contextmanager
def workers(jobs: int | None = None) -> Iterator[Executor | None]:
    """Open processes that share the compiled simulator; None where there is only one core."""
    jobs = jobs or min(os.cpu_count() or 1, 8)
    if jobs == 1:
        yield None
        return
    # A fork server takes 1 to 2.5 s to import the simulator. A fork beside the idle threads of polars, which read the
    # records, is safe as long as no work in here reads or writes tables: the children never call polars.
    pool = ProcessPoolExecutor(jobs, mp_context=get_context("fork"))
    try:
        yield pool
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def try_effect(fit: Fit, effects: tuple[str, ...], holdout: Holdout) -> Candidate:
    """Extend a fit by the last of a cause's effects and score it."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        extended = extend(fit, effects[-1])
        freedom = sum(len(effect_of_key(key).fitted) for key in effects)
        return Candidate(effects, extended, score_fit(extended, holdout), trace_of(extended, holdout), freedom)


def trace_of(fit: Fit, holdout: Holdout) -> float:
    """Return by how much the readings change when the least of a fit's effects is taken out. [noise]"""
    changes = []
    for key in fit.model.effects:
        without = replace(fit, model=fit.model.without_effect(key))
        squares = [
            np.nanmean((fit.simulated_on(each).position - without.simulated_on(each).position) ** 2) / each.noise**2
            for each in holdout.scored_experiments
        ]
        changes.append(float(np.sqrt(np.mean(squares))))
    return min(changes)


def select(
    base: Candidate, holdout: Holdout, library: Sequence[Effect], pool: Executor | None, progress: Progress
) -> list[Candidate]:
    """Try every effect alone, then further effects on top of the best, and return all that was tried, base first.

    The effects that need a global search come last, and only where no other one explains the gap.
    """
    tried = [base]
    for is_jagged in (False, True):
        keys = [effect.key for effect in library if effect.is_jagged == is_jagged]
        if is_jagged and any(explains(each, base) for each in tried):
            break
        tried += try_all([(base.fit, (key,)) for key in keys], holdout, pool, progress, "effects one by one")
    for size in range(2, MOST_EFFECTS + 1):
        order = sorted((each for each in tried if len(each.effects) == size - 1), key=misfit)
        leaders = [each for each in order[:LEADERS] if misfit(each) < NEAR_THE_BEST * misfit(order[0])]
        if explains(min(tried, key=misfit), base):
            break
        work: list[tuple[Fit, tuple[str, ...]]] = []
        for leader in leaders:
            for key in shortlist(leader.fit, library):
                effects = (*leader.effects, key)
                if not any(set(effects) == set(other) for _, other in work):
                    work.append((leader.fit, effects))
        if not work:
            break
        tried += try_all(work, holdout, pool, progress, f"{size} effects together")
        best = min((each for each in tried if len(each.effects) == size), key=misfit)
        if misfit(best) > (1.0 - WORTH_ANOTHER) ** 2 * misfit(order[0]):
            break
    return tried


def misfit(candidate: Candidate) -> float:
    """Return how far a cause is from unseen data: 1 where the noise is reached."""
    return candidate.score.misfit


def explains(candidate: Candidate, base: Candidate) -> bool:
    """Return whether a cause leaves so little that no further effect is looked for.

    Either the noise is reached, or what is left is a small part of what the base left: as much as the right effect
    leaves when it has another form than ours.
    """
    left, before = misfit(candidate) - 1.0, misfit(base) - 1.0
    return misfit(candidate) < GOOD_ENOUGH or left < FORM_SHARE**2 * before


def library_for(holdout: Holdout, keys: Sequence[str] | None = None) -> list[Effect]:
    """Return the effects, of those named or of all, that the records can show: settled loops none that acts in time."""
    is_loop = all(experiment.is_loop for experiment in holdout.experiments)
    named = EFFECTS if keys is None else [effect_of_key(key) for key in dict.fromkeys(keys)]
    return [effect for effect in named if not (is_loop and effect.acts_in_time)]


def shortlist(fit: Fit, library: Sequence[Effect]) -> list[str]:
    """Return the effects that promise most on what a fit leaves over, one that needs a global search among them."""
    keys = [effect.key for effect in library if effect.key not in fit.model.effects]
    gains = {key: max((trial.gain for trial in screened(fit, effect_of_key(key))), default=0.0) for key in keys}
    order = sorted(keys, key=lambda key: -gains[key])
    jagged = [key for key in order if effect_of_key(key).is_jagged]
    return [key for key in order if key not in jagged[1:]][:SHORTLIST]


def try_all(
    work: Sequence[tuple[Fit, tuple[str, ...]]],
    holdout: Holdout,
    pool: Executor | None,
    progress: Progress,
    what: str,
) -> list[Candidate]:
    """Try a list of extensions, on all cores where there is a pool."""
    done: list[Candidate] = []
    jobs: list[Future[Candidate]] = []
    if pool is not None:
        jobs = [pool.submit(try_effect, fit, effects, holdout) for fit, effects in work]
    for number, (fit, effects) in enumerate(work):
        progress(f"{what}: {' + '.join(effects)}", number / len(work))
        done.append(jobs[number].result() if jobs else try_effect(fit, effects, holdout))
    return done
