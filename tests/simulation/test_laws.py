"""The second laws of effects that have two: what holds of each, against closed forms and against blind plants."""

from itertools import pairwise

import numpy as np
import pytest
from simulation_runs import base_model, ramps_and_steps, run

from diagnosis.blindtest.chain.electromagnet import _plays
from diagnosis.blindtest.profiles import draw_profile
from valvemodel.model import Model
from valvemodel.reference import simulate_slowly
from valvemodel.simulation import simulate
from valvemodel.smooth.chain import SmoothChain, parts_for, run_smooth
from valvemodel.valves import read_valve

BASE = base_model()
PLAYS = {"hysteresis_half_width": 4e-4, "hysteresis_roundness": 0.2, "return_point_memory": 1.0}

LAWS = {
    "magnetic_hysteresis": (PLAYS, {"hysteresis_half_width": 0.0}),
}
"""By effect, its second law at telling values, and what makes that vanish."""


def with_law(key: str, model: Model = BASE) -> Model:
    return model.with_effect(key, **LAWS[key][0])


@pytest.mark.parametrize("key", LAWS)
def test_a_law_at_its_neutral_values_is_absent_to_the_last_bit(key):
    time, current = ramps_and_steps(seconds=16.0, seed=4)
    law, neutral = LAWS[key]
    assert (run(BASE.with_effect(key, **{**law, **neutral}), time, current) == run(BASE, time, current)).all()
    assert np.abs(run(with_law(key), time, current) - run(BASE, time, current)).max() > 1e-4


@pytest.mark.parametrize("key", LAWS)
@pytest.mark.parametrize("damping", [612.9, 1.59])
def test_splitting_periods_changes_nothing(key, damping):
    time, current = ramps_and_steps(seconds=16.0, seed=4)
    model = with_law(key, base_model(viscous_friction=damping))
    halved = np.empty(2 * len(time) - 1)
    halved[::2], halved[1::2] = time, 0.5 * (time[1:] + time[:-1])
    split = run(model, halved, np.repeat(current, 2)[:-1])[::2]
    assert np.abs(split - run(model, time, current)).max() < 1e-12


@pytest.mark.parametrize("key", LAWS)
@pytest.mark.parametrize("other", [None, "coil_lag"])
def test_the_law_in_plain_python(key, other):
    time, current = ramps_and_steps(seconds=2.0 if other else 15.0, seed=1)
    model = with_law(key) if other is None else with_law(key).with_effect(other)
    found = simulate(model, time=time, current=current).position
    expected = simulate_slowly(model, time=time, current=current).position
    assert np.abs(found - expected).max() < (1e-5 if other else 2e-14)


@pytest.mark.parametrize("key", LAWS)
def test_the_smooth_law_converges_to_the_exact_one(key):
    time, current = ramps_and_steps(seconds=16.0, rate=100.0)
    model = with_law(key)
    exact = simulate(model, time=time, current=current, start_position=0.02).position
    chain = SmoothChain(model, parts=parts_for(model, 0.01))
    off = [
        np.abs(run_smooth(chain, time=time, current=current, start_position=0.02, width=width) - exact).max()
        for width in (30.0, 1.0, 0.01)
    ]
    assert off[0] < 3e-3
    assert off[2] < 1e-6


def effective_current(current: np.ndarray, **values: float) -> np.ndarray:
    """Current that the flux stands for, by a valve whose pressure is proportional to it. [A]"""
    valve = read_valve("linear")
    model = Model(valve.name, valve.values).with_effect("magnetic_hysteresis", **values)
    time = 0.02 * np.arange(len(current) + 1)
    pressure = simulate(model, time=time, current=np.append(current, current[-1])).pressure[1:]
    return (pressure - valve.values["pressure_at_zero_current"]) / valve.values["pressure_per_current"]


def stroke(*turns: float) -> np.ndarray:
    """Ramps from turn to turn in equal steps. [A]"""
    parts = [np.linspace(start, end, 200, endpoint=False) for start, end in pairwise(turns)]
    return np.append(np.concatenate(parts), turns[-1])


def test_plays_lag_by_the_half_width_at_large_strokes():
    current = stroke(12e-3, 19e-3, 5e-3, 19e-3)
    lag = current - effective_current(current, **PLAYS)
    assert lag[200] == pytest.approx(4e-4, rel=1e-9)
    assert lag[400] == pytest.approx(-4e-4, rel=1e-9)
    assert lag[-1] == pytest.approx(4e-4, rel=1e-9)
    # After a reversal the flux stands but for its part without a play.
    follows = (lag[400] - lag[401]) / (current[400] - current[401])
    assert follows == pytest.approx(1.0 / 1.2, rel=1e-9)


def test_minor_loops_of_plays_close_and_are_forgotten():
    plain = effective_current(stroke(12e-3, 14e-3, 16e-3), **PLAYS)
    looped = stroke(12e-3, 14e-3, 13.6e-3, 14e-3, 16e-3)
    found = effective_current(looped, **PLAYS)
    assert found[600] == pytest.approx(plain[200], abs=1e-15)
    assert found[-1] == pytest.approx(plain[-1], abs=1e-15)
    drifted = effective_current(looped, **{**PLAYS, "return_point_memory": 0.0})
    assert abs(drifted[600] - drifted[200]) > 1e-5


def test_mirrored_currents_give_mirrored_fluxes():
    turns = np.array([12e-3, 15e-3, 11e-3, 13e-3, 9e-3, 16e-3])
    up, down = stroke(*turns), stroke(*(24e-3 - turns))
    assert np.abs(effective_current(up, **PLAYS) + effective_current(down, **PLAYS) - 24e-3).max() < 1e-15


def test_a_few_plays_are_as_good_as_thirty():
    """The independent plant: 30 plays at equal distances up to three half-widths, weights falling exponentially."""
    _, current = draw_profile(1, duration=60.0, rate=50.0, kind="small")
    half_width = 4e-4
    radii = half_width * np.linspace(0.1, 3.0, 30)
    weights = np.exp(-radii / half_width)
    weights /= weights.sum()
    expected = _plays(current, radii * half_width / float(weights @ radii), weights)
    loop = np.std(current - expected)
    found, dahl = (
        np.std(
            effective_current(
                current, hysteresis_half_width=half_width, hysteresis_roundness=0.0, return_point_memory=memory
            )
            - expected
        )
        / loop
        for memory in (1.0, 0.0)
    )
    assert found < 0.03
    assert dahl > 0.1
