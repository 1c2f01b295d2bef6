"""Limit cycles: the return map against closed forms and the exact simulator, the describing function held to it."""

import math

import numpy as np
import pytest

from valvemodel.errors import InputError
from valvemodel.linear import Loop, ReturnMap, describing_cycle
from valvemodel.linear.comparison import compare, errors_of
from valvemodel.linear.simulated import run_loop, simulated_cycle
from valvemodel.model import Model
from valvemodel.valves import read_valve

CURRENT = 12e-3


def loop_of(name="linear", *, ratio=1.5, proportional=0.0, integral=1.0, period=1e-3, **process) -> Loop:
    """A loop with its gains over the inverse static gain of the linear valve, 13.05 m/A."""
    valve = read_valve(name)
    effects = {"static_friction": {"static_friction_ratio": ratio}} if ratio > 1.0 else {}
    gain = 1.0 / 13.05
    return Loop(
        Model(valve.name, valve.values, effects),
        CURRENT,
        proportional * gain,
        integral * gain,
        period=period,
        **process,
    )


def test_integral_control_of_an_overdamped_stem_has_the_closed_form_s_period():
    loop = loop_of(integral=0.02)
    static, kinetic = loop.stickiness()
    closed = 4.0 * (static + kinetic) / (loop.integral * loop.slip_gain * (static - kinetic))
    cycle = ReturnMap(loop).cycle()
    assert cycle.period == pytest.approx(closed, rel=1e-3)
    assert cycle.amplitude == pytest.approx(0.5 * (static - kinetic), rel=1e-3)
    assert 0.99 < cycle.multiplier < 1.0
    # The square wave's harmonic balance: pi^2 / 8 of it.
    assert describing_cycle(loop).period == pytest.approx(math.pi**2 / 8.0 * closed, rel=2e-3)


@pytest.mark.parametrize(
    "loop",
    [
        loop_of(integral=3.0),
        loop_of("calibrated", ratio=1.2, integral=10.0),
        loop_of(proportional=1.0, integral=10.0, period=5e-4),
        loop_of("calibrated", ratio=1.2, proportional=2.5, integral=0.5, lag=5.0, dead_time=1.0, period=1e-2),
        loop_of(ratio=1.1, proportional=1.0, integral=0.3, lag=3.0, period=5e-3),
    ],
    ids=["integral", "integral on a bent map", "proportional and integral", "around lag and dead time", "around a lag"],
)
def test_return_map_is_within_one_percent_of_the_simulated_cycle(loop):
    errors = errors_of(compare(loop))["return_map"]
    assert abs(errors["period"]) < 0.01
    assert abs(errors["amplitude"]) < 0.01


@pytest.mark.parametrize("offset", [0.3, -0.4])
def test_simulator_follows_the_map_from_stop_to_stop(offset):
    loop = loop_of(integral=3.0, period=2e-4)
    mapping = ReturnMap(loop)
    section = mapping.start + offset * mapping.jump
    expected, length = [float(section[0])], 0.0
    for _ in range(3):
        turn = mapping.turn(section)
        section, length = turn.section, length + turn.duration
        expected.append(float(section[0]))
    start = mapping.states_at(mapping.start + offset * mapping.jump)
    positions = run_loop(loop, duration=1.1 * length, start=start)
    rests = positions[:-1][(np.abs(np.diff(positions)) < 1e-9) & (positions[:-1] < loop.setpoint)]
    stops = rests[np.flatnonzero(np.abs(np.diff(rests, prepend=-1.0)) > 1e-6)]
    assert np.abs(np.array(expected[1:]) - stops[: len(expected)][-3:]).max() < 0.01 * mapping.jump


def test_departures_die_out_as_the_multiplier_says():
    mapping = ReturnMap(loop_of(ratio=1.2, integral=10.0))
    cycle = mapping.cycle()
    fixed = cycle.states[[1]]
    departure = 0.02 * mapping.jump
    after = mapping.turn(fixed + departure).section - fixed
    assert abs(after[0] / departure) == pytest.approx(cycle.multiplier, rel=0.02)
    assert cycle.is_stable


def test_describing_function_misses_the_cycle_that_proportional_action_leaves():
    found = compare(loop_of(proportional=1.0, integral=10.0, period=5e-4))
    assert found["describing_function"] is None
    assert found["return_map"] is not None
    assert errors_of(found)["describing_function"]["verdict"] == "missed"


def test_without_a_slip_jump_nothing_cycles():
    found = compare(loop_of(ratio=1.0, proportional=0.5, integral=0.5, period=1e-2))
    assert found["return_map"] is None
    assert found["simulation"] is None


def test_period_of_the_controller_acts_as_half_of_it_in_dead_time():
    periods = {}
    for period in (1e-3, 4e-3):
        loop = loop_of(ratio=1.5, proportional=1.0, integral=10.0, period=period)
        mapped = ReturnMap(loop).cycle()
        simulated = simulated_cycle(loop, duration=12.0 * mapped.period, start=mapped.states)
        periods[period] = (mapped.period, simulated.period)
    shifts = [periods[4e-3][number] - periods[1e-3][number] for number in (0, 1)]
    assert shifts[0] == pytest.approx(shifts[1], rel=0.35)


def test_effects_with_a_memory_are_refused():
    valve = read_valve("linear")
    with pytest.raises(InputError, match="without memory"):
        ReturnMap(Loop(Model(valve.name, valve.values, {"coil_lag": {}}), CURRENT, 0.0, 0.1))


@pytest.mark.parametrize("given", [{"integral": 0.0}, {"integral": -1.0}, {"lag": -1.0}, {"period": 0.0}])
def test_impossible_loops_are_refused(given):
    with pytest.raises(InputError):
        loop_of(**given)
