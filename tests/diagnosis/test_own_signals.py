"""Each stage is asked what its own signals explain: plants of an independent route whose effect has no name here."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from diagnosis.blindtest.plants import draw_plant, measure
from diagnosis.judging.stages import with_own_signals
from diagnosis.report.where import where_section
from diagnosis.whereabouts.own_signals import Explained, Trial, explained_by_stages
from diagnosis.whereabouts.residual_curves import Curve, curves_of_own_signals
from diagnosis.whereabouts.stage_functions import OF_STAGE, Seen, play
from diagnosis.whereabouts.where import where_of
from identification.experiment import Experiment, experiment_of
from identification.fit import Fit, fit_base, simulate_model
from valvemodel.declarations import STAGES
from valvemodel.effects import effect_of_key
from valvemodel.model import Model
from valvemodel.records import Record

LEADS = {
    "gap_drift": "a gap that creeps with time",
    "coil_lag": "a lag of the current",
    "supply_droop": "a pressure that sags when it changes",
    "chamber_filling": "a lag of the pressure",
    "position_dependent_friction": "friction by position",
    "asymmetric_viscous_friction": "a force by speed",
    "friction_drift": "friction by time",
    "sensor_lag": "a lag of the reading",
    "sensor_drift": "a zero that creeps with time",
}
"""What of its stage's signals each effect is."""


@pytest.fixture(scope="module")
def fitted(given: Model) -> Callable[..., tuple[Experiment, Fit]]:
    """Fit the base to the record of a plant with some effects, once for each."""

    @cache
    def fit(*effects: str, seed: int, with_pressure: bool = False) -> tuple[Experiment, Fit]:
        taken = measure(draw_plant(seed, effects), seed + 1000, duration=100.0, with_pressure=with_pressure)
        experiment = experiment_of(Record.from_arrays(name="plant", **taken))
        return experiment, fit_base(given, [experiment])

    return fit


def asked(experiment: Experiment, base: Fit) -> list[Explained]:
    return explained_by_stages(experiment, base, base.starts[0], STAGES, None)


@pytest.fixture(scope="module")
def told(fitted: Callable[..., tuple[Experiment, Fit]]) -> Callable[..., list[Explained]]:
    """Ask all stages about the record of a plant with an effect, once for each."""

    @cache
    def ask(effect: str, seed: int) -> list[Explained]:
        return asked(*fitted(effect, seed=seed))

    return ask


@pytest.mark.parametrize("effect", LEADS)
def test_stage_of_an_effect_explains_most_and_by_what_it_is(told, effect: str) -> None:
    found = told(effect, 21)
    stage = effect_of_key(effect).stage
    assert stage in [each.stage for each in found[:2]]
    own = next(each.as_json() for each in found if each.stage == stage)
    assert next(iter(own["closed_by"])) == LEADS[effect]
    assert own["gap_closed"] >= own["closed_by"][LEADS[effect]] > 0.5
    # Another stage has not what it takes.
    assert found[0].excess < 0.5 * found[-1].excess


def test_what_is_explained_is_what_was_added(fitted) -> None:
    """A creep of the reading is found in size and course, laid on top of what the base reads."""
    experiment, base = fitted(seed=22)
    run = base.simulated_on(experiment)
    added = 6e-3 * (experiment.time / experiment.time[-1]) ** 2
    noise = experiment.noise * np.random.default_rng(3).standard_normal(len(added))
    found = asked(replace(experiment, position=run.position[0] + added + noise), base)
    assert found[0].stage == "sensor"
    assert found[0].left < 1.1 * experiment.noise < 5.0 * experiment.noise < found[0].missed
    # The base valve may take its part of what goes with the position.
    assert np.corrcoef(found[0].lead.values, added)[0, 1] > 0.9
    assert np.std(found[0].lead.values) == pytest.approx(np.std(added), rel=0.2)


def test_functions_see_no_more_than_their_stage() -> None:
    """A stage's functions stay as they are when what goes through another stage is changed."""
    generator = np.random.default_rng(0)
    signals = {name: np.cumsum(generator.standard_normal(400)) for name in ("current", "pressure", "position")}
    signals |= {"speed": generator.standard_normal(400), "friction": generator.uniform(-1.0, 1.0, 400)}
    seen = Seen(0.02 * np.arange(400), **{name: each - each.min() for name, each in signals.items()})
    others = {"electromagnet": "position", "nozzle": "current", "stem": "current", "sensor": "pressure"}
    for stage, other in others.items():
        changed = replace(seen, **{other: getattr(seen, other)[::-1]})
        for part, its in zip(OF_STAGE[stage](seen), OF_STAGE[stage](changed), strict=True):
            assert all(np.array_equal(part[kind], its[kind]) for kind in part), stage


def test_play_lags_by_its_half_width() -> None:
    there_and_back = np.concatenate([np.linspace(0.0, 1.0, 101), np.linspace(1.0, 0.0, 101)])
    behind = there_and_back + play(there_and_back, 0.1)
    assert behind[100] == pytest.approx(0.9)
    assert behind[-1] == pytest.approx(0.1)
    assert not np.diff(behind[101:121]).any()


def test_what_a_stage_leaves_weighs_its_hint(given: Model) -> None:
    experiment = replace(experiment_of_nothing(), noise=1e-4)
    left = dict(zip(STAGES, (2e-4, 1e-3, 1.1e-4, 1e-3), strict=True))
    nothing = Trial(given, 0.0, np.zeros(3), 2e-3)
    explained = [Explained(stage, experiment, 2e-3, each, {}, nothing) for stage, each in left.items()]
    even = dict.fromkeys(STAGES, 0.25)
    weighed = with_own_signals(even, explained)
    assert sum(weighed.values()) == pytest.approx(1.0)
    assert sorted(weighed, key=lambda stage: -weighed[stage])[:2] == ["stem", "electromagnet"]
    assert with_own_signals(even, []) == even
    # Those that were not asked keep their hints.
    behind = with_own_signals(even, explained[2:])
    assert behind["electromagnet"] == behind["nozzle"] == 0.25
    assert behind["stem"] > 10.0 * behind["sensor"]
    assert sum(behind.values()) == pytest.approx(1.0)


def experiment_of_nothing() -> Experiment:
    time = 0.02 * np.arange(3)
    return Experiment("nothing", time, 0.0 * time, 0.0 * time, None, 1.0, 1.0, np.zeros(3, int))


def test_settled_loop_is_asked_without_what_acts_in_time(given: Model) -> None:
    up = np.linspace(5e-3, 19e-3, 40)
    current = np.concatenate([up, up[::-1]])
    position = 0.2 * ((current - 4e-3) / 16e-3) ** 1.5 + 2e-3 * np.sign(np.gradient(current))
    loop = experiment_of(Record.from_arrays(name="loop", current=current, position=position))
    base = fit_base(given, [loop])
    found = asked(loop, base)
    assert {each.stage for each in found} == set(STAGES)
    kinds = [kind for each in found for kind in each.left_by]
    assert not [kind for kind in kinds if any(word in kind for word in ("lag", "time", "sags", "speed"))]
    assert all(np.isfinite(each.left) and each.left <= each.missed * (1.0 + 1e-9) for each in found)
    assert "time" not in {curve.against for curve in curves_of_own_signals(found)}


def test_slowly_logged_record_is_asked_too(given: Model) -> None:
    """At 2 Hz the stem has come to rest before each row; which way it went is told by the rows."""
    taken = measure(draw_plant(23, ("position_dependent_friction",)), 1023, duration=300.0, rate=2.0)
    experiment = experiment_of(Record.from_arrays(name="slow", **taken))
    found = asked(experiment, fit_base(given, [experiment]))
    curves = list(curves_of_own_signals(found))
    assert {"force", "friction"} <= {curve.signal for curve in curves}


def test_what_the_base_makes_of_one_record_alone_is_none_of_a_stages(given: Model, fitted) -> None:
    """Two records of valves with another spring and friction, nothing else missing, fitted together."""
    experiment, _ = fitted(seed=22)
    generator = np.random.default_rng(4)

    def of_valve(name: str, **values: float) -> Experiment:
        run = simulate_model(given.with_values(**values), experiment, start_position=0.05)
        noisy = run.position[0] + 1e-4 * generator.standard_normal(len(experiment.time))
        return experiment_of(
            Record.from_arrays(name=name, time=experiment.time, current=experiment.current, position=noisy)
        )

    one, other = of_valve("one", spring_rate=52.5e3), of_valve("other", spring_rate=55e3, coulomb_friction=1700.0)
    both = fit_base(given, [one, other])
    assert both.found.error > 3.0 * both.problem.noise_error
    for each in explained_by_stages(one, both, both.starts[0], STAGES, None):
        assert each.missed < 1.2 * one.noise
        assert each.excess < 0.3


def test_lag_is_that_of_the_times_that_there_are() -> None:
    """Rows at random times, a signal held between them, against the closed form of its steps."""
    time = np.sort(np.random.default_rng(2).uniform(0.0, 20.0, 400))
    signal = np.where(time > 10.0, 1.0, 0.0)
    seen = Seen(time, signal, signal, signal, signal, signal)
    stepped = time[np.argmax(signal)]
    expected = np.where(time >= stepped, -np.exp(-(time - stepped) / 0.3), 0.0)
    assert seen.lag(signal, 0.3) == pytest.approx(expected, abs=1e-12)


def test_unknown_cause_is_told_by_what_its_stage_would_have_to_do(fitted) -> None:
    experiment, base = fitted("position_dependent_friction", seed=21)
    where = where_of([experiment], base).with_own_signals(None)
    content = where.as_json()
    json.dumps(content, allow_nan=False)
    assert {each["stage"] for each in content["own_signals"]} == set(STAGES)
    sentences = where_section({"where": content | {"open_stages": ["stem", "nozzle"]}}).sentences
    assert any("what goes through its stage" in each for each in sentences)
    assert any("In the stem, friction by position closes" in each for each in sentences)
    stem = [each for each in where.explained if each.stage == "stem"]
    curves = list(curves_of_own_signals(stem))
    assert {curve.signal for curve in curves} == {"force", "friction"}


def curves_of_stem(explained: list[Explained]) -> list[Curve]:
    stem = [each for each in explained if each.stage == "stem"]
    return sorted(curves_of_own_signals(stem), key=lambda curve: -curve.share)


@pytest.mark.parametrize("seed", [21, 23])
def test_friction_over_position_shows_where_the_tight_spot_is(told, seed: int) -> None:
    plant = draw_plant(seed, ("position_dependent_friction",))
    curve = curves_of_stem(told("position_dependent_friction", seed))[0]
    assert (curve.signal, curve.against, curve.unit) == ("friction", "position", "N")
    true_place = next(each.parameters["centre"] for each in plant.effects if not each.nuisance)
    assert curve.at[np.argmax(curve.mean)] == pytest.approx(true_place, abs=0.015)
    assert curve.share > 0.5


def test_friction_that_differs_up_and_down_goes_with_the_speed(told) -> None:
    curve = curves_of_stem(told("asymmetric_viscous_friction", 21))[0]
    assert curve.against == "speed"
    assert curve.share > 0.5


def test_behind_a_measured_pressure_stem_and_sensor_are_asked(fitted) -> None:
    experiment, base = fitted("position_dependent_friction", seed=23, with_pressure=True)
    where = where_of([experiment], base).with_own_signals(None)
    assert [each.stage for each in where.explained] == ["stem", "sensor"]
    assert where.explained[0].as_json()["gap_closed"] > 0.6
    assert "behind the measured pressure" in where_section({"where": where.as_json()}).sentences[-1]
    assert next(iter(where.explained[0].left_by)) == "friction by position"


def test_nothing_is_asked_where_a_cause_was_found(fitted) -> None:
    experiment, base = fitted(seed=22)
    assert where_of([experiment], base).as_json()["own_signals"] == []
