"""Blind plants: valves with known effects, made by a route that shares no code with the toolkit.

    python -m diagnosis.blindtest.plants --demo OUT.csv

makes the bundled demo record again, and beside it `OUT-b.csv`, a second record of the same valve.
"""

import argparse
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from diagnosis.blindtest.chain.clock import Signal
from diagnosis.blindtest.chain.sensor import digitised
from diagnosis.blindtest.formulations import EFFECTS, Formulation
from diagnosis.blindtest.profiles import draw_profile
from diagnosis.blindtest.severity import Scale, judged, scale_of, sized
from diagnosis.blindtest.truth import Truth
from diagnosis.blindtest.valve import FINE_STEP, choked_truth, draw_base, integrate

__all__ = ["EFFECTS", "Plant", "Truth", "draw_plant", "integrate", "measure", "write_record"]

VISIBILITY = (3.0, 20.0)  # rms that a refit leaves of an effect, over the noise
BELOW_NOTICE, NOTICED = (0.1, 0.25), 0.3  # rms of a nuisance, over the noise; one that cannot be made less is none
NOISE = (0.05e-3, 0.2e-3)  # m
RESOLUTION = 0.05e-3  # m
PRESSURE_NOISE = 300.0  # Pa
NUISANCES = 2
# There or not there; or, for a stop, felt beyond the ramps' ends; or too stiff for the step.
NEVER_BELOW_NOTICE = ("choked_flow", "quantisation", "end_stop", "presliding")
# A plant's smallest magnitude over the formulation's lowest: not all weak effects are equally weak.
FLOORS, NUISANCE_FLOOR = (1.0, 3.0), 2e-4
START_SHARE = 0.8  # greatest part of the stuck band's half-width by which a start is off its middle

DEMO_SEED, DEMO_PROFILES = 1, (1, 2)
DEMO_EFFECTS, DEMO_VISIBILITY = ("asymmetric_filling",), (12.0, 25.0)

# Streams of random numbers that must not move when another one is drawn longer.
VALVE_STREAM, EFFECT_STREAM, RECORD_STREAM, NUISANCE_STREAM = 2, 3, 4, 5


@dataclass(frozen=True)
class Plant:
    """A real valve as the blind test sees it.

    Attributes
    ----------
    seed : int
    effects : tuple of Truth
        What is in it beyond the base model, nuisances included.
    base : dict
        Base parameters by name, SI units.
    noise : float
        Rms white noise of the reading. [m]
    resolution : float
        Step of the reading. [m]
    """

    seed: int
    effects: tuple[Truth, ...]
    base: dict[str, float] = field(default_factory=dict)
    noise: float = 1e-4
    resolution: float = RESOLUTION

    def answer(self) -> tuple[str, ...]:
        """The keys that a diagnosis should name, sorted."""
        return tuple(sorted(truth.effect for truth in self.effects if not truth.nuisance))

    def described(self) -> dict[str, Any]:
        """The whole truth as plain data, for a sealed file."""
        return asdict(self)


def draw_plant(
    seed: int,
    effects: Sequence[str] = ("static_friction",),
    *,
    nuisance: bool = False,
    visibility: tuple[float, float] = VISIBILITY,
) -> Plant:
    """Draw a valve with the named effects; the same arguments give the same valve.

    Parameters
    ----------
    seed : int
    effects : sequence of str
        Keys of the effects; empty for a valve that the base model describes.
    nuisance : bool
        Add two further effects below notice (0.1 to 0.25 of the noise).
    visibility : (float, float)
        Range of the rms that a refitted base leaves of each effect, over the noise; an effect stays
        within its physical bounds, and one that a refit imitates well stays below the range.
    """
    _check_names(effects)
    generator = np.random.default_rng([seed, VALVE_STREAM])
    noise = float(np.exp(generator.uniform(*np.log(NOISE))))
    valve_seed = int(generator.integers(1 << 30))
    plain = draw_base(np.random.default_rng(valve_seed))
    scale = scale_of(plain, seed)
    truths = [_draw_effect(seed, key, plain, scale, noise, visibility) for key in effects]
    truths = [_within_reach(truth, truths, scale) if truth.effect == "end_stop" else truth for truth in truths]
    if nuisance:
        others = (
            _draw_effect(seed, key, plain, scale, noise, BELOW_NOTICE, nuisance=True)
            for key in _nuisance_keys(seed, effects)
        )
        truths += islice((truth for truth in others if truth.visibility < NOTICED), NUISANCES)
    choked = choked_truth(tuple(truths))
    base = draw_base(np.random.default_rng(valve_seed), choked)
    settled = tuple(judged(truth, scale, noise, base) if truth is choked else truth for truth in truths)
    return Plant(seed, settled, base, noise)


def _check_names(effects: Sequence[str]) -> None:
    """Refuse names that are no effect, and doubles."""
    unknown = [key for key in effects if key not in EFFECTS]
    if unknown:
        raise ValueError(f"no effect is named {', '.join(unknown)}; there are {', '.join(EFFECTS)}")
    if len(set(effects)) < len(effects):
        raise ValueError(f"an effect is named twice in {', '.join(effects)}; name each once")


def _within_reach(stop: Truth, truths: Sequence[Truth], scale: Scale) -> Truth:
    """A stop as short of the travel that the other effects leave as it was of the base valve's."""
    others = tuple(truth for truth in truths if truth is not stop and truth.stage != "sensor")
    if not others:
        return stop
    side = stop.parameters["side"]
    moved = _reached(scale.trace_with(others), side) - _reached(scale.trace, side)
    return replace(
        stop, parameters={**stop.parameters, "reference_travel": stop.parameters["reference_travel"] + moved}
    )


def _reached(trace: Signal, side: float) -> float:
    """How far a reading comes to a side once it has been in the other half: it may have begun farther. [m]"""
    away = side * trace < 0.5 * np.ptp(trace) + float(np.min(side * trace))
    return side * float(np.max(side * trace[int(np.argmax(away)) :]))


def _nuisance_keys(seed: int, effects: Sequence[str]) -> list[str]:
    """Effects to add below notice, in the order of trying: others than the plant's own, of adjustable magnitude."""
    generator = np.random.default_rng([seed, NUISANCE_STREAM])
    left = [key for key in EFFECTS if key not in effects and key not in NEVER_BELOW_NOTICE]
    first = [str(key) for key in generator.choice(left, NUISANCES, replace=False)]
    return first + [str(key) for key in generator.permutation([key for key in left if key not in first])]


def _draw_effect(
    seed: int,
    key: str,
    base: dict[str, float],
    scale: Scale,
    noise: float,
    visibility: tuple[float, float],
    *,
    nuisance: bool = False,
) -> Truth:
    """Draw an effect's law and numbers, and size it."""
    generator = np.random.default_rng([seed, EFFECT_STREAM, list(EFFECTS).index(key)])
    laws = EFFECTS[key].formulations
    law: Formulation = laws[int(generator.integers(len(laws)))]
    target = float(np.exp(generator.uniform(*np.log(visibility))))
    floor = NUISANCE_FLOOR if nuisance else float(np.exp(generator.uniform(*np.log(FLOORS))))
    truth = Truth(key, EFFECTS[key].stage, law.name, law.draw(generator, base), nuisance=nuisance)
    return sized(truth, law, scale, noise=noise, target=target, floor=floor)


def measure(
    plant: Plant,
    profile_seed: int,
    *,
    duration: float = 150.0,
    rate: float = 50.0,
    with_pressure: bool = False,
    kind: str = "mixed",
    step: float = FINE_STEP,
) -> dict[str, Signal]:
    """Take a record of a plant under a drawn current profile.

    Parameters
    ----------
    profile_seed : int
        Seed of the profile, the start in the stuck band and the noise; another one, another record.
    duration, rate : float
        Length [s] and samples a second [Hz].
    with_pressure : bool
        Record the chamber's pressure too.
    kind : str
        `mixed`, `triangles`, `steps` or `small`.
    step : float
        Longest fine step. [s]

    Returns
    -------
    dict
        `time` [s], `current` [A], `position` [m] and, if wanted, `pressure` [Pa], each of shape (n,):
        the state just before the period's input acts.
    """
    time, current = draw_profile(profile_seed, duration=duration, rate=rate, kind=kind)
    generator = np.random.default_rng([plant.seed, profile_seed, RECORD_STREAM])
    share = float(generator.uniform(-START_SHARE, START_SHARE))
    true = integrate(plant.base, time, current, step=step, effects=plant.effects, start_share=share)
    noise = plant.noise * generator.standard_normal(time.size)
    record = {
        "time": time,
        "current": current,
        "position": digitised(true["position"], noise, plant.resolution, plant.effects),
    }
    if with_pressure:
        record["pressure"] = true["pressure"] + PRESSURE_NOISE * generator.standard_normal(time.size)
    return record


def write_record(path: str | Path, measurement: dict[str, Signal]) -> None:
    """Write a record as the toolkit reads it: s, mA, kPa (if measured) and mm."""
    columns = [("time", "time [s]", 1.0, "%.4f"), ("current", "current [mA]", 1e3, "%.5f")]
    columns += [("pressure", "pressure [kPa]", 1e-3, "%.4f"), ("position", "position [mm]", 1e3, "%.4f")]
    columns = [column for column in columns if column[0] in measurement]
    table = np.stack([measurement[name] * factor for name, _, factor, _ in columns], axis=1)
    header = ",".join(title for _, title, _, _ in columns)
    formats = [printed for *_, printed in columns]
    np.savetxt(path, table, fmt=formats, delimiter=",", header=header, comments="")


def demo_plant() -> Plant:
    """The valve of the bundled demo records."""
    return draw_plant(DEMO_SEED, DEMO_EFFECTS, visibility=DEMO_VISIBILITY)


def write_demo(path: Path) -> list[Path]:
    """Write the demo record, and beside it a second one of the same valve."""
    plant = demo_plant()
    paths = [path, path.with_name(f"{path.stem}-b{path.suffix}")]
    for out, profile in zip(paths, DEMO_PROFILES, strict=True):
        write_record(out, measure(plant, profile))
    return paths


def main(arguments: Sequence[str] | None = None) -> None:
    """Make the demo records from the command line."""
    parser = argparse.ArgumentParser(prog="python -m diagnosis.blindtest.plants", description=__doc__)
    parser.add_argument("--demo", type=Path, required=True, metavar="OUT.csv", help="where to write the record")
    for path in write_demo(parser.parse_args(arguments).demo):
        print(path)


if __name__ == "__main__":
    main()
