"""The simulator against its peers, effect by effect, in a fleet, in closed loop and as a process."""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import platform
import time
from pathlib import Path
from typing import Any

import click

SCHEMA = "valvemodel.benchmark.simulation/1"

WHOLE = {"periods": 10_000, "stretch": 1_300, "effect_periods": 10_000, "valves": 10_000}
QUICK = {"periods": 1_300, "stretch": 300, "effect_periods": 400, "valves": 200}
"""Periods of a workload and of the stretch on which settings are tried; periods with effects; valves of the fleet."""


@click.command()
@click.option("--json", "out", type=click.Path(path_type=Path), metavar="FILE", help="Also write the figures here.")
@click.option("--quick", is_flag=True, help="Short runs of SciPy alone, to see that all works; the figures are rough.")
def main(out: Path | None, quick: bool) -> None:
    """Measure everything side by side and print tables of times, digits and ratios."""
    from rich.console import Console

    from benchmarks.simulation.tables import print_tables
    from valvemodel.commands.waiting import progress_shown
    from valvemodel.files import write_json

    size = QUICK if quick else WHOLE
    with progress_shown() as report:
        found = measured(size, ["plain_python", "scipy_events"] if quick else None, report)
    print_tables(found, Console(width=200, highlight=False))
    if out is not None:
        write_json(out, found)


def measured(size: dict[str, int], only: list[str] | None, report) -> dict[str, Any]:
    """Measure all sections."""
    from benchmarks.simulation.effects import time_chain, time_effects
    from benchmarks.simulation.fleet import time_fleet
    from benchmarks.simulation.loop import time_loop
    from benchmarks.simulation.process import time_processes

    began = time.perf_counter()
    contest, left_out = compete(size, only, lambda what, share: report(what, 0.7 * share))
    effects = time_effects(size["effect_periods"], size["stretch"], lambda what: report(f"with {what}", 0.75))
    report("fleet", 0.85)
    fleet = time_fleet(size["valves"], size["periods"])
    report("closed loop", 0.93)
    loop = time_loop(size["periods"])
    report("whole processes", 0.96)
    return {
        "schema": SCHEMA,
        "python": platform.python_version(),
        "cores": os.cpu_count(),
        "contest": contest,
        "left_out": left_out,
        "chain": time_chain(size["periods"]),
        "effects": effects,
        "fleet": fleet,
        "closed_loop": loop,
        "processes": time_processes(1 if size is QUICK else 3),
        "seconds": time.perf_counter() - began,
    }


def compete(size: dict[str, int], only: list[str] | None, report) -> tuple[list[dict[str, Any]], list[str]]:
    """Run the toolkit and all peers on all workloads; say which are not installed."""
    from benchmarks.simulation import ours
    from benchmarks.simulation.contest import code_lines, installed_peers, time_ours, time_peer, workloads

    peers, left_out = installed_peers()
    if only is not None:
        peers = {name: peers[name] for name in only}
    rows = []
    done = 0
    for workload in workloads(size["periods"]):
        best = time_ours(workload)
        rows.append({**best, "title": "valvemodel, one thread", "lines": code_lines(Path(ours.__file__)), "ratio": 1.0})
        for name, peer in peers.items():
            report(f"{workload.stem_name} {workload.title}: {peer.TITLE}", done / (6.0 * len(peers)))
            found = time_peer(peer, workload, size["stretch"])
            ratio = found["us_per_period"] / best["us_per_period"]
            lines = code_lines(Path(str(peer.__file__)))
            rows.append({**found, "peer": name, "title": peer.TITLE, "lines": lines, "ratio": ratio})
            done += 1
    return rows, left_out


if __name__ == "__main__":
    main()
