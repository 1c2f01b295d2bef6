"""The diagnosis names what is in blind plants, says none where nothing is, and keeps its contract."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from diagnosis.blindtest.plants import Truth, draw_plant, measure
from diagnosis.diagnosing import diagnose, errors_as_given, said_of_given
from diagnosis.score import closed_share, persistence_of
from diagnosis.valve_diagnosis import Diagnosis
from diagnosis.whereabouts.regimes import regimes_of
from identification.driving.timing import END_OF_PERIOD, answers_own_row
from identification.experiment import experiment_of
from identification.holdout import hold_out
from identification.results.regimes import masks_of, time_since_reversal
from valvemodel.errors import InputError
from valvemodel.loops import settle_loop
from valvemodel.model import Model, read_model
from valvemodel.records import Record
from valvemodel.valves import read_valve


def record_of_plant(seed: int, effects: tuple[str, ...], *, profile: int = 1000, **options: object) -> Record:
    taken = measure(draw_plant(seed, effects), seed + profile, **options)
    return Record.from_arrays(
        name=f"plant {seed}",
        time=taken["time"],
        current=taken["current"],
        position=taken["position"],
        pressure=taken.get("pressure"),
    )


def calibrated() -> Model:
    valve = read_valve("calibrated")
    return Model(valve.name, valve.values)


@pytest.fixture(scope="module")
def viscous() -> Diagnosis:
    return diagnose([record_of_plant(1, ("asymmetric_viscous_friction",))], calibrated(), jobs=2)


def test_names_the_effect_of_a_blind_plant(viscous: Diagnosis) -> None:
    assert viscous.verdict == "effect"
    assert viscous.cause.effects == ("asymmetric_viscous_friction",)
    assert viscous.cause.probability > 0.8
    assert viscous.stage == "stem"
    assert viscous.cause.closed is not None
    assert viscous.cause.closed > 0.9


@pytest.mark.parametrize(("quick_share", "named"), [(1.0, "chamber_filling"), (0.5, "asymmetric_filling")])
def test_filling_is_unequal_where_it_differs_from_venting(quick_share: float, named: str) -> None:
    lags = {"slow_direction": -1.0, "quick_share": quick_share, "slow_time": 0.15}
    truth = Truth("asymmetric_filling", "nozzle", "two_time_constants", lags)
    taken = measure(replace(draw_plant(11, ()), effects=(truth,)), 1011)
    rivals = ("chamber_filling", "asymmetric_filling", "coil_lag", "sensor_lag", "transport_delay")
    found = diagnose([Record.from_arrays(name="lag", **taken)], calibrated(), candidates=rivals, jobs=2)
    assert found.cause.effects == (named,)
    assert found.cause.probability > 0.9
    assert found.cause.rivals == []


@pytest.mark.parametrize(
    ("effect", "candidates"),
    [
        ("transport_delay", ("transport_delay", "coil_lag", "chamber_filling", "presliding", "sensor_lag")),
        # Without the pressure the sensor would be in doubt: what could imitate the drift is all that is tried.
        ("gap_drift", ("sensor_drift", "friction_drift")),
    ],
)
def test_pressure_tells_the_stage(effect: str, candidates: tuple[str, ...]) -> None:
    record = record_of_plant(2, (effect,), duration=90.0, with_pressure=True)
    found = diagnose([record], calibrated(), candidates=candidates, jobs=2)
    assert found.stage in ("nozzle", "electromagnet")
    assert found.stage_probability["sensor"] < 0.05


@pytest.mark.parametrize("seed", [501, 503])
def test_says_none_where_nothing_is_missing(seed: int) -> None:
    found = diagnose([record_of_plant(seed, ())], calibrated(), jobs=2)
    assert found.verdict == "none"
    assert found.cause.effects == ()
    assert found.stage is None


def test_scores_on_another_record() -> None:
    records = [record_of_plant(1, ("end_stop",), profile=profile) for profile in (1000, 2000)]
    found = diagnose(records, calibrated(), jobs=2)
    assert found.cause.effects == ("end_stop",)
    assert found.as_json()["gap"]["scored_on"] == "other records"


def test_contract_of_the_json(viscous: Diagnosis) -> None:
    content = json.loads(json.dumps(viscous.as_json(), allow_nan=False))
    assert content["schema"] == "valvemodel.diagnosis/1"
    total = content["unknown_probability"] + sum(cause["probability"] for cause in content["causes"])
    assert total == pytest.approx(1.0)
    probabilities = [cause["probability"] for cause in content["causes"]]
    assert probabilities == sorted(probabilities, reverse=True)
    assert any(cause["effects"] == [] for cause in content["causes"])
    assert sum(content["where"]["stage_probability"].values()) <= 1.0 + 1e-9
    gap, best = content["gap"], content["causes"][0]
    assert gap["noise_floor"] <= gap["with_cause"] < gap["refitted"] < gap["as_given"]
    assert best["gap_after"] == gap["with_cause"]
    expected = (gap["refitted"] - best["gap_after"]) / (gap["refitted"] - gap["noise_floor"])
    assert best["gap_closed"] == pytest.approx(expected)
    low, high = best["gap_closed_interval"]
    assert low <= best["gap_closed"] <= high
    assert {"name", "where", "rms", "share"} <= set(content["where"]["regimes"][0])
    value = best["parameters"]["asymmetric_viscous_friction"]["viscous_asymmetry"]
    assert value["std"] > 0.0


def test_a_diagnosis_stays_as_it_is_whatever_its_json_is_made_into(viscous: Diagnosis) -> None:
    content = viscous.as_json()
    changed = (content["where"]["regimes"][0], content["control"], content["base"]["numbers"][0])
    for part, whole in zip(changed, (viscous.regimes[0], viscous.control, viscous.base_numbers[0]), strict=True):
        before = replace(whole)
        part.update(dict.fromkeys(part, None))
        assert whole == before


def test_files_can_be_read_again(viscous: Diagnosis, tmp_path) -> None:
    places = viscous.write(tmp_path / "deep" / "folder")
    assert {path.name for path in places.values()} == {
        "diagnosis.json", "base.json", "model.json", "report.html",
    }  # fmt: skip
    assert read_model(places["model.json"]).effects.keys() == {"asymmetric_viscous_friction"}
    assert not read_model(places["base.json"]).effects
    assert not list((tmp_path / "deep" / "folder").glob(".*"))


def test_rows_at_the_end_of_their_period_are_noticed() -> None:
    record = record_of_plant(3, ())
    shifted = Record.from_arrays(
        name="end", time=record.time[:-1], current=record.current[:-1], position=record.position[1:]
    )
    assert not answers_own_row(record)
    assert answers_own_row(shifted)
    found = diagnose([shifted], calibrated(), jobs=2)
    assert END_OF_PERIOD in found.warnings
    assert found.verdict == "none"


def test_a_slip_by_chance_in_the_row_of_a_step_is_not_taken_for_readings_at_the_end() -> None:
    record = record_of_plant(3, ())
    jumped = int(np.argmax(np.abs(np.diff(record.current)))) + 1
    position = record.position.copy()
    position[jumped:] += 0.05 * np.sign(record.current[jumped] - record.current[jumped - 1])
    assert not answers_own_row(
        Record.from_arrays(name="slip", time=record.time, current=record.current, position=position)
    )


@pytest.mark.parametrize("step", [2e-3, 6e-3])
def test_coarse_readings_are_not_taken_for_readings_at_the_end_of_their_period(step: float) -> None:
    record = record_of_plant(3, ())
    for phase in np.linspace(0.0, step, 12, endpoint=False):
        coarse = step * np.round((record.position - phase) / step) + phase
        assert not answers_own_row(
            Record.from_arrays(name="coarse", time=record.time, current=record.current, position=coarse)
        )


def test_a_model_of_another_valve_is_said_to_be_one(viscous: Diagnosis) -> None:
    holdout = viscous.holdout
    other = viscous.given.with_values(spring_rate=0.2 * viscous.given.values["spring_rate"])
    off = errors_as_given(other, holdout, "free")
    assert off.rms > 0.5
    assert "it is another valve's" in said_of_given(off, holdout)[0]
    assert said_of_given(viscous.as_given, holdout) == []


def test_held_out_samples_are_not_fitted() -> None:
    holdout = hold_out([experiment_of(record_of_plant(3, ()))])
    assert not np.any(holdout.fitted[0] & holdout.scored[0])
    assert 0.25 < holdout.scored[0].mean() < 0.42


def test_persistence_of_white_and_of_slow_errors() -> None:
    generator = np.random.default_rng(1)
    white = generator.standard_normal(4000)
    assert persistence_of(white) == pytest.approx(1.0, abs=0.2)
    slow = np.convolve(white, np.ones(20), "valid")
    assert 12.0 < persistence_of(slow) < 30.0


def test_closed_share() -> None:
    assert closed_share(3.0, 2.0, 1.0) == 0.5
    assert closed_share(1.0, 1.0, 1.0) is None


def test_time_since_reversal() -> None:
    time = np.arange(6.0)
    mode = np.array([1.0, 0.0, 0.0, -1.0, -1.0, 1.0])
    assert list(time_since_reversal(time, mode)) == [math.inf, math.inf, math.inf, 0.0, 1.0, 0.0]


def test_regimes_cover_the_record() -> None:
    experiment = experiment_of(record_of_plant(3, ()))
    mode = np.sign(np.gradient(experiment.position))
    masks = masks_of(experiment, mode)
    thirds = [masks[name] for name in ("low", "middle", "high")]
    assert np.all(sum(mask.astype(int) for mask in thirds) == 1)


def test_regimes_of_two_records_are_told_once() -> None:
    time = np.arange(3000) * 0.02
    position = 0.15 + 0.1 * np.sin(0.5 * time)
    whole = experiment_of(Record.from_arrays(name="whole", time=time, current=0.012 + 0.0 * time, position=position))
    half = replace(
        whole, time=time[:1500], current=whole.current[:1500], position=0.5 * position[:1500], block=whole.block[:1500]
    )
    alike = [np.ones(3000), np.ones(1500)]
    regimes = regimes_of([whole, half], alike, alike)
    found = {each.name: each for each in regimes}
    assert len(found) == len(regimes)
    assert found["early"].where == "in the first third of each record, before 10 to 20 s"
    assert found["low"].where == "in the lower third of the travel, below 58 to 117 mm"
    assert found["early"].share == found["early"].time_share == pytest.approx(1.0 / 3.0, abs=1e-3)
    assert found["low"].share + found["middle"].share + found["high"].share == pytest.approx(1.0)


@pytest.mark.parametrize(("candidates", "arrived"), [(["sensor_lag"], "sensor lag"), ([], "none was named")])
def test_candidates_that_cannot_show_are_refused(candidates: list[str], arrived: str) -> None:
    current = np.concatenate([np.arange(4.0, 18.0), np.arange(18.0, 4.0, -1.0)]) * 1e-3
    loop = Record.from_arrays(name="loop", current=current, position=settle_loop(calibrated(), current=current))
    with pytest.raises(InputError, match="at least one of the candidates can show") as caught:
        diagnose([loop], calibrated(), candidates=candidates)
    assert arrived in caught.value.arrived
