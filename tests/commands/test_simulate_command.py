"""`valvemodel simulate` writes a table that is exact, and starts where it was told."""

import json
import os
import subprocess
import sys

import numpy as np
import polars
import pytest

from valvemodel import Model, read_model, read_record, read_valve, simulate

COLUMNS = ["time [s]", "current [mA]", "pressure [kPa]", "position [mm]", "mode"]


def calibrated() -> Model:
    valve = read_valve("calibrated")
    return Model(valve.name, valve.values)


def test_table_is_that_of_the_simulator(command, short_record, tmp_path):
    result = command("simulate", "--input", short_record, "--out", "out.csv")
    assert result.exit_code == 0, result.output
    table = polars.read_csv(tmp_path / "out.csv")
    assert table.columns == COLUMNS
    assert set(table["mode"]) <= {"stuck", "rising", "falling"}
    record = read_record(short_record)
    run = simulate(calibrated(), time=record.time, current=record.current)
    assert np.array_equal(table["position [mm]"].to_numpy(), 1e3 * run.position)
    assert np.array_equal(table["pressure [kPa]"].to_numpy(), run.pressure / 1e3)
    assert np.array_equal(table["time [s]"].to_numpy(), record.time)
    assert table["mode"].to_list() == run.mode_names
    assert os.listdir(tmp_path) == ["out.csv"]


def test_columns_that_are_called_otherwise_are_named(command, short_record, tmp_path):
    header, *rows = short_record.read_text().splitlines()
    assert header.startswith("time [s],current [mA]")
    (tmp_path / "logger.csv").write_text("\n".join([header.replace("time [s],current [mA]", "Zeit [s],OP"), *rows]))
    named = ("--column", "time=Zeit", "--column", "current [mA]=OP")
    for source, words in ((short_record, ()), (tmp_path / "logger.csv", named)):
        result = command("simulate", "--input", source, *words, "--out", f"of-{source.stem}.csv")
        assert result.exit_code == 0, result.output
    assert (tmp_path / "of-logger.csv").read_text() == (tmp_path / f"of-{short_record.stem}.csv").read_text()


def test_start_is_the_middle_of_the_stuck_band_or_as_told(command, short_record, tmp_path):
    command("simulate", "--input", short_record, "--out", "rest.csv")
    result = command("simulate", "--input", short_record, "--start-position", "60.5 mm", "--out", "told.csv")
    assert result.exit_code == 0, result.output
    rest, told = (polars.read_csv(tmp_path / name) for name in ("rest.csv", "told.csv"))
    values = read_valve("calibrated").values
    force = 1e3 * rest["pressure [kPa]"][0] * values["diaphragm_area"]
    assert rest["position [mm]"][0] == pytest.approx(1e3 * force / values["spring_rate"], rel=1e-12)
    assert rest["mode"][0] == "stuck"
    assert told["position [mm]"][0] == pytest.approx(60.5, rel=1e-12)


def test_run_says_how_far_it_is_off_what_was_measured(command, short_record, tmp_path):
    result = command("simulate", "--input", short_record, "--start-position", "60 mm", "--out", "out.csv")
    simulated, measured = (polars.read_csv(path)["position [mm]"].to_numpy() for path in ("out.csv", short_record))
    off = np.sqrt(np.mean((simulated - measured) ** 2))
    assert f"wrote out.csv: 1500 rows, {off:.3g} mm (root mean square) off the measured position" in result.output
    alone = tmp_path / "alone.csv"
    alone.write_text("time [s],current [mA]\n0,5\n1,6\n2,7\n")
    assert "off the measured" not in command("simulate", "--input", alone, "--out", "out.csv").output


def test_effects_are_switched_on_with_units_or_without(command, short_record, tmp_path):
    for name, effect in (
        ("plain", "linkage_backlash:backlash_half_width=0.004"),
        ("unit", "linkage_backlash:backlash_half_width=4 mm"),
    ):
        result = command("simulate", "--input", short_record, "--effect", effect, "--out", f"{name}.csv")
        assert result.exit_code == 0, result.output
    assert (tmp_path / "plain.csv").read_text() == (tmp_path / "unit.csv").read_text()


def test_written_model_gives_what_its_effects_give(command, short_record, tmp_path):
    calibrated().with_effect("static_friction", static_friction_ratio=1.3).write(tmp_path / "model.json")
    command("simulate", "--model", "model.json", "--input", short_record, "--out", "a.csv")
    effect = "static_friction:static_friction_ratio=1.3"
    command("simulate", "--input", short_record, "--effect", effect, "--out", "b.csv")
    assert (tmp_path / "a.csv").read_text() == (tmp_path / "b.csv").read_text()


def test_number_of_a_model_needs_its_unit_and_its_place(command, short_record, tmp_path):
    whole = calibrated().with_effect("static_friction", static_friction_ratio=1.3).as_json()
    place = tmp_path / "model.json"

    def said_of(table, name, entry):
        content = json.loads(json.dumps(whole))
        owner = content["valve"] if table == "valve" else content["effects"][table]
        if entry is None:
            del owner[name]
        else:
            owner[name] = entry
        place.write_text(json.dumps(content))
        result = command("simulate", "--model", place, "--input", short_record, "--out", "out.csv")
        assert result.exit_code == 2, result.output
        assert len(result.stderr.splitlines()) == 3
        assert len(result.stderr) < 500
        assert not (tmp_path / "out.csv").exists()
        return result.stderr

    said = said_of("valve", "spring_rate", {"value": 52.5, "unit": "N/mm"})
    assert all(word in said for word in ("spring_rate", "'N/mm'", "'N/m'"))
    assert "spring_rate has no unit" in said_of("valve", "spring_rate", {"value": 52500.0})
    assert "lacks spring_rate" in said_of("valve", "spring_rate", None)
    assert "spring_rate is 5\n" in said_of("valve", "spring_rate", 5)
    assert "spring_rate is" in said_of("valve", "spring_rate", {"value": True, "unit": "N/m"})
    assert "spring_rate is" in said_of("valve", "spring_rate", {"value": 10**400, "unit": "N/m"})
    assert "did you mean spring_rate" in said_of("valve", "spring_rat", {"value": 1.0, "unit": "N/m"})
    assert "lacks static_friction_ratio" in said_of("static_friction", "static_friction_ratio", None)
    said = said_of("static_friction", "static_friction_ratio", {"value": 1.3, "unit": "%"})
    assert all(word in said for word in ("static_friction_ratio", "'%'", "'1'"))


def test_infinite_numbers_may_be_left_out_of_a_model(tmp_path):
    model = calibrated().with_effect("end_stop", upper_stop=0.1)
    model.write(tmp_path / "model.json")
    assert "lower_stop" not in (tmp_path / "model.json").read_text()
    assert read_model(tmp_path / "model.json") == model


def test_typical_values_are_said_where_they_are_taken(command, short_record):
    words = ("simulate", "--input", short_record, "--out", "out.csv", "--effect")
    assert "stribeck at typical values: stribeck_ratio 1.3" in command(*words, "stribeck").stderr
    some = command(*words, "stribeck:stribeck_ratio=1.4").stderr
    assert "stribeck at typical values: " in some
    assert "stribeck_ratio" not in some
    assert "typical" not in command(*words, "asymmetric_friction:friction_asymmetry=0.2").stderr


def test_start_beyond_the_travel_is_a_warning(command, short_record):
    words = ("simulate", "--input", short_record, "--out", "out.csv", "--start-position")
    result = command(*words, "-5000 mm")
    assert result.exit_code == 0, result.output
    assert "warning: the start at -5000 mm is beyond the rated travel, 250 mm" in result.stderr
    assert "beyond" not in command(*words, "-20 mm").stderr


def test_table_goes_into_a_pipe(short_record, tmp_path):
    words = ["simulate", "--input", str(short_record), "--out"]
    done = subprocess.run([sys.executable, "-m", "valvemodel", *words, "/dev/stdout"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    subprocess.run([sys.executable, "-m", "valvemodel", *words, str(tmp_path / "out.csv")], check=True)
    assert done.stdout == (tmp_path / "out.csv").read_text()


def test_parquet_is_written_where_the_name_says_so(command, short_record, tmp_path):
    assert command("simulate", "--input", short_record, "--out", "out.parquet").exit_code == 0
    assert polars.read_parquet(tmp_path / "out.parquet").columns == COLUMNS


def test_input_needs_only_time_and_current(command, tmp_path):
    rows = "\n".join(f"{0.02 * k:.2f},{5 + 0.005 * k}" for k in range(500))
    (tmp_path / "in.csv").write_text(f"time [s],current [mA]\n{rows}\n")
    result = command("simulate", "--valve", "linear", "--input", "in.csv", "--out", "out.csv")
    assert result.exit_code == 0, result.output
    assert len(polars.read_csv(tmp_path / "out.csv")) == 500


def test_module_runs_as_the_program_does(short_record, tmp_path):
    words = ["simulate", "--input", str(short_record), "--out", str(tmp_path / "out.csv")]
    done = subprocess.run([sys.executable, "-m", "valvemodel", *words], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout == ""
    assert "1500 rows" in done.stderr


@pytest.mark.parametrize(
    ("key", "later"),
    [
        ("magnetic_hysteresis", "bouc_wen_gamma"),
        ("linkage_nonlinearity", "linkage_arm"),
        ("static_friction", "stick_speed"),
    ],
)
def test_a_file_from_before_a_number_was_known_means_what_it_meant(command, short_record, tmp_path, key, later):
    content = calibrated().with_effect(key).as_json()
    for name in ("whole", "older"):
        (tmp_path / f"{name}.json").write_text(json.dumps(content))
        result = command(
            "simulate", "--model", tmp_path / f"{name}.json", "--input", short_record, "--out", f"{name}.csv"
        )
        assert result.exit_code == 0, result.output
        content["effects"][key].pop(later, None)
    assert later not in (tmp_path / "older.json").read_text()
    assert (tmp_path / "older.csv").read_text() == (tmp_path / "whole.csv").read_text()
