"""Creep: how far something has gone that begins at a constant rate and slows down, over that rate."""

from __future__ import annotations

import math

from valvemodel.compiled import inlined
from valvemodel.declarations import Parameter, choice_of_law


def creep_parameters(name: str) -> tuple[Parameter, Parameter]:
    """Return the numbers that say how the creep of an effect goes on: its time, and whether it comes to an end."""
    return (
        Parameter(
            f"{name}_time",
            "s",
            "T: time constant of the warming, or time from which on the creep slows down",
            2.0,
            3000.0,
            300.0,
            (300.0, 40.0),
            "log",
        ),
        choice_of_law(
            f"{name}_creep", "0: warming, which comes to an end; 1: creep, which goes on as the logarithm of time"
        ),
    )


@inlined
def crept(time, time_constant, is_logarithmic):
    """Return how far a creep of unit rate at the start has come: to its time constant, or on as a logarithm. [s]"""
    if is_logarithmic > 0.0:
        return time_constant * math.log1p(time / time_constant)
    return -time_constant * math.expm1(-time / time_constant)
