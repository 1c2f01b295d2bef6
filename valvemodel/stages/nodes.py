"""What moves along a part of a period: its values at equidistant nodes and the polynomial through them."""

from __future__ import annotations

import math

import numpy as np

from valvemodel.compiled import compiled, inlined

NODES = 5
"""Spacings between the nodes of a part, at most; polynomials are of this degree."""

COARSE_NODES = 2
"""Spacings of a coarse run."""

REMEMBERED = 8
"""Durations or spacings of which what follows from them is remembered: a delay, or parts, come back to a few."""

ALIKE = 1e-12
"""Share by which two spacings differ that are equal but for rounding."""

ORDER = 18
"""Highest power of time in the series of a swing on bristles."""

OVERSHOOT = 0.05
"""Largest value of x (x - 1) ... (x - n) / (n + 1)! between the nodes, for any number of them used here."""


def _powers_through_nodes() -> np.ndarray:
    """Return [count, power, node]: the powers of the polynomial that is 1 at one of the nodes 0, 1 ... count."""
    table = np.zeros((NODES + 1, NODES + 1, NODES + 1))
    for count in range(NODES + 1):
        for node in range(count + 1):
            others = [other for other in range(count + 1) if other != node]
            basis = np.atleast_1d(np.poly(others)) / math.prod(node - other for other in others)
            table[count, : count + 1, node] = basis[::-1]
    return table


POWERS = _powers_through_nodes()
CHOOSE = np.array([[float(math.comb(n, k)) for k in range(NODES + 2)] for n in range(NODES + 2)])
FACTORIAL = np.array([float(math.factorial(n)) for n in range(NODES + 1)])


@inlined
def is_alike(known, spacing, count):
    """Return whether what is known, of a lag or of a response, is of so many spacings of that length."""
    return known.count == count and abs(known.spacing - spacing) <= ALIKE * spacing


@compiled
def fit_powers(count, values, powers):
    """Write the powers of the polynomial through values at the nodes 0, 1 ... count."""
    powers[0] = values[0]
    if count == 2:
        # The parabolas of a coarse run, of which it lays very many.
        bend = 0.5 * (values[0] + values[2]) - values[1]
        powers[1], powers[2] = values[1] - values[0] - bend, bend
        return
    for power in range(1, count + 1):
        total = 0.0
        for node in range(count + 1):
            total += POWERS[count, power, node] * values[node]
        powers[power] = total


@inlined
def value_at(count, powers, x):
    """Return a polynomial's value; x counts spacings."""
    value = powers[count]
    for power in range(count - 1, -1, -1):
        value = value * x + powers[power]
    return value


@inlined
def slope_at(count, powers, x):
    """Return a polynomial's slope by spacing."""
    slope = 0.0
    for power in range(count, 0, -1):
        slope = slope * x + power * powers[power]
    return slope


@compiled
def left_out(count, powers):
    """Return how far the function through the nodes is off their polynomial, by the decay of its differences.

    The slower of the last two decays counts, as one difference may vanish by chance.
    """
    middle = 0.5 * count
    last = FACTORIAL[count] * abs(powers[count])
    before = FACTORIAL[count - 1] * abs(powers[count - 1] + count * middle * powers[count])
    ratio = last / before if last < before else 1.0
    if count > 2:
        lower = powers[count - 2] + (count - 1.0) * middle * (powers[count - 1] + middle * middle * powers[count])
        lower = FACTORIAL[count - 2] * abs(lower)
        ratio = max(ratio, before / lower if before < lower else 1.0)
    return OVERSHOOT * ratio * max(last, ratio * before)


@compiled
def first_fall(count, values, powers):
    """Return where values at the nodes that begin positive first fall to 0, in spacings; infinity if nowhere."""
    for node in range(1, count + 1):
        if values[node] < 0.0:
            fit_powers(count, values, powers)
            return fall_between(count, powers, node - 1.0, float(node))
    return math.inf


@compiled
def fall_between(count, powers, low, high):
    """Return where a polynomial falls to 0 between two places, by bracketed Newton iteration; not before it has."""
    place = 0.5 * (low + high)
    for _ in range(60):
        value, slope = value_at(count, powers, place), slope_at(count, powers, place)
        if value > 0.0:
            low = place
        else:
            high = place
        following = place - value / slope if slope < 0.0 else 0.5 * (low + high)
        if abs(following - place) <= 1e-14 * high:
            # Seen from before the fall alone, its other side is still where the search began.
            high = min(high, max(following, place) + 1e-14 * high)
            break
        place = following if low < following < high else 0.5 * (low + high)
    return high
