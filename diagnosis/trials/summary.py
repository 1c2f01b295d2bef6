"""The summary of a blind test: hit rates with intervals, confusion, calibration, closure, seconds."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from diagnosis.judging.sham import WINS_FROM
from diagnosis.trials.marking import OUTCOMES
from diagnosis.trials.plan import KINDS
from diagnosis.trials.scoring import Result
from valvemodel.stages import EFFECTS

CONFIDENCE = 0.95
BINS = 10
"""Bins of equal width for probability said against frequency found."""

ROWS = (*(effect.key for effect in EFFECTS), "none")
COLUMNS = (*ROWS, "several", "unknown", "failed")
"""What can be true and what can be said; `several` stands for any set of more than one effect."""


def summary_of(results: Sequence[Result]) -> dict[str, Any]:
    """Return the counts of a blind test, as blindtest.json has them."""
    by_kind = {kind: [each for each in results if each.kind == kind] for kind in KINDS}
    by_kind = {kind: chosen for kind, chosen in by_kind.items() if chosen}
    return {
        "kinds": {kind: counts_of(chosen) for kind, chosen in by_kind.items()},
        "confusion": {
            "rows": list(ROWS),
            "columns": list(COLUMNS),
            **{kind: confusion_of(chosen) for kind, chosen in by_kind.items() if kind != "pair"},
        },
        "calibration": calibration_of(results),
        "closure": closure_of(results),
        "black_box": black_box_of(results),
        "sham_wins": rate_of(each.sham >= WINS_FROM for each in results if each.sham is not None),
        "seconds": spread_of([each.seconds for each in results if each.seconds is not None]),
        "computing_seconds": spread_of(
            [each.computing_seconds for each in results if each.computing_seconds is not None]
        ),
        "baseline": {kind: baseline_of(chosen) for kind, chosen in by_kind.items() if chosen[0].baseline} or None,
    }


def rate_of(hits: Iterable[bool]) -> dict[str, Any]:
    """Return a share with its Wilson interval."""
    from scipy.stats import binomtest

    hits = list(hits)
    if not hits:
        return {"hits": 0, "of": 0, "share": None, "interval": None}
    found = sum(hits)
    interval = binomtest(found, len(hits)).proportion_ci(CONFIDENCE, method="wilson")
    return {
        "hits": found,
        "of": len(hits),
        "share": found / len(hits),
        "interval": [float(interval.low), float(interval.high)],
    }


def counts_of(results: Sequence[Result]) -> dict[str, Any]:
    """Return what came out for the plants of one kind."""
    outcomes = Counter(each.mark.outcome for each in results)
    return {
        "plants": len(results),
        "right": rate_of(each.mark.is_right for each in results),
        "first_choice": rate_of(each.mark.outcome == "right" for each in results),
        "stage": rate_of(bool(each.mark.is_stage_right) for each in results if each.truth),
        "right_where_visible": rate_of(each.mark.is_right for each in results if not each.is_imitated),
        "false_alarm": rate_of(each.mark.outcome != "right" for each in results if not each.truth),
        "outcomes": {outcome: outcomes[outcome] for outcome in OUTCOMES if outcomes[outcome]},
    }


def confusion_of(results: Sequence[Result]) -> list[list[int]]:
    """Return how often each truth (a row) was answered by each first choice (a column)."""
    table = np.zeros((len(ROWS), len(COLUMNS)), int)
    for each in results:
        table[ROWS.index(each.truth[0] if each.truth else "none"), COLUMNS.index(said_by(each))] += 1
    return table.tolist()


def said_by(result: Result) -> str:
    """Return the column of an answer."""
    if result.verdict == "effect":
        return result.mark.named[0] if len(result.mark.named) == 1 else "several"
    return result.verdict


def calibration_of(results: Sequence[Result]) -> dict[str, Any]:
    """Return probability said against frequency found, and their expected difference.

    The probability is that of the answer with all that it declares indistinguishable.

    References
    ----------
    Expected calibration error of equal bins: Naeini, Cooper, Hauskrecht, AAAI (2015).
    """
    marks = [each.mark for each in results if each.verdict != "failed"]
    said = np.array([each.said for each in marks])
    is_true = np.array([each.is_true for each in marks])
    number = np.minimum((said * BINS).astype(int), BINS - 1)
    bins = []
    for index in range(BINS):
        chosen = number == index
        bins.append(
            {
                "low": index / BINS,
                "high": (index + 1) / BINS,
                "said": float(said[chosen].mean()) if chosen.any() else None,
                "found": rate_of(is_true[chosen]),
            }
        )
    errors = [abs(float(np.sum(said[number == index] - is_true[number == index]))) for index in range(BINS)]
    return {"bins": bins, "expected_calibration_error": sum(errors) / len(marks) if marks else None}


def closure_of(results: Sequence[Result]) -> dict[str, Any]:
    """Return the share of the reducible gap closed on unseen records of plants whose effects are candidates.

    Beside it the lowest decile where all models run free, which lose the phase of slips that stick.
    """
    chosen = [each.closure for each in results if each.kind in ("single", "pair")]
    known = [closure for closure in chosen if closure.get("closed") is not None]
    low, middle = np.quantile([each["closed"] for each in known], [0.1, 0.5]) if known else (None, None)
    free = [share for each in known if (share := each.get("closed_free")) is not None]
    low_free = np.quantile(free, 0.1) if free else None
    return {"plants": len(known), "median": middle, "lowest_decile": low, "lowest_decile_free": low_free}


def black_box_of(results: Sequence[Result]) -> dict[str, Any]:
    """Return the share of the gap on held-out blocks that a black box closes, beside the cause, where there is one."""
    pairs = [
        (each.black_box, each.cause)
        for each in results
        if each.kind in ("single", "pair") and each.verdict == "effect"
        if each.black_box is not None and each.cause is not None
    ]
    black_box, cause = np.median(pairs, axis=0) if pairs else (None, None)
    return {"plants": len(pairs), "median": black_box, "cause_median": cause}


def spread_of(values: Sequence[float]) -> dict[str, Any]:
    """Return median and 95th percentile. [s]"""
    middle, high = np.quantile(values, [0.5, 0.95]) if values else (None, None)
    return {"median": middle, "percentile_95": high}


def baseline_of(results: Sequence[Result]) -> dict[str, Any]:
    """Return what the trivial baseline reached on plants of one kind."""
    marks = [each.baseline for each in results if each.baseline is not None]
    return {
        "right": rate_of(each["is_right"] for each in marks),
        "stage": rate_of(bool(each["is_stage_right"]) for each in marks if each["is_stage_right"] is not None),
        "seconds": spread_of([each["seconds"] for each in marks]),
    }
