"""The library of effects: found by key, read from the command line."""

from __future__ import annotations

from valvemodel.declarations import Effect
from valvemodel.errors import InputError, unknown_name
from valvemodel.stages import EFFECTS

_BY_KEY = {effect.key: effect for effect in EFFECTS}


def effect_of_key(key: str) -> Effect:
    """Return the effect of a key.

    Raises
    ------
    InputError
        If there is none; names the nearest.
    """
    if key not in _BY_KEY:
        raise unknown_name("an effect", key, _BY_KEY)
    return _BY_KEY[key]


def parse_effect(text: str) -> tuple[str, dict[str, float]]:
    """Read `KEY` or `KEY:name=value,name=value` as the command line has it, values in SI units or with a unit.

    Returns
    -------
    (str, dict)
        The key and the values that were named. [SI]
    """
    from valvemodel.quantities import parse_quantity

    key, _, rest = text.partition(":")
    effect = effect_of_key(key.strip())
    values = {}
    for part in filter(None, (piece.strip() for piece in rest.split(","))):
        name, separator, number = part.partition("=")
        if not separator:
            raise InputError(
                "an effect is written KEY:name=value,name=value", f"got {part!r} in {text!r}", "add the value"
            )
        parameter = effect.parameter(name.strip())
        try:
            values[parameter.name] = float(number)
        except ValueError:
            values[parameter.name] = parse_quantity(number.strip(), unit=parameter.unit)
    return effect.key, values
