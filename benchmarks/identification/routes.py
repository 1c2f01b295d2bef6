"""Success and seconds of the exact and of the smooth route, over repetitions from bad starts."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.identification.plants import Case, Made, make, not_found

if TYPE_CHECKING:
    from identification.fit import Fit

LISTED = 5
"""Failures that are listed."""


@dataclass(frozen=True)
class Score:
    """How a route did on one case: seconds of each fit by the clock and of computing; by seed what was not found."""

    seconds: list[float]
    computing: list[float]
    failures: dict[int, list[str]]

    @property
    def successes(self) -> int:
        """Repetitions in which everything was found."""
        return len(self.seconds) - len(self.failures)

    def as_json(self) -> dict[str, Any]:
        """Return the numbers of this row."""
        return {
            "repetitions": len(self.seconds),
            "successes": self.successes,
            "seconds": {
                "median": float(np.median(self.seconds)),
                "95 %": float(np.quantile(self.seconds, 0.95)),
                "longest": max(self.seconds),
            },
            "seconds of computing": float(np.median(self.computing)),
            "failures": {str(seed): names for seed, names in list(self.failures.items())[:LISTED]},
        }


def fit_by_exact_route(made: Made) -> Fit:
    """Fit a plant's record on the exact simulator."""
    from identification.exact_fit import fit_exact
    from identification.experiment import experiment_of

    return fit_exact(made.start, [experiment_of(made.record)], effects=made.effects)


def fit_by_smooth_route(made: Made) -> Fit:
    """Fit a plant's record on smooth functions with CasADi's derivatives, then on the exact simulator."""
    from identification.experiment import experiment_of
    from identification.smooth_fit import fit_smooth

    return fit_smooth([experiment_of(made.record)], made.start, effects=made.effects).fit


ROUTES: dict[str, Callable[[Made], Fit]] = {"exact": fit_by_exact_route, "smooth": fit_by_smooth_route}

BUDGET = {"exact": 1.0, "smooth": 10.0}
"""Seconds that issue 4 allows for a fit after import."""


def score_route(route: str, case: Case, repetitions: int, tick: Callable[[], None]) -> Score:
    """Fit plants one after the other on one core; a first fit, not counted, loads what is compiled."""
    from identification.determined.uncertainty import estimates

    fit = ROUTES[route]
    seconds: list[float] = []
    computing: list[float] = []
    failures: dict[int, list[str]] = {}
    with threadpool_limits(1):
        fit(make(case, repetitions))
        for seed in range(repetitions):
            made = make(case, seed)
            began, before = time.perf_counter(), time.process_time()
            found = fit(made)
            seconds.append(time.perf_counter() - began)
            computing.append(time.process_time() - before)
            names = not_found(made.truth, estimates(found))
            if names:
                failures[seed] = names
            tick()
    return Score(seconds, computing, failures)
