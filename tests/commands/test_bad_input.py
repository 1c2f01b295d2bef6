"""Bad input ends with one clear message, exit status 2, and nothing written."""

import json
import shutil
import subprocess
import sys

import pytest

from valvemodel import Model, read_valve
from valvemodel.commands import COMMANDS

IN, OUT, DIR = "{record}", "out.csv", "out"

BAD = [
    ("unknown command", "simlate", "did you mean simulate?"),
    ("unknown option", f"simulate --inputs {IN} --out {OUT}", "--input"),
    ("no output", f"simulate --input {IN}", "--out"),
    ("missing input", f"simulate --input nope.csv --out {OUT}", "nope.csv does not exist"),
    ("folder as output", f"simulate --input {IN} --out .", "is a folder"),
    ("no such folder", f"simulate --input {IN} --out nowhere/{OUT}", "nowhere is no folder"),
    ("unknown valve", f"simulate --valve calibratd --input {IN} --out {OUT}", "did you mean calibrated?"),
    (
        "valve and model",
        f"simulate --valve linear --model m.json --input {IN} --out {OUT}",
        "exclude each other",
    ),
    ("missing model", f"simulate --model nope.json --input {IN} --out {OUT}", "nope.json"),
    ("wrong schema", f"simulate --model other.json --input {IN} --out {OUT}", "valvemodel.model/1"),
    ("not JSON", f"simulate --model {IN} --input {IN} --out {OUT}", "must be JSON"),
    ("unknown effect", f"simulate --effect stribek --input {IN} --out {OUT}", "did you mean stribeck"),
    ("unknown parameter", f"simulate --effect stribeck:ratio=2 --input {IN} --out {OUT}", "stribeck_ratio"),
    (
        "effect without value",
        f"simulate --effect stribeck:stribeck_ratio --input {IN} --out {OUT}",
        "name=value",
    ),
    (
        "effect out of bounds",
        f"simulate --effect stribeck:stribeck_ratio=99 --input {IN} --out {OUT}",
        "1..3",
    ),
    ("bounds without unit", f"simulate --effect stribeck:stribeck_ratio=99 --input {IN} --out {OUT}", "1..3\n"),
    (
        "parameter twice",
        f"simulate --effect stribeck:stribeck_ratio=1.2,stribeck_ratio=1.3 --input {IN} --out {OUT}",
        "stribeck_ratio came twice",
    ),
    ("nothing behind a colon", f"simulate --effect stribeck: --input {IN} --out {OUT}", "behind the colon"),
    ("effect like no other", f"simulate --effect xyzq --input {IN} --out {OUT}", "`valvemodel effects`"),
    ("effect twice", f"simulate --effect stribeck --effect stribeck --input {IN} --out {OUT}", "came twice"),
    ("start without unit", f"simulate --start-position 28.15 --input {IN} --out {OUT}", "28.15 mm"),
    (
        "start in pascals",
        f"simulate --start-position 28Pa --input {IN} --out {OUT}",
        "unit of something else",
    ),
    ("a column without a header", f"simulate --column current --input {IN} --out {OUT}", "--column is NAME=HEADER"),
    ("a column twice", f"diagnose {IN} --column time=a --column time=b --out {DIR}", "time came twice"),
    ("a column that is not there", f"fit {IN} --column position=PV --out {DIR}", "'PV' is not"),
    ("a model with effects to diagnose", f"diagnose {IN} --model stuck.json --out {DIR}", "give base.json"),
    ("valve and model to fit", f"fit {IN} --valve linear --model stuck.json --out {DIR}", "exclude each other"),
    ("no time", f"simulate --input loop.csv --out {OUT}", "time"),
    ("wrong unit", f"simulate --input psi.csv --out {OUT}", "psi"),
    ("no record", f"fit --out {DIR}", "RECORD"),
    ("file as folder", f"fit {IN} --out other.json", "other.json is a file"),
    ("folder under a file", f"diagnose {IN} --out other.json/report", "other.json is a file"),
    ("unknown effect to fit", f"fit {IN} --effect stribek --out {DIR}", "did you mean stribeck"),
    ("effect to fit twice", f"fit {IN} --effect stribeck --effect stribeck --out {DIR}", "came twice"),
    ("record twice", f"diagnose {IN} {IN} --out {DIR}", "came twice"),
    ("record copied", f"diagnose {IN} copy.csv --out {DIR}", "the same samples"),
    ("kinds mixed", f"diagnose {IN} stem.csv --out {DIR}", "have one kind"),
    ("loop and time fitted", f"fit loop.csv {IN} --out {DIR}", "loop.csv is a settled loop"),
    ("loop and time diagnosed", f"diagnose {IN} loop.csv --out {DIR}", "loop.csv is a settled loop"),
    ("input as output", "simulate --input input.csv --out input.csv", "another file than --input"),
    ("input as output by a link", "simulate --input input.csv --out link.csv", "another file than --input"),
    (
        "model as output",
        f"simulate --model other.json --input {IN} --out ./other.json",
        "another file than --model",
    ),
    (
        "valve as output",
        f"simulate --valve valve.toml --input {IN} --out valve.toml",
        "another file than --valve",
    ),
    ("full device", f"simulate --input {IN} --out /dev/full", "No space left on device"),
    ("full device, Parquet", f"simulate --input {IN} --out full.parquet", "No space left on device"),
    ("no position", f"diagnose input.csv --out {DIR}", "position"),
    ("no jobs", f"diagnose {IN} --jobs 0 --out {DIR}", "--jobs"),
    ("unknown effect to show", "effects stribek", "did you mean stribeck"),
    ("unknown valve to show", "valves calibratd", "did you mean calibrated?"),
]


@pytest.fixture
def files(tmp_path, short_record):
    shutil.copy(short_record, tmp_path / "copy.csv")
    (tmp_path / "other.json").write_text(json.dumps({"schema": "valvemodel.diagnosis/1"}))
    ramp = [(0.02 * k, 5.0 + 0.01 * k, 50.0 + 0.1 * k) for k in range(600)]
    write = {
        "loop.csv": ("current [mA],position [mm]", "{1},{2}"),
        "psi.csv": ("time [s],current [psi]", "{0},{1}"),
        "input.csv": ("time [s],current [mA]", "{0},{1}"),
        "stem.csv": ("time [s],force [N],position [mm]", "{0},{1},{2}"),
    }
    for name, (header, row) in write.items():
        (tmp_path / name).write_text("\n".join([header, *(row.format(*each) for each in ramp)]) + "\n")
    valve = read_valve("calibrated")
    Model(valve.name, valve.values).with_effect("static_friction").write(tmp_path / "stuck.json")
    (tmp_path / "valve.toml").write_text("")
    (tmp_path / "link.csv").symlink_to("input.csv")
    (tmp_path / "full.parquet").symlink_to("/dev/full")
    return tmp_path


@pytest.mark.parametrize(("words", "expected"), [case[1:] for case in BAD], ids=[case[0] for case in BAD])
def test_message_says_what_to_do(command, files, short_record, words, expected):
    before = sorted(files.rglob("*"))
    result = command(*(word.format(record=short_record) for word in words.split()))
    assert result.exit_code == 2, result.output
    assert expected in result.stderr
    assert result.stdout == ""
    assert "Traceback" not in result.output
    assert sorted(files.rglob("*")) == before


def test_folder_as_record_is_said_once(command, files):
    result = command("diagnose", files, "--out", DIR)
    assert result.exit_code == 2
    assert result.stderr.count("is a folder") == 1
    assert result.stderr.splitlines()[1] == f"  found:  {files} is a folder"


@pytest.mark.parametrize("name", COMMANDS)
def test_help_has_an_example(command, name):
    output = command(name, "--help").output
    assert "Example" in output
    assert f"valvemodel {name}" in output.split("Example")[1]


def test_overall_help_lists_the_commands_with_an_example(command):
    output = command("--help").output
    assert "Example: valvemodel diagnose" in output
    for name in COMMANDS:
        assert f"  {name} " in output


def test_version_is_that_of_the_package(command):
    from importlib.metadata import version

    assert command("--version").output == f"valvemodel {version('valvemodel')}\n"


def test_old_output_stays_where_a_run_fails(command, files, short_record):
    (files / "out.csv").write_text("old")
    command("simulate", "--input", "psi.csv", "--out", "out.csv")
    assert (files / "out.csv").read_text() == "old"


def test_several_files_appear_together_or_not_at_all(tmp_path):
    from valvemodel.commands.places import write_together

    def fail(folder):
        (folder / "one.json").write_text("{}")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_together(tmp_path / "a" / "b", fail)
    assert list(tmp_path.iterdir()) == []

    def succeed(folder):
        (folder / "one.json").write_text("{}")
        return {"one.json": folder / "one.json"}

    places = write_together(tmp_path / "a" / "b", succeed)
    assert places == {"one.json": tmp_path / "a" / "b" / "one.json"}
    assert [path.name for path in (tmp_path / "a" / "b").iterdir()] == ["one.json"]


def test_reader_that_leaves_early_is_no_trouble():
    program = f"{sys.executable} -m valvemodel effects --json | head -n 1"
    done = subprocess.run(["bash", "-c", program], capture_output=True, text=True)
    assert done.stderr == ""
