"""A first guess of the static numbers, read off the record: it makes the fit nearly independent of where it starts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from identification.problem import Problem

SPRING_GRID = np.exp(np.linspace(-2.4, 2.4, 97))
"""Spring rates that are tried, over the model's."""

MOST_SAMPLES = 4000
"""The static map has three numbers: so many samples determine them."""

LEAST_SHARE, MOST_SHARE = 0.02, 0.98
"""Shares of the supply within which a sample is used: beyond, its gap is badly determined."""

BAND_QUANTILE = 0.9
"""Quantile of the force left over that is taken for the Coulomb friction."""


def guessed(problem: Problem) -> np.ndarray:
    """Return the scaled point of a problem with spring rate, gap and Coulomb friction guessed from its readings.

    The spring force is half-way between the branches where the pressure force is, so that for each spring rate the gap
    follows from the readings, and c0 - E sqrt(i) is a straight line through them; the best spring rate is taken.
    """
    values, model = {}, problem.model.values
    current, position = _samples(problem)
    full = model["diaphragm_area"] * model["supply_pressure"]
    best = np.inf
    for spring in model["spring_rate"] * SPRING_GRID:
        force = spring * position + model["spring_preload"]
        pressure_force, gap = _fitted_force(problem, current, force / full)
        error = float(np.mean((pressure_force - force) ** 2)) / spring**2
        if error < best:
            best = error
            band = float(np.quantile(np.abs(pressure_force - force), BAND_QUANTILE))
            values = {"spring_rate": float(spring), "coulomb_friction": band, **gap}
    return np.array([
        unknown.scaled(values[unknown.name]) if unknown.name in values else 0.0 for unknown in problem.unknowns
    ])  # fmt: skip


def _samples(problem: Problem) -> tuple[np.ndarray, np.ndarray]:
    pairs = zip(problem.experiments, problem.used, strict=True)
    current, position = (np.concatenate(each) for each in _columns([(e.current[u], e.position[u]) for e, u in pairs]))
    every = max(len(current) // MOST_SAMPLES, 1)
    return current[::every], position[::every]


def _columns(pairs: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[list[np.ndarray], list[np.ndarray]]:
    return [first for first, _ in pairs], [second for _, second in pairs]


def _fitted_force(problem: Problem, current: np.ndarray, share: np.ndarray) -> tuple[np.ndarray, dict[str, float]]:
    """Return the pressure force of the straight gap line that fits shares of the supply best, and its numbers."""
    model = problem.model.values
    if model["pressure_per_current"] > 0.0:
        pressure = model["pressure_at_zero_current"] + model["pressure_per_current"] * current
        return model["diaphragm_area"] * pressure, {}
    inside = (share > LEAST_SHARE) & (share < MOST_SHARE)
    if inside.sum() < 3:
        return np.full(len(share), np.inf), {}
    gap = np.sqrt((1.0 / share[inside] - 1.0) / model["flow_ratio"])
    weight = 2.0 * model["flow_ratio"] * gap * share[inside] ** 2
    root = np.sqrt(current)
    line = np.column_stack([np.ones(inside.sum()), -root[inside]])
    offset, gain = np.linalg.lstsq(line * weight[:, None], gap * weight, rcond=None)[0]
    if min(offset, gain) <= 0.0:
        return np.full(len(share), np.inf), {}
    fitted = 1.0 / (1.0 + model["flow_ratio"] * (offset - gain * root) ** 2)
    force = model["diaphragm_area"] * model["supply_pressure"] * fitted
    return force, {"gap_offset": float(offset), "gap_gain": float(gain)}
