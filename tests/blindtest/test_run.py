"""A blind test seals before it diagnoses, goes on where it stopped, and refuses what was changed."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from diagnosis.blindtest.plants import draw_plant
from diagnosis.trials import answering
from diagnosis.trials.baseline import name_by_least_squares
from diagnosis.trials.blindtest import run_blindtest
from diagnosis.trials.plan import Settings, tasks_of
from diagnosis.trials.sealing import Places, check_settings, hash_of, hash_of_all, make_plant, open_truth, read_seal
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.records import read_record
from valvemodel.valves import read_valve

EXAMPLE = Path(__file__).resolve().parents[2] / "diagnosis" / "examples" / "demo.csv"
QUICK = Settings(seed=5, kinds=("single",), only=("end_stop",))


@pytest.fixture
def broken(monkeypatch):
    """Let each diagnosis look for the seal and the truths' hashes, and break off."""

    def look(records, *arguments, **options):
        folder = look.folder
        assert read_seal(Places(folder))["truths"].keys() == {path.stem for path in (folder / "sealed").iterdir()}
        raise RuntimeError("sealed")

    monkeypatch.setattr(answering, "diagnose", look)
    return look


@pytest.fixture(scope="module")
def sealed_once(tmp_path_factory):
    """One plant, sealed, with a diagnosis that broke off."""
    folder = tmp_path_factory.mktemp("blind")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(answering, "diagnose", lambda *arguments, **options: 1 / 0)
        run_blindtest(QUICK, 1, folder, jobs=1)
    return folder


def test_truth_is_sealed_before_the_first_diagnosis(tmp_path: Path, broken):
    broken.folder = tmp_path
    test = run_blindtest(QUICK, 2, tmp_path, jobs=1)
    errors = [json.loads(path.read_text())["error"] for path in tmp_path.glob("answers/*/answer.json")]
    assert errors == ["RuntimeError: sealed"] * 2
    assert [each.mark.outcome for each in test.results] == ["failed"] * 2
    assert test.sha256 == hash_of_all({path.stem: hash_of(path) for path in (tmp_path / "sealed").iterdir()})


def test_what_is_opened_is_the_plant_that_was_drawn(sealed_once: Path):
    task = tasks_of(QUICK, 1)[0]
    places = Places(sealed_once)
    opened = open_truth(task, places, read_seal(places)["truths"])
    assert opened == draw_plant(task.seeds["plant"], task.effects, nuisance=True)
    header = places.record(task).read_text().splitlines()[0]
    assert header == "time [s],current [mA],position [mm]"


def test_same_command_goes_on_and_more_plants_come_on_top(sealed_once: Path, broken):
    broken.folder = sealed_once
    before = {path: path.stat().st_mtime_ns for path in sealed_once.rglob("plant-0001*") if path.is_file()}
    assert before
    test = run_blindtest(QUICK, 2, sealed_once, jobs=1)
    assert len(test.results) == 2
    assert {path: path.stat().st_mtime_ns for path in before} == before
    first = json.loads((sealed_once / "answers" / "plant-0001" / "answer.json").read_text())
    assert first["error"].startswith("ZeroDivisionError")


def test_folder_of_another_test_is_refused(sealed_once: Path):
    with pytest.raises(InputError, match="another seed"):
        run_blindtest(Settings(seed=6, kinds=("single",), only=("end_stop",)), 1, sealed_once)


def test_a_slower_logger_reads_some_of_the_same_rows(sealed_once: Path, tmp_path: Path):
    slow = replace(QUICK, every=4)
    (task,), places = tasks_of(slow, 1), Places(tmp_path)
    make_plant(task, places, slow)
    whole, some = (read_record(each.record(task)) for each in (Places(sealed_once), places))
    for name in ("time", "current", "position"):
        assert np.array_equal(getattr(some, name), getattr(whole, name)[::4])


def test_a_current_measured_with_noise_is_that_of_the_same_run(sealed_once: Path, tmp_path: Path):
    noisy = replace(QUICK, current_noise=8e-6)
    (task,), places = tasks_of(noisy, 1), Places(tmp_path)
    make_plant(task, places, noisy)
    exact, measured = (read_record(each.record(task)) for each in (Places(sealed_once), places))
    assert np.array_equal(measured.position, exact.position)
    assert np.std(measured.current - exact.current) == pytest.approx(8e-6, rel=0.05)


def test_a_folder_from_before_there_were_slower_loggers_goes_on(sealed_once: Path):
    places = Places(sealed_once)
    before = places.seal.read_text()
    content = json.loads(before)
    for later in ("every", "current_noise"):
        del content["settings"][later]
    places.seal.write_text(json.dumps(content))
    try:
        check_settings(places, QUICK)
        with pytest.raises(InputError, match="every"):
            check_settings(places, replace(QUICK, every=4))
    finally:
        places.seal.write_text(before)


@pytest.mark.parametrize("place", ["sealed/plant-0001.json", "records/plant-0001.csv"])
def test_changed_files_are_refused(sealed_once: Path, place: str):
    path = sealed_once / place
    whole = path.read_text()
    path.write_text(whole.replace("1", "2", 1))
    try:
        with pytest.raises(InputError, match="was changed"):
            run_blindtest(QUICK, 1, sealed_once, jobs=1)
    finally:
        path.write_text(whole)


def test_baseline_names_the_effect_that_leaves_least():
    valve = read_valve("calibrated")
    record = read_record(EXAMPLE)
    record = replace(record, time=record.time[:2500], current=record.current[:2500], position=record.position[:2500])
    said = name_by_least_squares(record, Model(valve.name, valve.values), ["coil_lag", "asymmetric_filling"])
    assert said["effects"] == ["asymmetric_filling"]
    assert said["gap_after"] < 1e-3
