"""`valvemodel fit` writes the contract's fit.json and a model that simulate takes."""

import json
import math
from pathlib import Path

import numpy as np
import polars
import pytest

from valvemodel import Model, read_valve

BASE = {
    "stem_mass": "kg",
    "spring_rate": "N/m",
    "supply_pressure": "Pa",
    "viscous_friction": "N*s/m",
    "coulomb_friction": "N",
    "gap_offset": "m",
    "gap_gain": "m/A^0.5",
}


def fitted(folder: Path) -> dict:
    return json.loads((folder / "fit.json").read_text(), parse_constant=lambda name: pytest.fail(name))


@pytest.fixture(scope="module")
def made_up(demo_record, tmp_path_factory) -> Path:
    """A record of a valve with known numbers and a little noise."""
    from valvemodel import Model, read_record, read_valve, simulate, write_table

    valve = read_valve("calibrated")
    model = Model("truth", {**valve.values, "spring_rate": 60000.0, "coulomb_friction": 1700.0})
    record = read_record(demo_record)
    kept = record.time < 40.0
    run = simulate(model, time=record.time[kept], current=record.current[kept])
    noise = np.random.default_rng(1).normal(0.0, 1e-4, len(run.time))
    path = tmp_path_factory.mktemp("made") / "made.csv"
    columns = {
        "time [s]": run.time,
        "current [mA]": 1e3 * run.current,
        "pressure [kPa]": 1e-3 * run.pressure,
        "position [mm]": 1e3 * (run.position + noise),
    }
    write_table(path, columns)
    return path


def test_known_numbers_come_back(command, made_up, tmp_path):
    result = command("fit", made_up, "--out", "fitted")
    assert result.exit_code == 0, result.output
    content = fitted(tmp_path / "fitted")
    assert content["schema"] == "valvemodel.fit/1"
    assert {name: each["unit"] for name, each in content["parameters"].items()} == BASE
    for each in content["parameters"].values():
        assert set(each) == {"value", "unit", "std", "at_bound"}
        assert each["std"] is None or each["std"] > 0.0
        assert isinstance(each["at_bound"], bool)
    assert content["parameters"]["spring_rate"]["value"] == pytest.approx(60000.0, rel=0.02)
    assert content["parameters"]["coulomb_friction"]["value"] == pytest.approx(1700.0, rel=0.02)
    assert content["parameters"]["supply_pressure"]["value"] == pytest.approx(3e5, rel=0.01)
    assert content["rms"]["unit"] == "m"
    assert content["rms"]["fitted"] == pytest.approx(1e-4, rel=0.3)
    assert content["rms"]["unseen"] == pytest.approx(1e-4, rel=0.3)
    assert "spring_rate" in result.stdout
    assert "fitted/model.json" in result.stdout
    determined = content["determined"]
    assert "supply_pressure" in determined["structural"]["determined"]
    assert determined["numerical"]["combinations"][-1]["determined"]
    low, high = determined["parameters"]["spring_rate"]["interval"]
    assert low < content["parameters"]["spring_rate"]["value"] < high
    assert determined["parameters"]["spring_rate"]["in_proportion_to"] == "diaphragm_area"
    assert determined["profile"] is determined["bootstrap"] is None
    checks = {each["check"]: each["verdict"] for each in content["residual_check"]}
    assert checks["position: size"] == "passed"
    assert "95 % interval" in result.stdout


def test_profile_and_bootstrap_are_asked_for(command, made_up, tmp_path):
    result = command("fit", made_up, "--profile", "--bootstrap", "10", "--out", "fitted")
    assert result.exit_code == 0, result.output
    determined = fitted(tmp_path / "fitted")["determined"]
    assert set(determined["profile"]) == set(determined["bootstrap"]) == set(BASE)
    assert determined["parameters"]["spring_rate"]["interval_from"] == "profile"
    low, high = determined["profile"]["spring_rate"]
    assert low < 60000.0 < high or abs(low / 60000.0 - 1.0) < 1e-3


def test_a_fit_begins_with_a_model_that_another_wrote(command, made_up, tmp_path):
    valve = read_valve("calibrated")
    Model("refitted", {**valve.values, "diaphragm_area": 2.0 * valve.values["diaphragm_area"]}).write(
        tmp_path / "base.json"
    )
    result = command("fit", made_up, "--model", "base.json", "--out", "again")
    assert result.exit_code == 0, result.output
    # Twice the area takes twice the forces for the same travel.
    assert fitted(tmp_path / "again")["parameters"]["spring_rate"]["value"] == pytest.approx(2.0 * 60000.0, rel=1e-3)


def test_model_goes_into_simulate_and_several_records_into_one_fit(command, made_up, short_record, tmp_path):
    result = command("fit", made_up, short_record, "--effect", "linkage_backlash", "--out", "both")
    assert result.exit_code == 0, result.output
    content = fitted(tmp_path / "both")
    assert content["effects"] == ["linkage_backlash"]
    assert set(content["parameters"]) == {*BASE, "backlash_half_width", "backlash_start", "backlash_wear"}
    assert content["unseen"] == "other records"
    assert set(content["start_positions"]) == {"made", "short"}
    result = command("simulate", "--model", "both/model.json", "--input", made_up, "--out", "out.csv")
    assert result.exit_code == 0, result.output
    assert sorted(path.name for path in (tmp_path / "both").iterdir()) == ["fit.json", "model.json"]


def test_stem_alone_is_fitted_to_force_and_position(command, tmp_path):
    time = np.arange(0.0, 12.0, 0.002)
    position = 0.05 * np.sin(2.0 * math.pi * 0.5 * time) + 0.02 * np.sin(2.0 * math.pi * 1.3 * time)
    speed = np.gradient(position, time)
    force = 95.0 * np.gradient(speed, time) + 200.0 * speed + 20.0 * np.sign(speed)
    force += np.random.default_rng(2).normal(0.0, 1.0, time.size)
    rows = "\n".join(f"{t:.3f},{f!r},{y!r}" for t, f, y in zip(time, force.tolist(), position.tolist(), strict=True))
    (tmp_path / "stem.csv").write_text(f"time [s],force [N],position [m]\n{rows}\n")
    result = command("fit", "stem.csv", "--out", "fitted")
    assert result.exit_code == 0, result.output
    content = fitted(tmp_path / "fitted")
    assert content["rms"]["unit"] == "N"
    assert content["parameters"]["stem_mass"]["value"] == pytest.approx(95.0, rel=0.05)
    assert content["parameters"]["viscous_friction"]["value"] == pytest.approx(200.0, rel=0.05)
    assert any("diaphragm_area" in warning for warning in content["warnings"])
    model = json.loads((tmp_path / "fitted" / "model.json").read_text())
    assert model["valve"]["stem_mass"]["value"] == content["parameters"]["stem_mass"]["value"]


def test_percent_without_rated_travel_is_said(command, short_record, tmp_path):
    from importlib import resources

    text = (resources.files("valvemodel.valves") / "calibrated.toml").read_text()
    before, _, after = text.partition("[rated_travel]")
    (tmp_path / "mine.toml").write_text(before + after[after.index("\n[") + 1 :])
    table = polars.read_csv(short_record)
    percent = table.select("time [s]", "current [mA]", (polars.col("position [mm]") / 2.5).alias("position [%]"))
    percent.write_csv(tmp_path / "percent.csv")
    said = {}
    for valve in ("calibrated", "mine.toml", ""):
        chosen = ("--valve", valve) if valve else ()
        result = command("fit", "percent.csv", *chosen, "--out", "fitted")
        assert result.exit_code == 0, result.output
        said[valve] = [text for text in fitted(tmp_path / "fitted")["warnings"] if "rated_travel" in text]
    assert said["calibrated"] == []
    for valve in ("mine.toml", ""):
        assert "only their proportions mean something" in said[valve][0]


def test_loop_without_time_is_fitted(command, demo_record, tmp_path):
    table = polars.read_csv(demo_record).select("current [mA]", "position [mm]").gather_every(50)
    table.write_csv(tmp_path / "loop.csv")
    result = command("fit", "loop.csv", "--out", "fitted")
    assert result.exit_code == 0, result.output
    content = fitted(tmp_path / "fitted")
    assert {"stem_mass", "viscous_friction"} <= set(content["not_determined"])
    assert content["parameters"]["viscous_friction"]["std"] is None
