"""Blind plants diagnosed: hits by effect, false alarms, closure, seconds (`python -m benchmarks.blind`)."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import click
import numpy as np

PROFILE_OFFSET = 1000
"""The profile's seed is the plant's plus this."""


def diagnose_plant(seed: int, effects: tuple[str, ...], with_pressure: bool, jobs: int = 1) -> dict[str, Any]:
    """Make one plant, diagnose its record without the truth, and put both side by side."""
    from diagnosis.blindtest.plants import draw_plant, measure
    from diagnosis.diagnose import diagnose
    from valvemodel.model import Model
    from valvemodel.records import Record
    from valvemodel.simulation import simulate
    from valvemodel.valves import read_valve

    plant = draw_plant(seed, effects)
    taken = measure(plant, seed + PROFILE_OFFSET, with_pressure=with_pressure)
    record = Record.from_arrays(
        name=f"plant {seed}",
        time=taken["time"],
        current=taken["current"],
        position=taken["position"],
        pressure=taken.get("pressure"),
    )
    valve = read_valve("calibrated")
    began = time.process_time()
    diagnosis = diagnose([record], Model(valve.name, valve.values), jobs=jobs)
    seconds = time.process_time() - began
    unseen = measure(plant, seed + 2 * PROFILE_OFFSET)

    def gap(model: Model) -> float:
        start = float(np.median(unseen["position"][:5]))
        run = simulate(model, time=unseen["time"], current=unseen["current"], start_position=start)
        return float(np.sqrt(np.mean((run.position - unseen["position"]) ** 2)))

    return {
        "seed": seed,
        "truth": list(effects),
        "formulation": [truth.formulation for truth in plant.effects],
        "noise": float(np.hypot(plant.noise, plant.resolution / np.sqrt(12.0))),
        "verdict": diagnosis.verdict,
        "causes": [
            {"effects": list(each.effects), "probability": each.probability, "gap_after": each.errors.rms}
            for each in diagnosis.causes[:5]
        ],
        "rivals": [list(each) for each in diagnosis.cause.rivals],
        "unknown_probability": diagnosis.unknown_probability,
        "stage": diagnosis.stage,
        "yardstick": diagnosis.yardstick,
        "gap": {
            "as_given": diagnosis.as_given.rms,
            "refitted": diagnosis.refitted.rms,
            "with_cause": diagnosis.cause.errors.rms,
            "noise_floor": diagnosis.floor,
        },
        "unseen": {"base": gap(diagnosis.base.model), "found": gap(diagnosis.found.model)},
        "seconds": seconds,
    }


def hit_of(result: dict[str, Any]) -> str:
    """Return how an answer compares with the truth: right, alias, unknown, none, wrong or false alarm."""
    truth = set(result["truth"])
    named = set(result["causes"][0]["effects"])
    if not truth:
        return (
            "right" if result["verdict"] == "none" else "unknown" if result["verdict"] == "unknown" else "false alarm"
        )
    if result["verdict"] != "effect":
        rivals = [set(each) for each in result["rivals"]]
        return "alias" if result["verdict"] == "none" and truth in rivals else result["verdict"]
    if named == truth:
        return "right"
    if truth in [set(each) for each in result["rivals"][:3]]:
        return "alias"
    return "partly" if named & truth else "wrong"


def _task(arguments: tuple[int, tuple[str, ...], bool]) -> dict[str, Any]:
    return diagnose_plant(*arguments)


@click.command()
@click.option("--single", default=2, show_default=True, help="Plants of each effect.")
@click.option("--none", "without", default=10, show_default=True, help="Plants without an effect.")
@click.option("--only", multiple=True, help="Only these effects.")
@click.option("--seed", default=0, show_default=True)
@click.option("--jobs", default=2, show_default=True)
@click.option("--pressure", is_flag=True, help="Measure the pressure too.")
@click.option("--json", "path", type=click.Path(path_type=Path), help="Write all results here.")
def main(
    single: int, without: int, only: Sequence[str], seed: int, jobs: int, pressure: bool, path: Path | None
) -> None:
    """Diagnose blind plants and print the hits by effect."""
    from diagnosis.blindtest.plants import EFFECTS

    keys = list(only) or list(EFFECTS)
    work: list[tuple[int, tuple[str, ...], bool]]
    work = [(seed + number, (key,), pressure) for number in range(single) for key in keys]
    work += [(seed + 500 + number, (), pressure) for number in range(without)]
    results = []
    with ProcessPoolExecutor(jobs, mp_context=get_context("fork")) as pool:
        for result in pool.map(_task, work):
            results.append(result)
            named = "+".join(result["causes"][0]["effects"]) or "none"
            gap = result["gap"]
            click.echo(
                f"{hit_of(result):11s} {'+'.join(result['truth']) or 'none':28s} {result['seed']:4d} "
                f"{result['formulation'][0] if result['truth'] else '':22s} {result['verdict']:7s} {named:40s} "
                f"{result['causes'][0]['probability']:.2f} unknown {result['unknown_probability']:.2f} "
                f"{1e3 * gap['refitted']:.3f} {1e3 * gap['with_cause']:.3f} {1e3 * gap['noise_floor']:.3f} mm, "
                f"unseen {1e3 * result['unseen']['base']:.3f} {1e3 * result['unseen']['found']:.3f}, "
                f"{result['seconds']:.0f} s {['+'.join(each) for each in result['rivals'][:3]]}"
            )
    if path is not None:
        path.write_text(json.dumps(results, indent=1))
    for title, chosen in (
        ("one effect", [r for r in results if r["truth"]]),
        ("none", [r for r in results if not r["truth"]]),
    ):
        counts: dict[str, int] = {}
        for result in chosen:
            counts[hit_of(result)] = counts.get(hit_of(result), 0) + 1
        click.echo(f"{title}: {len(chosen)} plants: " + ", ".join(f"{k} {v}" for k, v in sorted(counts.items())))
    click.echo(f"seconds of computing: median {np.median([r['seconds'] for r in results]):.1f}")


if __name__ == "__main__":
    main()
