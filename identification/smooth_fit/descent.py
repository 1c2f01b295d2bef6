"""Descents on the smooth residuals: Gauss and Newton's in a trust region, from wide smoothing to narrow."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from identification.problem import Problem
from identification.search import Found
from identification.smooth_fit.residuals import SmoothResiduals
from identification.smooth_fit.shooting import ShootingProgram

WIDTHS = (100.0, 10.0, 1.0)
"""Smoothing widths from wide to narrow; the last is within a sixth of the usual noise of the exact valve. [N]"""

EVALUATIONS, PRECISION = 30, 1e-6


def descend_smooth(
    residuals: SmoothResiduals,
    start: np.ndarray,
    width: float,
    *,
    evaluations: int = EVALUATIONS,
    precision: float = PRECISION,
) -> Found:
    """Follow the residuals down at a width from a scaled start (trust-region reflective, scipy)."""
    from scipy.optimize import least_squares

    low, high = residuals.problem.bounds
    result = least_squares(
        lambda point: residuals.residuals(point, width),
        np.clip(start, low + 1e-9, high - 1e-9),
        jac=lambda point, *_: residuals.jacobian(point, width),
        bounds=(low, high),
        max_nfev=evaluations,
        ftol=precision,
        xtol=1e-7,
        gtol=1e-12,
        x_scale="jac",
    )
    return Found(result.x, float(result.cost))


def narrowed(residuals: SmoothResiduals, start: np.ndarray, widths: Sequence[float]) -> Iterator[tuple[float, Found]]:
    """Yield what is found at each width, beginning at the last one's point."""
    point = start
    for width in widths:
        found = descend_smooth(residuals, point, width)
        point = found.point
        yield width, found


def narrowed_by_shooting(problem: Problem, start: np.ndarray, widths: Sequence[float]) -> Iterator[tuple[float, Found]]:
    """Yield the same by multiple shooting: it needs no guess, and ten times as long."""
    program = ShootingProgram(problem)
    point, nodes = start, None
    for width in widths:
        found, nodes = program.solve(point, width, nodes)
        point = found.point
        yield width, found
