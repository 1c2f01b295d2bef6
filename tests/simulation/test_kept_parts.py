"""Rows that differ behind the pressure alone share it: their readings are those of rows that are run one by one."""

import numpy as np
import pytest
from simulation_runs import base_model, ramps_and_steps, with_effects

from identification.problem import SEARCH_TOLERANCE
from valvemodel import runs
from valvemodel.base_valve import BASE_PARAMETERS
from valvemodel.chain import CURRENT as BY_CURRENT
from valvemodel.effects import effect_of_key
from valvemodel.model import Model
from valvemodel.parameters import ACT_ON_PRESSURE, MEMORY, STATE, by_pressure, one_by_one
from valvemodel.simulation import anchors_of
from valvemodel.stages import EFFECTS
from valvemodel.stages.kept_parts import MOST_KEPT
from valvemodel.trajectory import TOLERANCE

TIME, CURRENT = ramps_and_steps(seconds=12.0, seed=5)
PRESSED = [effect.key for effect in EFFECTS if effect.stage in ("electromagnet", "nozzle")]
MOVING = ["coil_lag", "chamber_filling", "asymmetric_filling", "supply_droop", "transport_delay", "gap_drift"]
BEHIND = ["static_friction", "stribeck", "presliding", "spring_hardening", "sensor_lag", "load_force", "end_stop"]
SMALL = 1e-5


def varied(model: Model, share: float) -> np.ndarray:
    """Rows in which each number of the valve and of the effects is larger by a share, one after the other."""
    names = [each.name for each in BASE_PARAMETERS if each.is_fitted]
    names += [each.name for key in model.effects for each in effect_of_key(key).fitted]
    rows = model.rows(1 + len(names))
    for row, name in enumerate(names):
        rows[name][row + 1] *= 1.0 + share
    return rows


def run_in_order(rows: np.ndarray, time=TIME, current=CURRENT, tolerance=SEARCH_TOLERANCE, anchors=runs.FREE):
    """Readings, pressures and modes of rows that share their pressures."""
    found, memories = np.empty((3, len(rows), len(time))), np.zeros(1, MEMORY)
    run_into(found, memories, rows, by_pressure(rows), time, current, tolerance, anchors)
    return found, memories[0]


def run_into(found, memories, rows, order, time=TIME, current=CURRENT, tolerance=SEARCH_TOLERANCE, anchors=runs.FREE):
    """Run rows in an order into arrays of readings, pressures and modes."""
    states = np.zeros(len(rows), STATE)
    runs.run_in_order(rows, states, memories, time, current, anchors, BY_CURRENT, tolerance, *found, *order)


def run_one_by_one(rows: np.ndarray, time=TIME, current=CURRENT, tolerance=SEARCH_TOLERANCE, anchors=runs.FREE):
    """Readings, pressures and modes of rows each of which lays its own."""
    found = np.empty((3, len(rows), len(time)))
    for row in range(len(rows)):
        part = slice(row, row + 1)
        runs.run_chain(
            rows[part], np.zeros(1, STATE), np.zeros(1, MEMORY), time, current, anchors, BY_CURRENT, tolerance,
            *(each[part] for each in found),
        )  # fmt: skip
    return found


def readings_alone(rows: np.ndarray, order: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Readings of rows in an order, whose pressures and modes are left out: such a run may go stage by stage."""
    found, nothing = np.empty((len(rows), len(TIME))), np.empty((len(rows), 0))
    run_into((found, nothing, nothing), np.zeros(1, MEMORY), rows, order)
    return found


@pytest.mark.parametrize("key", PRESSED)
@pytest.mark.parametrize("behind", ["", *BEHIND])
def test_readings_are_those_of_rows_run_one_by_one(key, behind):
    rows = varied(with_effects(base_model(), key, *filter(None, [behind])), SMALL)
    shared, memory = run_in_order(rows)
    assert np.array_equal(shared, run_one_by_one(rows))
    assert memory["takes_parts"] == by_pressure(rows)[1][-1]
    assert np.array_equal(readings_alone(rows, by_pressure(rows)), readings_alone(rows, one_by_one(len(rows))))
    assert 0 < by_pressure(rows)[1].sum() < len(rows) - 1


@pytest.mark.parametrize("key", MOVING)
def test_valves_that_differ_much_behind_the_pressure_share_it_within_the_tolerance(key):
    rows = with_effects(base_model(), key).rows(6)
    for row, name in enumerate(("stem_mass", "spring_rate", "viscous_friction", "coulomb_friction", "diaphragm_area")):
        rows[name][row + 1] *= 1.4
    (readings, _, _), _ = run_in_order(rows)
    assert by_pressure(rows)[1].sum() == 5
    assert np.abs(readings - run_one_by_one(rows)[0]).max() < SEARCH_TOLERANCE
    assert np.abs(readings - readings[0]).max(axis=1)[1:].min() > 10.0 * SEARCH_TOLERANCE


@pytest.mark.parametrize("key", MOVING)
def test_readings_put_anew_share_the_pressure_too(key):
    rows = varied(with_effects(base_model(), key, "static_friction"), SMALL)
    measured = run_one_by_one(rows[:1])[0][0] + 1e-4 * np.sin(40.0 * TIME)
    anchors = anchors_of(TIME, measured, 1.0)
    rows["start_position"] = anchors[0]
    shared, _ = run_in_order(rows, anchors=anchors)
    assert np.array_equal(shared, run_one_by_one(rows, anchors=anchors))


def test_an_exact_run_lays_its_own_pressure():
    rows = varied(with_effects(base_model(), "chamber_filling"), 0.2)
    shared, memory = run_in_order(rows, tolerance=TOLERANCE)
    assert memory["parts_kept"] == 0
    assert np.array_equal(shared, run_one_by_one(rows, tolerance=TOLERANCE))


def test_a_run_of_more_parts_than_can_be_kept_shares_none():
    time = 0.02 * np.arange(MOST_KEPT + 50.0)
    current = 0.012 + 0.006 * np.sin(1.7 * time)
    rows = with_effects(base_model(), "chamber_filling").rows(2)
    rows["coulomb_friction"][1] *= 1.1
    shared, memory = run_in_order(rows, time, current)
    assert memory["takes_parts"] == 0
    assert run_in_order(rows, time[: MOST_KEPT // 4], current[: MOST_KEPT // 4])[1]["takes_parts"] == 1
    assert np.array_equal(shared, run_one_by_one(rows, time, current))


def test_a_row_whose_drifts_are_followed_otherwise_lays_its_own_pressure():
    rows = with_effects(base_model(), "gap_drift", "load_force").rows(3)
    rows["load_period"] = 17.0, 0.3, 17.0
    shared, memory = run_in_order(rows)
    assert memory["takes_parts"] == 0
    assert np.array_equal(shared, run_one_by_one(rows))


@pytest.mark.parametrize("key", ["", *(effect.key for effect in EFFECTS)])
def test_what_is_said_to_act_on_the_pressure_does_and_nothing_else(key):
    model = with_effects(base_model(), *filter(None, [key]), "chamber_filling")
    effects = [effect_of_key(each) for each in model.effects]
    names = [each.name for each in BASE_PARAMETERS if each.is_fitted or each.name in ACT_ON_PRESSURE]
    names += [each.name for effect in effects for each in effect.parameters if each.is_fitted]
    before = run_one_by_one(model.rows())[1][0]
    moving = set()
    for name in names:
        row = model.rows()
        row[name] = 1.05 * row[name] if row[name][0] != 0.0 else 1e-3
        if np.abs(run_one_by_one(row)[1][0] - before).max() > 1e-3 * before.max():
            moving.add(name)
    assert moving <= set(ACT_ON_PRESSURE)
    assert {"gap_offset", "gap_gain", "supply_pressure", "flow_ratio", "chamber_filling_time"} <= moving


def test_rows_are_ordered_by_their_pressures():
    rows = with_effects(base_model(), "chamber_filling").rows(6)
    rows["coulomb_friction"] *= np.linspace(1.0, 2.0, 6)
    rows["gap_gain"][[1, 4]] *= 1.1
    rows["chamber_filling_time"][2] *= 1.2
    order, follows = by_pressure(rows)
    assert sorted(order) == list(range(6))
    groups = np.split(order, np.flatnonzero(~follows)[1:])
    assert sorted(sorted(group.tolist()) for group in groups) == [[0, 3, 5], [1, 4], [2]]
    assert not by_pressure(rows[:1])[1].any()
