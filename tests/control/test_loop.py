"""The compiled loop is the stepped loop; a controller sees readings only and stays within 4..20 mA."""

import time

import numpy as np
import pytest
from control_samples import CONTROLLERS, START, valve_of
from hypothesis import given, settings
from hypothesis import strategies as st

from valvemodel.control.controller import Controller
from valvemodel.control.laws.settings import HIGHEST_CURRENT, LOWEST_CURRENT
from valvemodel.control.loop import run_compiled, run_stepped
from valvemodel.control.scenario import held_levels
from valvemodel.errors import InputError

NAMES = sorted(CONTROLLERS)
LEVELS = (0.12, 0.18, 0.171, 0.1)


def scenario(**changes):
    return held_levels(LEVELS, **{"duration": 2.0, "period": 0.01, "noise": 2e-4, **changes})


def same(one, other) -> bool:
    return all(
        (getattr(one, name) == getattr(other, name)).all() for name in ("time", "current", "reading", "position")
    )


@pytest.mark.parametrize("name", NAMES)
def test_compiled_and_stepped_runs_agree_to_the_last_bit(name):
    asked = scenario(resolution=5e-4, load=150.0, period=0.013)
    model = valve_of(ratio=1.3)
    controller = CONTROLLERS[name].with_settings(period=0.013)
    compiled = run_compiled(model, controller, asked, start_current=START)
    assert same(compiled, run_stepped(model, controller.started(), asked, start_current=START))
    assert np.ptp(compiled.position) > 0.02


@pytest.mark.parametrize(
    "effect", ["chamber_filling", "transport_delay", "stribeck", "linkage_backlash", "sensor_lag", "load_force"]
)
def test_they_agree_with_effects(effect):
    model = valve_of().with_effect(effect)
    controller = CONTROLLERS["pid"]
    runs = (
        run_compiled(model, controller, scenario(), start_current=START),
        run_stepped(model, controller.started(), scenario(), start_current=START),
    )
    assert same(*runs)


readings = st.floats(-1.0, 1.0)
records = st.lists(st.tuples(st.floats(0.0, 0.3), readings), min_size=2, max_size=60)


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(NAMES), records)
def test_no_law_leaves_the_current_range(name, rows):
    step = CONTROLLERS[name].started()
    for setpoint, reading in rows:
        assert LOWEST_CURRENT <= step(setpoint, reading) <= HIGHEST_CURRENT


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(NAMES), records, st.floats(1e-3, 1.0))
def test_rate_limit_is_kept(name, rows, limit):
    step = CONTROLLERS[name].with_settings(rate_limit=limit).started()
    currents = np.array([step(*row) for row in rows])
    assert (np.abs(np.diff(currents)) <= limit * 0.01 * (1.0 + 1e-12)).all()


@pytest.mark.parametrize("name", NAMES)
def test_currents_follow_from_set_points_and_readings_alone(name):
    run = run_compiled(valve_of(ratio=1.4), CONTROLLERS[name], scenario(), start_current=START)
    step = CONTROLLERS[name].started()
    told = [step(setpoint, reading) for setpoint, reading in zip(run.setpoint, run.reading, strict=True)]
    assert told == run.current.tolist()


@settings(max_examples=15, deadline=None)
@given(st.sampled_from(NAMES), st.floats(1.0, 2.0), st.floats(0.2, 3.0), st.floats(-200.0, 200.0))
def test_hidden_state_behind_the_same_readings_changes_nothing(name, ratio, mass, load):
    """A resolution of 10 m hides the valve: every reading is 0."""
    asked = scenario(resolution=10.0, noise=0.0)
    hidden = scenario(resolution=10.0, noise=0.0, load=load)
    plain = run_compiled(valve_of(), CONTROLLERS[name], asked, start_current=START)
    other = run_compiled(
        valve_of("linear", ratio).with_values(stem_mass=mass), CONTROLLERS[name], hidden, start_current=START
    )
    assert (plain.reading == 0.0).all()
    assert (plain.current == other.current).all()
    assert name in ("sc", "landing") or (plain.position != other.position).any()


def test_a_users_controller_is_held_within_the_range_and_must_return_a_number():
    run = run_stepped(valve_of(), lambda setpoint, reading: 1.0, scenario(), start_current=START)
    assert (run.current == HIGHEST_CURRENT).all()
    with pytest.raises(InputError, match="returns a current"):
        run_stepped(valve_of(), lambda setpoint, reading: float("nan"), scenario(), start_current=START)


def test_resolution_and_noise_reach_the_controller_only():
    run = run_compiled(valve_of(), CONTROLLERS["sc"], scenario(resolution=1e-3, noise=2e-4), start_current=START)
    steps = run.reading / 1e-3
    assert np.allclose(steps, np.round(steps), atol=1e-9)
    quiet = run_compiled(valve_of(), CONTROLLERS["sc"], scenario(noise=0.0), start_current=START)
    assert (quiet.position == run.position).all()


def test_a_load_pushes_the_stem_down():
    pushed = run_compiled(valve_of(), CONTROLLERS["sc"], scenario(load=3500.0, noise=0.0), start_current=START)
    half = 100
    assert pushed.position[2 * half - 1] < pushed.position[half] - 0.01


@pytest.mark.parametrize(
    "changes", [{"period": 0.0}, {"period": 60.0}, {"noise": -1e-4}, {"noise": np.nan}, {"resolution": -1.0},
                {"duration": 0.05}, {"load": np.inf}],
)  # fmt: skip
def test_scenarios_that_make_no_sense_are_refused(changes):
    with pytest.raises(InputError):
        scenario(**changes)


def test_settings_are_checked():
    with pytest.raises(InputError, match="did you mean integral_gain"):
        Controller("pid", {"integral_gian": 1.0})
    with pytest.raises(InputError, match="dead_band"):
        Controller("pid", {"dead_band": -1.0})


def test_a_thousand_seconds_take_no_time():
    """Of this process alone: the machine may be busy with others."""
    asked = held_levels([0.12, 0.18, 0.15, 0.1, 0.2] * 20, duration=10.0, period=0.01, noise=1e-4)
    model, controller = valve_of(ratio=1.2), CONTROLLERS["pid"]

    def seconds(run) -> float:
        began = time.process_time()
        run()
        return time.process_time() - began

    compiled = min(seconds(lambda: run_compiled(model, controller, asked, start_current=START)) for _ in range(7))
    stepped = min(
        seconds(lambda: run_stepped(model, lambda r, y: 0.012 + 0.05 * (r - y), asked, start_current=START))
        for _ in range(2)
    )
    assert compiled < 20e-3
    assert stepped < 1.0
