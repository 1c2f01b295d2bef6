"""`valvemodel control`: files, schema, and what it refuses."""

import json

import pytest
from click.testing import CliRunner

from valvemodel.control.kinds import KINDS


@pytest.fixture
def command(tmp_path, monkeypatch):
    from valvemodel.commands import command_line

    monkeypatch.chdir(tmp_path)
    return lambda *words: CliRunner().invoke(command_line, ["control", *map(str, words)])


def test_contest_writes_its_files(command, tmp_path):
    done = command(
        "--effect", "static_friction:static_friction_ratio=1.2", "--setpoints", "120 mm, 60 %, 130 mm",
        "--duration", "2 s", "--period", "20 ms", "--tuning-runs", "40", "--out", "contest",
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    assert "self-calibration: I_threshold 3.6" in done.output
    folder = tmp_path / "contest"
    assert {path.name for path in folder.iterdir()} == {"control.json", "control.csv", "control.png", "control.svg"}
    content = json.loads((folder / "control.json").read_text())
    assert content["schema"] == "valvemodel.control/1"
    assert content["scenario"]["setpoints"]["value"] == [0.12, 0.15, 0.13]
    header = (folder / "control.csv").read_text().splitlines()[0].split(",")
    assert header[:2] == ["time [s]", "setpoint [mm]"]
    assert header[2:5] == ["pid current [mA]", "pid reading [mm]", "pid position [mm]"]
    assert len(header) == 2 + 3 * len(KINDS)


def test_claims_write_theirs(command, tmp_path):
    done = command("--claims", "--coarse", "--tuning-runs", "40", "--period", "20 ms", "--out", "claims")
    assert done.exit_code == 0, done.output
    content = json.loads((tmp_path / "claims" / "claims.json").read_text())
    assert content["schema"] == "valvemodel.claims/1"
    assert all(f"- {text}" in done.output for text in content["findings"])
    assert (tmp_path / "claims" / "claims.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    "words",
    [
        ("--setpoints", "500 mm"),
        ("--setpoints", "120"),
        ("--setpoints", "120 mm,,130 mm"),
        ("--period", "0 s"),
        ("--period", "10"),
        ("--noise", "1 s"),
        ("--resolution", "nan mm"),
        ("--duration", "1 ms"),
        ("--claims", "--load", "1 N"),
        ("--coarse",),
        ("--seed", "-1"),
        ("--valve", "linear", "--model", "model.json"),
        ("--model", "absent.json"),
        ("--effect", "static_frction"),
    ],
)
def test_bad_input_ends_with_2_and_writes_nothing(command, tmp_path, words):
    done = command(*words, "--out", "folder")
    assert done.exit_code == 2, done.output
    assert not isinstance(done.exception, Exception) or isinstance(done.exception, SystemExit)
    assert not (tmp_path / "folder").exists()
