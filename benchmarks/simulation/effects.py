"""Each effect alone, all of a stage together, and one a stage: time a period and what the default leaves over."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from benchmarks.simulation.ours import DEFAULT, FINER, SEARCH, Accuracy, chain_run
from benchmarks.simulation.stopwatch import shortest_time
from benchmarks.simulation.workload import PERIOD
from valvemodel.declarations import STAGES
from valvemodel.model import Model
from valvemodel.stages import EFFECTS
from valvemodel.valves import read_valve

REPEATS = 3

ONE_A_STAGE = ("magnetic_hysteresis", "chamber_filling", "stribeck", "linkage_backlash")


def currents(periods: int) -> np.ndarray:
    """Return a triangle of 20 s between 5 and 19 mA, then random steps every 0.5 s, shape (periods,). [A]"""
    phase = np.arange(periods) * PERIOD / 20.0 % 1.0
    triangle = 5e-3 + 14e-3 * (1.0 - np.abs(2.0 * phase - 1.0))
    lasting = round(0.5 / PERIOD)
    levels = np.random.default_rng(3).uniform(5e-3, 19e-3, periods // lasting + 1)
    return np.where(np.arange(periods) < periods // 2, triangle, np.repeat(levels, lasting)[:periods])


def combinations() -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield what each row is called and which effects are on, at their typical values."""
    yield "none", ()
    for effect in EFFECTS:
        yield effect.key, (effect.key,)
    for stage in STAGES:
        yield f"all of the {stage}", tuple(effect.key for effect in EFFECTS if effect.stage == stage)
    yield "one a stage", ONE_A_STAGE


def time_effects(periods: int, stretch: int, report: Callable[[str], None]) -> list[dict[str, Any]]:
    """Return a row for each combination: times over all periods, distances over a shorter stretch."""
    valve = read_valve("calibrated")
    drive, short = currents(periods), currents(stretch)
    rows = []
    for title, keys in combinations():
        report(title)
        model = Model(valve.name, valve.values)
        for key in keys:
            model = model.with_effect(key)
        finer = chain_run(model, short, FINER)()
        rows.append(
            {
                "effects": list(keys),
                "title": title,
                **measured(model, drive, short, finer, DEFAULT, ""),
                **measured(model, drive, short, finer, SEARCH, "_in_a_search"),
            }
        )
    return rows


def measured(
    model: Model, drive: np.ndarray, short: np.ndarray, finer: np.ndarray, accuracy: Accuracy, suffix: str
) -> dict[str, float]:
    """Return the time a period at an accuracy, and the largest distance from the finer run."""
    shortest = shortest_time(chain_run(model, drive, accuracy), REPEATS)
    distance = np.abs(chain_run(model, short, accuracy)() - finer).max()
    return {f"ns_per_period{suffix}": 1e9 * shortest / len(drive), f"m_from_finer{suffix}": float(distance)}


def time_chain(periods: int) -> dict[str, float]:
    """Return the time a period of the base model, driven by current, on the two halves of the drive. [ns]"""
    valve = read_valve("calibrated")
    drive = currents(2 * periods)
    halves = {"triangle": drive[:periods], "steps": drive[periods:]}
    return {
        f"ns_per_period_{title}": 1e9 * shortest_time(chain_run(Model(valve.name, valve.values), half), 40) / periods
        for title, half in halves.items()
    }
