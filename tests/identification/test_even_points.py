"""Points that fill a box evenly: where searches begin."""

import numpy as np
import pytest

from identification.search import spread_evenly

BOUNDS = np.array([[-1.0, 2.0, 0.0], [1.0, 5.0, 1e-3]])


def test_points_lie_in_the_box_and_depend_on_the_seed_alone():
    points = spread_evenly(128, BOUNDS, np.random.default_rng(3))
    assert points.shape == (128, 3)
    assert (points >= BOUNDS[0]).all()
    assert (points <= BOUNDS[1]).all()
    assert np.array_equal(points, spread_evenly(128, BOUNDS, np.random.default_rng(3)))
    assert not np.allclose(points, spread_evenly(128, BOUNDS, np.random.default_rng(4)))


@pytest.mark.parametrize("dimensions", [2, 5, 9])
def test_points_are_more_even_than_random_ones(dimensions):
    from scipy.stats import qmc

    bounds = np.array([np.zeros(dimensions), np.ones(dimensions)])
    even = [qmc.discrepancy(spread_evenly(256, bounds, np.random.default_rng(seed))) for seed in range(5)]
    random = [qmc.discrepancy(np.random.default_rng(seed).random((256, dimensions))) for seed in range(5)]
    assert np.mean(even) < 0.8 * np.mean(random)
