"""Beside slips the base valve makes up for an effect that hides in it, and a search begins there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from identification.extending.extension import extend, extend_from
from identification.fit import Fit
from identification.search import errors
from identification.starting.compensation import compensated, compensated_trials, is_compensated
from identification.starting.joining import joined
from tests.identification.blind_fits import base_of_plant
from valvemodel.effects import effect_of_key
from valvemodel.stages import EFFECTS

SEED = 10


@pytest.fixture(scope="module")
def sticking() -> Fit:
    """A fit with static friction to a valve that has it and unequal friction up and down."""
    _, base = base_of_plant(SEED, ("static_friction", "asymmetric_friction"))
    return extend(base, "static_friction")


def left_at(start) -> float:
    problem, point = start
    return float(errors(problem, point[None, :])[0]) / problem.noise_error


@pytest.mark.parametrize("key", ["air_leak", "asymmetric_friction", "linkage_backlash"])
def test_the_base_valve_makes_up_for_what_hides_in_it(sticking, key):
    effect = effect_of_key(key)
    values = {
        each.name: each.neutral + 0.3 * (each.starts[-1] - each.neutral) if each.is_fitted else each.starts[0]
        for each in effect.parameters
    }
    plain = joined(sticking.problem, sticking.found.point, effect, values)
    problem, point = compensated(sticking, effect, values)
    assert problem.unknowns == plain[0].unknowns
    assert problem.experiments == sticking.problem.experiments
    own = [unknown.name in sticking.model.effects["static_friction"] for unknown in sticking.unknowns]
    assert np.array_equal(point[: len(own)][own], sticking.found.point[own])
    assert left_at((problem, point)) < 0.5 * left_at(plain)


def test_trials_come_with_what_they_gain(sticking):
    trials = compensated_trials(sticking, effect_of_key("asymmetric_friction"))
    gains = [trial.gain for trial in trials]
    assert gains == sorted(gains, reverse=True)
    for trial in trials:
        left = left_at((trial.problem, trial.point)) * trial.problem.noise_error
        assert trial.gain == pytest.approx(2.0 * (sticking.found.error - left))


def test_what_slopes_beside_slips_hide_is_found(sticking, monkeypatch):
    found = extend(sticking, "asymmetric_friction")
    monkeypatch.setattr("identification.extending.extension.is_compensated", lambda fit, effect: False)
    assert found.found.error < 0.8 * extend(sticking, "asymmetric_friction").found.error


def test_only_what_hides_is_made_up_for_and_only_beside_slips(sticking):
    hiding = [each.key for each in EFFECTS if is_compensated(sticking, each)]
    assert sorted(hiding) == ["air_leak", "asymmetric_friction", "linkage_backlash"]
    smooth = replace(sticking, model=sticking.model.without_effect("static_friction"))
    assert not any(is_compensated(smooth, each) for each in EFFECTS)


def test_a_known_start_is_made_up_for_first(sticking):
    """Of a fit that leaves little only the first start is followed."""
    effect = effect_of_key("air_leak")
    begun = extend_from(sticking, effect.key, {each.name: each.starts[0] for each in effect.parameters})
    assert begun.found.error < 2.0 * sticking.found.error
