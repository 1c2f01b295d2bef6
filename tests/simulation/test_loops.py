"""Settled loops agree with the exact simulator held for long, and with the play operator."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from valvemodel.errors import InputError
from valvemodel.loops import SETTLING_EFFECTS, settle_loop, shape_of_loop
from valvemodel.model import Model
from valvemodel.simulation import simulate
from valvemodel.valves import read_valve

MILLIAMPERE = 1e-3
RAMP_STEP = 0.05  # s; a stem that slides on does not come to rest within it
HOLD = 5.0  # s; more than 400 time constants of the overdamped stem


def calibrated(**changes: float) -> Model:
    valve = read_valve("calibrated")
    return Model(valve.name, valve.values).with_values(**changes)


def sweep_with_minor_loops() -> np.ndarray:
    """Up and down as in the paper's Fig. 7, then minor loops of uneven steps. [A]"""
    parts = [(4.0, 18.01, 0.5), (17.5, 3.99, -0.5), (4.5, 12.0, 0.5), (12.0, 7.0, -0.7), (7.0, 20.0, 1.3)]
    return np.concatenate([np.arange(*part) for part in parts]) * MILLIAMPERE


def held(model: Model, current: np.ndarray, start_position: float = np.nan) -> np.ndarray:
    time = HOLD * np.arange(len(current) + 1)
    run = simulate(model, time=time, current=np.append(current, current[-1]), start_position=start_position)
    return run.position[1:]


def ramped(model: Model, current: np.ndarray, duration: float) -> np.ndarray:
    """The exact simulator under ramps of so many seconds, each followed by a hold; read at the end of the holds."""
    time, drive, ends = [0.0], [current[0]], []
    clock = HOLD
    for before, after in pairwise(current):
        count = round(duration / RAMP_STEP)
        steps = np.arange(count) / count
        time += list(clock + duration * steps)
        drive += list(before + (after - before) * (steps + 1.0 / count))
        clock += duration + HOLD
        ends.append(len(time))
        time.append(clock - 1e-3)
        drive.append(after)
    return simulate(model, time=np.array(time), current=np.array(drive)).position[ends]


STATIC = {"static_friction": {"static_friction_ratio": 1.3}}
CASES = {
    "base": (calibrated(), {}),
    "half critical damping": (calibrated(viscous_friction=267.0), {}),
    "ringing": (calibrated(viscous_friction=1.59), {}),
    "static friction": (calibrated(), STATIC),
    "static friction, ringing": (calibrated(viscous_friction=30.0), STATIC),
    "limited travel": (calibrated(travel_max=0.15, travel_min=0.03, viscous_friction=1.59), {}),
}


@pytest.mark.parametrize("case", CASES)
def test_stepped_loop_is_the_simulator_held_for_long(case: str) -> None:
    base, effects = CASES[case]
    model = Model("loop", base.values, effects)
    current = sweep_with_minor_loops()
    np.testing.assert_allclose(settle_loop(model, current=current), held(model, current), atol=2e-8)
    start = 0.02
    settled = settle_loop(model, current=current, start_position=start)
    np.testing.assert_allclose(settled, held(model, current, start), atol=2e-8)


@pytest.mark.parametrize("key", sorted(SETTLING_EFFECTS))
def test_every_settling_effect_is_the_simulator_held_for_long(key: str) -> None:
    model = calibrated().with_effect(key)
    current = sweep_with_minor_loops()
    settled = settle_loop(model, current=current)
    np.testing.assert_allclose(settled, held(model, current), atol=2e-8)
    if key != "static_friction":
        assert np.abs(settled - settle_loop(calibrated(), current=current)).max() > 1e-5


def test_ramped_loop_without_static_friction_is_the_play_operator() -> None:
    model = calibrated(viscous_friction=1.59)
    current = sweep_with_minor_loops()
    values = model.values
    gap = values["gap_offset"] - values["gap_gain"] * np.sqrt(current)
    pressure = values["supply_pressure"] / (1.0 + values["flow_ratio"] * gap**2)
    middle = values["diaphragm_area"] * pressure / values["spring_rate"]
    reach = values["coulomb_friction"] / values["spring_rate"]
    expected = [middle[0]]
    for centre in middle[1:]:
        expected.append(min(max(expected[-1], centre - reach), centre + reach))
    settled = settle_loop(model, current=current, is_ramped=True)
    np.testing.assert_allclose(settled, expected, rtol=1e-13)


@pytest.mark.parametrize("viscous_friction", [612.9, 30.0])
def test_ramped_loop_is_the_limit_of_slow_ramps(viscous_friction: float) -> None:
    model = calibrated(viscous_friction=viscous_friction).with_effect("static_friction", static_friction_ratio=1.3)
    current = sweep_with_minor_loops()[:34]
    settled = settle_loop(model, current=current, is_ramped=True)[1:]
    missed = [np.abs(ramped(model, current, duration) - settled).max() for duration in (10.0, 100.0)]
    assert missed[1] < max(0.3 * missed[0], 1e-8)
    assert missed[1] < 2e-4


def test_damping_shows_in_a_stepped_loop_only_below_the_critical() -> None:
    current = sweep_with_minor_loops()
    over, more = (settle_loop(calibrated(viscous_friction=each), current=current) for each in (700.0, 1400.0))
    np.testing.assert_array_equal(over, more)
    under, less = (settle_loop(calibrated(viscous_friction=each), current=current) for each in (150.0, 100.0))
    assert np.abs(under - less).max() > 1e-3


def test_shape_is_that_of_the_branches() -> None:
    model = calibrated()
    shape = shape_of_loop(model, position=0.1, highest_current=0.025)
    current = np.concatenate([np.linspace(4.0, 20.0, 3000), np.linspace(20.0, 4.0, 3000)]) * MILLIAMPERE
    position = settle_loop(model, current=current)
    up = np.interp(0.1, position[:3000], current[:3000])
    down = np.interp(0.1, position[:2999:-1], current[:2999:-1])
    assert shape.width == pytest.approx(up - down, rel=1e-4)
    assert shape.height == pytest.approx(2.0 * 1423.0 / 52500.0, rel=1e-9)
    rates = [np.interp(each, current[:3000], np.gradient(position[:3000], current[:3000])) for each in (up,)]
    rates += [np.interp(down, current[:2999:-1], np.gradient(position[:2999:-1], current[:2999:-1]))]
    assert shape.slope == pytest.approx(np.mean(rates), rel=1e-3)


def test_effects_without_a_closed_form_are_refused() -> None:
    with pytest.raises(InputError, match="stribeck"):
        settle_loop(calibrated().with_effect("stribeck"), current=np.array([4e-3, 5e-3]))
    with pytest.raises(InputError, match="currents"):
        settle_loop(calibrated(), current=np.array([4e-3, -5e-3]))
