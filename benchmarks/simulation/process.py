"""Whole processes: the simulate command on a file, and what the import takes of it."""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.simulation.contest import shortest_time
from benchmarks.simulation.effects import currents
from benchmarks.simulation.workload import PERIOD

ROWS = 7_500


def run(*words: str) -> subprocess.CompletedProcess[str]:
    """Run Python with these words."""
    return subprocess.run([sys.executable, *words], check=True, capture_output=True, text=True)


def time_processes(repeats: int) -> dict[str, Any]:
    """Return seconds of the command, of an import of the simulation, and of numba's alone for comparison."""
    with tempfile.TemporaryDirectory() as folder:
        source, out = Path(folder) / "in.csv", Path(folder) / "out.csv"
        table = np.column_stack([PERIOD * np.arange(ROWS), 1e3 * currents(ROWS)])
        np.savetxt(source, table, delimiter=",", header="time [s],current [mA]", comments="", fmt="%.6f")
        words = ("-m", "valvemodel", "simulate", "--input", str(source), "--out", str(out))
        run(*words)
        whole = shortest_time(lambda: run(*words), repeats)
    bare = shortest_time(lambda: run("-c", "pass"), repeats)
    return {
        "rows": ROWS,
        "command_seconds": whole,
        "import_seconds": shortest_time(lambda: run("-c", "import valvemodel.simulation"), repeats) - bare,
        "import_seconds_of_numba": shortest_time(lambda: run("-c", "import numba"), repeats) - bare,
        "import_seconds_by_importtime": import_seconds("valvemodel.simulation"),
    }


def import_seconds(module: str) -> float:
    """Return the cumulative time that `-X importtime` gives a module. [s]"""
    lines = run("-X", "importtime", "-c", f"import {module}").stderr.splitlines()
    (found,) = (line for line in lines if line.endswith(f" {module}"))
    cumulative = re.findall(r"\d+", found)[1]
    return 1e-6 * int(cumulative)
