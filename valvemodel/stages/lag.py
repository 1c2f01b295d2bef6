"""A first-order lag behind a polynomial in time, exact: q' = -rate q + f(t)."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined
from valvemodel.stages.nodes import CHOOSE, REMEMBERED, fit_powers, is_alike

SUPPLY_LAG, CHAMBER_LAG, AMPLIFIER_LAG, COIL_LAG, EDDY_LAG, READING_LAG, SHORTER_READING_LAG = range(7)
LAGS = SHORTER_READING_LAG + 1
"""Which lags there are, and how many."""

LONG = 8.0
"""Rate times spacing from which the responses are taken upwards; below, the power series is summed."""

NEARBY = 0.02
"""A rate that is off by this, times the part's length, still serves where passes mend it."""

APART = 3e-4
"""Share of their mean by which two lags are kept apart: a reading is off by 3e-9 of what the stem moves."""


@inlined
def longer_and_shorter(first, second):
    """Return the time constants of two lags in series, kept apart about their mean; which comes first is one. [s]"""
    if second == 0.0:
        return first, 0.0
    mean = 0.5 * (first + second)
    half = max(0.5 * abs(first - second), 0.5 * APART * mean)
    return mean + half, mean - half


@inlined
def in_series(longer, shorter, by_longer, by_shorter):
    """Return what comes out of both lags in series: by partial fractions, a sum of one and the other alone."""
    return by_longer + shorter / (longer - shorter) * (by_longer - by_shorter)


@inlined
def remembered_lag(memory, which, rate, spacing, count):
    """Return what is known of one of the lags at a rate over a spacing, laid anew unless it was among the last few."""
    return lag_within(memory, which, rate, spacing, count, 0.0)


@inlined
def nearby_lag(memory, which, rate, spacing, count):
    """Return what is known of one of the lags at about a rate, near enough for passes over the nodes to mend it."""
    return lag_within(memory, which, rate, spacing, count, NEARBY)


@inlined
def lag_within(memory, which, rate, spacing, count, allowed):
    """Return one of the lags at a rate that is off, times the length, by what is allowed at most, or lay it anew."""
    for place in range(REMEMBERED):
        lag = memory.lags[which, place]
        if is_alike(lag, spacing, count) and abs(lag.rate - rate) * spacing * count <= allowed:
            return lag
    turn = int(memory.lag_turns[which])
    memory.lag_turns[which] = (turn + 1) % REMEMBERED
    lag = memory.lags[which, turn]
    lay_lag(lag, rate, spacing, count)
    return lag


@inlined
def forget_lags(memory):
    """Forget all lags: what is near must not depend on an earlier run."""
    for which in range(LAGS):
        memory.lag_turns[which] = 0.0
        for place in range(REMEMBERED):
            memory.lags[which, place].spacing = -1.0


@compiled
def lay_lag(lag, rate, spacing, count):
    """Write down the decay and the responses to powers at all nodes."""
    lag.rate, lag.spacing, lag.count = rate, spacing, count
    short = rate * spacing
    decay, response = lag.decay, lag.response
    # At the first node: the response after one spacing to the powers 0, 1 ...
    if short < LONG:
        term, total = spacing / (count + 1.0), 0.0
        following = count + 2.0
        while abs(term) > 1e-18 * spacing:
            total += term
            term *= -short / following
            following += 1.0
        response[1, count] = total
        for power in range(count, 0, -1):
            response[1, power - 1] = (spacing - short * response[1, power]) / power
    else:
        response[1, 0] = spacing * (1.0 - math.exp(-short)) / short
        for power in range(1, count + 1):
            response[1, power] = (spacing - power * response[1, power - 1]) / short
    decay[0], decay[1] = 1.0, math.exp(-short)
    for node in range(1, count):
        decay[node + 1] = decay[node] * decay[1]
        for power in range(count + 1):
            total, scale = decay[1] * response[node, power], 1.0
            for lower in range(power, -1, -1):
                total += CHOOSE[power, lower] * scale * response[1, lower]
                scale *= node
            response[node + 1, power] = total


@compiled
def follow_nodes(lag, start, forces, powers, values):
    """Write the values at all nodes of a lag that starts at a value, under forces given at the nodes."""
    count = int(lag.count)
    fit_powers(count, forces, powers)
    values[0] = start
    for node in range(1, count + 1):
        total = lag.decay[node] * start
        for power in range(count + 1):
            total += lag.response[node, power] * powers[power]
        values[node] = total
