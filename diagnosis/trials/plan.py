"""The plan of a blind test: which plants are made, from which seeds, for which question."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain, combinations, count, islice
from typing import Any

import numpy as np

from diagnosis.blindtest.formulations import EFFECTS
from valvemodel.effects import effect_of_key
from valvemodel.errors import InputError, unknown_name

KINDS = ("single", "pair", "none", "left-out")
"""One effect; two; none; one that the diagnosis is not offered as a candidate."""

_SEED_OF = {"plant": 0, "record": 1, "unseen": 2}


@dataclass(frozen=True)
class Settings:
    """What a blind test asks; the number of plants may grow later, all else stays.

    Attributes
    ----------
    seed : int
    kinds : tuple of str
        Of `KINDS`, taken in turn.
    only : tuple of str
        Keys of the effects that plants have; all where empty.
    with_pressure : bool
        Whether the pressure is measured too.
    every : int
        Of the rows as they are driven so many are one of the record, as of a logger that is slower.
    current_noise : float [A]
        White noise that the current is measured with, and that the valve knows nothing of.
    """

    seed: int = 0
    kinds: tuple[str, ...] = KINDS
    only: tuple[str, ...] = ()
    with_pressure: bool = False
    every: int = 1
    current_noise: float = 0.0

    def __post_init__(self) -> None:
        for kind in self.kinds:
            if kind not in KINDS:
                raise unknown_name("a kind of plant", kind, KINDS)
        for key in self.only:
            effect_of_key(key)
        if self.current_noise < 0.0:
            raise InputError(
                "noise is not negative", f"a current with noise of {1e3 * self.current_noise:g} mA", "give 0 or more"
            )

    def as_json(self) -> dict[str, Any]:
        """Return the settings as files have them."""
        return {
            "seed": self.seed,
            "kinds": list(self.kinds),
            "only": list(self.only),
            "with_pressure": self.with_pressure,
            "every": self.every,
            "current_noise": self.current_noise,
        }


@dataclass(frozen=True)
class Task:
    """One plant to be made: its number, the question, the effects, and the seed of each thing that is drawn."""

    number: int
    kind: str
    effects: tuple[str, ...]
    seeds: dict[str, int] = field(hash=False)

    @property
    def name(self) -> str:
        """The plant's name in files."""
        return f"plant-{self.number:04d}"

    @property
    def left_out(self) -> tuple[str, ...]:
        """The effects that are taken out of the candidates."""
        return self.effects if self.kind == "left-out" else ()


def tasks_of(settings: Settings, plants: int) -> list[Task]:
    """Return the first plants of a test; more plants leave these as they are."""
    effects = {kind: effects_of(kind, settings) for kind in settings.kinds}
    kinds = islice((kind for _ in count() for kind in settings.kinds), plants)
    return [
        Task(number, kind, next(effects[kind]), seeds_of(settings.seed, number)) for number, kind in enumerate(kinds, 1)
    ]


def seeds_of(seed: int, number: int) -> dict[str, int]:
    """Return the seeds of one plant, of its record and of its unseen record."""
    return {
        what: int(np.random.SeedSequence([seed, number, stream]).generate_state(1)[0] >> 1)
        for what, stream in _SEED_OF.items()
    }


def effects_of(kind: str, settings: Settings) -> Iterator[tuple[str, ...]]:
    """Yield the effects of the plants of a kind without end, each set in turn before one comes again."""
    generator = np.random.default_rng([settings.seed, KINDS.index(kind)])
    sets = sets_of(kind, settings.only)
    return chain.from_iterable([sets[number] for number in generator.permutation(len(sets))] for _ in count())


def sets_of(kind: str, only: Sequence[str]) -> list[tuple[str, ...]]:
    """Return all sets of effects that plants of a kind can have; a pair has one of `only`, where it is given."""
    if kind == "none":
        return [()]
    if kind == "pair":
        return [pair for pair in combinations(EFFECTS, 2) if not only or set(pair) & set(only)]
    return [(key,) for key in only or EFFECTS]
