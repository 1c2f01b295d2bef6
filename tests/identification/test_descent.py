"""A search that is followed to its end goes on beyond its points as long as the error falls."""

from dataclasses import replace

import numpy as np
import pytest
from blind_fits import base_of_plant

from identification.problem import DIFFERENCE, ROUGH_TOLERANCE, SEARCH_TOLERANCE, Problem
from identification.search import (
    END_EVALUATIONS,
    END_PRECISION,
    Slopes,
    descend,
    descend_roughly,
    descend_to_end,
    errors,
)
from identification.starting.joining import joined
from valvemodel.effects import effect_of_key


class BentValley:
    """Residuals of a narrow valley that bends again and again (Rosenbrock 1960, chained), least at ones."""

    is_in_steps = has_series = False
    is_smooth = True
    bounds = np.full(6, -5.0), np.full(6, 5.0)

    def residuals(self, points):
        bends = 100.0 * (points[:, 1:] - points[:, :-1] ** 2)
        return np.concatenate([bends, 1.0 - points[:, :-1]], axis=1)

    def jacobian(self, point, known):
        slopes = np.zeros((10, 6))
        rows = np.arange(5)
        slopes[rows, rows], slopes[rows, rows + 1] = -200.0 * point[:-1], 100.0
        slopes[5 + rows, rows] = -1.0
        return slopes


def test_a_search_goes_on_while_the_error_falls():
    start = np.full(6, -1.2)
    near = descend(BentValley(), start, evaluations=END_EVALUATIONS, precision=END_PRECISION)
    ended = descend_to_end(BentValley(), start)
    assert near.may_go_on
    assert near.error > 1.0
    assert not ended.may_go_on
    assert ended.point == pytest.approx(np.ones(6), abs=1e-6)


@pytest.mark.parametrize(("is_smooth", "has_series", "most"), [(True, False, 3), (False, False, 1), (True, True, 8)])
def test_a_derivative_serves_on_some_points_where_the_error_is_smooth(monkeypatch, is_smooth, has_series, most):
    asked, taken = [], []
    monkeypatch.setattr(BentValley, "is_smooth", is_smooth)
    monkeypatch.setattr(BentValley, "has_series", has_series)
    derivative = BentValley.jacobian
    monkeypatch.setattr(BentValley, "jacobian", lambda *given: taken.append(given) or derivative(*given))
    monkeypatch.setattr(Slopes, "jacobian", lambda *given, ask=Slopes.jacobian: asked.append(given) or ask(*given))
    ended = descend_to_end(BentValley(), np.full(6, 0.9))
    assert ended.point == pytest.approx(np.ones(6), abs=1e-4)
    assert not ended.may_go_on or has_series
    assert len(asked) / most <= len(taken) < len(asked) / most + 4


def test_rough_runs_lead_where_finer_ones_do_and_the_error_is_that_of_the_problem(monkeypatch):
    _, base = base_of_plant(9302, ("sensor_lag",))
    lag = effect_of_key("sensor_lag")
    problem, start = joined(base.problem, base.found.point, lag, {**lag.typical, "sensor_time_constant": 0.1})
    finer = descend(problem, start, evaluations=6, precision=1e-3, renewed=3)
    tolerances = []
    residuals = Problem.residuals
    monkeypatch.setattr(
        Problem, "residuals", lambda self, points: tolerances.append(self.tolerance) or residuals(self, points)
    )
    found = descend_roughly(problem, start, evaluations=6)
    assert set(tolerances) == {problem.rough_tolerance}
    assert problem.tolerance < problem.rough_tolerance
    assert found.error == float(errors(problem, found.point[None, :])[0])
    assert found.error == pytest.approx(finer.error, rel=0.05)
    assert found.error < 0.5 * base.found.error


@pytest.mark.parametrize(("tolerance", "factor"), [(1e-7, 1.0), (SEARCH_TOLERANCE, 1.0), (ROUGH_TOLERANCE, 10.0)])
def test_differences_are_as_much_wider_as_runs_are_rougher(monkeypatch, tolerance, factor):
    _, base = base_of_plant(9302, ("sensor_lag",))
    problem, point = replace(base.problem, tolerance=tolerance), base.found.point
    asked = []
    residuals = Problem.residuals
    monkeypatch.setattr(Problem, "residuals", lambda self, points: asked.append(points) or residuals(self, points))
    problem.jacobian(point)
    assert np.abs(asked[-1] - point).max(axis=1) == pytest.approx(np.full(len(point), factor * DIFFERENCE))


@pytest.mark.parametrize(
    ("noise", "expected"), [(5e-4, ROUGH_TOLERANCE), (4e-5, 4e-5), (1e-6, SEARCH_TOLERANCE), (np.inf, ROUGH_TOLERANCE)]
)
def test_rough_runs_are_no_rougher_than_the_noise(noise, expected):
    _, base = base_of_plant(9302, ("sensor_lag",))
    (experiment,) = base.problem.experiments
    loud = replace(experiment, noise=5e-4)
    assert replace(base.problem, experiments=[loud, replace(experiment, noise=noise)]).rough_tolerance == expected
