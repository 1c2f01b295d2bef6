"""Residuals of a problem against the same written out in numpy, and what a search sees of them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from identification.experiment import Experiment, simulate_rows
from identification.problem import LOST, SEARCH_TOLERANCE, Problem
from identification.search import Slopes, Turned
from identification.starting.joining import joined
from identification.unknowns import base_unknowns
from valvemodel import simulate
from valvemodel.effects import effect_of_key
from valvemodel.model import Model
from valvemodel.valves import read_valve

NOISE, PRESSURE_NOISE = 1e-4, 300.0


def experiment(
    valve: Model, seed: int, *, with_pressure: bool, reach: float = math.inf, in_steps: bool = False
) -> Experiment:
    generator, count = np.random.default_rng(seed), 400 + 50 * seed
    time = np.arange(count) / 50.0
    wave = np.sin(1.1 * time + seed)
    current = 0.012 + 0.004 * (np.sign(wave) if in_steps else wave)
    run = simulate(valve, time=time, current=current)
    position = run.position + NOISE * generator.standard_normal(count)
    position[generator.integers(0, count, 9)] = np.nan
    pressure = run.pressure + PRESSURE_NOISE * generator.standard_normal(count) if with_pressure else None
    block = np.zeros(count, int)
    return Experiment(
        "made", time, current, position, pressure, NOISE, PRESSURE_NOISE * with_pressure, block, reach=reach
    )


def problem_of(*experiments: Experiment, valve: Model) -> Problem:
    used = [np.isfinite(each.position) & (np.arange(len(each.time)) % 3 > 0) for each in experiments]
    return Problem(valve, list(experiments), base_unknowns(valve), used)


@pytest.fixture(scope="module")
def valve() -> Model:
    given = read_valve("calibrated")
    return Model(given.name, given.values)


def written_out(problem: Problem, points: np.ndarray) -> np.ndarray:
    parts = []
    for number, (each, used) in enumerate(zip(problem.experiments, problem.used, strict=True)):
        rows = problem.rows(points, number)
        run = simulate_rows(each, rows, tolerance=SEARCH_TOLERANCE, with_pressure=each.pressure is not None)
        error = (each.position - run.position) / each.noise
        if math.isfinite(each.reach):
            error = np.sign(error) * each.reach * np.sqrt(np.log1p((error / each.reach) ** 2))
        parts.append(error[:, used])
        if each.pressure is not None:
            parts.append(((each.pressure - run.pressure) / each.pressure_noise)[:, used])
    return np.concatenate([*parts, points / problem.prior_spreads], axis=1)


@pytest.mark.parametrize("reach", [math.inf, 4.0])
def test_residuals_stand_in_the_order_of_the_records(valve, reach):
    problem = problem_of(
        experiment(valve, 1, with_pressure=True, reach=reach), experiment(valve, 2, with_pressure=False), valve=valve
    )
    points = 0.05 * np.random.default_rng(0).standard_normal((3, len(problem.unknowns)))
    expected = written_out(problem, points)
    assert np.abs(expected).max() > 3.0
    assert problem.residuals(points) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_a_position_that_is_no_number_is_lost(valve):
    seen = experiment(valve, 1, with_pressure=True)
    problem = problem_of(seen, valve=valve)
    gone = np.flatnonzero(problem.used[0])[5]
    torn = replace(seen, position=seen.position.copy(), pressure=np.array(seen.pressure))
    torn.position[gone] = torn.pressure[gone] = np.nan
    before, after = (
        replace(problem, experiments=[each]).residuals(np.zeros((1, len(problem.unknowns))))[0] for each in (seen, torn)
    )
    assert sorted(np.flatnonzero(before != after)) == [5, 5 + problem.used[0].sum()]
    assert after[5] == LOST
    assert after[5 + problem.used[0].sum()] == 0.0, "a pressure that was not measured counts for nothing"


@pytest.mark.parametrize("renewed", [1, 3])
def test_turned_residuals_say_the_same_of_every_step(valve, renewed):
    problem = problem_of(experiment(valve, 1, with_pressure=True), valve=valve)
    plain, seen = (
        Slopes(lambda point: problem.residuals(point[None, :])[0], problem.jacobian, renewed) for _ in range(2)
    )
    turned, count = Turned(seen), len(problem.unknowns)
    for point in 0.1 * np.random.default_rng(0).standard_normal((4, count)):
        residual, slopes = plain.residuals(point), plain.jacobian(point)
        small, triangle = turned.residuals(point), turned.jacobian(point)
        assert small.shape == (count + 1,)
        assert small @ small == pytest.approx(residual @ residual)
        assert small @ triangle == pytest.approx(residual @ slopes, rel=1e-9, abs=1e-9 * np.abs(slopes).sum())
        assert triangle.T @ triangle == pytest.approx(slopes.T @ slopes, rel=1e-9)


def test_residuals_that_are_all_zero_can_be_turned():
    slopes = np.random.default_rng(0).standard_normal((20, 3))
    turned = Turned(Slopes(lambda point: np.zeros(20), lambda point, known: slopes, 1))
    assert not turned.residuals(np.ones(3)).any()
    triangle = turned.jacobian(np.ones(3))
    assert triangle.T @ triangle == pytest.approx(slopes.T @ slopes)


def test_fewer_residuals_than_unknowns_can_be_turned():
    slopes = np.random.default_rng(0).standard_normal((2, 3))
    turned = Turned(Slopes(lambda point: np.array([3.0, 4.0]), lambda point, known: slopes, 1))
    small, triangle = turned.residuals(np.ones(3)), turned.jacobian(np.ones(3))
    assert (small[0], triangle.shape) == (5.0, (4, 3))
    assert small @ triangle == pytest.approx(np.array([3.0, 4.0]) @ slopes)


@pytest.mark.parametrize("off", [np.nan, np.inf])
def test_errors_of_a_run_that_is_lost_stay_as_they_are(valve, off):
    seen = experiment(valve, 1, with_pressure=False)
    run = simulate_rows(seen, valve.rows(), tolerance=SEARCH_TOLERANCE)
    run.smooth[0, 40] = off
    errors = seen.errors_of(run)[0]
    assert not np.isfinite(errors[40])
    assert np.isnan(errors[40]) == np.isnan(off)
    assert (np.isnan(errors) == np.isnan(seen.position))[np.arange(len(errors)) != 40].all()


@pytest.mark.parametrize("delay", [0.0403, 0.0558])
def test_what_begins_on_its_bound_has_the_slope_just_off_it(valve, delay):
    """With a lag of a microsecond a run goes another way, and is off by a part of the tolerance: a slope by so small a
    step had been ten to a hundred times too steep, and a search that had come there stayed."""
    key, dispersion = "transport_delay", 0.06
    smeared = valve.with_effect(key, transport_delay=delay, line_dispersion=dispersion)
    problem, point = joined(
        problem_of(experiment(smeared, 1, with_pressure=False, in_steps=True), valve=valve),
        np.zeros(6),
        effect_of_key(key),
        {key: delay, "line_dispersion": 0.0},
    )
    lag = [unknown.name for unknown in problem.unknowns].index("line_dispersion")
    ahead = point.copy()
    ahead[lag] += 1e-3
    expected = np.diff(replace(problem, tolerance=1e-9).residuals(np.array([point, ahead])), axis=0)[0] / 1e-3
    assert np.linalg.norm(problem.jacobian(point)[:, lag] - expected) < 0.1 * np.linalg.norm(expected)
