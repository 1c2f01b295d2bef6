"""Figures of issue 4, each with its threshold (`python -m benchmarks.identification`)."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import click

PARTS = ("exact", "smooth", "loops", "calibration", "emps", "coverage", "peers", "optimisers")

USUAL = ("exact", "smooth", "loops", "calibration", "emps", "coverage", "peers")

UNASKED_SHARE = 10
"""A case that is not asked for is repeated less often by this factor."""

Tick = Callable[[], None]


@click.command()
@click.option("--repetitions", default=100, show_default=True, help="Of the exact route and of the loops.")
@click.option("--smooth-repetitions", default=10, show_default=True, help="Of the CasADi route.")
@click.option("--peer-repetitions", default=5, show_default=True, help="Of the peers; those of minutes run twice.")
@click.option("--coverage-repetitions", default=0, show_default=True, help="0 leaves coverage to its own benchmark.")
@click.option("--only", "parts", multiple=True, type=click.Choice(PARTS), default=USUAL, help="May come several times.")
@click.option("--json", "path", type=click.Path(path_type=Path), help="Write all figures here.")
def main(
    repetitions: int,
    smooth_repetitions: int,
    peer_repetitions: int,
    coverage_repetitions: int,
    parts: tuple[str, ...],
    path: Path | None,
) -> None:
    """Fit what independent plants recorded, and print success, seconds and errors."""
    from valvemodel.files import write_json

    work: dict[str, Callable[[], Any]] = {
        "exact": lambda: routes("exact", repetitions),
        "smooth": lambda: routes("smooth", smooth_repetitions),
        "loops": lambda: loops(repetitions),
        "calibration": calibration,
        "emps": emps,
        "coverage": lambda: coverage(coverage_repetitions),
        "peers": lambda: peers(peer_repetitions),
        "optimisers": lambda: optimisers(peer_repetitions),
    }
    found = {}
    for part in parts:
        found[part] = work[part]()
        if path is not None:
            write_json(path, found)


def counted(label: str, count: int, run: Callable[[Tick], Any]) -> Any:
    """Run something that ticks, with a bar on a terminal."""
    with click.progressbar(length=count, label=label, file=sys.stderr) as bar:
        return run(lambda: bar.update(1))


def routes(route: str, repetitions: int) -> dict[str, Any]:
    """Print success and seconds of a route on every kind of valve."""
    import importlib.util

    from benchmarks.identification.plants import CASES
    from benchmarks.identification.routes import BUDGET, score_route

    if route == "smooth" and importlib.util.find_spec("identification.smooth_fit") is None:
        click.echo("smooth route: left out, there is no identification.smooth_fit")
        return {}
    found = {}
    for key, case in CASES.items():
        count = repetitions if case.is_asked else max(repetitions // UNASKED_SHARE, 1)
        score = counted(case.title, count, partial(score_route, route, case, count))
        found[key] = row = score.as_json()
        seconds = row["seconds"]
        note = f"asked: 99 %, {BUDGET[route]:g} s" if case.is_asked else "not asked for"
        click.echo(
            f"{route} route, {case.title:28s} {score.successes} of {count} found, seconds: median "
            f"{seconds['median']:.2f}, 95 % {seconds['95 %']:.2f}, longest {seconds['longest']:.2f}, "
            f"of computing {row['seconds of computing']:.2f} ({note})"
            + "".join(f"\n  seed {seed}: {', '.join(names)}" for seed, names in row["failures"].items())
        )
    return found


def loops(repetitions: int) -> dict[str, Any]:
    """Print the errors of loops of 57 points."""
    from benchmarks.identification.loops import score_loops

    found: dict[str, Any] = counted("loops", repetitions, partial(score_loops, repetitions))
    for name, row in found.items():
        click.echo(
            f"loop of 57 points, {name:7s} rms error {row['rms']:.2%}, largest {row['largest']:.2%}, within 1 % in "
            f"{row['within 1 %']} of {repetitions}; error over its deviation {row['error over its deviation, rms']:.2f}"
        )
    return found


def calibration() -> list[dict[str, Any]]:
    """Print the bias of the self-calibration."""
    from benchmarks.identification.calibration import bias_table

    rows = bias_table()
    click.echo("self-calibration        points                        noise   bias     scatter  stated   warned")
    for row in rows:
        click.echo(
            f"  {row['valve']:20s}  {row['points']:28s} {row['noise']:6.1%}  {row['bias']:+7.2%}"
            f"  {row['scatter']:7.2%}  {row['stated']:7.2%}  {row['warned']:6.0%}"
        )
    return rows


def emps() -> dict[str, Any]:
    """Print how far EMPS is off the published numbers, and what the best model says."""
    from benchmarks.emps import emps_file, figures
    from identification.inverse_dynamics import prepare_signals
    from valvemodel.records import read_record

    file = emps_file()
    if not file.exists():
        click.echo(f"EMPS: left out, no record at {file}; set VALVEMODEL_DATA")
        return {}
    found = figures(prepare_signals(read_record(file)))
    for name in ("symmetric", "direction-dependent"):
        row = found[name]
        click.echo(
            f"EMPS, {name}: parameters within {row['largest parameter error']:.2%} (asked: 0.5 %), force error "
            f"{row['force error, points']:+.4f} points (asked: 0.3)"
        )
    click.echo("\n".join(f"EMPS, best model: {text}" for text in found["says"]))
    return found


def coverage(repetitions: int) -> dict[str, float]:
    """Print the pooled coverage of 95 % intervals on the base valve."""
    import numpy as np

    if repetitions == 0:
        click.echo("coverage of 95 % intervals: left out here, see `python -m benchmarks.coverage`")
        return {}
    from benchmarks.coverage import CASES, try_once

    found = {}
    for case in ("base", "two effects"):
        trials = [try_once(seed, CASES[case]) for seed in range(repetitions)]
        hits = [is_covered for trial in trials for is_covered in trial.is_covered.values()]
        found[case] = float(np.mean(hits))
        click.echo(f"coverage of 95 % intervals, {case}: {found[case]:.1%} of {len(hits)} (asked: 93..97 %)")
    return found


def peers(repetitions: int) -> dict[str, Any]:
    """Print what peers do on the same data."""
    from benchmarks.identification.peers import PEERS, score_peer

    found = {}
    for name, peer in PEERS.items():
        if not peer.is_there:
            click.echo(
                f"{name}: left out, {peer.package} is not installed (pip install 'valvemodel[identification-peers]')"
            )
            continue
        count = min(repetitions, peer.most)
        found[name] = row = counted(name, count, partial(score_peer, peer, repetitions))
        click.echo(
            f"{name:46s} {row['successes']} of {row['repetitions']} within 2 %, median {row['seconds']:.2f} s, "
            f"{row['lines of user code']} lines of user code"
        )
    return found


def optimisers(repetitions: int) -> dict[str, Any]:
    """Print which optimisers find the valve at equal cost, on the exact simulator."""
    from benchmarks.identification.optimisers import SEARCHES, score_search
    from benchmarks.identification.plants import CASES

    found: dict[str, Any] = {}
    for key in ("base", "static", "ringing"):
        for search in SEARCHES:
            found[f"{key}, {search}"] = row = counted(
                f"{key}, {search}",
                repetitions,
                partial(score_search, search, CASES[key], repetitions),
            )
            click.echo(
                f"{CASES[key].title:28s} {search:12s} {row['successes']} of {row['repetitions']}"
                f", {row['seconds']:.2f} s"
            )
    return found


if __name__ == "__main__":
    main()
