"""The library of effects: found by key, read from the command line."""

from __future__ import annotations

from collections.abc import Collection

from valvemodel.declarations import Effect
from valvemodel.errors import InputError, unknown_name
from valvemodel.stages import EFFECTS

_BY_KEY = {effect.key: effect for effect in EFFECTS}

HIGHER = frozenset(each.name for effect in EFFECTS for each in effect.parameters if each.is_higher)
"""Parameters that are a further one of a series of like numbers."""


def effect_of_key(key: str) -> Effect:
    """Return the effect of a key.

    Raises
    ------
    InputError
        If there is none; names the nearest, or where they are listed.
    """
    if key not in _BY_KEY:
        error = unknown_name("an effect", key, _BY_KEY)
        has_near = error.remedy.startswith("did you mean")
        raise InputError(
            error.rule, error.arrived, error.remedy if has_near else "choose one that `valvemodel effects` lists"
        )
    return _BY_KEY[key]


def are_aliases(key: str, other: str) -> bool:
    """Return whether one of two effects states the other, which may be `none`, as its alias."""
    pairs = ((key, other), (other, key))
    return any(one != "none" and its in effect_of_key(one).aliases for one, its in pairs)


def differ_by_aliases(effects: tuple[str, ...], others: tuple[str, ...]) -> bool:
    """Return whether two causes differ by one effect for which the other, or none, is declared to come close."""
    mine, theirs = set(effects) - set(others) or {"none"}, set(others) - set(effects) or {"none"}
    if len(mine) != 1 or len(theirs) != 1:
        return False
    return are_aliases(mine.pop(), theirs.pop())


def jumps(keys: Collection[str]) -> bool:
    """Return whether one of some effects makes the stem stop and jump."""
    return any(effect_of_key(key).breakaway for key in keys)


def is_jagged(keys: Collection[str]) -> bool:
    """Return whether the error of a fit with one of some effects has many minima."""
    return any(effect_of_key(key).is_jagged for key in keys)


def takes_long(keys: Collection[str]) -> bool:
    """Return whether a run with one of some effects takes long."""
    return any(effect_of_key(key).takes_long for key in keys)


def jumps_in_closed_form(keys: Collection[str]) -> bool:
    """Return whether one of some effects makes the stem stop and jump, and a run takes no longer for any of them."""
    return jumps(keys) and not any(effect_of_key(key).is_chaotic for key in keys)


def parse_effect(text: str) -> tuple[str, dict[str, float]]:
    """Read `KEY` or `KEY:name=value,name=value` as the command line has it, values in SI units or with a unit.

    Returns
    -------
    (str, dict)
        The key and the values that were named. [SI]

    Raises
    ------
    InputError
        If it is not written so, or a parameter comes twice.
    """
    from valvemodel.quantities import parse_quantity

    key, colon, rest = text.partition(":")
    effect = effect_of_key(key.strip())
    values: dict[str, float] = {}
    parts = [piece.strip() for piece in rest.split(",") if piece.strip()]
    if colon and not parts:
        raise InputError(
            "an effect is written KEY or KEY:name=value,name=value",
            f"got nothing behind the colon of {text!r}",
            "add a value, or leave the colon out for typical values",
        )
    for part in parts:
        name, separator, number = part.partition("=")
        if not separator:
            raise InputError(
                "an effect is written KEY:name=value,name=value", f"got {part!r} in {text!r}", "add the value"
            )
        parameter = effect.parameter(name.strip())
        if parameter.name in values:
            raise InputError(
                "a parameter of an effect is given once",
                f"{parameter.name} came twice in {text!r}",
                "keep one of its values",
            )
        try:
            values[parameter.name] = float(number)
        except ValueError:
            values[parameter.name] = parse_quantity(number.strip(), unit=parameter.unit)
    return effect.key, values
