"""Friction that falls with speed, in each of its laws: all forms of the chain against the derived function."""

from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest
from simulation_runs import base_model, ramps_and_steps, run

from valvemodel.equations import numeric
from valvemodel.reference import simulate_slowly
from valvemodel.reference.stem import stribeck_share as share_in_plain_python
from valvemodel.simulation import simulate
from valvemodel.smooth.stem import weakened
from valvemodel.stages.stem import stribeck_excess, stribeck_slope

LAWS = [(1.0, 0.0), (2.0, 0.0), (1.0, 1.0), (2.0, 1.0), (2.0, 0.4)]
SPEEDS = [1e-5, 1e-3, 8e-3, 0.03, 0.4]


def numbers(shape: float, tail: float, ratio: float = 1.5) -> dict[str, float]:
    return {"stribeck_ratio": ratio, "stribeck_velocity": 8e-3, "stribeck_shape": shape, "stribeck_tail": tail}


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("speed", SPEEDS)
def test_all_forms_are_the_derived_law(law, speed):
    law = numbers(*law)
    expected = numeric.stribeck_factor(speed, **law)
    row = base_model().with_effect("stribeck", **law).rows()[0]
    assert 1.0 + stribeck_excess(row, 1.0, speed) == pytest.approx(expected, rel=1e-14)
    assert -stribeck_slope(row, 1.0, speed) == pytest.approx(numeric.stribeck_factor_by_speed(speed, **law), rel=1e-12)
    assert 1.0 + 0.5 * share_in_plain_python(SimpleNamespace(**law), -speed) == pytest.approx(expected, rel=1e-14)
    assert float(weakened(SimpleNamespace(**law), ca.DM(speed))) == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize("law", [numbers(1.0, 1.0), numbers(2.0, 1.0)])
def test_half_of_a_tail_is_left_at_its_speed_and_much_far_beyond(law):
    assert numeric.stribeck_factor(8e-3, **law) == pytest.approx(1.25)
    order = law["stribeck_shape"]
    assert numeric.stribeck_factor(0.8, **law) - 1.0 == pytest.approx(0.5 * 100.0**-order, rel=0.011)


def test_a_law_at_its_neutral_values_is_absent_to_the_last_bit():
    time, current = ramps_and_steps(seconds=16.0, seed=4)
    absent, present = (base_model().with_effect("stribeck", **numbers(2.0, 1.0, ratio)) for ratio in (1.0, 1.5))
    plain = run(base_model(), time, current)
    assert (run(absent, time, current) == plain).all()
    assert np.abs(run(present, time, current) - plain).max() > 1e-4


@pytest.mark.parametrize("law", [(1.0, 1.0), (2.0, 1.0)])
@pytest.mark.parametrize("other", [None, "coil_lag", "presliding"])
def test_a_tail_in_plain_python(law, other):
    time, current = ramps_and_steps(seconds=2.0, seed=1)
    model = base_model().with_effect("stribeck", **numbers(*law, 1.2))
    model = model if other is None else model.with_effect(other)
    found = simulate(model, time=time, current=current).position
    expected = simulate_slowly(model, time=time, current=current).position
    assert np.abs(found - expected).max() < (1e-5 if other else 1e-9)
