"""The self-calibration, eqs. (35)-(40), derived by least squares and from the geometry of the loop."""

from __future__ import annotations

from functools import cache

import sympy as sp

from derivations.glossary import symbol, symbols


@cache
def branch_slope() -> sp.Expr:
    """Mean of the two secants of three records, (35)."""
    i_1, i_2, i_3, y_1, y_2, y_3 = symbols("I_1 I_2 I_3 Y_1 Y_2 Y_3")
    return ((y_2 - y_1) / (i_2 - i_1) + (y_3 - y_2) / (i_3 - i_2)) / 2


@cache
def least_squares_slope() -> sp.Expr:
    """Slope of the straight line that fits three records best, what step 3 of the paper asks for."""
    slope, intercept = sp.symbols("slope intercept", real=True)
    pairs = zip(symbols("I_1 I_2 I_3"), symbols("Y_1 Y_2 Y_3"), strict=True)
    cost = sum((position - slope * current - intercept) ** 2 for current, position in pairs)
    solution = sp.solve([sp.diff(cost, slope), sp.diff(cost, intercept)], [slope, intercept], dict=True)
    return sp.factor(solution[0][slope])


@cache
def mean_slope() -> sp.Expr:
    """(37): the slope that is nearest to both in the least-squares sense."""
    rising, falling, slope = symbols("k_1 k_2 k_m")
    (nearest,) = sp.solve(sp.diff((slope - rising) ** 2 + (slope - falling) ** 2, slope), slope)
    return nearest


@cache
def branch_intercept() -> sp.Expr:
    """(38): the intercept that fits three records best once the slope is fixed."""
    slope = symbol("k_m")
    intercept = sp.Symbol("intercept", real=True)
    pairs = zip(symbols("I_1 I_2 I_3"), symbols("Y_1 Y_2 Y_3"), strict=True)
    cost = sum((position - slope * current - intercept) ** 2 for current, position in pairs)
    (best,) = sp.solve(sp.diff(cost, intercept), intercept)
    return sp.expand(best)


@cache
def loop_width() -> sp.Expr:
    """Change of current from the rising to the falling branch at one position, (40)."""
    position, slope, rising, falling = symbols("y k_m b_1 b_2")
    return sp.collect(sp.expand((position - rising) / slope - (position - falling) / slope), 1 / slope)
