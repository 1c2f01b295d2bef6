"""Optimal moves arrive on the exact valve, respect what limits the current, and are as fast as theory allows."""

from __future__ import annotations

import math

import numpy as np
import pytest
from click.testing import CliRunner

from valvemodel.control.optimal_move import BAND, Move, least_time, least_travel
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.records import read_record
from valvemodel.valves import read_valve

START, PERIOD = 12e-3, 0.02


def calibrated(**changes: float) -> Model:
    valve = read_valve("calibrated")
    return Model(valve.name, {**valve.values, **changes})


def check_admissible(move: Move, rate: float, current_range: tuple[float, float] = (4e-3, 20e-3)) -> None:
    assert move.is_reached
    assert abs(move.trajectory.position[-1] - move.target) <= BAND
    assert move.overshoot <= 1e-6
    assert move.current.min() >= current_range[0] - 1e-9
    assert move.current.max() <= current_range[1] + 1e-9
    steps = np.abs(np.diff(move.current, prepend=START))
    assert steps.max() <= rate * PERIOD * (1.0 + 1e-6) + 1e-9


@pytest.mark.parametrize("target", [0.15, 0.08])
def test_an_unlimited_current_moves_the_valve_within_a_few_periods(target):
    move = least_time(calibrated(), start_current=START, target=target, period=PERIOD)
    check_admissible(move, math.inf)
    assert move.duration <= 3 * PERIOD


def test_a_limited_rate_is_used_to_the_full():
    """Without dynamics upstream nothing beats the ramp that stops in time: the way to go over the rate."""
    rate = 5e-3
    move = least_time(calibrated(), start_current=START, target=0.15, rate=rate, period=PERIOD)
    check_admissible(move, rate)
    net_change = abs(move.current[-1] - START)
    assert move.duration == pytest.approx(net_change / rate, abs=3 * PERIOD)


def test_a_lag_is_outrun_by_overdriving_the_current():
    model, rate = calibrated().with_effect("coil_lag", coil_time_constant=0.3), 20e-3
    move = least_time(model, start_current=START, target=0.15, rate=rate, period=PERIOD)
    check_admissible(move, rate)
    assert move.current.max() > move.current[-1] + 0.3e-3
    # A ramp to the final current needs the lag's tail down to the band, five time constants and more.
    assert move.duration < 0.75


@pytest.mark.parametrize("key", ["static_friction", "transport_delay"])
def test_effects_are_known_to_the_move(key):
    move = least_time(calibrated().with_effect(key), start_current=START, target=0.15, rate=20e-3, period=PERIOD)
    check_admissible(move, 20e-3)


def test_the_valve_under_swinging_does_not_overshoot():
    move = least_time(calibrated(viscous_friction=60.0), start_current=START, target=0.15, rate=100e-3, period=PERIOD)
    check_admissible(move, 100e-3)


def test_least_travel_takes_its_time_and_travels_no_more_than_the_way():
    rate = 10e-3
    fast = least_time(calibrated(), start_current=START, target=0.15, period=PERIOD, rate=rate)
    slow = least_travel(calibrated(), start_current=START, target=0.15, period=PERIOD, rate=rate, within=0.8)
    check_admissible(slow, rate)
    assert slow.duration <= 0.8 + 1e-9
    assert slow.travel <= fast.travel + 1e-5
    # A rising current that never turns back travels just the way between its ends.
    assert slow.travel == pytest.approx(slow.current[-1] - START, rel=1e-3)


@pytest.mark.parametrize(
    ("changed", "rule"),
    [
        ({"target": 0.5}, "within what the current's range reaches"),
        ({"target": 0.1216}, "farther than its band"),
        ({"start_current": 30e-3}, "starts inside"),
        ({"rate": 1e-5}, "at most"),
    ],
)
def test_what_cannot_be_asked_is_said(changed, rule):
    with pytest.raises(InputError, match=rule):
        least_time(calibrated(), **{"start_current": START, "target": 0.15, "period": PERIOD, **changed})


def test_least_travel_has_time_to_spare():
    slow = least_travel(calibrated(), start_current=START, target=0.15, period=PERIOD, within=2.0)
    assert slow.is_reached
    assert slow.duration <= 2.0 + 1e-9
    assert slow.travel == pytest.approx(slow.current[-1] - START, rel=1e-3)


def test_too_short_a_time_is_said():
    with pytest.raises(InputError, match="the time that it takes"):
        least_travel(calibrated(), start_current=START, target=0.15, period=PERIOD, rate=5e-3, within=0.2)


def test_command_writes_the_exact_run(tmp_path):
    from valvemodel.commands import command_line

    out = tmp_path / "move.csv"
    arguments = ["move", "--to", "150 mm", "--from", "12 mA", "--rate", "20 mA/s", "--period", "20 ms"]
    done = CliRunner().invoke(command_line, [*arguments, "--out", str(out)])
    assert done.exit_code == 0, done.output
    assert "overshoot 0" in done.output
    record = read_record(out)
    assert record.position[-1] == pytest.approx(0.15, abs=BAND)
    assert np.abs(np.diff(record.current)).max() <= 20e-3 * PERIOD * (1.0 + 1e-6)


def test_command_refuses_what_does_not_belong_together(tmp_path):
    from valvemodel.commands import command_line

    done = CliRunner().invoke(
        command_line, ["move", "--to", "150 mm", "--within", "2 s", "--out", str(tmp_path / "move.csv")]
    )
    assert done.exit_code == 2
    assert not list(tmp_path.iterdir())
