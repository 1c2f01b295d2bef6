"""Numbers as an engineer reads them: millimetres and kilopascals, rounded to what is known."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TypeGuard

_SHOWN: dict[str, tuple[tuple[str, float], ...]] = {
    "m": (("mm", 1e3), ("µm", 1e6), ("nm", 1e9)),
    "m/s": (("mm/s", 1e3), ("µm/s", 1e6), ("nm/s", 1e9)),
    "A": (("mA", 1e3), ("µA", 1e6)),
    "Pa": (("kPa", 1e-3), ("Pa", 1.0)),
    "s": (("s", 1.0), ("ms", 1e3)),
    "m/N": (("µm/N", 1e6),),
    "m^2": (("cm²", 1e4),),
    "s/Pa": (("s/kPa", 1e3),),
    "m/A^0.5": (("µm/√A", 1e6),),
    "1/m^2": (("1/m²", 1.0),),
    "N*s/m": (("N·s/m", 1.0),),
    "1": (("", 1.0),),
}
"""Names and factors for each SI unit, the usual one first, finer ones where it would be a small fraction."""

_SMALLEST_SHOWN = 0.02
"""In the usual unit; below it the finer unit is easier to read: 15 µm rather than 0.015 mm."""

NOT_DETERMINED = "not determined"


def is_number(value: object) -> TypeGuard[float]:
    """Return whether a value is a finite number."""
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def shown_unit(unit: str, values: Iterable[float | None]) -> tuple[str, float]:
    """Return the name and the factor of the one unit in which all these SI values read well."""
    largest = max((abs(value) for value in values if value is not None and is_number(value)), default=0.0)
    choices = _SHOWN.get(unit, ((unit, 1.0),))
    for name, factor in choices:
        if largest == 0.0 or largest * factor >= _SMALLEST_SHOWN:
            return name, factor
    return choices[-1] if largest else choices[0]


def rounded(value: float, digits: int = 3) -> str:
    """Write a number with significant digits, without an exponent where it is short enough.

    Examples
    --------
    >>> rounded(0.15), rounded(1423.4), rounded(2.4e-9)
    ('0.150', '1423', '2.4e-9')
    """
    if value == 0:
        return "0"
    size = math.floor(math.log10(abs(value)))
    if not -4 <= size < 7:
        mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
        mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
        return f"{mantissa}e{int(exponent)}"
    return f"{value:.{max(0, digits - 1 - size)}f}"


def amount(value: float | None, unit: str, like: Iterable[float | None] = ()) -> str:
    """Write an SI value with its unit; `like` are values beside it that share the unit.

    Examples
    --------
    >>> amount(0.00194, "m"), amount(52.5e3, "Pa"), amount(1.25, "1")
    ('1.94 mm', '52.5 kPa', '1.25')
    """
    if value is None or not is_number(value):
        return NOT_DETERMINED
    name, factor = shown_unit(unit, [value, *like])
    return f"{rounded(value * factor)} {name}".rstrip()


def amount_with_std(value: float | None, std: float | None, unit: str) -> str:
    """Write an SI value and its standard deviation, both rounded to what the deviation leaves known.

    Examples
    --------
    >>> amount_with_std(4.003e-3, 0.021e-3, "m")
    '4.003 ± 0.021 mm'
    """
    if value is None or not is_number(value):
        return NOT_DETERMINED
    if std is None or not is_number(std) or std < 0:
        return f"{amount(value, unit)} (uncertainty {NOT_DETERMINED})"
    name, factor = shown_unit(unit, [value])
    value, std = value * factor, std * factor
    if std == 0:
        return f"{rounded(value, 4)} ± 0 {name}".rstrip()
    decimals = 1 - math.floor(math.log10(std))
    if decimals > 6 or decimals < -6:
        return f"{rounded(value, 4)} ± {rounded(std, 2)} {name}".rstrip()
    places = max(0, decimals)
    return f"{value:.{places}f} ± {std:.{places}f} {name}".rstrip()


def percent(share: float | None) -> str:
    """Write a probability or a share as a percentage that never pretends to certainty.

    Examples
    --------
    >>> percent(0.9731), percent(0.9992), percent(0.001), percent(1.2)
    ('97 %', 'over 99 %', 'under 1 %', '100 %')
    """
    if share is None or not is_number(share):
        return NOT_DETERMINED
    if share >= 1:
        return "100 %"
    if share > 0.99:
        return "over 99 %"
    if 0 < share < 0.01:
        return "under 1 %"
    return f"{round(100 * share) + 0} %"


def closed_text(share: float | None) -> str:
    """Write the share of a gap that is closed; a gap that grows is not closed at all.

    Examples
    --------
    >>> closed_text(0.62), closed_text(-0.34)
    ('62 %', 'nothing')
    """
    return "nothing" if share is not None and is_number(share) and share <= 0 else percent(share)


def probability_text(probability: float | None) -> str:
    """Write a probability, which is never 0 or 1.

    Examples
    --------
    >>> probability_text(0.0), probability_text(0.974), probability_text(1.0)
    ('under 1 %', '97 %', 'over 99 %')
    """
    if probability is None or not is_number(probability):
        return NOT_DETERMINED
    return percent(min(max(probability, 1e-9), 1 - 1e-9))


def percent_interval(interval: object) -> str:
    """Write an interval of a share, or nothing where there is none.

    Examples
    --------
    >>> percent_interval([0.982, 1.003])
    '98 to 100 %'
    >>> percent_interval([0.998, 1.0])
    'over 99 %'
    """
    if not isinstance(interval, list | tuple) or len(interval) != 2:
        return ""
    low, high = interval
    if low is None or high is None or not (is_number(low) and is_number(high)):
        return ""
    low, high = (min(1.0, max(-9.99, end)) for end in (low, high))
    if low >= 0.995:
        return percent(low)
    return f"{round(100 * low) + 0} to {round(100 * high) + 0} %"
