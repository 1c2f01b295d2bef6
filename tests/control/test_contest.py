"""A contest is fair, and what the claims say follows from the grid."""

import numpy as np
import pytest
from control_samples import valve_of

from valvemodel.control import tuning
from valvemodel.control.claims import claims_of, findings_of
from valvemodel.control.contest import hold_contest, make_bench
from valvemodel.control.contest_json import contest_json
from valvemodel.control.grid import FACTORS, KEYS, READ, Grid, run_grid
from valvemodel.control.kinds import KINDS, kind_of
from valvemodel.control.scenario import held_levels
from valvemodel.errors import InputError

SMALL = {name: (levels[0], levels[-1]) for name, levels in FACTORS.items()} | {
    "gain_factor": (1.0,), "period_factor": (1.0,), "noise_factor": (1.0,)
}  # fmt: skip


@pytest.mark.parametrize("key", ["pid", "knocker", "landing"])
def test_every_kind_is_tuned_by_the_same_number_of_runs(key, monkeypatch):
    bench = make_bench(valve_of(ratio=1.2), noise=1e-4, resolution=0.0, seed=0)
    scenario = held_levels([0.12, 0.16], duration=1.0, period=0.01)
    counted = []
    plain = tuning.Bench.training_cost
    monkeypatch.setattr(tuning.Bench, "training_cost", lambda self, *given: counted.append(1) or plain(self, *given))
    tuned, least = tuning.tune(bench, kind_of(key), scenario, budget=100)
    assert len(counted) == 100
    assert least == pytest.approx(plain(bench, bench.controller(kind_of(key), tuned), scenario))


@pytest.fixture(scope="module")
def contest():
    return hold_contest(valve_of(ratio=1.2), duration=5.0, budget=96, seed=1)


def test_judged_set_points_and_noise_are_not_those_of_the_tuning(contest):
    judged, trained = (
        {float(each.setpoint[part.start]) for part in each.steps} for each in (contest.scenario, contest.training)
    )
    assert not any(abs(one - other) < 1e-6 for one in judged for other in trained)
    assert not (contest.scenario.noise[:100] == contest.training.noise[:100]).any()


def test_both_right_readings_of_the_threshold_run_with_the_same_gains(contest):
    branch, mean = contest.entry("sc_pid_branch"), contest.entry("sc_pid_mean")
    for name in ("proportional_gain", "integral_gain", "derivative_gain"):
        assert branch.controller.settings[name] == mean.controller.settings[name]
    assert np.abs(branch.run.current[:400] - mean.run.current[:400]).max() < 1e-9


def test_self_calibration_alone_stays_off_on_bent_branches_and_the_landing_does_not(contest):
    assert contest.entry("sc").overall["steady_error"] > 5e-3
    landing = contest.entry("landing").overall
    assert landing["settled_share"] == 1.0
    assert landing["steady_error"] < 1e-3
    assert contest.entry("sc").overall["limit_cycle_amplitude"] == 0.0


def test_json_has_every_kind_with_settings_and_measures(contest):
    content = contest_json(contest)
    assert [each["key"] for each in content["controllers"]] == [kind.key for kind in KINDS]
    for each in content["controllers"]:
        assert len(each["steps"]) == len(contest.scenario.steps)
        assert set(each["tuned"]) <= set(each["settings"])
        assert set(content["units"]) <= set(each["overall"])


def test_set_points_out_of_reach_are_refused():
    with pytest.raises(InputError, match="reach"):
        hold_contest(valve_of(), levels=[0.3], budget=40)


@pytest.fixture(scope="module")
def grid():
    return run_grid(valve_of(), budget=64, factors=SMALL)


def test_grid_has_every_measure_at_every_point(grid):
    shape = tuple(len(levels) for levels in SMALL.values())
    for key in KEYS:
        assert set(grid.measured[key]) == set(READ)
        assert all(each.shape == shape for each in grid.measured[key].values())


def test_pid_hunts_only_where_the_static_friction_is_larger(grid):
    _, oscillates = claims_of(grid)["pid_oscillates"]
    assert not oscillates[0].any(), "F_s = F_c: integral control of a play comes to rest"
    assert oscillates[1].any()


def made_up_grid(**changed) -> Grid:
    """A grid in which every controller settles, but for what is changed."""
    shape = tuple(len(levels) for levels in FACTORS.values())
    well = dict.fromkeys(READ, 0.0) | {"settling_time": 1.0, "settled_share": 1.0}
    measured = {
        key: {name: np.broadcast_to(changed.get(key, {}).get(name, value), shape) for name, value in well.items()}
        for key in KEYS
    }
    return Grid(valve_of(), {1.0: 0.0, 2.0: 0.02}, {}, measured, 0.01, 1e-4, 2.5e-3, FACTORS)


def test_findings_are_computed_from_the_grid():
    calm = findings_of(made_up_grid())
    assert any(text.startswith("PID oscillates") and ": 0 % of 1440 cases." in text for text in calm)
    assert not any("mends" in text for text in calm), "where nothing fails nothing is mended"
    high = (np.array(FACTORS["friction_ratio"]) > 1.3).reshape(-1, 1, 1, 1, 1)
    failing = {"limit_cycle_amplitude": np.where(high, 0.01, 0.0), "settled_share": np.where(high, 0.0, 1.0)}
    stale = findings_of(made_up_grid(sc_pid_mean=failing, dead_band=failing))
    failed = next(text for text in stale if text.startswith("SC-PID fails"))
    assert "50 % of 1440 cases; most by friction ratio: 0 % at 1," in failed
    assert any("integral dead band mends 0 %" in text and text.startswith("PID") for text in stale)
    assert any(text.startswith("landing on the model's branches mends 100 %") for text in stale)
