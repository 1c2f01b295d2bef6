"""A worn joint, two plays side by side, against its law on the stem's own travel and an independent integration."""

import numpy as np
import pytest
from independent_chain import IndependentChain
from simulation_runs import base_model, ramps_and_steps, run, stepped_readings, with_effects

from identification.problem import FINE_TOLERANCE, SEARCH_TOLERANCE
from valvemodel import runs
from valvemodel.model import Model
from valvemodel.parameters import MEMORY, STATE
from valvemodel.reference import simulate_slowly
from valvemodel.simulation import simulate
from valvemodel.trajectory import TOLERANCE

TIME, CURRENT = ramps_and_steps(seconds=3.0, seed=1)
HALF_WIDTH, START = 3e-3, 0.4
WEARS = [0.0, 0.3, 0.8, 1.0]
BOUNDS = {TOLERANCE: 1e-9, FINE_TOLERANCE: 5e-7, SEARCH_TOLERANCE: 5e-5}
"""What a run is off at most, by its tolerance. [m]"""


def with_play(wear: float, *keys: str, half_width: float = HALF_WIDTH, **values: float) -> Model:
    numbers = {"backlash_half_width": half_width, "backlash_start": START, "backlash_wear": wear}
    return with_effects(base_model(**values), *keys).with_effect("linkage_backlash", **numbers)


def plays(travel: np.ndarray, wear: float) -> np.ndarray:
    """Mean of two plays that follow a travel place by place, shape (n,). [m]"""
    half_widths = HALF_WIDTH * np.array([1.0 - wear, 1.0 + wear])
    linkages, means = travel[0] + START * half_widths, []
    for place in travel:
        linkages = np.minimum(np.maximum(linkages, place - half_widths), place + half_widths)
        means.append(linkages.mean())
    return np.array(means)


@pytest.mark.parametrize("wear", WEARS)
@pytest.mark.parametrize("damping", [612.9, 1.59])
def test_linkage_is_the_mean_of_two_plays_of_the_travel(wear, damping):
    model = with_play(wear, viscous_friction=damping)
    found = simulate(model, time=TIME, current=CURRENT)
    # The events bring the turns between the samples.
    instants = np.concatenate([TIME, found.events.time])
    order = np.argsort(instants, kind="stable")
    travel = np.concatenate([found.stem_position, found.events.position])[order]
    is_sample = (np.arange(len(instants)) < len(TIME))[order]
    assert np.abs(plays(travel, wear)[is_sample] - found.position).max() < 1e-12
    # Without looking between the samples the same comes out, bit by bit where nothing is worn.
    assert np.abs(run(model, TIME, CURRENT) - found.position).max() <= (0.0 if wear == 0.0 else 1e-14)


def test_without_wear_it_is_the_play_that_it_was_to_the_last_bit():
    whole = run(with_play(0.0), TIME, CURRENT)
    assert (whole == run(with_play(1e-300), TIME, CURRENT)).all()
    for keys in [("sensor_lag",), ("sensor_lag", "linkage_nonlinearity", "spring_hardening")]:
        assert (
            np.abs(run(with_play(0.0, *keys), TIME, CURRENT) - run(with_play(1e-9, *keys), TIME, CURRENT)).max() < 1e-9
        )


@pytest.mark.parametrize("keys", [(), ("sensor_lag",), ("sensor_lag", "linkage_nonlinearity", "spring_hardening")])
def test_wear_without_play_changes_nothing(keys):
    worn, straight = with_play(0.6, *keys, half_width=0.0), with_effects(base_model(), *keys)
    assert (run(worn, TIME, CURRENT) == run(straight, TIME, CURRENT)).all()


EFFECTS = [
    (), ("sensor_lag",), ("sensor_lag", "linkage_nonlinearity"), ("sensor_lag", "spring_hardening"),
    ("sensor_lag", "linkage_nonlinearity", "chamber_filling"), ("chamber_filling", "stribeck"),
    ("sensor_lag", "presliding"),
]  # fmt: skip


@pytest.mark.parametrize("keys", EFFECTS, ids=" ".join)
@pytest.mark.parametrize("wear", WEARS[1:])
def test_worn_joint_agrees_with_an_independent_integration(keys, wear):
    model = with_play(wear, *keys)
    expected = IndependentChain.of(model).run(TIME, CURRENT)
    # Coarse steps on bristles are not cut where a play closes, worn or not.
    bounds = {TOLERANCE: BOUNDS[TOLERANCE]} if "presliding" in keys else BOUNDS
    for tolerance, bound in bounds.items():
        assert np.abs(run(model, TIME, CURRENT, tolerance=tolerance) - expected).max() < bound, tolerance


@pytest.mark.parametrize("keys", [(), ("sensor_lag",), ("sensor_lag", "linkage_nonlinearity")])
@pytest.mark.parametrize("damping", [612.9, 1.59])
def test_worn_joint_agrees_with_the_reference(keys, damping):
    model = with_play(0.4, *keys, viscous_friction=damping)
    found = simulate(model, time=TIME, current=CURRENT).position
    assert np.abs(found - simulate_slowly(model, time=TIME, current=CURRENT).position).max() < 1e-9


def test_slow_triangle_is_taken_up_in_two_stages():
    """After a turn: nothing for 2 b (1 - w), half the slope up to 2 b (1 + w), then all of it."""
    wear, leg = 0.3, 10.0
    time = np.arange(0.0, 3.0 * leg, 0.01)
    current = np.interp(time, leg * np.arange(4), [8e-3, 16e-3, 8e-3, 16e-3])
    reading, travel = (run(model, time, current) for model in (with_play(wear), base_model()))
    # The stem rests at the turn until friction lets it go: there the plays start anew.
    turn = np.argmax(travel)
    back, way = reading[turn] - reading[turn:], travel[turn] - travel[turn:]
    falls = slice(0, np.argmax(way))
    tight, loose = 2.0 * HALF_WIDTH * (1.0 - wear), 2.0 * HALF_WIDTH * (1.0 + wear)
    expected = np.interp(way, [0.0, tight, loose, 1.0], [0.0, 0.0, 0.5 * (loose - tight), 1.0 - 2.0 * HALF_WIDTH])
    assert way.max() > 2.0 * loose
    assert np.sum((tight < way[falls]) & (way[falls] < loose)) > 5
    assert np.abs(back - expected)[falls].max() < 1e-12


@pytest.mark.parametrize("keys", [(), ("sensor_lag",), ("sensor_lag", "linkage_nonlinearity", "stribeck")])
def test_stepping_behind_a_worn_joint_equals_a_whole_run(keys):
    model = with_play(0.4, *keys)
    whole = simulate(model, time=TIME, current=CURRENT).position
    assert (stepped_readings(model, TIME, CURRENT) == whole).all()


@pytest.mark.parametrize("keys", [(), ("sensor_lag",)])
def test_worn_joint_that_is_put_anew_is_read_there(keys):
    anchors, readings = np.full(len(TIME), np.nan), np.empty((1, len(TIME)))
    anchors[60], anchors[100] = 0.05, 0.12
    runs.run_chain(
        with_play(0.4, *keys).rows(), np.zeros(1, STATE), np.zeros(1, MEMORY), TIME, CURRENT,
        anchors, runs.CURRENT, TOLERANCE, readings, runs.NONE, runs.NONE,
    )  # fmt: skip
    assert readings[0, [60, 100]] == pytest.approx([0.05, 0.12], abs=1e-14)
