"""`valvemodel blindtest` makes, seals, diagnoses, opens and scores, and keeps what is done."""

import json
import os
import re
import signal
import subprocess
import sys
import time

import pytest


def test_one_plant_from_seal_to_page(command, tmp_path):
    words = ("blindtest", "--plants", 1, "--kinds", "none", "--jobs", 1, "--out", "blind")
    result = command(*words)
    assert result.exit_code == 0, result.output
    assert "No effect" in result.stdout
    content = json.loads((tmp_path / "blind" / "blindtest.json").read_text())
    assert content["schema"] == "valvemodel.blindtest/1"
    assert content["kinds"]["none"]["plants"] == 1
    assert content["kinds"]["none"]["right"]["hits"] == content["results"][0]["mark"]["is_right"]
    assert content["sealed_sha256"] == json.loads((tmp_path / "blind" / "seal.json").read_text())["sha256"]
    page = (tmp_path / "blind" / "blindtest.html").read_text()
    assert content["sealed_sha256"] in page
    assert not re.search(r'(?:src|href)="(?!data:|#)', page)
    answered = (tmp_path / "blind" / "answers" / "plant-0001" / "answer.json").stat().st_mtime_ns
    assert command(*words).exit_code == 0
    assert (tmp_path / "blind" / "answers" / "plant-0001" / "answer.json").stat().st_mtime_ns == answered


def test_unknown_kind_is_refused_without_a_trace(command, tmp_path):
    result = command("blindtest", "--kinds", "singel", "--out", "blind")
    assert result.exit_code == 2
    assert "did you mean single" in result.output
    assert not list(tmp_path.iterdir())


def session_is_empty(leader: int) -> bool:
    """Return whether all processes of a session have ended, within a few seconds."""
    for _ in range(100):
        try:
            os.killpg(leader, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.1)
    return False


@pytest.mark.parametrize("stop", [lambda pid: os.killpg(pid, signal.SIGINT), lambda pid: os.kill(pid, signal.SIGTERM)])
def test_interrupt_keeps_what_is_done_and_sends_the_workers_home(tmp_path, stop):
    words = [sys.executable, "-m", "valvemodel", "blindtest", "--kinds", "single", "--out", str(tmp_path / "blind")]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
    for _ in range(300):
        time.sleep(0.1)
        if list(tmp_path.glob("blind/sealed/plant-*.json")):
            break
    stop(process.pid)
    output, trouble = process.communicate(timeout=60)
    assert process.returncode == 130
    assert output == ""
    assert "the same command goes on" in trouble
    assert session_is_empty(process.pid)
    assert list(tmp_path.glob("blind/sealed/plant-*.json"))
