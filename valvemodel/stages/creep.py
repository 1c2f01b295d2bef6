"""Creep: how far something has gone that begins at a constant rate and slows down, over that rate."""

from __future__ import annotations

import math

from valvemodel.compiled import inlined


@inlined
def crept(time, time_constant, is_logarithmic):
    """Return how far a creep of unit rate at the start has come: to its time constant, or on as a logarithm. [s]"""
    if is_logarithmic > 0.0:
        return time_constant * math.log1p(time / time_constant)
    return -time_constant * math.expm1(-time / time_constant)
