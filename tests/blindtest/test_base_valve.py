"""The fine-step base valve against closed forms."""

import numpy as np
import pytest

from diagnosis.blindtest.chain.nozzle import static_pressure
from diagnosis.blindtest.valve import integrate


def pressure_at(base, current):
    gap = np.array(base["gap_offset"] - base["gap_gain"] * np.sqrt(current))
    return float(static_pressure(gap, base))


def test_nominal_range_is_that_of_the_converter(base):
    assert pressure_at(base, 4e-3) == pytest.approx(40e3, rel=0.01)
    assert pressure_at(base, 20e-3) == pytest.approx(210e3, rel=0.01)


def test_step_settles_at_the_edge_of_the_dead_band(base):
    time = np.arange(100) / 50.0
    current = np.where(time < 0.5, 8e-3, 14e-3)
    final = integrate(base, time, current)["position"][-1]
    force = base["diaphragm_area"] * pressure_at(base, 14e-3)
    assert final == pytest.approx((force - base["coulomb_friction"]) / base["spring_rate"], abs=1e-8)


def test_dead_band_is_twice_the_friction_over_the_spring(base):
    time = np.arange(300) / 50.0
    current = np.select([time < 2, time < 4], [8e-3, 14e-3], 5e-3)
    position = integrate(base, time, current)["position"]
    area, rate = base["diaphragm_area"], base["spring_rate"]
    without_friction = area * (pressure_at(base, 14e-3) - pressure_at(base, 5e-3)) / rate
    band = without_friction - (position[199] - position[-1])
    assert band == pytest.approx(2 * base["coulomb_friction"] / rate, abs=1e-8)


def test_slip_follows_the_overdamped_closed_form(base):
    time = np.arange(60) / 50.0
    current = np.where(time < 0.1, 8e-3, 14e-3)
    position = integrate(base, time, current, step=2e-6)["position"]
    mass, rate, damping = base["stem_mass"], base["spring_rate"], base["viscous_friction"]
    root = np.sqrt(damping**2 - 4 * mass * rate)
    fast, slow = (-damping - root) / (2 * mass), (-damping + root) / (2 * mass)
    area = base["diaphragm_area"]
    target = (area * pressure_at(base, 14e-3) - base["coulomb_friction"]) / rate
    since = np.maximum(time - 0.1, 0.0)
    share = (slow * np.exp(fast * since) - fast * np.exp(slow * since)) / (slow - fast)
    expected = target + (position[0] - target) * share
    assert np.abs(position - expected).max() < 1e-9


def test_it_starts_in_the_middle_of_the_stuck_band_and_stays(base):
    time = np.arange(50) / 50.0
    out = integrate(base, time, np.full(50, 10e-3))
    middle = base["diaphragm_area"] * pressure_at(base, 10e-3) / base["spring_rate"]
    assert np.ptp(out["position"]) == 0
    assert out["position"][0] == pytest.approx(middle, abs=1e-9)


def test_error_falls_with_the_square_of_the_step(base, ramps):
    fine = integrate(base, *ramps, step=2e-6)["position"]
    coarse, half = (np.abs(integrate(base, *ramps, step=h)["position"] - fine).max() for h in (1e-4, 5e-5))
    assert coarse < 2e-6
    assert coarse / half == pytest.approx(4.0, rel=0.15)


def test_row_shows_the_state_before_the_input_acts(base):
    time = np.arange(100) / 50.0
    current = np.where(np.arange(100) < 50, 8e-3, 16e-3)
    out = integrate(base, time, current)
    assert out["pressure"][50] == out["pressure"][0]
    assert out["pressure"][51] > out["pressure"][50]
    assert out["position"][50] == out["position"][0]
    assert out["position"][51] > out["position"][50]


def test_travel_stops_of_the_base_valve_hold(base, ramps):
    limited = {**base, "travel_min": 0.09, "travel_max": 0.12}
    position = integrate(limited, *ramps)["position"]
    assert position.max() == 0.12
    assert position.min() >= 0.09


def test_time_must_be_uniform(base):
    with pytest.raises(ValueError, match="uniformly"):
        integrate(base, np.array([0.0, 0.02, 0.05]), np.full(3, 8e-3))
