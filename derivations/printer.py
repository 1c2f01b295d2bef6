"""Prints a sympy expression as a line of Python: full names, positive terms first, one fraction bar."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp

from derivations.glossary import LETTERS

_SUM, _PRODUCT, _POWER, _ATOM = range(4)
_CONSTANTS = {"mu_0": "MAGNETIC_CONSTANT", "epsilon": "VELOCITY_BAND"}
_HALF = sp.Rational(1, 2)


@dataclass(frozen=True)
class Printer:
    """Prints for one dialect: `spelling` maps sympy's function names, `pi` is that number's name."""

    spelling: Mapping[str, str]
    pi: str

    def line(self, expression: sp.Expr) -> str:
        """Return the expression as one line."""
        return self._print(expression)[0]

    def _inside(self, expression: sp.Basic, at_least: int) -> str:
        text, strength = self._print(expression)
        return text if strength >= at_least else f"({text})"

    def _print(self, expression: sp.Basic) -> tuple[str, int]:
        if isinstance(expression, sp.Symbol):
            return self._name(expression), _ATOM
        if expression is sp.pi:
            return self.pi, _ATOM
        if isinstance(expression, sp.Add):
            return self._sum(expression), _SUM
        if isinstance(expression, sp.Piecewise):
            return self._switched(expression), _PRODUCT
        if isinstance(expression, sp.Integer) and expression >= 0:
            return str(expression), _ATOM
        if isinstance(expression, sp.Pow) and expression.exp.is_number and abs(expression.exp) == _HALF:
            return self._product(expression)
        if isinstance(expression, sp.Pow) and not expression.exp.could_extract_minus_sign():
            return self._power(expression), _POWER
        if isinstance(expression, sp.Mul | sp.Pow | sp.Rational):
            return self._product(expression)
        (argument,) = expression.args
        return f"{self.spelling[type(expression).__name__]}({self.line(argument)})", _ATOM

    @staticmethod
    def _name(expression: sp.Symbol) -> str:
        letter = LETTERS.get(expression.name)
        return _CONSTANTS.get(expression.name) or (letter.name if letter else expression.name)

    def _sum(self, expression: sp.Add) -> str:
        terms = [self._inside(term, _PRODUCT) for term in expression.as_ordered_terms()]
        terms.sort(key=lambda text: text.startswith("-"))
        return terms[0] + "".join(f" - {term[1:]}" if term[0] == "-" else f" + {term}" for term in terms[1:])

    def _power(self, expression: sp.Pow) -> str:
        base, exponent = self._inside(expression.base, _ATOM), self._inside(expression.exp, _ATOM)
        # The formatter hugs ** between plain names and numbers only.
        is_plain = "(" not in base + exponent
        return f"{base}**{exponent}" if is_plain else f"{base} ** {exponent}"

    def _product(self, expression: sp.Expr) -> tuple[str, int]:
        number, factors = expression.as_coeff_mul()
        sign, number = ("-", -number) if number < 0 else ("", number)
        parts = [sp.Integer(number.p), sp.Integer(number.q), *factors]
        powers = [_base_and_power(factor) for factor in parts[2:]]
        root = sp.Mul(*(base ** (2 * power) for base, power in powers if abs(power) == _HALF), evaluate=True)
        above = [factor for factor, (_, power) in zip(factors, powers, strict=True) if not _is_below(power)]
        below = [base**-power for base, power in powers if _is_below(power) and abs(power) != _HALF]
        above = [factor for factor in above if abs(_base_and_power(factor)[1]) != _HALF]
        top = [self._inside(factor, _POWER) for factor in above]
        bottom = [self._inside(factor, _POWER) for factor in below]
        if root != 1 and sp.numer(root) == 1:
            bottom.append(f"{self.spelling['sqrt']}({self.line(1 / root)})")
        elif root != 1:
            top.append(f"{self.spelling['sqrt']}({self.line(root)})")
        top = ([str(number.p)] if number.p != 1 or not top else []) + top
        bottom = ([str(number.q)] if number.q != 1 else []) + bottom
        if sign and above and top[0] == self._print(above[0])[0] and self._print(above[0])[1] == _POWER:
            # The formatter puts a power in brackets behind a minus.
            top[0] = f"({top[0]})"
        text = sign + " * ".join(top)
        if bottom:
            text += " / " + (bottom[0] if len(bottom) == 1 else f"({' * '.join(bottom)})")
        is_atom = not sign and len(top) == 1 and not bottom
        return text, _ATOM if is_atom else _PRODUCT

    def _switched(self, expression: sp.Piecewise) -> str:
        # An indicator times a value needs no `where`, which numba refuses on scalars and CasADi lacks.
        (zero, band), (value, rest) = expression.args
        assert (zero, rest) == (0, sp.true)
        assert isinstance(band, sp.StrictLessThan | sp.StrictGreaterThan)
        limit = f"{self.line(band.lts)} >= {self.line(band.gts)}"
        return f"({limit}) * {self._inside(value, _PRODUCT)}"


def _base_and_power(factor: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """A power taken apart; the exponential is a function here, not a power of e."""
    return (factor, sp.S.One) if isinstance(factor, sp.exp) else factor.as_base_exp()


def _is_below(power: sp.Expr) -> bool:
    return bool(power.could_extract_minus_sign()) and abs(power) != _HALF
