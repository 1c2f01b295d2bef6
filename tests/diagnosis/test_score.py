"""What a sample tells of an error, read finely or in coarse steps."""

import math
from dataclasses import replace

import numpy as np
import pytest

from diagnosis.score import squares_of
from identification.experiment import Experiment, Simulated

NOISE, STEP = 1e-4, 4e-3


def read(off: float, noise: float, step: float, *, reach: float = math.inf) -> tuple[Experiment, Simulated]:
    """A stem on its way through many steps, and a model that is off by so much."""
    count = 200_000
    time = 0.02 * np.arange(count)
    true = np.linspace(0.012, 0.092, count)
    seen = true + noise * np.random.default_rng(3).standard_normal(count)
    position = step * np.round(seen / step) if step else seen
    experiment = Experiment("made", time, time, position, None, NOISE, 0.0, np.zeros(count, int), reach=reach)
    return experiment, Simulated(np.zeros((1, count)), time, time, step, (true + off)[None, :])


@pytest.mark.parametrize("off", [0.0, 0.3, 2.0, 9.0])
def test_coarse_and_fine_readings_tell_of_the_same_error(off):
    for step in (0.0, STEP):
        mean = squares_of(*read(off * NOISE, NOISE, step)).mean()
        assert mean == pytest.approx(off**2 + 1.0, rel=0.05)


@pytest.mark.parametrize("steps", [1.0, 2.0, 3.0])
def test_an_error_of_whole_steps_counts_as_much(steps):
    assert squares_of(*read(steps * STEP, 0.0, STEP)).mean() == pytest.approx((steps * STEP / NOISE) ** 2, rel=0.05)


def test_all_stays_on_a_coarse_step_count_alike_a_flicker_between_two_of_them_and_gaps_ending_none():
    """A rest beside an edge tells no more than a crossing of it."""
    levels = np.repeat([3, 4, 5, 3], [40, 400, 20, 4])
    levels[38] = 4
    levels[[200, 201, 230]] = 3
    position = np.where(np.arange(464) == 300, np.nan, STEP * levels)
    time = 0.02 * np.arange(464)
    worth = Experiment("made", time, time, position, None, NOISE, 0.0, np.zeros(464, int)).worth_in_steps(STEP)
    assert worth.mean() == pytest.approx(1.0)
    stays = [worth[:38], worth[38:440], worth[440:460], worth[460:]]
    assert [stay.sum() / worth.sum() for stay in stays] == pytest.approx([10 / 34, 10 / 34, 10 / 34, 4 / 34])
    assert all(np.ptp(stay) < 1e-12 for stay in stays)


def test_in_a_record_with_stairs_large_ones_count_by_their_logarithm():
    plain, tempered = (read(STEP, 0.0, STEP, reach=reach) for reach in (math.inf, 4.0))
    worth = plain[0].worth_in_steps(STEP)
    assert squares_of(*tempered) / worth == pytest.approx(16.0 * np.log1p(squares_of(*plain) / worth / 16.0))
    fine = read(STEP, 0.0, 0.0, reach=4.0)
    assert squares_of(*fine) == pytest.approx(fine[0].errors_of(fine[1])[0] ** 2)
    assert squares_of(replace(fine[0], reach=math.inf), fine[1]).mean() == pytest.approx((STEP / NOISE) ** 2)
