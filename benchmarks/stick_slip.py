"""How well static friction and Stribeck friction explain blind plants of either, by their laws.

python -m benchmarks.stick_slip --first 9200 --count 10
"""

from __future__ import annotations

import argparse
import time

from diagnosis.blindtest.plants import draw_plant, measure
from diagnosis.choosing.stairs import on_stairs
from diagnosis.score import score_fit
from diagnosis.trying.workshop import Workshop
from identification.experiment import experiment_of
from identification.extending.extension import Extension, extend
from identification.fit import Fit, fit_base
from identification.holdout import Holdout, hold_out
from valvemodel.model import Model
from valvemodel.records import Record
from valvemodel.stages import EFFECTS
from valvemodel.valves import read_valve

KEYS = ("stribeck", "static_friction")


def prepare(record: Record) -> tuple[Holdout, Fit]:
    """Return what a diagnosis begins with: the parts of a record and the base valve, tempered on stairs."""
    valve = read_valve("calibrated")
    model, experiments = Model(valve.name, valve.values), [experiment_of(record)]
    holdout = hold_out(experiments)
    base = fit_base(model, holdout.experiments, holdout.fitted)
    _, holdout, base = on_stairs(experiments, Workshop(holdout), base, EFFECTS, model)
    return holdout, base


def main(arguments: list[str] | None = None) -> None:
    """Print for each plant the gap that is left on unseen data over the noise, and the seconds of each search."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.stick_slip", description=__doc__)
    parser.add_argument("--first", type=int, default=9200, help="seed of the first plant")
    parser.add_argument("--count", type=int, default=10, help="plants of each effect, one after the other")
    given = parser.parse_args(arguments)
    for number in range(2 * given.count):
        key, seed = KEYS[number // given.count], given.first + number
        plant = draw_plant(seed, (key,))
        taken = measure(plant, seed + 7)
        record = Record.from_arrays(
            name=str(seed), time=taken["time"], current=taken["current"], position=taken["position"]
        )
        holdout, base = prepare(record)
        words = [f"{seed} {key} {plant.effects[0].formulation}: base {score_fit(base, holdout).misfit ** 0.5:.2f}"]
        kin = None
        for tried in reversed(KEYS):
            begun = time.process_time()
            kin = extend(base, tried, Extension(kin=kin))
            spent = time.process_time() - begun
            words.append(f"{tried} {score_fit(kin, holdout).misfit ** 0.5:.2f} in {spent:.1f} s")
        print(", ".join(words), flush=True)


if __name__ == "__main__":
    main()
