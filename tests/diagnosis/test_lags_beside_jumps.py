"""Lags that are tried beside a law of stick-slip whose viscous friction stands in for them."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from workshops import EMPTY

from diagnosis.choosing import lags_beside_jumps as lags
from diagnosis.trying.candidates import Candidate


def named(misfit: float, *effects: str) -> Candidate:
    """Return a cause with nothing but its effects and a misfit."""
    return Candidate(effects, None, SimpleNamespace(misfit=misfit))


def sluggish(cause: Candidate, times: float) -> Candidate:
    """Return a cause whose fit has so many times the viscous friction that was given."""
    values = {key: {} for key in cause.effects}
    unknowns = [SimpleNamespace(name="spring_rate"), SimpleNamespace(name="viscous_friction")]
    found = SimpleNamespace(point=np.array([5.0, np.log(times)]))
    return replace(cause, fit=SimpleNamespace(model=SimpleNamespace(effects=values), unknowns=unknowns, found=found))


@pytest.mark.parametrize(
    ("law", "left", "times", "is_tried"),
    [
        ("static_friction", 20.0, 4.0, True),
        ("static_friction", 20.0, 2.0, False),
        ("static_friction", 38.0, 4.0, False),
        ("static_friction", 1.1, 4.0, False),
        ("stribeck", 20.0, 4.0, False),
        ("static_friction", 34.0, 4.0, False),
    ],
)
def test_lags_are_tried_on_top_of_a_law_in_closed_form_that_makes_slips_last(monkeypatch, law, left, times, is_tried):
    asked = []
    monkeypatch.setattr(lags, "try_all", lambda work, *_: asked.append([each.effects for each in work]) or [])
    monkeypatch.setattr(lags, "sharpen_all", lambda *_: [])
    alone = [sluggish(named(each.score.misfit, *each.effects), times) for each in (named(40.0), named(left, law))]
    alone += [named(39.0, key) for key in ("chamber_filling", "sensor_lag", "transport_delay")]
    # What comes nearer alone needs no jumps.
    alone += [named(30.0, "air_leak")]
    alone[2:] = [sluggish(each, 1.0) for each in alone[2:]]
    found = lags.lags_beside_jumps(alone, EMPTY)
    quick, slow = [(law, "sensor_lag"), (law, "transport_delay")], [(law, "chamber_filling")]
    assert found == []
    assert [each for each in asked if each] == [quick, slow] * is_tried


def test_no_lag_is_tried_where_nothing_was_alone():
    assert lags.lags_beside_jumps([named(40.0)], EMPTY) == []


@pytest.mark.parametrize(("left", "is_enough"), [(1.0, True), (3.0, True), (9.0, False)])
def test_what_lags_by_several_laws_is_not_tried_beside_jumps_where_another_lag_takes_in_most(
    monkeypatch, left, is_enough
):
    asked = []
    lagging = named(left, "static_friction", "sensor_lag")
    monkeypatch.setattr(lags, "try_all", lambda work, *_: asked.append([each.effects for each in work]) or [lagging])
    monkeypatch.setattr(lags, "sharpen_all", lambda *_: [])
    monkeypatch.setattr(lags, "short_of_noise", lambda tried: [])
    monkeypatch.setattr(lags, "is_near_noise", lambda each, base: each.score.misfit < 1.1)
    alone = [named(40.0), named(20.0, "static_friction"), named(39.0, "chamber_filling"), named(39.0, "sensor_lag")]
    found = lags.lags_beside_jumps([sluggish(each, 4.0) for each in alone], EMPTY)
    assert {each.effects for each in found} == {lagging.effects}
    assert asked == [[("static_friction", "sensor_lag")], [("static_friction", "chamber_filling")]][: 2 - is_enough]
