"""Searches about a fit that is judged by the re-anchored run go from afar to near, and end no worse than they began."""

from types import SimpleNamespace

import numpy as np
import pytest

from identification import sharpening
from identification.search import Found


@pytest.mark.parametrize(
    ("errors", "rounds", "expected"),
    [([5.0, 7.0, 3.0], 3, 3.0), ([5.0, 0.9, 3.0], 2, 0.9), ([11.0, 12.0, 13.0], 3, 10.0)],
)
def test_each_round_begins_where_the_best_was_found_and_looks_nearer(monkeypatch, errors, rounds, expected):
    asked = []

    def searched(problem, centre, seed, *, widest, generations):
        asked.append((float(centre[0]), widest))
        return Found(np.array([errors[seed]]), errors[seed])

    monkeypatch.setattr(sharpening, "searched_about", searched)
    monkeypatch.setattr(sharpening, "descend", lambda problem, point: Found(point, 99.0))
    monkeypatch.setattr(sharpening, "finished", lambda problem, found: found)
    fit = SimpleNamespace(
        problem=SimpleNamespace(is_anchored=True, noise_error=1.0), found=Found(np.array([10.0]), 10.0)
    )
    assert sharpening.sharpened(fit).error == expected
    starts, widths = zip(*asked, strict=True)
    assert len(asked) == rounds
    assert list(widths) == sorted(widths, reverse=True)
    assert list(starts) == [min([10.0, *errors[:number]]) for number in range(rounds)]
