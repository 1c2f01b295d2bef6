"""`valvemodel blindtest` makes, seals, diagnoses, opens and scores, and keeps what is done."""

import json
import os
import re
import signal
import subprocess
import sys
import time


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


def test_interrupt_keeps_what_is_done(tmp_path):
    words = [sys.executable, "-m", "valvemodel", "blindtest", "--kinds", "single", "--out", str(tmp_path / "blind")]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
    for _ in range(300):
        time.sleep(0.1)
        if list(tmp_path.glob("blind/sealed/plant-*.json")):
            break
    os.killpg(process.pid, signal.SIGINT)
    output, trouble = process.communicate(timeout=60)
    assert process.returncode == 130
    assert output == ""
    assert "the same command goes on" in trouble
    assert list(tmp_path.glob("blind/sealed/plant-*.json"))
