"""A search that is followed to its end goes on beyond its points as long as the error falls."""

import numpy as np
import pytest

from identification.search import END_EVALUATIONS, END_PRECISION, Slopes, descend, descend_to_end


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
