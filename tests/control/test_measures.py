"""Measures on courses whose answer is known."""

import numpy as np
import pytest

from valvemodel.control.measures import (
    integral_absolute_error,
    limit_cycle,
    measures_of,
    overall,
    overshoot,
    reversals,
    settling_time,
    steady_error,
    travelled_distance,
    turning_points,
)

PERIOD = 0.01
TIME = PERIOD * np.arange(3000)


def test_first_order_step():
    position = 0.1 + 0.05 * (1.0 - np.exp(-TIME / 0.5))
    assert settling_time(position, 0.15, period=PERIOD, band=1e-3) == pytest.approx(0.5 * np.log(50.0), abs=PERIOD)
    assert overshoot(position, 0.15) < 1e-12
    assert integral_absolute_error(position, 0.15, period=PERIOD) == pytest.approx(0.05 * 0.5, rel=0.02)
    assert travelled_distance(position) == pytest.approx(0.05, rel=1e-6)
    assert reversals(position, least=1e-4) == 0
    assert limit_cycle(position, period=PERIOD, least=1e-4) == (0.0, float("inf"))


def test_second_order_step_overshoots_as_its_damping_says():
    damping, frequency = 0.3, 4.0
    damped = frequency * np.sqrt(1.0 - damping**2)
    swing = np.cos(damped * TIME) + damping * frequency / damped * np.sin(damped * TIME)
    position = 0.2 - 0.05 * (1.0 - np.exp(-damping * frequency * TIME) * swing)
    assert overshoot(position, 0.15) == pytest.approx(
        0.05 * np.exp(-np.pi * damping / np.sqrt(1.0 - damping**2)), rel=1e-3
    )
    peaks = 0.05 * np.exp(-np.pi * damping / np.sqrt(1.0 - damping**2) * np.arange(1, 20))
    assert reversals(position, least=1e-3) == np.count_nonzero(peaks[:-1] + peaks[1:] > 1e-3)
    assert limit_cycle(position, period=PERIOD, least=1e-4)[0] == 0.0, "what dies out is no limit cycle"


@pytest.mark.parametrize("shape", [np.sin, lambda angle: np.sign(np.sin(angle)), lambda angle: (angle / np.pi) % 1.0])
def test_limit_cycle_of_a_known_wave(shape):
    angle = 2.0 * np.pi * TIME / 2.5
    position = 0.1 + 0.004 * shape(angle)
    amplitude, period = limit_cycle(position, period=PERIOD, least=1e-3)
    swing = np.ptp(position)
    assert amplitude == pytest.approx(0.5 * swing, rel=0.02)
    expected = 1.25 if swing < 0.0045 else 2.5
    assert period == pytest.approx(expected, rel=0.02)


def test_noise_below_the_least_swing_neither_turns_nor_cycles():
    position = 0.1 + 1e-5 * np.random.default_rng(0).normal(size=3000)
    assert turning_points(position, least=2.5e-4) in ([0], [0, 2999]) or reversals(position, least=2.5e-4) == 0
    assert limit_cycle(position, period=PERIOD, least=2.5e-4) == (0.0, float("inf"))


def test_a_stem_that_rests_has_no_turning_points():
    assert reversals(np.full(50, 0.1), least=1e-4) == 0


def test_never_settled_is_infinite_and_settled_at_once_is_zero():
    assert settling_time(np.full(10, 0.2), 0.1, period=PERIOD, band=1e-3) == float("inf")
    assert settling_time(np.full(10, 0.1), 0.1, period=PERIOD, band=1e-3) == 0.0


def test_steady_error_is_signed_and_overall_takes_its_size():
    low = measures_of(np.full(100, 0.09), 0.1, period=PERIOD, rated_travel=0.25)
    near = measures_of(np.full(100, 0.1001), 0.1, period=PERIOD, rated_travel=0.25)
    assert low.steady_error == pytest.approx(0.01)
    assert steady_error(np.full(100, 0.1001), 0.1) == pytest.approx(-1e-4)
    both = overall([low, near])
    assert both["steady_error"] == pytest.approx(0.01)
    assert both["settled_share"] == 0.5
    assert both["settling_time"] == 0.0
    assert both["integral_absolute_error"] == pytest.approx(0.0101)
