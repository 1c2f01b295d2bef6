"""Traces that are known to be alike are, those that a signal tells apart are not, and invisible ones are said to be."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from diagnosis.judging.confusability import Confusability, confusability
from identification.experiment import experiment_of
from identification.fit import fit_base
from valvemodel.effects import effect_of_key
from valvemodel.files import finite

LAGS = [effect_of_key(key) for key in ("coil_lag", "chamber_filling", "sensor_lag")]


def similarity(found: Confusability, key: str, other: str) -> float:
    return float(found.similarity[found.effects.index(key), found.effects.index(other)])


@pytest.fixture(scope="module")
def of_position(quiet, given) -> Confusability:
    return confusability(fit_base(given, [quiet]))


def test_an_effect_is_like_itself_only_to_be_sure(of_position: Confusability):
    assert np.nanmin(np.diag(of_position.similarity)) == pytest.approx(1.0)
    visible = np.isfinite(of_position.similarity)
    assert of_position.similarity[visible].min() >= 0.0
    assert of_position.similarity[visible].max() <= 1.0


def test_hardening_spring_and_bowed_linkage_are_one_static_map(of_position: Confusability):
    assert similarity(of_position, "spring_hardening", "linkage_nonlinearity") > 0.98
    assert similarity(of_position, "spring_hardening", "coil_lag") < 0.5


def test_good_gauge_tells_the_lags_of_its_two_sides_apart(minute, given, of_position: Confusability):
    with_gauge = replace(experiment_of(minute), pressure_noise=10.0)
    with_pressure = confusability(fit_base(given, [with_gauge]), LAGS)
    assert similarity(of_position, "sensor_lag", "coil_lag") > 0.9
    assert similarity(with_pressure, "sensor_lag", "coil_lag") < 0.5
    assert similarity(with_pressure, "chamber_filling", "coil_lag") > 0.9


def test_what_changes_nothing_is_not_visible(quiet, given):
    # in noise wider than any effect every trace drowns
    loud = fit_base(given, [quiet])
    noisy = [replace(quiet, noise=1e4 * quiet.noise)]
    found = confusability(fit_base(given, noisy), LAGS)
    assert np.all(found.visibility < confusability(loud, LAGS).visibility / 5000.0)
    assert np.all(np.isnan(found.similarity))
    content = json.dumps(finite(found.as_json()), allow_nan=False)
    assert json.loads(content)["similarity"][0] == [None] * 3
