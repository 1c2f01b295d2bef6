"""A tight spot is found wherever it lies; what takes long is not followed where nothing speaks for it."""

import numpy as np
import pytest
from blind_fits import base_of_plant, fits_to_plant

from identification.extending.extension import Extension, extend
from identification.search import LOOKED, roam_over
from identification.starting.screening import placed, screened
from valvemodel.effects import effect_of_key

KEY = "position_dependent_friction"


@pytest.mark.parametrize("seed", [9300, 9311, 9324, 9330])
def test_a_tight_spot_is_found_whether_a_start_leads_to_it_or_not(seed):
    _, _, found = fits_to_plant(seed, KEY)
    assert found.found.error < 1.05 * found.problem.noise_error


@pytest.mark.parametrize(("seed", "is_lost"), [(9300, False), (9324, True), (9330, True)])
def test_starts_alone_may_lose_a_tight_spot(seed, is_lost):
    _, base = base_of_plant(seed, (KEY,))
    assert (extend(base, KEY, Extension(is_global=False)).found.error > 10.0 * base.problem.noise_error) == is_lost


@pytest.mark.parametrize("seed", [9300, 9311])
def test_a_tight_spot_is_found_where_it_is_as_high_and_as_wide(seed):
    plant, _, found = fits_to_plant(seed, KEY)
    values, truth = found.model.effects[KEY], plant.effects[0].parameters
    assert values["tight_spot_position"] == pytest.approx(truth["centre"], abs=5e-4)
    assert values["tight_spot_excess"] == pytest.approx(truth["height"], rel=0.02)
    # The blind plant's width is a standard deviation.
    assert values["tight_spot_width"] == pytest.approx(np.sqrt(2.0) * truth["width"], rel=0.02)


def test_the_start_searched_for_promises_more_than_any_at_hand():
    _, base = base_of_plant(9311, (KEY,))
    trials = screened(base, effect_of_key(KEY))
    start = placed(base, effect_of_key(KEY), trials)
    left = [2.0 * base.found.error - each.gain for each in (start, trials[0])]
    assert left[0] < 0.8 * left[1]


def test_bristles_are_not_followed_where_they_promise_nothing():
    _, base = base_of_plant(9306, (KEY,))
    found = extend(base, "presliding")
    assert found.found.error == base.found.error
    assert found.model.effects["presliding"]["presliding_compliance"] == 0.0


def test_what_promises_less_than_is_asked_is_not_followed():
    _, base, found = fits_to_plant(9306, "sensor_drift")
    promised = screened(base, effect_of_key("sensor_drift"))[0].gain / (2.0 * base.found.error)
    assert promised > 0.0
    followed = extend(base, "sensor_drift", Extension(promise=0.99 * promised))
    assert followed.found.error == pytest.approx(found.found.error)
    idle = extend(base, "sensor_drift", Extension(promise=1.01 * promised))
    assert idle.found.error == base.found.error > found.found.error
    assert idle.model.effects["sensor_drift"]["sensor_drift_rate"] == 0.0


def test_a_search_over_a_box_finds_the_least_of_many_minima():
    def ripples(points: np.ndarray, _: np.ndarray) -> np.ndarray:
        return np.sum((points - 0.3) ** 2 + 0.05 * (1.0 - np.cos(40.0 * (points - 0.3))), axis=1)

    point, error = roam_over(ripples, [(-1.0, 1.0)] * 2, size=16, generations=80)
    assert np.abs(point - 0.3).max() < 0.02
    assert error == pytest.approx(ripples(point[None, :], np.inf)[0])


def test_a_search_ends_early_where_it_has_not_come_down_far_enough():
    asked: list[int] = []

    def hill(points: np.ndarray, _: np.ndarray) -> np.ndarray:
        asked.append(len(points))
        return np.sum(points**2, axis=1)

    def generations(promising: float) -> int:
        asked.clear()
        roam_over(hill, [(-1.0, 1.0)] * 5, size=2, generations=40, promising=promising)
        return len(asked) - 1

    assert generations(0.0) == LOOKED
    assert generations(1.0) == 40
