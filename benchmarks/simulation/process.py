"""Whole processes: the simulate command on a file, and what the import takes of it."""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.simulation.effects import currents
from benchmarks.simulation.stopwatch import shortest_process
from benchmarks.simulation.workload import PERIOD

ROWS = 7_500
NUMBA = ("-c", "import numba")


def time_processes(repeats: int) -> dict[str, Any]:
    """Return seconds of the command, of an import of the simulation, and of numba's alone for comparison."""
    with tempfile.TemporaryDirectory() as folder:
        source, out = Path(folder) / "in.csv", Path(folder) / "out.csv"
        table = np.column_stack([PERIOD * np.arange(ROWS), 1e3 * currents(ROWS)])
        np.savetxt(source, table, delimiter=",", header="time [s],current [mA]", comments="", fmt="%.6f")
        command = ("-m", "valvemodel", "simulate", "--input", str(source), "--out", str(out))
        shortest_process(command, 1)
        whole = shortest_process(command, repeats)
    imported = shortest_process(("-c", "import valvemodel.simulation"), repeats)
    return {
        "rows": ROWS,
        **{f"command_{name}": value for name, value in whole.items()},
        **{f"python_and_import_{name}": value for name, value in imported.items()},
        **{f"python_and_numba_{name}": value for name, value in shortest_process(NUMBA, repeats).items()},
        "import_seconds_by_importtime": import_seconds("valvemodel.simulation"),
    }


def import_seconds(module: str) -> float:
    """Return the cumulative time that `-X importtime` gives a module. [s]"""
    command = [sys.executable, "-X", "importtime", "-c", f"import {module}"]
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stderr.splitlines()
    (found,) = (line for line in lines if line.endswith(f" {module}"))
    cumulative = re.findall(r"\d+", found)[1]
    return 1e-6 * int(cumulative)
