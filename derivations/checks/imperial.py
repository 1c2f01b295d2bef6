"""Searches the units of the United States for the round number behind a rounded SI value."""

from __future__ import annotations

from dataclasses import dataclass

from derivations.paper import Entry

POUND, INCH, GRAVITY = 0.45359237, 0.0254, 9.80665  # kg, m, m/s^2, by definition
POUND_FORCE = POUND * GRAVITY

_UNITS = {
    "kg": {"lb": POUND},
    "kg/s^2": {"lbf/in": POUND_FORCE / INCH, "lbf/ft": POUND_FORCE / (12 * INCH)},
    "m^2": {"in^2": INCH**2},
    "N": {"lbf": POUND_FORCE},
    "Pa": {"psi": POUND_FORCE / INCH**2},
    "kg/s": {"lbf s/in": POUND_FORCE / INCH, "lbf s/ft": POUND_FORCE / (12 * INCH)},
}
# What one gets by reading lb as a mass where a force is meant, and forgetting the inch.
_SLIPS = {"kg/s": ("lbf s/in", POUND)}
_STEPS = {"N": 10.0, "kg/s^2": 10.0, "m^2": 10.0, "Pa": 5.0}  # what counts as round; else halves
_HALVES = 0.5


@dataclass(frozen=True)
class Guess:
    """A round amount whose SI value rounds to the printed digits; `chance` is that of an accident."""

    letter: str
    digits: str
    amount: float
    unit: str
    exact: float
    chance: float
    right_factor: float


def imperial(entry: Entry) -> Guess | None:
    """Return the round imperial value of an entry in a unit of its own kind, if there is one."""
    for name, factor in _UNITS.get(entry.unit, {}).items():
        guess = _round(entry, name, factor, factor)
        if guess:
            return guess
    return None


def odd_one_out(entry: Entry) -> Guess | None:
    """Return the round value that an entry has only by a slip of the unit, if its own units give none."""
    if imperial(entry) or entry.unit not in _SLIPS:
        return None
    name, wrong_factor = _SLIPS[entry.unit]
    return _round(entry, name, wrong_factor, _UNITS[entry.unit][name])


def _round(entry: Entry, name: str, factor: float, right_factor: float) -> Guess | None:
    step = _STEPS.get(entry.unit, _HALVES)
    amount = step * round(entry.value / factor / step)
    chance = min(1.0, 2 * entry.half_step / factor / step)
    # Half a unit of the last digit, and a hair for a value that lies on the edge.
    if amount == 0 or chance == 1 or abs(amount * factor - entry.value) > entry.half_step * (1 + 1e-9):
        return None
    return Guess(entry.letter, entry.digits, amount, name, amount * factor, chance, right_factor)
