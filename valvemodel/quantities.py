"""The edge where units exist: text and files carry them, everything inside is SI."""

from __future__ import annotations

import difflib
import math
import re
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np

from valvemodel.errors import InputError

_USUAL = {
    "s": ("s", "ms", "min", "h", "d"),
    "A": ("mA", "A"),
    "Pa": ("kPa", "Pa", "bar", "mbar", "MPa", "hPa", "psi"),
    "m": ("mm", "m", "cm", "um", "in"),
    "N": ("N", "kN", "lbf", "kgf"),
}
"""The units that people write for each SI unit, for suggestions."""

_GAUGE = {
    "barg": "bar",
    "bar g": "bar",
    "kpag": "kPa",
    "psig": "psi",
    "mbarg": "mbar",
    "mpag": "MPa",
    "pag": "Pa",
}
"""Gauge pressures as instruments name them; pressures are gauge here anyway."""

_ABSOLUTE = {
    "bara",
    "kpaa",
    "psia",
    "mbara",
    "mpaa",
    "paa",
    "kpa abs",
    "bar abs",
    "kpa(a)",
    "bar(a)",
    "psi(a)",
}

_SHOWN = {
    "m": (("mm", 1e3), ("um", 1e6)),
    "Pa": (("kPa", 1e-3), ("Pa", 1.0)),
    "A": (("mA", 1e3), ("uA", 1e6)),
    "m/A^0.5": (("um/A^0.5", 1e6),) * 2,
}
"""How an SI unit is shown and what to multiply by: usually, and below a hundredth of that."""

_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*", re.DOTALL)
_NAME = r"[A-Za-zµμΩ°][A-Za-zµμΩ°_]*[0-9]?[A-Za-z]*"
_FACTOR = rf"\(*(?:{_NAME}|1(?=\s*/))(?:\^\(?-?\d{{1,2}}(?:\.\d{{1,3}})?\)?|[²³])?\)*"
_UNIT = re.compile(rf"{_FACTOR}(?:\s*[*/·⋅ ]\s*{_FACTOR})*")
"""A product of names with short exponents: what pint would calculate in vain never reaches it."""


def scale_of(unit: str, dimension: str) -> tuple[float, float]:
    """Return multiplier and divisor that bring a value in a unit to the SI unit `dimension`.

    One of the two is 1 and, for the usual units, the other a whole number, so that nothing is lost.

    Raises
    ------
    InputError
        If the unit is unknown, measures something else, or is of an absolute pressure.
    """
    return _scale_of(unit.strip(), dimension)


@cache
def _scale_of(unit: str, dimension: str) -> tuple[float, float]:
    if unit.lower() in _ABSOLUTE:
        raise InputError(
            "pressures are gauge pressures",
            f"[{unit}] is an absolute pressure",
            "subtract the atmospheric pressure and name the unit without the a",
        )
    pint_unit = _parsed(_GAUGE.get(unit.lower(), unit), dimension)
    registry = _registry()
    target = registry.Unit(_tidy(dimension) or "dimensionless")
    if pint_unit.dimensionality != target.dimensionality:
        raise InputError(
            f"a unit of this quantity converts to {dimension or '1'}",
            f"[{unit}] is a unit of something else",
            _suggestion(unit, dimension),
        )
    factor = float(registry.Quantity(1.0, pint_unit).to(target).magnitude)
    if not math.isclose(float(registry.Quantity(2.0, pint_unit).to(target).magnitude), 2 * factor):
        raise InputError("a unit starts at zero", f"[{unit}] has an offset", _suggestion(unit, dimension))
    if 0 < factor < 1 and math.isclose(1 / factor, round(1 / factor), rel_tol=1e-14):
        return 1.0, float(round(1 / factor))
    if factor > 1 and math.isclose(factor, round(factor), rel_tol=1e-14):
        return float(round(factor)), 1.0
    return factor, 1.0


def to_si(values: Any, unit: str, dimension: str) -> Any:
    """Convert a number or an array from a unit to the SI unit that `dimension` names.

    Parameters
    ----------
    values : float or array, any shape
        Numbers in `unit`.
    unit : str
        The unit that they are in, for example "mA".
    dimension : str
        The SI unit that is wanted, for example "A".

    Raises
    ------
    InputError
        If the unit is unknown or measures something else.

    Examples
    --------
    >>> to_si(12.5, "mA", "A")
    0.0125
    """
    multiplier, divisor = scale_of(unit, dimension)
    values = np.asarray(values, dtype=float) if not isinstance(values, int | float) else float(values)
    return values * multiplier / divisor


def is_unit_of(unit: str, dimension: str) -> bool:
    """Return whether a text is a unit that converts to the SI unit `dimension`."""
    try:
        scale_of(unit, dimension)
    except InputError:
        return False
    return True


def parse_quantity(text: str, unit: str) -> float:
    """Read a number with its unit, as on the command line, and return it in the SI unit `unit`.

    A number alone is taken only where the quantity has no unit; elsewhere units are read, not guessed.

    Raises
    ------
    InputError
        If there is no number, no unit, or a unit of something else.

    Examples
    --------
    >>> parse_quantity("28.15 mm", unit="m")
    0.02815
    >>> parse_quantity("1.4", unit="1")
    1.4
    """
    match = _NUMBER.fullmatch(text)
    example = _example(unit)
    if not match:
        raise InputError("a quantity is a number and its unit", f"got {text!r}", f'write it like "{example}"')
    number, given = float(match[1]), match[2]
    if given.startswith(","):
        raise InputError("the decimal sign is a point", f"got {text!r}", f'write it like "{example}"')
    if not math.isfinite(number):
        raise InputError("a quantity is finite", f"got {text!r}", f'write it like "{example}"')
    is_plain = unit in ("", "1")
    if not given and not is_plain:
        raise InputError(
            "a quantity has a unit (units are read, not guessed)",
            f"got {text!r} without one",
            f'write it like "{match[1]} {_usual(unit)[0]}"',
        )
    multiplier, divisor = scale_of(given or "1", "" if is_plain else unit)
    if number == 0:
        return 0.0
    return float(Fraction(match[1]) * Fraction(multiplier) / Fraction(divisor))


def format_quantity(value: float | None, unit: str, digits: int = 4) -> str:
    """Return an SI value as an engineer writes it: mm, kPa, mA, with a few significant digits.

    Examples
    --------
    >>> format_quantity(0.02815, "m")
    '28.15 mm'
    >>> format_quantity(52500.0, "N/m")
    '52500 N/m'
    """
    if value is None or math.isnan(value):
        return "not determined"
    if math.isinf(value):
        return "none"
    usual, small = _SHOWN.get(unit, ((unit, 1.0), (unit, 1.0)))
    shown, factor = small if 0 < abs(value * usual[1]) < 1e-2 else usual
    number = value * factor
    if number and not 1e-3 <= abs(number) < 1e6:
        text = f"{number:.{digits - 1}e}"
        mantissa, _, exponent = text.partition("e")
        mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
        text = f"{mantissa}e{int(exponent)}"
    else:
        decimals = max(0, digits - 1 - math.floor(math.log10(abs(number)))) if number else 0
        text = f"{number:.{decimals}f}"
        text = text.rstrip("0").rstrip(".") if "." in text else text
    return text if shown in ("", "1") else f"{text} {shown}"


def _parsed(unit: str, dimension: str) -> Any:
    text = _tidy(unit)
    remedy = _suggestion(unit, dimension)
    unknown = InputError("a unit is one of the known ones", f"[{unit}] is not a unit", remedy)
    registry = _registry()
    if text in ("1", ""):
        return registry.Unit("dimensionless")
    if len(text) > 40 or not (_UNIT.fullmatch(text) or text == "%"):
        raise unknown
    try:
        return registry.Unit(text)
    except Exception:
        # pint raises its own errors, and those of Python's tokenizer and parser, for odd texts
        raise unknown from None


def _tidy(unit: str) -> str:
    text = unit.strip().replace("**", "^")
    text = re.sub(r"sqrt\((\w+)\)", r"\1^0.5", text)
    return "" if text == "1" else text


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()


def _usual(dimension: str) -> tuple[str, ...]:
    return _USUAL.get(dimension, (dimension,) if dimension else ("no unit",))


def _example(dimension: str) -> str:
    return "1.5" if dimension in ("", "1") else f"1.5 {_usual(dimension)[0]}"


def _suggestion(unit: str, dimension: str) -> str:
    usual = _usual(dimension)
    lowered = {name.lower(): name for name in reversed(usual)}
    if unit.lower() in lowered:
        return f"did you mean {lowered[unit.lower()]}? upper and lower case differ in units"
    nearest = difflib.get_close_matches(unit.lower(), list(lowered), n=1, cutoff=0.7)
    if nearest:
        return f"did you mean {lowered[nearest[0]]}?"
    return f"use {', '.join(usual[:-1]) + ' or ' if len(usual) > 1 else ''}{usual[-1]}"
