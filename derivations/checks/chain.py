"""Numbers of the whole chain with Table 2: current to gap to pressure to force, and backwards."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from derivations.electromagnet import RIGHT, ansatz_factor, gap_of_ansatz, rate_slope
from derivations.glossary import symbol
from derivations.paper import Paper


@dataclass(frozen=True)
class Sweep:
    """What one reading of (31) gives over the paper's sweep of currents; SI units."""

    factor: float
    sign: str
    gaps: tuple[float, float]
    pressures: tuple[float, float]
    needed: tuple[float, float]


def gap_law(paper: Paper, sign: str, factor: float) -> sp.Expr:
    """(31) with Table 2's numbers, as a function of the current alone; `sign` is 'printed' or 'right'."""
    law = paper["31"].right if sign == "printed" else gap_of_ansatz(ansatz_factor(RIGHT))
    law = law.subs(symbol("b"), rate_slope())
    return law.subs(paper.numbers(n=factor, nu=paper.sentences["exponent v"]))


def sweep(paper: Paper, sign: str, factor: float) -> Sweep:
    """Follow the sweep forward to gap and pressure, and ask which currents the gap's range needs."""
    current, gap = symbol("i"), symbol("delta")
    law = gap_law(paper, sign, factor)
    pressure = paper["16"].right.subs(paper.numbers())
    gaps = [float(law.subs(current, value)) for value in paper.sentences["sweep currents"]]
    widest = paper.numbers()[symbol("delta_max")]
    needed = [float(sp.solve(sp.Eq(law, wanted), current)[0]) for wanted in (sp.Float(widest), sp.S.Zero)]
    pressures = [float(pressure.subs(gap, value)) for value in gaps]
    return Sweep(factor, sign, (gaps[0], gaps[1]), (pressures[0], pressures[1]), (needed[0], needed[1]))


def pressure_at(paper: Paper, position: float, direction: int) -> float:
    """Pressure at which a stem that came in that direction rests: S_1 P = k y + direction F_c."""
    numbers = paper.numbers()
    balance = sp.Eq(symbol("S_1") * symbol("P_b") - symbol("k") * position - direction * symbol("F_c"), 0)
    (pressure,) = sp.solve(balance, symbol("P_b"))
    return float(pressure.subs(numbers))


def gap_at(paper: Paper, pressure: float) -> float:
    """(16) the other way round: the gap that gives a pressure."""
    gaps = sp.solve(sp.Eq(paper["16"].right, symbol("P_b")), symbol("delta"))
    values = [float(gap.subs(paper.numbers(P_b=pressure))) for gap in gaps]
    return max(values)


def line_of_points(paper: Paper) -> tuple[float, float]:
    """c0 and E of delta = c0 - E sqrt(i) through the text's two points."""
    offset, gain = sp.symbols("offset gain", positive=True)
    conditions = []
    for name in ("upper point", "lower point"):
        current, position, direction = paper.sentences[name]
        gap = gap_at(paper, pressure_at(paper, position, direction))
        conditions.append(sp.Eq(offset - gain * sp.sqrt(sp.Float(current)), sp.Float(gap)))
    solution = sp.solve(conditions, [offset, gain])
    return float(solution[offset]), float(solution[gain])
