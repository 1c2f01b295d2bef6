"""How often the measured pressure names the right half of the chain, on blind plants with one effect each.

    python -m benchmarks.stages [--seeds 2]

Prints one line a plant (shares of both halves, seconds) and, without the pressure, what the smallest corrections take.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from diagnosis.blindtest.plants import draw_plant, measure
from diagnosis.whereabouts.where import where_of
from identification.experiment import experiment_of
from identification.fit import fit_base
from valvemodel.declarations import FRONT
from valvemodel.model import Model
from valvemodel.records import Record
from valvemodel.stages import EFFECTS
from valvemodel.valves import read_valve


def judged(seed: int, key: str, stage: str) -> tuple[bool | None, str]:
    """Return whether the right half has most of the gap (None where both are at their noise), and a line about it."""
    taken = measure(draw_plant(seed, (key,)), seed + 1000, with_pressure=True)
    signals: dict[str, Any] = dict(taken)
    experiment = experiment_of(Record.from_arrays(name=key, **signals))
    blind = replace(experiment, pressure=None)
    valve = read_valve("calibrated")
    model = Model(valve.name, valve.values)
    words, share = [], None
    for each in (experiment, blind):
        base = fit_base(model, [each])
        began = time.perf_counter()
        found = where_of([each], base)
        seconds = time.perf_counter() - began
        if each is experiment:
            share = found.stages[0].share
            words.append(f"before the tap {share:.2f}" if share is not None else "at the noise")
        else:
            words += [f"{one.signal} closes {one.closed or 0.0:.2f}" for one in found.stages[1::2]]
        words.append(f"{seconds:.2f} s")
    is_right = None if share is None else (share > 0.5) == (stage in FRONT)
    return is_right, f"{key:28s} {stage:14s} {is_right!s:6s} " + ", ".join(words)


def main(arguments: Sequence[str] | None = None) -> None:
    """Judge plants of every effect."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.stages", description=__doc__)
    parser.add_argument("--seeds", type=int, default=2, help="plants of each effect")
    count = parser.parse_args(arguments).seeds
    marks = []
    for number, effect in enumerate(EFFECTS):
        for turn in range(count):
            is_right, line = judged(900 + 100 * turn + number, effect.key, effect.stage)
            marks.append(is_right)
            print(line, flush=True)
    told = [mark for mark in marks if mark is not None]
    print(f"{sum(told)} of {len(told)} in the right half, {len(marks) - len(told)} at the noise")


if __name__ == "__main__":
    main()
