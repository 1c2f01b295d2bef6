"""Which effects: every effect alone, then more on top of the best, as long as unseen data gain from it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context

from diagnosis.holdout import Holdout
from diagnosis.score import Score, score_fit
from identification.extension import extend, screened
from identification.fit import Fit
from valvemodel.effects import effect_of_key
from valvemodel.stages import EFFECTS

LEADERS = 3
"""Best causes that are tried with one more effect."""

SHORTLIST = 5
"""Effects that are tried on top of each leader, by what they promise on its residual."""

MOST_EFFECTS = 3
"""Effects that a cause may have."""

GOOD_ENOUGH = 1.06
"""Mean weighted square at which the noise is reached and no further effect is looked for."""

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Candidate:
    """A cause that was tried: its effects in the order of adding, its fit, its score on unseen data."""

    effects: tuple[str, ...]
    fit: Fit
    score: Score

    @property
    def freedom(self) -> int:
        """Number of the effects' free parameters."""
        return sum(len(effect_of_key(key).fitted) for key in self.effects)


@contextmanager
def workers(jobs: int | None = None) -> Iterator[Executor | None]:
    """Open processes that share the compiled simulator; None where there is only one core."""
    jobs = jobs or min(os.cpu_count() or 1, 8)
    if jobs == 1:
        yield None
        return
    pool = ProcessPoolExecutor(jobs, mp_context=get_context("fork"))
    try:
        yield pool
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def try_effect(fit: Fit, effects: tuple[str, ...], holdout: Holdout) -> Candidate:
    """Extend a fit by the last of a cause's effects and score it."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        import time; t0=time.process_time()
        extended = extend(fit, effects[-1])
        import os,time
        if os.environ.get("VM_T"): print(effects, round(time.process_time()-t0,2), extended.problem.__class__.__name__, flush=True)
        return Candidate(effects, extended, score_fit(extended, holdout))


def select(base: Candidate, holdout: Holdout, pool: Executor | None, progress: Progress) -> list[Candidate]:
    """Try every effect alone, then further effects on top of the best, and return all that was tried, base first."""
    tried = [base]
    keys = sorted((effect.key for effect in EFFECTS), key=lambda key: not effect_of_key(key).is_jagged)
    tried += try_all([(base.fit, (key,)) for key in keys], holdout, pool, progress, "effects one by one")
    for size in range(2, MOST_EFFECTS + 1):
        leaders = sorted((each for each in tried if len(each.effects) == size - 1), key=total)[:LEADERS]
        leaders = [leader for leader in leaders if is_worth_more(leader, leaders[0])]
        work = []
        for leader in leaders:
            for key in shortlist(leader.fit):
                effects = (*leader.effects, key)
                if not any(set(effects) == set(other) for _, other in work):
                    work.append((leader.fit, effects))
        if not work:
            break
        tried += try_all(work, holdout, pool, progress, f"{size} effects together")
        best_before = total(leaders[0])
        if min(total(each) for each in tried if len(each.effects) == size) > 0.9 * best_before:
            break
    return tried


def total(candidate: Candidate) -> float:
    """Return the weighted squared error on unseen data."""
    return float(candidate.score.weighted.sum())


def is_worth_more(leader: Candidate, first: Candidate) -> bool:
    """Return whether a cause leaves enough over to look for one more effect, and is near enough to the best."""
    mean = total(leader) / leader.score.counts.sum()
    return mean > GOOD_ENOUGH * signals(leader) and total(leader) < 4.0 * total(first)


def signals(candidate: Candidate) -> int:
    """Return how many signals are scored: position, and pressure where it was measured."""
    return 1 if candidate.fit.problem.experiments[0].pressure is None else 2


def shortlist(fit: Fit) -> list[str]:
    """Return the effects that promise most on what a fit leaves over."""
    keys = [effect.key for effect in EFFECTS if effect.key not in fit.model.effects]
    gains = {key: max((trial.gain for trial in screened(fit, effect_of_key(key))), default=0.0) for key in keys}
    return sorted(keys, key=lambda key: -gains[key])[:SHORTLIST]


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
