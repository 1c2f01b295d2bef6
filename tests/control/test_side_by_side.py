"""Work side by side keeps its order and stops where it is interrupted."""

import time

import pytest

from valvemodel.control.side_by_side import side_by_side


def test_results_come_in_order_with_their_share():
    shares = []
    assert side_by_side(lambda item, go_on: 2 * item, range(5), shares.append) == [0, 2, 4, 6, 8]
    assert shares == [0.2, 0.4, 0.6, 0.8, 1.0]


def test_an_interrupt_ends_the_work_under_way():
    ended = []

    def work(item, go_on):
        try:
            for _ in range(1000 if item else 1):
                go_on()
                time.sleep(0.01)
        finally:
            ended.append(item)

    def interrupt(share):
        raise KeyboardInterrupt

    began = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        side_by_side(work, range(6), interrupt)
    assert time.perf_counter() - began < 5.0
    assert 0 in ended
    assert len(ended) < 6
