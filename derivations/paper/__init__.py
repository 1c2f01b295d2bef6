"""What the paper prints, transcribed: equations, tables, and the sentences that can be checked."""

from __future__ import annotations

from derivations.paper.equations import equations
from derivations.paper.printed import Entry, Paper, Printed
from derivations.paper.tables import SENTENCES, TABLE_1, TABLE_2

__all__ = ["PAPER", "Entry", "Paper", "Printed"]

PAPER = Paper(equations(), TABLE_1, TABLE_2, SENTENCES)
