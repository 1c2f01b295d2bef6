"""How often 95 % intervals of a fit hold the truth of independent plants (`python -m benchmarks.coverage`)."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import click
import numpy as np

DURATION, RATE, NOISE = 100.0, 100.0, 1e-4
"""Length of each record [s], samples a second [Hz], white noise of the reading [m]."""

START_SHARE = 0.8
"""Greatest part of the stuck band's half-width by which a start is off its middle."""

EXCESS, STIFFENING, STATIC_EXCESS = (0.3, 2.0), (0.05, 0.4), (0.1, 0.5)
"""Ranges of the effects: damping up over damping down less 1, stiffening over the travel, F_s over F_c less 1."""

DECAY_SPEED = 1e-5
"""Above this the plant's static excess is gone: as good as at once. [m/s]"""

POOLED, EACH = (0.93, 0.97), (0.91, 0.98)
"""Coverage that is asked for: of all parameters pooled, and of each."""

CASES: dict[str, tuple[str, ...]] = {
    "base": (),
    "two effects": ("asymmetric_viscous_friction", "spring_hardening"),
    "static friction": ("static_friction",),
}
"""Effects of each case, of the plant and of the fit; with static friction the intervals come from samples."""

SOUND = 1.05
"""A fit that leaves more than this of the noise has missed its minimum; it counts, and is counted."""


@dataclass(frozen=True)
class Trial:
    """One repetition: by parameter whether its interval holds the truth, and its error over its standard deviation."""

    is_covered: dict[str, bool]
    errors: dict[str, float]
    is_sound: bool
    seconds: float


def try_once(seed: int, effects: tuple[str, ...]) -> Trial:
    """Make a plant by the independent route, record it, fit it from the nominal valve, and compare."""
    from diagnosis.blindtest.profiles import draw_profile
    from diagnosis.blindtest.valve import draw_base, integrate
    from identification.fitting import fit_records
    from valvemodel.model import Model
    from valvemodel.records import Record
    from valvemodel.valves import read_valve

    generator = np.random.default_rng([seed, 77])
    base = draw_base(generator)
    truths, own = _effects(generator, effects, base["viscous_friction"])
    time, current = draw_profile(seed, duration=DURATION, rate=RATE)
    share = float(generator.uniform(-START_SHARE, START_SHARE))
    run = integrate(base, time, current, effects=truths, start_share=share)
    position = run["position"] + NOISE * generator.standard_normal(len(time))
    record = Record.from_arrays(name=f"plant {seed}", time=time, current=current, position=position)
    valve = read_valve("calibrated")
    has_profile = "static_friction" in effects
    outcome = fit_records([record], Model(valve.name, valve.values), effects=effects, has_profile=has_profile)
    truth = _as_fitted({**base, **own}, valve.values)
    covered, errors = {}, {}
    for each in outcome.parameters:
        low, high = outcome.determined.intervals[each.name]
        if each.name not in outcome.open and low is not None and high is not None:
            covered[each.name] = low <= truth[each.name] <= high
            errors[each.name] = 3.92 * (each.value - truth[each.name]) / (high - low)
    return Trial(covered, errors, outcome.rms_fitted < SOUND * NOISE, outcome.seconds)


def _effects(generator: np.random.Generator, keys: tuple[str, ...], damping: float) -> tuple[Any, dict[str, float]]:
    """Draw the plant's effects, and say their numbers as the model declares them."""
    from diagnosis.blindtest.chain.stem import TRAVEL_SCALE
    from diagnosis.blindtest.truth import Truth

    if not keys:
        return (), {}
    if keys == ("static_friction",):
        static = float(generator.uniform(*STATIC_EXCESS))
        numbers = {"static_excess": static, "decay_speed": DECAY_SPEED}
        return (Truth("static_friction", "stem", "karnopp", numbers),), {"static_friction_ratio": 1.0 + static}
    excess, stiffening = float(generator.uniform(*EXCESS)), float(generator.uniform(*STIFFENING))
    truths = (
        Truth("asymmetric_viscous_friction", "stem", "one_sided", {"excess": excess, "direction": 1.0}),
        Truth("spring_hardening", "stem", "cubic", {"stiffening": stiffening}),
    )
    return truths, {
        "viscous_friction": damping * (1.0 + 0.5 * excess),
        "viscous_asymmetry": excess / (2.0 + excess),
        "spring_hardening": stiffening / TRAVEL_SCALE**2,
    }


def _as_fitted(truth: Mapping[str, float], held: Mapping[str, float]) -> dict[str, float]:
    """Return the plant's numbers scaled, without any change of current and position, to what a fit holds."""
    from valvemodel.equations.symmetries import GROUPS

    scaled = dict(truth)
    for group in GROUPS["current, position", False]:
        *references, name = group
        for reference in references:
            if name in truth:
                scaled[name] *= (truth[reference] / held[reference]) ** group[reference]
    return scaled


def _task(work: tuple[int, tuple[str, ...]]) -> Trial:
    return try_once(*work)


@click.command()
@click.option("--repetitions", default=300, show_default=True)
@click.option(
    "--case",
    "cases",
    multiple=True,
    type=click.Choice(list(CASES)),
    help="May be given several times.",
    default=("base", "two effects"),
    show_default=True,
)
@click.option("--seed", default=0, show_default=True, help="Of the first plant.")
@click.option("--jobs", default=2, show_default=True)
@click.option("--json", "path", type=click.Path(path_type=Path), help="Write the shares here.")
def main(repetitions: int, cases: tuple[str, ...], seed: int, jobs: int, path: Path | None) -> None:
    """Fit plants and print the share of 95 % intervals that hold the truth."""
    from valvemodel.files import write_json

    shares = {}
    with ProcessPoolExecutor(jobs, mp_context=get_context("fork")) as pool:
        for case in cases:
            work = [(seed + number, CASES[case]) for number in range(repetitions)]
            with click.progressbar(pool.map(_task, work), length=repetitions, label=case, file=sys.stderr) as bar:
                shares[case] = _report(case, list(bar))
    if path is not None:
        write_json(path, shares)


def _report(case: str, trials: list[Trial]) -> dict[str, float]:
    names = sorted({name for trial in trials for name in trial.is_covered})
    hits = {name: [trial.is_covered[name] for trial in trials if name in trial.is_covered] for name in names}
    seconds, sound = np.median([each.seconds for each in trials]), sum(each.is_sound for each in trials)
    click.echo(f"{case}: {len(trials)} repetitions, {sound} fits down to the noise, median {seconds:.2f} s a fit")
    for name in names:
        share = float(np.mean(hits[name]))
        error = np.array([trial.errors[name] for trial in trials if name in trial.errors])
        verdict = "" if EACH[0] <= share <= EACH[1] else f", outside {EACH[0]:.0%}..{EACH[1]:.0%}"
        click.echo(
            f"  {name:22s} {share:6.1%} of {len(hits[name])} determined; error over its deviation: "
            f"mean {error.mean():+.2f}, rms {np.sqrt(np.mean(error**2)):.2f}{verdict}"
        )
    pooled = float(np.mean([hit for name in names for hit in hits[name]]))
    verdict = "within" if POOLED[0] <= pooled <= POOLED[1] else "outside"
    click.echo(f"  {'pooled':22s} {pooled:6.1%}, {verdict} {POOLED[0]:.0%}..{POOLED[1]:.0%}")
    return {**{name: float(np.mean(hits[name])) for name in names}, "pooled": pooled}


if __name__ == "__main__":
    main()
