"""PID: python-control's discrete-time loop on a linear plant, and its options."""

import numpy as np
import pytest
from control_samples import CONTROLLERS, START, valve_of

from benchmarks.linear_loop import nonlinear_loop, rest_of, slipping_valve, transfer_loop
from valvemodel.control.controller import Controller
from valvemodel.control.loop import run_compiled
from valvemodel.control.scenario import held_levels

GAINS = {"proportional_gain": 0.02, "integral_gain": 0.4, "derivative_gain": 2e-5}


@pytest.mark.parametrize("period", [0.005, 0.02])
@pytest.mark.parametrize("loop", [transfer_loop, nonlinear_loop])
def test_closed_loop_is_python_controls(loop, period):
    model = slipping_valve()
    scenario = held_levels([rest_of(model), 0.16, 0.12, 0.14], duration=1.0, period=period)
    run = run_compiled(model, Controller("pid", {**GAINS, "start_current": START}), scenario, start_current=START)
    assert np.abs(run.position - loop(model, GAINS, scenario)).max() < 1e-11
    assert np.ptp(run.position) > 0.03


def outputs(rows, **settings):
    step = Controller("pid", {**GAINS, "start_current": START, **settings}).started()
    return np.array([step(*row) for row in rows])


def test_output_is_eq_34():
    errors = np.array([1e-3, -2e-3, 5e-4, 3e-3])
    told = outputs([(0.1 + error, 0.1) for error in errors])
    expected = START + 0.02 * errors + 0.4 * 0.01 * np.cumsum(errors) + 2e-5 / 0.01 * np.diff(errors, prepend=errors[0])
    assert told == pytest.approx(expected, abs=1e-15)


def test_options_are_off_by_default():
    rows = [(0.1, 0.0)] * 400 + [(0.0, 0.1)] * 20
    plain = outputs(rows, derivative_gain=0.0)
    assert plain[300:420].min() == 20e-3, "the integral of (34) winds up and holds the limit"
    assert (outputs(rows, derivative_gain=0.0, has_anti_windup=0.0) == plain).all()
    wound = outputs(rows, derivative_gain=0.0, has_anti_windup=1.0)
    assert wound[420 - 18] < 20e-3


def test_derivative_on_measurement_does_not_kick():
    rows = [(0.1, 0.1)] * 3 + [(0.12, 0.1)] * 3
    kicked = outputs(rows)
    calm = outputs(rows, differentiates_reading=1.0)
    kick = 2e-5 / 0.01 * 0.02
    assert kicked[3] - calm[3] == pytest.approx(kick, rel=1e-12)
    assert kicked[4:] == pytest.approx(calm[4:], abs=1e-15)


def test_dead_band_stops_the_integral_inside_only():
    held = outputs([(0.1, 0.1005)] * 50, dead_band=1e-3, proportional_gain=0.0, derivative_gain=0.0)
    assert (held == START).all()
    moved = outputs([(0.1, 0.1015)] * 50, dead_band=1e-3, proportional_gain=0.0, derivative_gain=0.0)
    assert moved[-1] == pytest.approx(START - 50 * 0.4 * 0.01 * 1.5e-3)


def test_integral_alone_crosses_the_dead_band_of_a_play_in_closed_form():
    """Stuck at an error e, the current grows by K_I e a period until the full width of the loop is crossed.

    A play operator of half width F_c/k behind the straight line of `linear` has the width 2 F_c/(A c) in current.
    """
    model = valve_of("linear")
    values = model.values
    width = 2.0 * values["coulomb_friction"] / (values["diaphragm_area"] * values["pressure_per_current"])
    setpoints = (0.17, 0.16)
    scenario = held_levels(setpoints, duration=30.0, period=0.01)
    controller = Controller("integral", {"integral_gain": 0.1, "start_current": START})
    run = run_compiled(model, controller, scenario, start_current=START)
    turn = scenario.steps[1].start
    assert run.position[turn] == pytest.approx(0.17, abs=1e-6)
    error = run.position[turn] - setpoints[1]
    stuck = np.flatnonzero(np.abs(run.position[turn:] - run.position[turn]) > 1e-12)[0]
    assert abs(stuck - width / (0.1 * 0.01 * error)) < 2.5
    assert run.position[-1] == pytest.approx(0.16, abs=1e-6), "without a slip jump integral control comes to rest"


def test_scheduled_gains_follow_the_slope_of_the_branches():
    from valvemodel.control.branches import branches_of
    from valvemodel.control.laws.feedforward import gain_schedule

    branches = branches_of(valve_of())
    record = Controller("scheduled", {"is_scheduled": 1.0}, branches).record[0]
    low, high = branches.reach
    factors = [gain_schedule(record, low + share * (high - low)) for share in (0.15, 0.5, 0.9)]
    assert factors[0] > 1.3 * factors[1] > 1.3 * factors[2], "the valve is steeper the higher it stands"
    assert gain_schedule(CONTROLLERS["scheduled"].record[0], 0.13) == pytest.approx(1.0, rel=1e-9)
