"""The remedies do what their sources say."""

import numpy as np
import pytest
from control_samples import CONTROLLERS, START, made_up_branches, made_up_calibration, valve_of

from valvemodel.control.branches import branches_of
from valvemodel.control.controller import Controller
from valvemodel.control.laws.settings import KNOCKER, LANDING, REINFORCEMENT, TWO_MOVES
from valvemodel.control.loop import run_compiled
from valvemodel.control.scenario import held_levels
from valvemodel.control.tuning import aged


def currents(rows, **settings):
    step = Controller("law", {"start_current": START, **settings}).started()
    return np.array([step(*row) for row in rows])


def test_knocker_adds_pulses_in_the_direction_of_the_output():
    pulses = {"knock_amplitude": 1e-3, "knock_width": 0.02, "knock_interval": 0.1, "integral_gain": 0.1}
    rows = [(0.101, 0.1)] * 60 + [(0.099, 0.1)] * 60
    added = currents(rows, law=KNOCKER, **pulses) - currents(rows, integral_gain=0.1)
    assert set(np.round(added, 12)) == {-1e-3, 0.0, 1e-3}
    assert np.count_nonzero(added[:55] > 0.0) == pytest.approx(0.2 * 55, abs=2)
    assert (added[:55] >= 0.0).all()
    assert (added[75:] <= 0.0).all()
    onsets = np.flatnonzero(np.diff((added != 0.0).astype(int)) == 1)
    assert set(np.diff(onsets)) == {10}


def test_knocker_rests_inside_the_dead_band():
    pulses = {"knock_amplitude": 1e-3, "knock_width": 0.02, "knock_interval": 0.1, "proportional_gain": 0.1}
    rows = [(0.1, 0.1 + 5e-4 * (-1) ** k) for k in range(50)]
    calm = currents(rows, law=KNOCKER, dead_band=1e-3, **pulses)
    assert (calm == currents(rows, proportional_gain=0.1)).all()


def test_reinforcement_adds_a_constant_with_the_sign_of_the_change():
    errors = [0.0, 2e-3, 5e-3, 4e-3, 4e-3, 1e-3, 3e-3]
    rows = [(0.1 + error, 0.1) for error in errors]
    added = currents(rows, law=REINFORCEMENT, proportional_gain=0.1, reinforcement=4e-4) - currents(
        rows, proportional_gain=0.1
    )
    assert added == pytest.approx([0.0, 4e-4, 4e-4, -4e-4, 0.0, -4e-4, 4e-4], abs=1e-15)


def test_two_moves_free_the_stem_and_then_go_to_the_middle_of_the_loop():
    calibration = made_up_calibration()
    settings = {
        "law": TWO_MOVES, "first_move": 5e-4, "move_duration": 0.03, "still_duration": 0.1, "dead_band": 1e-3,
        "integral_gain": 0.01, **calibration.settings,
    }  # fmt: skip
    told = currents([(0.15, 0.12)] * 3 + [(0.15, 0.15)] * 20, **settings)
    mean = (0.15 - 0.5 * (calibration.rising_intercept + calibration.falling_intercept)) / calibration.slope
    assert told[:3] == pytest.approx([mean + 0.5 * calibration.threshold + 5e-4] * 3, abs=1e-12)
    assert told[3:] == pytest.approx([mean] * 20, abs=1e-12)
    stuck = currents([(0.15, 0.15)] * 8 + [(0.15, 0.147)] * 30, **settings)
    assert np.max(stuck[8:]) == pytest.approx(mean + 0.5 * calibration.threshold + 5e-4), "an error that stays"


@pytest.mark.parametrize("ratio", [1.0, 1.3, 1.8])
def test_a_landing_ends_at_the_set_point_whatever_it_takes_to_break_away(ratio):
    model = valve_of(ratio=ratio)
    branches = branches_of(model)
    settings = {"law": LANDING, "dwell": 0.3, "dead_band": 1e-3, "slip_jump": branches.slip_jump}
    scenario = held_levels([0.12, 0.19, 0.186, 0.15, 0.151], duration=4.0, period=0.01)
    run = run_compiled(model, Controller("landing", settings, branches), scenario, start_current=START)
    ends = np.array([run.position[part][-1] - run.setpoint[part][-1] for part in scenario.steps])
    assert np.abs(ends).max() < 2e-5
    assert np.abs(np.diff(run.position[-100:])).max() == 0.0


@pytest.mark.parametrize("growth", [0.2, 0.6])
def test_a_landing_learns_a_friction_that_has_grown(growth):
    model = valve_of(ratio=1.3)
    branches = branches_of(model)
    settings = {"law": LANDING, "dwell": 0.3, "dead_band": 1e-3, "slip_jump": branches.slip_jump}
    scenario = held_levels([0.13, 0.17, 0.14, 0.17, 0.14], duration=10.0, period=0.01)
    run = run_compiled(aged(model, growth), Controller("landing", settings, branches), scenario, start_current=START)
    ends = np.array([run.position[part][-1] - run.setpoint[part][-1] for part in scenario.steps])
    assert np.abs(ends).max() < 1e-3
    repeated = [run.position[part] for part in scenario.steps[3:]]
    settled = [np.flatnonzero(np.abs(each - each[-1]) > 1e-3)[-1] for each in repeated]
    assert max(settled) < 30, "what it learned in the first moves serves the later ones at once"


def test_no_law_is_told_more_than_its_kind_knows():
    from valvemodel.control.kinds import KINDS

    for kind in KINDS:
        controller = CONTROLLERS[kind.key]
        assert ("line_slope" in controller.settings) == (kind.knows == "calibration"), kind.key
        assert (controller.branches is not None) == (kind.knows == "model"), kind.key


def test_tables_hold_the_currents_of_the_branches():
    branches = made_up_branches()
    record = CONTROLLERS["landing"].record[0]
    place = record["table_low"] + 40 * record["table_step"]
    assert record["rising_currents"][40] == pytest.approx(float(branches.rising_current(place)))
