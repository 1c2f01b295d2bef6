"""Runs that are worth nothing any more end early, and change no search."""

import numpy as np
import pytest

from identification.experiment import experiment_of, score_rows
from identification.search import roam_over
from valvemodel.model import Model
from valvemodel.records import Record
from valvemodel.runs import FREE
from valvemodel.valves import read_valve

ROWS = 9


def experiment():
    instants = np.arange(400) / 50.0
    current = 0.012 + 0.006 * np.sin(1.5 * instants)
    reading = 0.1 + 0.05 * np.sin(1.5 * instants - 0.4) + 1e-4 * np.cos(977.0 * instants)
    return experiment_of(Record("a swing", current=current, position=reading, time=instants))


def rows_of(key: str | None) -> np.ndarray:
    valve = read_valve("calibrated")
    model = Model(valve.name, valve.values)
    rows = (model.with_effect(key) if key else model).rows(ROWS)
    rows["coulomb_friction"] *= np.linspace(0.5, 1.5, ROWS)
    return rows


@pytest.mark.parametrize("is_anchored", [True, False])
@pytest.mark.parametrize("key", [None, "stribeck", "sensor_drift", "presliding", "sensor_lag"])
def test_a_run_that_comes_to_more_than_it_may_ends_and_no_other_changes(key, is_anchored):
    seen = experiment()
    used, anchors = np.isfinite(seen.position), seen.anchors if is_anchored else FREE

    def sums(most: np.ndarray | float = np.inf) -> np.ndarray:
        return score_rows(seen, used, rows_of(key), tolerance=1e-5, anchors=anchors, most=most)

    whole = sums()
    middle = float(np.median(whole))
    short = sums(middle)
    is_more = whole > middle
    assert 0 < is_more.sum() < ROWS
    assert np.array_equal(short[~is_more], whole[~is_more])
    # Runs that go through the chain stage by stage are quicker than the question.
    assert np.all(np.isinf(short[is_more]) | (short[is_more] == whole[is_more]))
    if is_anchored:
        assert np.isinf(short[is_more]).all()
    assert np.array_equal(sums(2.0 * whole), whole)


def test_a_search_finds_the_same_where_worse_points_are_not_looked_at_closely():
    ended = []

    def ripples(points: np.ndarray, most: np.ndarray) -> np.ndarray:
        return np.sum((points - 0.3) ** 2 + 0.05 * (1.0 - np.cos(40.0 * (points - 0.3))), axis=1)

    def shortened(points: np.ndarray, most: np.ndarray) -> np.ndarray:
        found = ripples(points, most)
        ended.append(int((found > most).sum()))
        return np.where(found > most, np.inf, found)

    box = [(-1.0, 1.0)] * 3
    whole, short = (roam_over(each, box, size=8, generations=30) for each in (ripples, shortened))
    assert np.array_equal(whole[0], short[0])
    assert whole[1] == short[1]
    assert sum(ended) > 100
