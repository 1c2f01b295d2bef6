"""Bias of the self-calibration, eqs. (35)-(40): noise, curvature, and an unlucky choice of points."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.identification.loops import CURRENT, UP, settled, true_shape

NOISES = (0.0, 0.001, 0.005, 0.02)
"""Noise of a reading over the range of the loop."""

DRAWS = 300

POINTS = {
    "far from the reversals": ((13.0, 14.0, 15.0), (9.0, 8.0, 7.0)),
    "wide apart": ((11.0, 14.0, 17.0), (12.0, 9.0, 6.0)),
    "close together": ((14.0, 14.5, 15.0), (8.5, 8.0, 7.5)),
    "first point in the dead band": ((13.0, 14.0, 15.0), (16.0, 9.0, 7.0)),
    "at the ends": ((7.0, 12.0, 17.5), (13.0, 8.0, 5.0)),
}
"""Currents of the points, rising and falling. [mA]"""

VALVES = {"straight": 0.0, "curved": 1.0}
"""Affine map from current to pressure, or that of eqs. (16), (31)."""


def bias_table() -> list[dict[str, Any]]:
    """Return a row for each valve, choice of points and noise: bias and scatter of the width, warnings."""
    from diagnosis.blindtest.valve import NOMINAL

    rows = []
    for valve in VALVES:
        base = dict(NOMINAL)
        position = settled(base) if valve == "curved" else straight_loop(base)
        for title, (rising, falling) in POINTS.items():
            rows += [row_of(base, valve, position, title, rising, falling, noise) for noise in NOISES]
    return rows


def row_of(
    base: dict[str, float],
    valve: str,
    position: np.ndarray,
    title: str,
    rising: tuple[float, ...],
    falling: tuple[float, ...],
    noise: float,
) -> dict[str, Any]:
    """Return mean, scatter and warnings of one choice of points over draws of the noise."""
    from identification.self_calibration import calibrate

    places = [np.searchsorted(UP, np.array(rising) - 1e-9), 2 * len(UP) - 2 - np.searchsorted(UP, np.array(falling))]
    spread = noise * float(np.ptp(position))
    middle = float(np.mean([position[place].mean() for place in places]))
    truth = true_width(base, valve, middle)
    generator = np.random.default_rng(0)
    widths, stated, warned = [], [], 0
    for _ in range(DRAWS if noise > 0.0 else 1):
        read = position + spread * generator.standard_normal(len(position))
        found = calibrate(
            rising_current=CURRENT[places[0]],
            rising_position=read[places[0]],
            falling_current=CURRENT[places[1]],
            falling_position=read[places[1]],
            noise=spread,
        )
        widths.append(found.width / truth - 1.0)
        stated.append(found.std / truth)
        warned += bool(found.warnings)
    return {
        "valve": valve,
        "points": title,
        "noise": noise,
        "true width": truth,
        "bias": float(np.mean(widths)),
        "scatter": float(np.std(widths)),
        "stated": float(np.mean(stated)),
        "warned": warned / len(widths),
    }


SLOPE = 170e3 / 16e-3
"""Of the straight valve: 4..20 mA gives 40..210 kPa. [Pa/A]"""


def straight_loop(base: dict[str, float]) -> np.ndarray:
    """Return the loop of a valve with straight branches: the play operator itself. [m]"""
    middle = base["diaphragm_area"] * (40e3 + SLOPE * (CURRENT - 4e-3)) / base["spring_rate"]
    reach = base["coulomb_friction"] / base["spring_rate"]
    position = [middle[0]]
    for centre in middle[1:]:
        position.append(min(max(position[-1], centre - reach), centre + reach))
    return np.array(position)


def true_width(base: dict[str, float], valve: str, position: float) -> float:
    """Return the width of the loop at a position. [A]"""
    if valve == "curved":
        return true_shape(base, position)["width"]
    return 2.0 * base["coulomb_friction"] / (base["diaphragm_area"] * SLOPE)
