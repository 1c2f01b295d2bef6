"""The dimension of an expression, from the units in the glossary."""

from __future__ import annotations

from functools import cache

import sympy as sp

from derivations.glossary import LETTERS, symbol

_KILOGRAM, _METRE, _SECOND, _AMPERE = sp.symbols("kg m s A", positive=True)
_NEWTON = _KILOGRAM * _METRE / _SECOND**2
_VOLT = _NEWTON * _METRE / (_AMPERE * _SECOND)
_UNITS = {
    "kg": _KILOGRAM,
    "m": _METRE,
    "s": _SECOND,
    "A": _AMPERE,
    "N": _NEWTON,
    "Pa": _NEWTON / _METRE**2,
    "V": _VOLT,
    "ohm": _VOLT / _AMPERE,
    "Wb": _VOLT * _SECOND,
    "T": _VOLT * _SECOND / _METRE**2,
    "H": _VOLT * _SECOND / _AMPERE,
}


class DimensionError(ValueError):
    """Raised where a sum adds unlike quantities, or a letter is not in the glossary."""


@cache
def unit(text: str) -> sp.Expr:
    """Return the unit that a string names, in kg, m, s, A."""
    names = {**_UNITS, "nu": symbol("nu")}
    return sp.sympify(text.replace("^", "**"), locals=names)


def is_alike(first: sp.Expr, second: sp.Expr) -> bool:
    """Say whether two dimensions are the same."""
    logarithm = sp.expand_log(sp.log(first / second), force=True)
    return sp.simplify(logarithm) == 0


def dimension(expression: sp.Basic) -> sp.Expr:
    """Return the dimension of an expression in kg, m, s, A.

    Raises
    ------
    DimensionError
        If a sum or a comparison joins unlike quantities, or a letter is unknown; names them.
    """
    if isinstance(expression, sp.Symbol):
        if expression.name not in LETTERS:
            raise DimensionError(f"the letter {expression.name} stands nowhere else in the paper")
        return unit(LETTERS[expression.name].unit)
    if isinstance(expression, sp.Add | sp.core.relational.Relational):
        return _common(expression)
    if isinstance(expression, sp.Piecewise):
        for _, condition in expression.args:
            for relation in condition.atoms(sp.core.relational.Relational):
                _common(relation)
        return _common(sp.Tuple(*(value for value, _ in expression.args)))
    if isinstance(expression, sp.Mul):
        return sp.Mul(*map(dimension, expression.args))
    if isinstance(expression, sp.Pow):
        return dimension(expression.base) ** expression.exp
    if isinstance(expression, sp.Derivative):
        return dimension(expression.expr) / sp.Mul(*map(dimension, expression.variables))
    if isinstance(expression, sp.Abs):
        return dimension(expression.args[0])
    if isinstance(expression, sp.core.function.AppliedUndef):
        return unit(LETTERS[type(expression).__name__].unit)
    return sp.Integer(1)


def _common(expression: sp.Basic) -> sp.Expr:
    parts = [part for part in expression.args if part != 0]
    dimensions = [dimension(part) for part in parts]
    for part, one in zip(parts, dimensions, strict=True):
        if not is_alike(one, dimensions[0]):
            raise DimensionError(f"{sp.sstr(parts[0])} [{dimensions[0]}] stands beside {sp.sstr(part)} [{one}]")
    return dimensions[0]


def fault(left: sp.Basic, right: sp.Basic) -> str:
    """Say why two sides of an equation cannot be equal by dimension; empty where they can."""
    try:
        one, other = dimension(left), dimension(right)
    except DimensionError as error:
        return str(error)
    return "" if is_alike(one, other) else f"the left side is in [{one}], the right side in [{other}]"
