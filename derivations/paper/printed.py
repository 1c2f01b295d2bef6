"""The forms in which the paper's contents are held: frozen, so that a change is a new paper."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import Any

import sympy as sp

from derivations.glossary import MAGNETIC_CONSTANT, label, symbol, typeset


@dataclass(frozen=True)
class Printed:
    """One printed equation, both sides in the glossary's letters."""

    equation: str
    left: sp.Expr
    right: sp.Basic

    @property
    def text(self) -> str:
        """The equation on one line."""
        return f"{label(self.left)} = {label(self.right)}"

    @property
    def latex(self) -> str:
        """The equation in LaTeX."""
        return f"{typeset(self.left)} = {typeset(self.right)}"


@dataclass(frozen=True)
class Entry:
    """One number of a table, with the digits that are printed."""

    letter: str
    digits: str
    unit: str

    @property
    def value(self) -> float:
        """The number."""
        return float(self.digits)

    @property
    def half_step(self) -> float:
        """Half of the last digit that is printed."""
        return 0.5 * 10.0 ** int(Decimal(self.digits).as_tuple().exponent)


@dataclass(frozen=True)
class Paper:
    """The whole paper; the checks read nothing else."""

    equations: Mapping[str, Printed]
    table_1: Mapping[str, tuple[float, float]]
    table_2: Mapping[str, Entry]
    sentences: Mapping[str, Any]

    def __getitem__(self, equation: str) -> Printed:
        """Return one printed equation."""
        return self.equations[equation]

    def numbers(self, **more: float) -> dict[sp.Symbol, Any]:
        """Table 2 and the magnetic constant by symbol, with further letters set."""
        given = {symbol(letter): entry.value for letter, entry in self.table_2.items()}
        return given | {symbol("mu_0"): MAGNETIC_CONSTANT} | {symbol(key): value for key, value in more.items()}

    def with_equation(self, equation: str, right: sp.Basic) -> Paper:
        """Return a paper that prints another right side."""
        changed = replace(self.equations[equation], right=right)
        return replace(self, equations={**self.equations, equation: changed})

    def with_entry(self, entry: Entry) -> Paper:
        """Return a paper whose Table 2 prints another number, or one more."""
        return replace(self, table_2={**self.table_2, entry.letter: entry})

    def with_sentence(self, name: str, content: Any) -> Paper:
        """Return a paper that says something else."""
        return replace(self, sentences={**self.sentences, name: content})
