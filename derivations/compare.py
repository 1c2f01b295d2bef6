"""Compares a printed expression with the derived one and says in what way it is wrong."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass

import sympy as sp

from derivations.dimensions import fault
from derivations.glossary import LETTERS, label, symbol

_DIGITS = 30
_CLOSE = sp.Float("1e-20")
_LONG = 25  # operations; trying every letter in every place of more takes minutes


@dataclass(frozen=True)
class Comparison:
    """How a printed form stands to the derived one, and the sentence that says so."""

    verdict: str
    sentence: str


def is_equal(first: sp.Expr, second: sp.Expr) -> bool:
    """Say whether two expressions are the same: refuted by numbers, proved by algebra."""
    return not _differs_in_numbers(first, second) and _is_proved(first, second)


def classify(
    printed: sp.Expr, derived: sp.Expr, *, left: sp.Expr | None = None, inherited: sp.Expr | None = None
) -> Comparison:
    """Compare: `inherited` is what follows if the paper's earlier, wrong equations are used."""
    if is_equal(printed, derived):
        return Comparison("holds", "printed less derived is 0")
    wrong_dimension = fault(left, printed) if left is not None else ""
    if wrong_dimension:
        swap = swapped_letter(printed, derived)
        repair = f"; with {swap} it is the derived form" if swap else ""
        return Comparison("misprint", f"{wrong_dimension}{repair}")
    if inherited is not None and is_equal(printed, inherited):
        return Comparison(
            "inherits an error", "with the paper's earlier equations as printed, the printed form follows"
        )
    flipped = flipped_term(printed, derived)
    if flipped is not None:
        return Comparison("sign error", f"with the sign of {label(flipped)} turned, printed less derived is 0")
    swap = swapped_letter(printed, derived)
    if swap:
        return Comparison("misprint", f"with {swap} it is the derived form")
    return Comparison("wrong premise", f"printed less derived is {label(printed - derived)}")


def flipped_term(printed: sp.Expr, derived: sp.Expr) -> sp.Expr | None:
    """Return the one term, or the whole, whose sign, turned, makes the printed form the derived one."""
    if is_equal(-printed, derived):
        return printed
    for term in sp.Add.make_args(printed):
        if is_equal(printed - 2 * term, derived):
            return term
    return None


def swapped_letter(printed: sp.Expr, derived: sp.Expr) -> str:
    """Return 'new for old' where one letter, exchanged in one place, repairs the printed form."""
    if sp.count_ops(printed) > _LONG:
        return ""
    offered = [symbol(letter) for letter in LETTERS if symbol(letter) in derived.free_symbols]
    for old, build in _places(printed):
        for new in offered:
            if new != old and is_equal(build(new), derived):
                return f"{label(new)} for {label(old)}"
    return ""


def _places(expression: sp.Expr) -> Iterator:
    """Each letter in each place, with a function that puts another letter there."""
    if isinstance(expression, sp.Symbol):
        yield expression, lambda new: new
        return
    for index, argument in enumerate(expression.args):
        for old, build in _places(argument):

            def rebuilt(new: sp.Symbol, index: int = index, build=build) -> sp.Expr:
                arguments = list(expression.args)
                arguments[index] = build(new)
                return expression.func(*arguments)

            yield old, rebuilt


def _differs_in_numbers(first: sp.Expr, second: sp.Expr) -> bool:
    """Look at one point, the same in every run; letters positive, so that roots are real."""
    letters = sorted(first.free_symbols | second.free_symbols, key=lambda letter: letter.name)
    draw = random.Random(31)
    point = {letter: sp.Rational(draw.randint(1000, 3000), 1009) for letter in letters}
    one, other = (sp.N(side.subs(point), _DIGITS) for side in (first, second))
    size = sp.Max(sp.Abs(one), sp.Abs(other))
    if not size.is_finite:
        return True
    return bool(size != 0 and sp.Abs(one - other) / size > _CLOSE)


def _is_proved(first: sp.Expr, second: sp.Expr) -> bool:
    if first == second:
        return True
    if not _open_powers(first - second):
        return sp.simplify(first - second) == 0
    return _is_equal_by_logarithms(first, second) or _is_equal_by_names(first, second)


def _open_powers(expression: sp.Expr) -> list[sp.Pow]:
    """The powers with a letter in the exponent, on which simplifying can take for ever."""
    return [power for power in expression.atoms(sp.Pow) if power.exp.free_symbols]


def _is_equal_by_logarithms(first: sp.Expr, second: sp.Expr) -> bool:
    """Two terms that differ in sign cancel if every logarithm in their ratio has no weight."""
    terms = sp.Add.make_args(sp.Add(first, -second))
    if len(terms) != 2:
        return False
    gone, came = sorted(terms, key=lambda term: not term.could_extract_minus_sign())
    ratio = sp.expand(sp.expand_log(sp.log(came) - sp.log(-gone), force=True))
    ratio = sp.expand(sp.expand_log(ratio, force=True))
    weights = sp.collect(ratio, list(ratio.atoms(sp.log)), evaluate=False)
    return all(sp.simplify(weight) == 0 for weight in weights.values())


def _is_equal_by_names(first: sp.Expr, second: sp.Expr) -> bool:
    """Give each such power a name, and compare what is rational in the names."""
    sides = [sp.powdenest(sp.expand_power_base(side, force=True), force=True) for side in (first, second)]
    powers = sorted({power for side in sides for power in _open_powers(side)}, key=sp.count_ops, reverse=True)
    for power in powers:
        name = sp.Dummy(positive=True)
        sides = [side.xreplace({power: name}) for side in sides]
    return sp.simplify(sides[0] - sides[1]) == 0
