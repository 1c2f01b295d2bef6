"""`valvemodel simulate` writes a table that is exact, and starts where it was told."""

import os
import subprocess
import sys

import numpy as np
import polars
import pytest

from valvemodel import Model, read_record, read_valve, simulate

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
    assert np.array_equal(table["pressure [kPa]"].to_numpy(), 1e-3 * run.pressure)
    assert np.array_equal(table["time [s]"].to_numpy(), record.time)
    assert table["mode"].to_list() == run.mode_names
    assert os.listdir(tmp_path) == ["out.csv"]


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
