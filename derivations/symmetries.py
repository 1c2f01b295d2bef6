"""Which numbers of the chain its signals determine: the scalings of them under which no signal changes."""

from __future__ import annotations

from functools import cache

import sympy as sp
from sympy.polys.matrices import DomainMatrix

from derivations import electromagnet, nozzle, stem
from derivations.glossary import symbol, symbols

RECORDS = {
    "current, position": "a record of current and position",
    "current, pressure, position": "a record of current, pressure and position",
    "force, position": "a record of force and position",
    "current, settled position": "a settled loop of current and position",
    "current, settled pressure, settled position": "a settled loop of current, pressure and position",
}
"""The kinds of records by their signals."""

_REFERENCES = "S_1 P_1 K"
_OTHERS = "k F_c F_s f_v m F_0 c_0 E"
_AFFINE_REFERENCES = "S_1 P_i"
_AFFINE_OTHERS = "k F_c F_s f_v m P_0"
_ROOT = sp.Symbol("root_of_current", positive=True)
_SIGNALS = (_ROOT, *symbols("y v P_b F_p"))

Powers = dict[str, sp.Rational]


def letters(*, is_affine: bool = False) -> list[str]:
    """Return the letters of the valve's numbers, those first that the others are measured by."""
    chosen = (_AFFINE_REFERENCES, _AFFINE_OTHERS) if is_affine else (_REFERENCES, _OTHERS)
    return " ".join(chosen).split()


@cache
def relations(record: str, *, is_affine: bool = False) -> tuple[sp.Expr, ...]:
    """What a record can show, each solved for one signal: the pressure, the accelerations, where slips begin and end.

    Parameters
    ----------
    record : str
        One of RECORDS.
    is_affine : bool
        Whether current gives pressure by a straight line instead of (31), (16); the preload is then 0, since it could
        not be told from the pressure at no current.
    """
    pressure = _pressure(is_affine)
    driving = stem.driving_force().subs(symbol("F_0"), 0) if is_affine else stem.driving_force()
    if "force" in record:
        driving = driving.subs(symbol("S_1") * symbol("P_b"), symbol("F_p"))
    shown = []
    for direction in (1, -1):
        shown += [sp.solve(driving - direction * symbol(limit), symbol("y"))[0] for limit in ("F_s", "F_c")]
        if "settled" not in record:
            slip = stem.slip_acceleration().subs(sp.sign(symbol("v")), direction)
            shown.append(slip.subs(symbol("F_d"), driving))
    if "pressure" in record:
        shown.append(pressure)
    elif "current" in record:
        shown = [each.subs(symbol("P_b"), pressure) for each in shown]
    return tuple(shown)


def _pressure(is_affine: bool) -> sp.Expr:
    """The pressure as a function of the root of the current."""
    if is_affine:
        return symbol("P_0") + symbol("P_i") * _ROOT**2
    gap = electromagnet.coil_gap().subs(symbol("i"), _ROOT**2)
    return nozzle.static_pressure_by_ratio().subs(symbol("delta"), gap)


@cache
def scalings(record: str, *, is_affine: bool = False) -> tuple[Powers, ...]:
    """Return a basis of the scalings that no signal of a record shows, each as powers of one factor by letter.

    A direction in the space of the logarithms of the numbers is such a scaling where the derivative of every relation
    along it vanishes for all values of the signals. The coefficients of the signals' monomials make this a linear
    system over the field of rational functions of the numbers, and its null space is all that is not determined.

    References
    ----------
    Lie symmetries as the test of structural identifiability: Yates, Evans, Chappell, Automatica 45 (2009).
    """
    names = letters(is_affine=is_affine)
    rows = [
        row
        for relation in relations(record, is_affine=is_affine)
        for row in _conditions(relation, symbols(" ".join(names)))
    ]
    null = DomainMatrix.from_Matrix(sp.Matrix(rows)).to_field().nullspace().to_Matrix()
    return tuple(_constant(null.row(number), names) for number in range(null.rows))


def _conditions(relation: sp.Expr, numbers: tuple[sp.Symbol, ...]) -> list[list[sp.Expr]]:
    """One linear condition on the powers for each monomial of the signals."""
    powers = sp.symbols(f"power:{len(numbers)}")
    change = sum(power * number * sp.diff(relation, number) for power, number in zip(powers, numbers, strict=True))
    numerator = sp.Poly(sp.expand(sp.numer(sp.together(change))), *_SIGNALS)
    return [[sp.expand(condition).coeff(power) for power in powers] for condition in numerator.coeffs()]


def _constant(row: sp.Matrix, names: list[str]) -> Powers:
    """The null vector over its first entry: the same for all values of the numbers, else it is no scaling."""
    first = next(entry for entry in row if entry != 0)
    powers = {name: sp.cancel(entry / first) for name, entry in zip(names, row, strict=True) if entry != 0}
    assert all(power.is_Rational for power in powers.values()), f"{powers} is no scaling"
    return powers


@cache
def groups(record: str, *, is_affine: bool = False) -> tuple[Powers, ...]:
    """Return the products of powers that no scaling changes: what a record determines, by letter."""
    names = letters(is_affine=is_affine)
    weights = sp.Matrix([[each.get(name, 0) for name in names] for each in scalings(record, is_affine=is_affine)])
    if not weights:
        return tuple({name: sp.Integer(1)} for name in names)
    basis = [dict(zip(names, vector, strict=True)) for vector in weights.nullspace()]
    return tuple({name: power for name, power in vector.items() if power != 0} for vector in basis)
