"""Runs spread over cores are those of one core to the bit; threads take the cores on which no process is at work."""

from multiprocessing import get_context

import numpy as np
import pytest

from identification.cores import _left_over, begun, in_parts, workers
from identification.experiment import Experiment, experiment_of, score_rows, simulate_rows
from identification.problem import SEARCH_TOLERANCE
from valvemodel.model import Model
from valvemodel.records import Record
from valvemodel.stages import EFFECTS
from valvemodel.valves import read_valve

ROWS = 13
KNOWN = {"load_force": {"load_sine": 200.0, "load_period": 5.0}, "end_stop": {"upper_stop": 0.19}}


def experiment() -> Experiment:
    instants = np.arange(400) / 50.0
    current = 0.012 + 0.006 * np.sin(1.5 * instants)
    reading = 0.1 + 0.05 * np.sin(1.5 * instants - 0.4) + 1e-4 * np.cos(977.0 * instants)
    return experiment_of(Record("a swing", current=current, position=reading, time=instants))


def rows_of(key: str) -> np.ndarray:
    valve = read_valve("calibrated")
    rows = Model(valve.name, valve.values).with_effect(key, **KNOWN.get(key, {})).rows(ROWS)
    rows["coulomb_friction"] *= np.linspace(0.5, 1.5, ROWS)
    # Rows that share their pressure lie among each other.
    rows["gap_gain"] *= 1.0 + 1e-3 * (np.arange(ROWS) % 5)
    return rows


@pytest.mark.parametrize("key", [effect.key for effect in EFFECTS])
def test_rows_run_alike_on_one_core_and_on_several(key):
    seen, anchors = experiment(), experiment().anchors
    used = np.isfinite(seen.position)

    def runs() -> tuple[np.ndarray, ...]:
        free = simulate_rows(seen, rows_of(key), tolerance=SEARCH_TOLERANCE)
        put = simulate_rows(seen, rows_of(key), tolerance=SEARCH_TOLERANCE, anchors=anchors, with_pressure=True)
        return free.position, put.position, put.pressure, score_rows(seen, used, rows_of(key), tolerance=1e-5)

    alone = runs()
    with workers(3):
        beside = runs()
    assert np.ptp(alone[0], axis=0).max() > 1e-5
    for one, other in zip(alone, beside, strict=True):
        assert np.array_equal(one, other)


@pytest.mark.parametrize("count", [1, 2, 3, 7, 50])
@pytest.mark.parametrize("jobs", [1, 2, 5])
def test_each_row_is_done_once(count, jobs):
    done = np.zeros(count, int)

    def do(part: slice) -> None:
        done[part] += 1

    with workers(jobs):
        in_parts(do, count)
    assert (done == 1).all()


@pytest.mark.parametrize("jobs", [1, 2])
def test_what_is_begun_gives_its_answer(jobs):
    with workers(jobs) as pool:
        answers = [begun(pool, divmod, number, 3) for number in range(5)]
        assert [answer() for answer in answers] == [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1)]
        with pytest.raises(ZeroDivisionError):
            begun(pool, divmod, 1, 0)()


def test_what_fails_in_a_thread_is_heard():
    def fail(part: slice) -> None:
        raise ValueError(part)

    with workers(2), pytest.raises(ValueError, match="slice"):
        in_parts(fail, 4)


ALL_AT_WORK = get_context("fork").Barrier(4)


def left_over_beside_three() -> int:
    ALL_AT_WORK.wait(60.0)
    left_over = _left_over()
    ALL_AT_WORK.wait(60.0)
    return left_over


def test_threads_take_the_cores_that_no_process_is_at_work_on():
    assert _left_over() == 1
    with workers(4) as pool:
        assert pool is not None
        assert _left_over() == 4
        assert pool.submit(_left_over).result() == 4
        together = [pool.submit(left_over_beside_three) for _ in range(4)]
        assert [each.result() for each in together] == [1, 1, 1, 1]
        with pytest.raises(ZeroDivisionError):
            pool.submit(divmod, 1, 0).result()
        assert _left_over() == 4
    assert _left_over() == 1
