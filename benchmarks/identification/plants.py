"""Valves to fit: records made by the blind plants' integrator, which shares no code with the simulator; bad starts."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

if TYPE_CHECKING:
    from identification.determined.uncertainty import Estimate
    from valvemodel.model import Model
    from valvemodel.records import Record

DURATION, RATE, NOISE = 100.0, 100.0, 1e-4
"""Length of each record [s], samples a second [Hz], white noise of the reading [m]."""

START_SHARE = 0.8
"""Greatest part of the stuck band's half-width by which a start is off its middle."""

HELD = ("diaphragm_area", "supply_pressure", "flow_ratio")
"""At their nominal values: current and position show only ratios to them."""

SEARCHED = ("spring_rate", "coulomb_friction", "viscous_friction", "gap_offset", "gap_gain")
"""Each start is off by a factor from one half to two."""

CLOSE, SURE = 0.02, 3.0
"""A parameter is found within this share, or within this many of its own standard deviations."""

DECAY_SPEED = 1e-6
"""Friction falls from breakaway to Coulomb within the first fine step of a slip. [m/s]"""


@dataclass(frozen=True)
class Case:
    """A kind of valve: damping (None: as drawn), range of F_s over F_c, and whether issue 4 asks for it."""

    title: str
    viscous_friction: float | None = None
    ratios: tuple[float, float] | None = None
    is_asked: bool = True

    @property
    def effects(self) -> tuple[str, ...]:
        """Keys of the effects to fit."""
        return () if self.ratios is None else ("static_friction",)


CASES = {
    "base": Case("base valve"),
    "static": Case("base valve, F_s free", ratios=(1.05, 1.6)),
    "ringing": Case("f_v = 1.59 N s/m", 1.59),
    "ringing static": Case("f_v = 1.59 N s/m, F_s free", 1.59, (1.05, 1.6), is_asked=False),
}


@dataclass(frozen=True)
class Made:
    """A plant's true numbers, its record [s, A, m], and a model whose numbers are off."""

    truth: dict[str, float]
    time: Array
    current: Array
    position: Array
    start: Model
    effects: tuple[str, ...]

    @property
    def record(self) -> Record:
        """The record as the toolkit takes it."""
        from valvemodel.records import Record

        return Record.from_arrays("plant", time=self.time, current=self.current, position=self.position)


def make(case: Case, seed: int) -> Made:
    """Draw a valve, integrate it finely under plant-like currents, and draw where a fit starts."""
    from diagnosis.blindtest.plants import Truth, integrate
    from diagnosis.blindtest.profiles import draw_profile
    from diagnosis.blindtest.valve import NOMINAL, draw_base
    from valvemodel.model import Model
    from valvemodel.valves import read_valve

    generator = np.random.default_rng([seed, 4])
    base = {**draw_base(generator), **{name: NOMINAL[name] for name in HELD}}
    if case.viscous_friction is not None:
        base["viscous_friction"] = case.viscous_friction
    truth = dict(base)
    effects: tuple[Truth, ...] = ()
    if case.ratios is not None:
        truth["static_friction_ratio"] = float(generator.uniform(*case.ratios))
        own = {"static_excess": truth["static_friction_ratio"] - 1.0, "decay_speed": DECAY_SPEED}
        effects = (Truth("static_friction", "stem", "karnopp", own),)
    time, current = draw_profile(seed, duration=DURATION, rate=RATE)
    share = float(generator.uniform(-START_SHARE, START_SHARE))
    run = integrate(base, time, current, effects=effects, start_share=share)
    position = run["position"] + NOISE * generator.standard_normal(len(time))
    off = {name: truth[name] * float(2.0 ** generator.uniform(-1.0, 1.0)) for name in SEARCHED}
    valve = read_valve("calibrated")
    return Made(truth, time, current, position, Model("off", {**valve.values, **off}), case.effects)


def missed(truth: dict[str, float], values: dict[str, float]) -> list[str]:
    """Return the parameters that are off by more than the share, among those that a record shows."""
    shown = [*SEARCHED, *(["static_friction_ratio"] if "static_friction_ratio" in truth else [])]
    return [name for name in shown if not abs(values[name] - truth[name]) <= CLOSE * truth[name]]


def not_found(truth: dict[str, float], found: Iterable[Estimate]) -> list[str]:
    """Return the parameters that are off by more than the share and by more than their own deviations."""
    values = {each.name: each for each in found}
    far = missed(truth, {name: each.value for name, each in values.items()})
    return [
        name for name in far if (std := values[name].std) is None or abs(values[name].value - truth[name]) > SURE * std
    ]
