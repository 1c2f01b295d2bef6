"""Two effects of which neither is near alone are found together."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from diagnosis.blindtest.plants import draw_plant, measure
from diagnosis.choosing.jointly import in_order, is_joined, nearest, try_jointly
from diagnosis.score import score_fit
from diagnosis.trying.candidates import Candidate, Work, try_effect
from diagnosis.trying.workshop import Workshop
from identification.experiment import experiment_of
from identification.fit import fit_base
from identification.holdout import hold_out
from identification.search import Found
from valvemodel.effects import effect_of_key
from valvemodel.records import Record


def problem(**held: float) -> SimpleNamespace:
    """Return a problem with a saturation in a form, beside a lag."""
    values = {"saturation_slope": 0.0, "saturation_reach": 0.0, "saturation_law": 0.0} | held
    return SimpleNamespace(
        model=SimpleNamespace(effects={"magnetic_saturation": values, "coil_lag": {"lag_behind_core": 0.0}})
    )


def test_few_starts_of_the_same_form_go_on():
    flat, bent = problem(), problem(saturation_slope=0.7)
    found = [
        (each, Found(np.array([error]), error)) for each, error in [(flat, 3.0), (flat, 1.0), (flat, 2.0), (bent, 4.9)]
    ]
    kept = nearest(found, 9, 1)
    assert [(each is flat, point[0]) for each, point in kept] == [(True, 1.0), (False, 4.9)]
    assert [point[0] for _, point in nearest(found, 2, 2)] == [1.0, 2.0]


def test_what_lies_far_behind_goes_no_further():
    found = [(each, Found(np.array([error]), error)) for each, error in [(problem(), 1.0), (problem(x=1.0), 5.1)]]
    assert [point[0] for _, point in nearest(found, 9, 1)] == [1.0]


def test_what_may_stand_in_for_two_leaves_room_for_them():
    spot = effect_of_key("position_dependent_friction").typical
    beside = ("coil_lag", "sensor_lag", "gap_drift", "sensor_drift")
    pairs = [{"position_dependent_friction": spot, key: effect_of_key(key).typical} for key in beside]
    pairs.append({key: effect_of_key(key).typical for key in ("coil_lag", "gap_drift")})
    found = [
        (SimpleNamespace(model=SimpleNamespace(effects=effects)), Found(np.array([error]), error))
        for error, effects in enumerate(pairs, start=1)
    ]
    assert [point[0] for _, point in nearest(found, 5, 1)] == [1, 2, 5]


def test_what_takes_a_global_search_or_is_read_off_is_not_joined():
    assert not any(map(is_joined, ("static_friction", "stribeck", "quantisation")))
    assert all(map(is_joined, ("coil_lag", "position_dependent_friction", "presliding", "load_force")))


def test_the_better_one_comes_first():
    alone = {"coil_lag": SimpleNamespace(score=SimpleNamespace(misfit=9.0))}
    alone["gap_drift"] = SimpleNamespace(score=SimpleNamespace(misfit=2.0))
    assert in_order(("coil_lag", "gap_drift"), alone) == ("gap_drift", "coil_lag")


@pytest.mark.parametrize("keys", [("supply_droop", "magnetic_hysteresis"), ("sensor_drift", "sensor_lag")])
def test_both_effects_of_a_blind_valve_are_found_together(given, keys):
    record = Record.from_arrays(name="plant", **measure(draw_plant(9401, keys), 9408))
    holdout = hold_out([experiment_of(record)])
    fit = fit_base(given, holdout.experiments, holdout.fitted)
    base = Candidate((), fit, score_fit(fit, holdout))
    others = ("coil_lag", "spring_hardening", "gap_drift", "area_variation", "pressure_dependent_friction")
    alone = [try_effect(Work(fit, (key,), is_global=False), holdout) for key in (*keys, *others)]
    found = min(try_jointly([base, *alone], Workshop(holdout)), key=lambda each: each.score.misfit)
    assert set(found.effects) == set(keys)
    assert found.score.misfit < 1.3
    assert min(each.score.misfit for each in alone) > 2.0 * found.score.misfit
