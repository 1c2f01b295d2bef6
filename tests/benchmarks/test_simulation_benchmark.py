"""The simulation benchmark runs, says what it measured, and its truth and the toolkit do not share code."""

import ast
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.simulation import contest, ours, truth
from benchmarks.simulation.workload import STEMS, triangle

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    out = tmp_path_factory.mktemp("benchmark") / "simulation.json"
    command = [sys.executable, "-m", "benchmarks.simulation", "--quick", "--json", str(out)]
    printed = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    assert "times slower than valvemodel" in printed.stdout
    assert printed.stderr == ""
    return json.loads(out.read_text(encoding="utf-8"))


def test_every_section_is_there(found):
    assert found["schema"] == "valvemodel.benchmark.simulation/1"
    assert found["chain"]["ns_per_period_triangle"] > 0.0
    assert {row["title"] for row in found["effects"]} >= {"none", "stribeck", "all of the stem", "one a stage"}
    assert found["fleet"]["peak_megabytes"] < 500.0
    assert found["closed_loop"]["m_between_them"] == 0.0
    processes = found["processes"]
    assert 0.0 < processes["python_and_import_processor_seconds"] < processes["command_processor_seconds"]


def test_toolkit_is_exact_and_faster_than_scipy(found):
    rows = {(row["peer"], row["stem"], row["workload"]): row for row in found["contest"]}
    assert len({(stem, workload) for _, stem, workload in rows}) == 6
    for (peer, _, _), row in rows.items():
        if peer == "valvemodel":
            assert row["digits"] >= 12.0
        if peer == "scipy_events":
            assert row["digits"] >= 6.0
            assert row["ratio"] > 100.0
        if peer == "plain_python":
            assert row["digits"] >= 12.0


def test_exact_effects_do_not_depend_on_the_accuracy(found):
    (plain,) = (row for row in found["effects"] if row["title"] == "none")
    assert plain["m_from_finer"] == plain["m_from_finer_in_a_search"] == 0.0
    assert any(row["m_from_finer_in_a_search"] > 0.0 for row in found["effects"])


def test_lost_event_is_seen_in_the_digits():
    pressures = triangle(400)
    held = pressures.tolist()
    exact = truth.exact_positions(STEMS["A"], held)
    workload = contest.Workload("A", "triangle", pressures, exact, exact)
    positions = ours.stem_run(STEMS["A"], pressures)()
    assert workload.best_digits(positions) > 12.0
    # One jump of (F_s - F_c)/k is missed.
    assert workload.best_digits(np.where(np.arange(400) > 200, positions - 5.4e-3, positions)) < contest.LOST


def test_truth_uses_nothing_of_the_toolkit():
    for module in (truth, sys.modules["benchmarks.simulation.workload"]):
        for node in ast.walk(ast.parse(Path(module.__file__).read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert not str(node.module).startswith(("valvemodel", "numba"))
