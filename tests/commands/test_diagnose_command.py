"""`valvemodel diagnose` writes the contract's files and answers in words."""

import json
import os
import re
import signal
import subprocess
import sys
import time

import pytest


@pytest.fixture(scope="module")
def diagnosed(tmp_path_factory, short_record):
    """One diagnosis of the short record: its result and its folder."""
    from click.testing import CliRunner

    from valvemodel.commands import command_line

    folder = tmp_path_factory.mktemp("diagnosed") / "report"
    result = CliRunner().invoke(command_line, ["diagnose", str(short_record), "--out", str(folder), "--jobs", "1"])
    assert result.exit_code == 0, result.output
    return result, folder


def test_files_are_the_four_of_the_contract(diagnosed):
    _, folder = diagnosed
    names = ["base.json", "diagnosis.json", "model.json", "report.html"]
    assert sorted(path.name for path in folder.iterdir()) == names


def test_json_keeps_the_contract(diagnosed):
    _, folder = diagnosed
    content = json.loads((folder / "diagnosis.json").read_text(), parse_constant=lambda name: pytest.fail(name))
    assert content["schema"] == "valvemodel.diagnosis/1"
    assert content["verdict"] in ("effect", "none", "unknown")
    total = content["unknown_probability"] + sum(cause["probability"] for cause in content["causes"])
    assert total == pytest.approx(1.0, abs=1e-9)
    probabilities = [cause["probability"] for cause in content["causes"]]
    assert probabilities == sorted(probabilities, reverse=True)
    assert [] in [cause["effects"] for cause in content["causes"]]
    keys = {
        "effects", "probability", "parameters", "gap_after", "gap_closed", "gap_closed_interval",
        "indistinguishable_from",
        "may_hide_beside",
    }  # fmt: skip
    for cause in content["causes"]:
        assert keys <= set(cause)
    assert {"unit", "as_given", "refitted", "with_cause", "noise_floor", "scored_on"} <= set(content["gap"])
    assert content["gap"]["scored_on"] == "held-out blocks"
    assert {"stage", "stage_probability", "regimes"} <= set(content["where"])
    for regime in content["where"]["regimes"]:
        assert {"name", "where", "rms", "share"} <= set(regime)


def test_answer_names_the_gap_and_the_place_of_the_report(diagnosed):
    result, folder = diagnosed
    assert "noise floor" in result.stdout
    assert str(folder / "report.html") in result.stdout.replace("\n", "")


def test_readme_shows_what_the_demo_prints(demo_record, command):
    result = command("diagnose", demo_record, "--out", "demo-report", "--jobs", "2")
    readme = (demo_record.parents[2] / "README.md").read_text()
    shown = re.search(r"<!-- demo: .*?-->\n```text\n(.*?)\n```", readme, re.DOTALL)[1]
    masked = [re.sub(r"\d[\d.e-]*", "#", " ".join(text.split())) for text in (shown, result.stdout)]
    assert masked[0] == masked[1], "run `python docs/demo.py`"


@pytest.mark.parametrize("name", ["base.json", "model.json"])
def test_models_go_into_simulate(diagnosed, command, short_record, name):
    _, folder = diagnosed
    result = command("simulate", "--model", folder / name, "--input", short_record, "--out", "out.csv")
    assert result.exit_code == 0, result.output


def test_report_needs_no_network(diagnosed):
    _, folder = diagnosed
    page = (folder / "report.html").read_text()
    assert not re.search(r'(?:src|href)="(?!data:|#)', page)


def test_interrupt_leaves_nothing(demo_record, tmp_path):
    words = [
        sys.executable,
        "-m",
        "valvemodel",
        "diagnose",
        str(demo_record),
        str(demo_record.with_name("demo-b.csv")),
        "--jobs",
        "1",
        "--out",
        str(tmp_path / "a" / "b"),
    ]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
    time.sleep(2.0)
    os.killpg(process.pid, signal.SIGINT)
    output, trouble = process.communicate(timeout=60)
    assert process.returncode == 130
    assert output == ""
    assert trouble == "valvemodel: interrupted; nothing was written\n"
    assert list(tmp_path.iterdir()) == []


def test_next_experiment_goes_into_simulate(command, short_record, tmp_path):
    words = ("--next-experiment", "next.csv", "--next-duration", "10 s", "--next-range", "6 mA", "15 mA")
    result = command("diagnose", short_record, "--out", "report", "--jobs", 1, *words)
    assert result.exit_code == 0, result.output
    content = json.loads((tmp_path / "report" / "diagnosis.json").read_text())["next_experiment"]
    assert content["file"] == "next.csv"
    assert content["separation"]["profile"] > 0.0
    assert len(content["rivals"]) >= 2
    assert "next.csv" in result.stdout
    assert "The next experiment" in (tmp_path / "report" / "report.html").read_text()
    rows = [float(line.split(",")[1]) for line in (tmp_path / "next.csv").read_text().splitlines()[1:]]
    assert min(rows) >= 6.0
    assert max(rows) <= 15.0
    assert command("simulate", "--input", "next.csv", "--out", "out.csv").exit_code == 0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--next-experiment", "nowhere/next.csv"), "choose another place with --next-experiment"),
        (("--next-experiment", "next.csv", "--next-range", "15 mA", "6 mA"), "a lower and a higher current"),
        (("--next-experiment", "next.csv", "--next-duration", "30"), "a quantity has a unit"),
    ],
)
def test_next_experiment_is_checked_before_the_work(command, short_record, tmp_path, words, message):
    result = command("diagnose", short_record, "--out", "report", *words)
    assert result.exit_code == 2
    assert message in result.output
    assert list(tmp_path.iterdir()) == []
