"""Causes as every diagnosis tells them, and the gap that shrinks with them step by step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from diagnosis.score import Errors
from valvemodel.effects import effect_of_key


@dataclass(frozen=True)
class Cause:
    """One cause with its probability, its parameters, and how far the gap shrinks with it; no effects is `none`.

    `rivals` are the causes that the records cannot tell from it, `hiding` the effects of which they would show nothing
    beside it.
    """

    effects: tuple[str, ...]
    probability: float
    errors: Errors
    parameters: dict[str, dict[str, dict[str, Any]]]
    closed: float | None
    closed_interval: tuple[float, float] | None
    rivals: list[tuple[str, ...]]
    hiding: list[str] = field(default_factory=list)

    def as_json(self) -> dict[str, Any]:
        """Return the cause as diagnosis.json has it."""
        return {
            "effects": list(self.effects),
            "probability": self.probability,
            "parameters": self.parameters,
            "gap_after": self.errors.rms,
            "gap_closed": self.closed,
            "gap_closed_interval": None if self.closed_interval is None else list(self.closed_interval),
            "indistinguishable_from": [list(rival) for rival in self.rivals],
            "may_hide_beside": self.hiding,
        }


def steps_of(
    given: float, left: Sequence[tuple[tuple[str, ...], float]], shown: tuple[str, ...], floor: float
) -> list[tuple[str, float]]:
    """Return the gap step by step: as given, base refitted, each effect added, noise floor.

    Parameters
    ----------
    given : float
        The gap of the model as given.
    left : sequence of (effects, gap)
        What each cause leaves, that of no effects among them.
    shown : tuple of str
        Effects of the cause that is shown, in the order of adding.
    floor : float
    """
    steps = [("as given", given), ("base refitted", next(rms for effects, rms in left if not effects))]
    for count in range(1, len(shown) + 1):
        part = shown[:count]
        title = f"+ {effect_of_key(part[-1]).title}"
        steps += [(title, rms) for effects, rms in left if set(effects) == set(part)]
    return [*steps, ("noise floor", floor)]
