"""The next experiment: the current profile that tells rival causes apart best, within limits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from diagnosis.separation import Rival, blank_experiment, least_separation, rival_of, separations
from diagnosis.trying.candidates import Candidate
from diagnosis.valve_diagnosis import Diagnosis
from identification.experiment import Experiment
from valvemodel.progress import Progress, tell_nobody
from valvemodel.records import write_table

SEGMENTS = 6
"""Pieces of a profile, each a ramp and a dwell; they may be repeated."""

MOST_REPEATS = 6

SEARCHED_SAMPLES = 1200
"""Samples of a profile while it is searched; the one that is found is judged at the record's own rate."""

POPULATION, GENERATIONS = 36, 25

FINALISTS = 12
"""Profiles of the last generation, the best to first order, whose rivals are refitted: of two that promise as much to
first order a rival may follow one and not the other."""

USUAL_PRESSURE_NOISE = 300.0
"""Noise that a pressure gauge is taken to have where none was used yet. [Pa]"""


@dataclass(frozen=True)
class Limits:
    """What the next experiment may do: currents [A], slew rate [A/s], duration [s]."""

    lowest: float = 4e-3
    highest: float = 20e-3
    rate: float = math.inf
    duration: float = 120.0


@dataclass(frozen=True, eq=False)
class NextExperiment:
    """A designed input.

    Attributes
    ----------
    name : str
        Of the file of the profile.
    time, current : arrays, shape (n,) [s], [A]
    rivals : list of tuple of str
    is_open : bool
        Whether the diagnosis declares the rivals indistinguishable; else the runner-up stands in.
    separation : dict of float
        Least difference between two refitted rivals, root mean square over the noise: under the present input (`now`)
        and this one (`profile`); where the pressure was not measured, the same with it (`pressure_now`,
        `profile_and_pressure`).
    pair : tuple
        The two that differ least under this input.
    """

    name: str
    time: np.ndarray
    current: np.ndarray
    rivals: list[tuple[str, ...]]
    is_open: bool
    separation: dict[str, float]
    pair: tuple[tuple[str, ...], tuple[str, ...]]
    limits: Limits

    def as_json(self) -> dict[str, Any]:
        """Return what diagnosis.json has of it."""
        return {
            "file": self.name,
            "rivals": [list(each) for each in self.rivals],
            "is_open": self.is_open,
            "separation": {"unit": "noise standard deviations, root mean square", **self.separation},
            "closest_pair": [list(each) for each in self.pair],
            "limits": asdict(self.limits),
        }

    def write(self, path: Path) -> None:
        """Write the profile as CSV that `valvemodel simulate --input` takes."""
        write_table(path, {"time [s]": np.round(self.time, 9), "current [mA]": np.round(1e3 * self.current, 5)})


def next_experiment(
    diagnosis: Diagnosis,
    limits: Limits,
    *,
    name: str = "next.csv",
    seed: int = 0,
    progress: Progress = tell_nobody,
) -> NextExperiment:
    """Design the input that makes the smallest expected difference between refitted rivals as large as possible.

    The rivals are the cause and what the diagnosis cannot tell from it, or else the runner-up. Profiles are ramps and
    dwells between free levels, repeated or not; the search is differential evolution, begun at the usual test signals.
    It takes refits to first order, and of what comes out of it the best by a refit is chosen.

    References
    ----------
    Atkinson, Fedorov: The design of experiments for discriminating between two rival models, Biometrika 62 (1975).
    """
    from scipy.optimize import differential_evolution

    chosen, is_open = rivals_in(diagnosis)
    rivals = [rival_of(each.effects, each.fit) for each in chosen]
    present = diagnosis.experiments[0]
    period = present.period
    coarse = max(period, limits.duration / SEARCHED_SAMPLES)
    pressure_noise = present.pressure_noise or None
    evaluated = 0

    def least(design: np.ndarray) -> float:
        nonlocal evaluated
        evaluated += 1
        progress("designing the next experiment", min(evaluated / (POPULATION * (GENERATIONS + 1)), 1.0))
        time, current = profile_of(design, limits, coarse)
        blank = blank_experiment(time, current, noise=present.noise, pressure_noise=pressure_noise)
        return -min(separations(rivals, blank).values())

    first = first_designs(np.random.default_rng(seed))
    found = differential_evolution(
        least,
        [(0.0, 1.0)] * first.shape[1],
        init=first,
        maxiter=GENERATIONS,
        tol=1e-3,
        polish=False,
        rng=np.random.default_rng(seed),
    )
    order = np.argsort(found.population_energies)[:FINALISTS]
    profiles = [profile_of(found.population[number], limits, period) for number in order]
    time, current = best_by_refits(rivals, diagnosis.experiments, profiles, -found.population_energies[order])
    separation, pair = judged(rivals, diagnosis.experiments, time, current)
    return NextExperiment(
        name=name,
        time=time,
        current=current,
        rivals=[rival.effects for rival in rivals],
        is_open=is_open,
        separation=separation,
        pair=pair,
        limits=limits,
    )


def judged(
    rivals: Sequence[Rival], present: Sequence[Experiment], time: np.ndarray, current: np.ndarray
) -> tuple[dict[str, float], tuple[tuple[str, ...], tuple[str, ...]]]:
    """Return the separations under the present and the next input, and the pair that is closest under the next."""
    now = present[0].time, present[0].current
    apart, pair = left_by_refits(rivals, present, time, current)
    separation = {"now": left_by_refits(rivals, present, *now)[0], "profile": apart}
    if present[0].pressure is None:
        separation["pressure_now"] = left_by_refits(rivals, present, *now, with_gauge=True)[0]
        separation["profile_and_pressure"] = left_by_refits(rivals, present, time, current, with_gauge=True)[0]
    return separation, pair


def best_by_refits(
    rivals: Sequence[Rival],
    present: Sequence[Experiment],
    profiles: Sequence[tuple[np.ndarray, np.ndarray]],
    promised: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the profile, time [s] and current [A], under which refitted rivals differ most.

    Parameters
    ----------
    profiles : sequence of (time, current)
        The one first that promises most to first order.
    promised : array, shape (profiles,)
        Separations to first order: a refit leaves no more, and what is within the noise tells nothing apart.
    """
    best, most = profiles[0], 0.0
    for profile, promise in zip(profiles, promised, strict=True):
        if promise < max(most, 1.0):
            break
        left, _ = left_by_refits(rivals, present, *profile)
        if left > most:
            best, most = profile, left
    return best


def left_by_refits(
    rivals: Sequence[Rival],
    present: Sequence[Experiment],
    time: np.ndarray,
    current: np.ndarray,
    *,
    with_gauge: bool = False,
) -> tuple[float, tuple[tuple[str, ...], tuple[str, ...]]]:
    """Return the least separation of refitted rivals under an input, and the pair; with a pressure gauge or as now."""
    pressure_noise = present[0].pressure_noise or (USUAL_PRESSURE_NOISE if with_gauge else None)
    blank = blank_experiment(time, current, noise=present[0].noise, pressure_noise=pressure_noise)
    return least_separation(rivals, present, blank)


def rivals_in(diagnosis: Diagnosis) -> tuple[list[Candidate], bool]:
    """Return the cause and its rivals, or where it has none the next cause of no more effects, and which it is."""
    by_effects = {each.effects: each for each in diagnosis.tried}
    own = diagnosis.cause
    if own.rivals:
        return [by_effects[effects] for effects in (own.effects, *own.rivals)], True
    others = [
        each.effects
        for each in diagnosis.causes[1:]
        if len(each.effects) <= max(len(own.effects), 1) and not (own.effects and set(own.effects) < set(each.effects))
    ]
    return [by_effects[own.effects], by_effects[others[0]]], False


def profile_of(design: np.ndarray, limits: Limits, period: float) -> tuple[np.ndarray, np.ndarray]:
    """Return time [s] and current [A] of a design: levels, lengths and ramp shares of the segments, and repeats.

    Parameters
    ----------
    design : array, shape (3 segments + 1,)
        All between 0 and 1.
    limits : Limits
    period : float [s]
    """
    levels, lengths, ramps = design[:-1].reshape(3, SEGMENTS)
    repeats = 1 + min(int(design[-1] * MOST_REPEATS), MOST_REPEATS - 1)
    levels = np.tile(limits.lowest + (limits.highest - limits.lowest) * levels, repeats)
    lengths = np.tile(np.exp(3.0 * lengths), repeats)
    lengths *= limits.duration / lengths.sum()
    ramps = np.tile(ramps, repeats) * lengths
    at, current = [0.0], [float(levels[-1])]
    for level, length, ramp in zip(levels, lengths, ramps, strict=True):
        change = level - current[-1]
        ramp = min(max(ramp, abs(change) / limits.rate, 1e-9), length)
        reached = current[-1] + math.copysign(min(abs(change), limits.rate * ramp), change)
        start = at[-1]
        at += [start + ramp, start + length]
        current += [reached, reached]
    time = period * np.arange(round(limits.duration / period) + 1)
    return time, np.round(np.interp(time, at, current), 8)


def first_designs(generator: np.random.Generator) -> np.ndarray:
    """Return the usual test signals and random ones, shape (population, 3 segments + 1)."""
    up_and_down = np.tile([0.0, 1.0], SEGMENTS // 2)
    stairs = 1.0 - np.abs(np.linspace(-1.0, 1.0, SEGMENTS))
    designs = []
    for shape, size, ramp in product((up_and_down, stairs), (1.0, 0.3, 0.08), (1.0, 0.0)):
        for middle, repeats in ((0.5, 0.0), (0.7, 0.6)):
            levels = np.clip(middle + size * (shape - 0.5), 0.0, 1.0)
            designs.append(np.concatenate([levels, np.full(SEGMENTS, 0.5), np.full(SEGMENTS, ramp), [repeats]]))
    others = generator.random((POPULATION - len(designs), 3 * SEGMENTS + 1))
    return np.vstack([*designs, others])
