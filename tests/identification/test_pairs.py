"""Two effects are told by what each changes alone, where neither by itself comes near."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from blind_fits import base_of_plant

from identification.extending.pairs import FORMS, LARGEST, Trace, begun, promising_pairs, traces_of
from identification.search import errors
from identification.starting.hints import resized
from valvemodel.effects import effect_of_key
from valvemodel.stages import EFFECTS

LAG, DRIFT, SPRING = "coil_lag", "gap_drift", "spring_hardening"


def trace(key: str, change: list[float]) -> Trace:
    """Return a trace of an effect at its declared starts."""
    values = {each.name: each.starts[0] for each in effect_of_key(key).parameters}
    return Trace(key, values, np.zeros(1), np.array(change, np.float32))


def fit_that_leaves(*left: float) -> SimpleNamespace:
    """Return a fit without unknowns of its own that leaves some residuals."""
    return SimpleNamespace(own_slopes=(np.array(left), np.zeros((len(left), 1)), np.zeros((1, 1))))


def test_the_pair_that_explains_most_at_any_sizes_comes_first():
    # A residual falls by what is changed: -2 (1, 0, 0) and -0.5 (0, 1, 0) leave nothing; (1, 1, 0) is nearest alone.
    traces = [trace(LAG, [-1.0, 0.0, 0.0]), trace(DRIFT, [0.0, -1.0, 0.0]), trace(SPRING, [-1.0, -1.0, 0.5])]
    best, *others = promising_pairs(fit_that_leaves(2.0, 0.5, 0.0), traces, 9)
    assert set(best.keys) == {LAG, DRIFT}
    assert best.sizes == pytest.approx((2.0, 0.5))
    assert best.gain == pytest.approx(2.0**2 + 0.5**2)
    assert all(each.gain < best.gain for each in others)


def test_an_effect_is_neither_reversed_nor_made_larger_than_it_can_be():
    traces = [trace(LAG, [-1.0, 0.0]), trace(DRIFT, [0.0, -1.0])]
    assert promising_pairs(fit_that_leaves(2.0, -0.5), traces, 9) == []
    (far,) = promising_pairs(fit_that_leaves(90.0, 1.0), traces, 9)
    assert far.sizes[0] == LARGEST


def test_two_traces_of_one_effect_are_no_pair_and_few_forms_of_a_pair_are_kept():
    traces = [trace(LAG, [-1.0, 0.1 * turn]) for turn in range(9)] + [trace(DRIFT, [0.0, -1.0])]
    found = promising_pairs(fit_that_leaves(1.0, 1.0), traces, 99)
    assert len(found) == 1  # all are of the same form
    forms = [{"saturation_slope": slope, "saturation_reach": reach} for slope in (0.0, 0.7) for reach in (0.0, 0.05)]
    knee = trace("magnetic_saturation", [-1.0, 0.0])
    bent = [Trace(knee.key, knee.values | form, knee.move, knee.change) for form in forms]
    lag = {"eddy_time_constant": 0.0, "lag_behind_core": 0.0}
    lags = [{"coil_time_constant": value, **lag} for value in (0.0, 0.1)]
    unlike = [Trace(LAG, lag, knee.move, traces[0].change) for lag in lags]
    found = promising_pairs(fit_that_leaves(1.0, 1.0), [*bent, *unlike, traces[-1]], 99)
    counts = [sum(set(each.keys) == {knee.key, DRIFT} for each in found)]
    assert counts == [FORMS]
    assert promising_pairs(fit_that_leaves(1.0, 1.0), [], 9) == []


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda each: each.key)
def test_an_effect_of_no_size_is_absent_where_its_sizes_tell(effect):
    start = {each.name: float(each.typical or 0.0) for each in effect.parameters}
    gone = resized(effect, start, 0.0)
    for each in effect.parameters:
        assert gone[each.name] == (each.neutral if each.is_size else start[each.name])
        assert resized(effect, start, 1.0)[each.name] == start[each.name]


def test_the_two_effects_of_a_blind_valve_promise_most_together():
    plant, base = base_of_plant(9402, ("asymmetric_filling", "gap_drift"))
    keys = ("asymmetric_filling", "gap_drift", "coil_lag", "spring_hardening", "sensor_lag", "linkage_backlash")
    traces = [each for key in keys for each in traces_of(base, effect_of_key(key))]
    first = promising_pairs(base, traces, 9)[0]
    assert set(first.keys) == set(plant.answer())
    problem, point = begun(base, first)
    assert set(problem.model.effects) == set(plant.answer())
    assert float(errors(problem, point[None, :])[0]) < 0.5 * base.found.error
