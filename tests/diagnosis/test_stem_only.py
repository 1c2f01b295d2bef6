"""Records of force and position alone: the contract of the answer, on made-up strokes and on EMPS."""

from __future__ import annotations

import json
import math
import os
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from diagnosis.stem.diagnosing import StemOnlyDiagnosis, diagnose_stem_records, model_of
from diagnosis.told import SCHEMA
from valvemodel.declarations import STAGES
from valvemodel.effects import effect_of_key
from valvemodel.errors import InputError
from valvemodel.model import Model, read_model
from valvemodel.records import Record, read_record
from valvemodel.simulation import simulate

MASS, VISCOUS, COULOMB, PRELOAD = 20.0, 150.0, 25.0, 4.0
GIVEN = Model(
    "near",
    {"stem_mass": 18.0, "viscous_friction": 140.0, "coulomb_friction": 22.0, "spring_rate": 0.0},
)


@cache
def strokes(
    name: str = "strokes", *, asymmetry: float = 0.0, spring: float = 0.0, ripple: float = 0.0, seed: int = 1
) -> Record:
    """Return a known motion with the force that it takes, its derivatives in closed form."""
    noise = np.random.default_rng(seed)
    time = np.arange(16000) / 1000.0
    position, velocity, acceleration = 0.15 + 0.0 * time, 0.0 * time, 0.0 * time
    for size, period in ((0.09, 7.3), (0.04, 2.1), (0.01, 0.83)):
        way, phase = 2.0 * math.pi / period, seed * period
        position += size * np.sin(way * time + phase)
        velocity += size * way * np.cos(way * time + phase)
        acceleration -= size * way**2 * np.sin(way * time + phase)
    side = np.sign(velocity)
    force = MASS * acceleration + VISCOUS * (1.0 + asymmetry * side) * velocity + COULOMB * side + PRELOAD
    force += spring * position + ripple * np.sin(2.0 * math.pi * position / 0.012)
    return Record.from_arrays(
        name,
        time=time,
        force=force + 0.3 * noise.standard_normal(time.size),
        position=position + 1e-7 * noise.standard_normal(time.size),
        warnings=("a doubt",),
    )


@cache
def found(**truth: float) -> StemOnlyDiagnosis:
    """Return the diagnosis of one record, made once."""
    return diagnose_stem_records([strokes(**truth)], GIVEN)


def check_contract(content: dict) -> None:
    """Check a diagnosis.json against the contract of the command."""
    json.dumps(content, allow_nan=False)
    assert content["schema"] == SCHEMA == "valvemodel.diagnosis/1"
    assert content["verdict"] in ("effect", "none", "unknown")
    where, causes, gap = content["where"], content["causes"], content["gap"]
    assert where["stage"] == (None if content["verdict"] == "none" else "stem")
    assert set(where["stage_probability"]) == set(STAGES)
    keys = {"name", "where", "rms", "share", "time_share"}
    assert all(set(regime) == keys for regime in where["regimes"])
    probabilities = [cause["probability"] for cause in causes]
    assert sum(probabilities) + content["unknown_probability"] == pytest.approx(1.0)
    assert probabilities == sorted(probabilities, reverse=True)
    assert [] in [cause["effects"] for cause in causes]
    for cause in causes:
        assert set(cause) == {
            "effects", "probability", "parameters", "gap_after", "gap_closed", "gap_closed_interval",
            "indistinguishable_from",
            "may_hide_beside",
        }  # fmt: skip
        assert set(cause["parameters"]) == set(cause["effects"])
        for key, parameters in cause["parameters"].items():
            for name, entry in parameters.items():
                declared = effect_of_key(key).parameter(name)
                assert declared.low <= entry["value"] <= declared.high
                assert entry["unit"] == declared.unit
                assert entry["std"] is None or entry["std"] >= 0.0
    assert gap["unit"] == "N"
    assert gap["scored_on"] in ("held-out blocks", "other records")
    assert gap["with_cause"] == causes[0]["gap_after"]
    assert gap["noise_floor"] <= gap["with_cause"] * (1.0 + 1e-9)
    if causes[0]["gap_closed"] is not None:
        share = (gap["refitted"] - causes[0]["gap_after"]) / (gap["refitted"] - gap["noise_floor"])
        assert causes[0]["gap_closed"] == pytest.approx(share)


@pytest.mark.parametrize(
    ("truth", "verdict"),
    [({"asymmetry": 0.3}, "effect"), ({}, "none"), ({"ripple": 8.0}, "unknown"), ({"spring": 2e3}, "none")],
)
def test_the_answer_keeps_the_contract(truth, verdict):
    diagnosis = found(**truth)
    content = diagnosis.as_json()
    check_contract(content)
    assert content["verdict"] == diagnosis.verdict == verdict
    assert content["gap"]["scored_on"] == "held-out blocks"
    assert content["records"] == ["strokes"]


def test_the_cause_its_size_and_the_gap_are_found():
    content = found(asymmetry=0.3).as_json()
    best = content["causes"][0]
    assert best["effects"] == ["asymmetric_viscous_friction"]
    entry = best["parameters"]["asymmetric_viscous_friction"]["viscous_asymmetry"]
    assert entry["value"] == pytest.approx(0.3, rel=0.02)
    assert 0.0 < entry["std"] < 0.02
    assert best["gap_closed"] > 0.9
    assert content["where"]["stage_probability"]["stem"] > 0.9
    assert content["gap"]["as_given"] > content["gap"]["refitted"] > content["gap"]["with_cause"]


def test_regimes_are_parts_of_the_same_error():
    regimes = {regime.name: regime for regime in found(asymmetry=0.3).regimes}
    for name in ("rising", "falling", "near_rest", "high_speed", "early", "late", "low", "high"):
        assert 0.0 < regimes[name].share < 1.0, name
    assert regimes["rising"].share + regimes["falling"].share == pytest.approx(1.0)
    assert regimes["high_speed"].rms > regimes["near_rest"].rms
    assert "stuck" not in regimes


def test_the_files_are_written_and_the_models_run(tmp_path):
    diagnosis = found(asymmetry=0.3)
    places = diagnosis.write(tmp_path / "new" / "answer")
    assert set(places) == {"diagnosis.json", "base.json", "model.json", "report.html"}
    assert json.loads(places["diagnosis.json"].read_text()) == json.loads(json.dumps(diagnosis.as_json()))
    base, model = read_model(places["base.json"]), read_model(places["model.json"])
    assert not base.effects
    assert model.effects["asymmetric_viscous_friction"]["viscous_asymmetry"] == pytest.approx(0.3, rel=0.02)
    truth = {
        "stem_mass": MASS,
        "viscous_friction": VISCOUS,
        "coulomb_friction": COULOMB,
        "spring_preload": PRELOAD,
    }
    for name, value in truth.items():
        assert model.values[name] == pytest.approx(value, rel=0.02), name
    assert model.values["spring_rate"] == base.values["spring_rate"] == 0.0
    assert model.values["diaphragm_area"] == GIVEN.values["diaphragm_area"]
    time = np.arange(50) * 0.02
    for each in (base, model):
        moved = simulate(each, time=time, current=np.full(50, 0.01), start_position=0.1)
        assert np.isfinite(moved.position).all()


def test_the_report_speaks_of_force_and_not_of_current(tmp_path):
    for number, truth in enumerate(({"asymmetry": 0.3}, {}, {"ripple": 8.0})):
        page = found(**truth).write(tmp_path / str(number))["report.html"].read_text()
        assert "Force against position" in page
        assert "Force over time" in page
        assert " current" not in page


def test_a_spring_is_written_into_the_models():
    diagnosis = found(spring=2e3)
    assert diagnosis.base.values["spring_rate"] == pytest.approx(2e3, rel=0.02)
    assert not any("no spring" in warning for warning in diagnosis.warnings)


def test_what_no_valve_can_have_stays_as_given_and_is_said():
    fit = found().base_fit
    heavy = fit.parameters["stem_mass"]._replace(value=-3.0)
    model, notes = model_of(replace(fit, parameters={**fit.parameters, "stem_mass": heavy}), GIVEN, "strokes")
    assert model.values["stem_mass"] == GIVEN.values["stem_mass"]
    assert model.values["coulomb_friction"] == pytest.approx(COULOMB, rel=0.02)
    assert len(notes) == 1
    assert "stem_mass must be positive" in notes[0]
    assert "-3" in notes[0]


def test_warnings_are_the_records_and_the_answers():
    warnings = found(asymmetry=0.3).warnings
    assert warnings[0] == "a doubt"
    assert any("spring rate of 0" in warning for warning in warnings)
    assert any("static friction" in warning for warning in warnings)
    assert not any("another valve" in warning for warning in warnings)
    other = diagnose_stem_records([strokes()], GIVEN.with_values(coulomb_friction=1423.0))
    assert any("another valve" in warning for warning in other.warnings)


def test_several_records_are_scored_on_the_last():
    records = [strokes(name, asymmetry=0.3, seed=seed) for seed, name in enumerate("abc", 1)]
    said = []
    diagnosis = diagnose_stem_records(records, GIVEN, progress=lambda what, share: said.append(share))
    content = diagnosis.as_json()
    check_contract(content)
    assert content["gap"]["scored_on"] == "other records"
    assert content["causes"][0]["effects"] == ["asymmetric_viscous_friction"]
    assert content["causes"][0]["gap_closed"] > 0.9
    assert content["records"] == ["a", "b", "c"]
    assert said == sorted(said)
    assert 0.0 <= said[0] <= said[-1] <= 1.0


def test_an_effect_that_the_last_record_lacks_is_not_named():
    records = [strokes("worn", asymmetry=0.3), strokes("sound", seed=2)]
    content = diagnose_stem_records(records, GIVEN).as_json()
    check_contract(content)
    assert content["verdict"] == "unknown"
    assert content["causes"][0]["effects"] == []


def test_a_record_without_noise_lacks_nothing():
    time = np.arange(16000) / 1000.0
    velocity = 0.1 * np.cos(time)
    force = -2.0 * np.sin(time) + VISCOUS * velocity + COULOMB * np.sign(velocity) + PRELOAD
    record = Record.from_arrays("clean", time=time, force=force, position=0.1 * np.sin(time))
    content = diagnose_stem_records([record], GIVEN).as_json()
    check_contract(content)
    assert content["verdict"] == "none"


def test_records_that_are_not_of_the_stem_alone_are_refused():
    valve = Record.from_arrays("valve", time=[0, 1], current=[0.004, 0.02], position=[0.0, 0.2])
    with pytest.raises(InputError, match="valve has a current"):
        diagnose_stem_records([strokes(), valve], GIVEN)
    with pytest.raises(InputError, match="at least one record"):
        diagnose_stem_records([], GIVEN)
    slow = strokes("slow")
    assert slow.time is not None
    slow = Record.from_arrays("slow", time=2.0 * slow.time, force=slow.force, position=slow.position)
    with pytest.raises(InputError, match="one sampling interval"):
        diagnose_stem_records([strokes(), slow], GIVEN)


@pytest.fixture(scope="module")
def emps() -> StemOnlyDiagnosis:
    beside = Path(__file__).resolve().parents[2].parent / "shared" / "data"
    file = Path(os.environ.get("VALVEMODEL_DATA", beside)) / "emps" / "emps.csv"
    if not file.exists():
        pytest.skip(f"no EMPS record: {file} does not exist; set VALVEMODEL_DATA")
    return diagnose_stem_records([read_record(file, needs=("force", "position"))], GIVEN)


def test_emps_lacks_direction_dependent_viscous_friction(emps):
    content = emps.as_json()
    check_contract(content)
    assert content["verdict"] == "effect"
    assert content["causes"][0]["effects"] == ["asymmetric_viscous_friction"]
    assert content["causes"][0]["gap_closed"] == pytest.approx(0.55, abs=0.05)
    assert content["gap"]["refitted"] == pytest.approx(2.38, abs=0.1)


def test_emps_base_model_is_the_published_one(emps):
    published = {
        "stem_mass": 95.1089,
        "viscous_friction": 203.5034,
        "coulomb_friction": 20.3935,
        "spring_preload": -3.1648,
    }
    for name, value in published.items():
        assert emps.base.values[name] == pytest.approx(value, rel=0.005), name
    values = emps.found.values
    share = emps.found.effects["asymmetric_viscous_friction"]["viscous_asymmetry"]
    assert values["viscous_friction"] * (1.0 + share) == pytest.approx(166.7061, rel=0.005)
    assert values["viscous_friction"] * (1.0 - share) == pytest.approx(240.4236, rel=0.005)


def test_shows_itself_and_draws_its_force():
    import matplotlib
    import matplotlib.pyplot as plt

    from identification import fit_records

    matplotlib.use("Agg")
    diagnosis = found(asymmetry=0.4)
    assert "asymmetric viscous friction" in repr(diagnosis)
    assert "</td>" in diagnosis._repr_html_()
    assert "N]" in "".join(diagnosis.to_pandas().columns)
    assert diagnosis.plot().get_ylabel() == "force [N]"
    assert diagnosis.plot_loop().get_xlabel() == "position [mm]"
    fit = fit_records([strokes()], GIVEN)
    assert fit.plot_residuals().get_ylabel() == "measured less model [N]"
    assert "</td>" in fit._repr_html_()
    plt.close("all")


def test_public_door_takes_either_kind():
    from diagnosis import diagnose

    record = strokes(asymmetry=0.4)
    assert repr(diagnose(record, GIVEN)) == repr(found(asymmetry=0.4))
    with pytest.raises(InputError, match="candidates are chosen for records with current"):
        diagnose(record, candidates=["stribeck"])
