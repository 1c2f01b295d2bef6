"""Many valves on one core and on two, objectives alone kept; run by itself, so that its peak memory is its own."""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import click
import numpy as np

from benchmarks.simulation.effects import currents
from benchmarks.simulation.workload import PERIOD

MEGABYTE = 1024.0
"""In kilobytes."""


def time_fleet(valves: int, periods: int) -> dict[str, Any]:
    """Return times and peak memory of a process of its own."""

    def run(*size: int) -> dict[str, Any]:
        command = [sys.executable, "-m", "benchmarks.simulation.fleet", *map(str, size)]
        return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)

    # The first run on a machine compiles, which takes memory of its own.
    run(1, 10)
    return run(valves, periods)


def peak_kilobytes() -> float:
    """Return the most memory this process has had; Linux counts what its parent had as well, but not in its status."""
    status = Path("/proc/self/status")
    if not status.exists():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    (peak,) = (line for line in status.read_text(encoding="utf-8").splitlines() if line.startswith("VmHWM"))
    return float(peak.split()[1])


@click.command()
@click.argument("valves", type=int)
@click.argument("periods", type=int)
def main(valves: int, periods: int) -> None:
    """Print times and peak memory as JSON."""
    from valvemodel.batch import objectives
    from valvemodel.model import Model
    from valvemodel.simulation import simulate
    from valvemodel.valves import read_valve

    valve = read_valve("calibrated")
    model = Model(valve.name, valve.values).with_effect("static_friction")
    clock, current = PERIOD * np.arange(periods), currents(periods)
    measured = simulate(model, time=clock, current=current).position
    rows = model.rows(valves)
    rows["coulomb_friction"] *= np.random.default_rng(4).uniform(0.5, 1.5, valves)

    def seconds(workers: int) -> float:
        began = time.perf_counter()
        objectives(rows, time=clock, current=current, position=measured, workers=workers)
        return time.perf_counter() - began

    seconds(2)
    one, two = (min(seconds(workers) for _ in range(2)) for workers in (1, 2))
    click.echo(
        json.dumps(
            {
                "valves": valves,
                "periods": periods,
                "seconds_on_one_core": one,
                "seconds_on_two_cores": two,
                "speed_up": one / two,
                "ns_per_period_on_one_core": 1e9 * one / (valves * periods),
                "peak_megabytes": peak_kilobytes() / MEGABYTE,
            }
        )
    )


if __name__ == "__main__":
    main()
