"""Self-calibration and branches against closed forms."""

import numpy as np
import pytest
from control_samples import START, made_up_calibration, valve_of

from valvemodel.control.branches import branches_of
from valvemodel.control.calibration import LOADS, self_calibrate
from valvemodel.control.contest import make_bench
from valvemodel.control.contest_json import calibration_json
from valvemodel.control.controller import Controller
from valvemodel.control.laws.settings import BRANCH_LINE, MEAN_LINE
from valvemodel.control.loop import run_compiled
from valvemodel.control.scenario import held_levels
from valvemodel.errors import InputError

RISING_CURRENTS, FALLING_CURRENTS = LOADS[0]


def branch_current(model, position, side):
    """The current at which the sliding stem stops: A P = k y +- F_c, eqs. (16) and (31) solved for it."""
    v = model.values
    pressure = (v["spring_rate"] * position + side * v["coulomb_friction"]) / v["diaphragm_area"]
    if v["pressure_per_current"] > 0.0:
        return (pressure - v["pressure_at_zero_current"]) / v["pressure_per_current"]
    gap = np.sqrt((v["supply_pressure"] / pressure - 1.0) / v["flow_ratio"])
    return ((v["gap_offset"] - gap) / v["gap_gain"]) ** 2


def branch_position(model, current, side):
    v = model.values
    gap = v["gap_offset"] - v["gap_gain"] * np.sqrt(current)
    pressure = v["supply_pressure"] / (1.0 + v["flow_ratio"] * gap**2)
    return (v["diaphragm_area"] * pressure - side * v["coulomb_friction"]) / v["spring_rate"]


@pytest.mark.parametrize("name", ["linear", "calibrated"])
@pytest.mark.parametrize("ratio", [1.0, 1.3])
def test_branches_are_those_of_the_closed_form(name, ratio):
    model = valve_of(name, ratio)
    found = branches_of(model)
    position = np.linspace(*found.reach, 50)[1:-1]
    assert np.abs(found.rising_current(position) - branch_current(model, position, 1.0)).max() < 2e-6
    assert np.abs(found.falling_current(position) - branch_current(model, position, -1.0)).max() < 2e-6
    jump = (ratio - 1.0) * model.values["coulomb_friction"] / model.values["spring_rate"]
    assert found.slip_jump == pytest.approx(jump, abs=2e-4)


def test_width_on_the_linear_valve_is_the_true_one():
    model = valve_of("linear")
    values = model.values
    width = 2.0 * values["coulomb_friction"] / (values["diaphragm_area"] * values["pressure_per_current"])
    assert self_calibrate(model).threshold == pytest.approx(width, rel=1e-6)
    assert self_calibrate(model, noise=1e-4, seed=3).threshold == pytest.approx(width, rel=1e-2)


def test_calibration_on_bent_branches_is_35_to_40_of_the_closed_form():
    model = valve_of("calibrated")
    rising, falling = (np.array(each) for each in LOADS[0])
    up, down = branch_position(model, rising, 1.0), branch_position(model, falling, -1.0)
    slope = np.mean([np.mean(np.diff(y) / np.diff(i)) for i, y in ((rising, up), (falling, down))])
    width = (np.mean(down - slope * falling) - np.mean(up - slope * rising)) / slope
    found = self_calibrate(model)
    assert found.threshold == pytest.approx(width, rel=1e-5)
    assert found.slope == pytest.approx(slope, rel=1e-5)


def test_error_of_the_width_on_bent_branches_is_stated():
    bench = make_bench(valve_of("calibrated"), noise=0.0, resolution=0.0, seed=0)
    stated = calibration_json(bench)["true_width"]
    assert [each["where"] for each in stated] == ["low", "middle", "high"]
    errors = [each["error_of_threshold"] for each in stated]
    assert errors[0] < -0.35, "one width cannot be that of a loop 6.5 mA wide low"
    assert errors[2] > 0.3, "and 2.8 mA wide high"
    for each in stated:
        place = each["position"]["value"]
        true = branch_current(bench.model, place, 1.0) - branch_current(bench.model, place, -1.0)
        assert each["value"] == pytest.approx(true, rel=1e-3)


@pytest.mark.parametrize(
    ("rising", "falling"),
    [
        ((13e-3, 12e-3, 19e-3), FALLING_CURRENTS),
        (RISING_CURRENTS, (4.5e-3, 8.5e-3, 12.5e-3)),
        ((13e-3, 16e-3, 21e-3), FALLING_CURRENTS),
        ((5e-3, 6e-3, 7e-3), FALLING_CURRENTS),
        (RISING_CURRENTS, (19.5e-3, 11e-3, 8e-3)),
        ((13e-3, 16e-3), FALLING_CURRENTS),
    ],
)
def test_loads_that_calibrate_nothing_are_refused(rising, falling):
    with pytest.raises(InputError):
        self_calibrate(valve_of(), loads=[(rising, falling)])


def test_loads_farther_apart_are_taken_where_breakaway_needs_them():
    assert tuple(self_calibrate(valve_of(ratio=1.1)).falling[:, 0]) == LOADS[0][1]
    assert tuple(self_calibrate(valve_of(ratio=2.0)).falling[:, 0]) == LOADS[1][1]


def test_a_valve_that_friction_holds_is_refused():
    with pytest.raises(InputError):
        branches_of(valve_of().with_values(coulomb_friction=2e4))


def feedforward_of(record, reading_of_threshold, **settings):
    controller = Controller("sc", {"feedforward": reading_of_threshold, **made_up_calibration().settings, **settings})
    step = controller.started()
    return np.array([step(*row) for row in record])


def test_full_width_on_a_branch_line_is_half_width_about_the_mean_line():
    rng = np.random.default_rng(0)
    record = [(level, level + rng.normal(scale=5e-3)) for level in np.repeat(rng.uniform(0.13, 0.2, 40), 3)]
    branch, mean = feedforward_of(record, BRANCH_LINE), feedforward_of(record, MEAN_LINE)
    assert np.ptp(mean) > 3e-3
    assert branch == pytest.approx(mean, abs=1e-12)
    misread = feedforward_of(record, MEAN_LINE, threshold_share=1.0)
    assert np.abs(misread - mean) == pytest.approx(0.5 * made_up_calibration().threshold, rel=1e-9)


@pytest.mark.parametrize("reading", [BRANCH_LINE, MEAN_LINE])
def test_self_calibration_alone_is_exact_where_branches_are_straight_and_fresh(reading):
    model = valve_of("linear")
    settings = {"feedforward": reading, **self_calibrate(model).settings}
    scenario = held_levels([0.13, 0.18, 0.17, 0.19, 0.11], duration=2.0, period=0.01)
    run = run_compiled(model, Controller("sc", settings), scenario, start_current=START)
    ends = np.array([run.position[part][-1] - run.setpoint[part][-1] for part in scenario.steps])
    assert np.abs(ends).max() < 1e-6
