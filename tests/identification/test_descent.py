"""A search that is followed to its end goes on beyond its points as long as the error falls."""

import numpy as np
import pytest

from identification.search import END_EVALUATIONS, END_PRECISION, descend, descend_to_end


class BentValley:
    """Residuals of a narrow valley that bends again and again (Rosenbrock 1960, chained), least at ones."""

    is_in_steps = has_series = False
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
    assert near.is_cut_short
    assert near.error > 1.0
    assert not ended.is_cut_short
    assert ended.point == pytest.approx(np.ones(6), abs=1e-6)
