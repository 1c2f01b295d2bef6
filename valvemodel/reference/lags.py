"""Lags: how two in series answer."""

from __future__ import annotations

from math import exp, expm1


def answer_of_both(longer: float, shorter: float, time: float) -> float:
    """Return how two lags in series answer an impulse; equal ones too, and one alone. [1/s]"""
    if shorter == 0.0:
        return exp(-time / longer) / longer
    rate = 1.0 / shorter - 1.0 / longer
    share = -expm1(-rate * time) / rate if rate > 0.0 else time
    return exp(-time / longer) * share / longer / shorter
