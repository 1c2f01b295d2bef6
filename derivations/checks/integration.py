"""Eqs. (32), (33): the chain put together."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from derivations import nozzle
from derivations.checks.finding import compared, found
from derivations.checks.stem import acceleration_at_rest
from derivations.compare import classify
from derivations.electromagnet import RIGHT, ansatz_factor, gap_gain, gap_of_ansatz
from derivations.glossary import label, symbol, symbols
from derivations.paper import Paper
from derivations.verdict import Verdict


def verdicts(paper: Paper) -> Iterator[Verdict]:
    """Yield what is found of (32), (33)."""
    yield _pressure(paper)
    yield _constants(paper)
    yield _conditions(paper)
    yield _breakaway(paper)


def _pressure_of(gap: sp.Expr) -> sp.Expr:
    return nozzle.static_pressure().subs(symbol("delta"), gap)


def _pressure(paper: Paper) -> Verdict:
    return compared(
        paper,
        "32",
        _pressure_of(gap_of_ansatz(ansatz_factor(RIGHT))),
        ("(31) with the right sign into (16)", "(31) as printed into (16) gives the printed form"),
        "As (16), with the gap of (31) whose factor is 1.",
        inherited=_pressure_of(paper["31"].right),
    )


def _constants(paper: Paper) -> Verdict:
    """Put C, D, E, F back into (33) and compare its force with S_1 times (32)."""
    letters = {symbol(f"{letter}_33"): paper[f"33-{letter}"].right for letter in "CDEF"}
    force = paper["33"].right.args[0].expr + symbol("F_c") + symbol("k") * symbol("y") + symbol("v") * symbol("f_v")
    area = symbol("S_1")
    # (a^p i^p) for (a i)^p, so that both sides have the same powers
    spread = [
        sp.expand_power_base(side, force=True)
        for side in (
            force.subs(letters),
            area * _pressure_of(gap_of_ansatz(ansatz_factor(RIGHT))),
            area * _pressure_of(paper["31"].right),
        )
    ]
    comparison = classify(spread[0], spread[1], inherited=spread[2])
    return found(
        "33",
        comparison.verdict,
        paper["33-E"].right,
        4 * symbol("C_q2") * symbol("D_2") * gap_gain(RIGHT),
        (
            *(f"{label(letter)} = {label(value)}" for letter, value in letters.items()),
            f"S_1 C/((D - E i^((v-1)/v))^2 + F) against S_1 times (32): {comparison.sentence}",
        ),
        "C, D, F are right; E has the factor (2 v - 1) of (31), which should be 1.",
    )


def _conditions(paper: Paper) -> Verdict:
    before = [condition for _, condition in paper["6"].right.args]
    after = [condition for _, condition in paper["33"].right.args]
    static = symbol("F_s")
    lost = [condition for condition in before if condition.has(static)]
    is_lost = bool(lost) and not any(condition.has(static) for condition in after)
    return found(
        "33",
        "incomplete" if is_lost else "holds",
        paper["33"].text,
        "(6) with (32): five branches",
        (
            f"(6) has {len(before)} branches, (33) has {len(after)}",
            *(f"dropped: {label(condition)}" for condition in lost if is_lost),
            f"F_s is left in (33): {paper['33'].right.has(static)}",
        ),
        "(33) needs the conditions on F_p + F_k and F_s of (6); without them F_s plays no part.",
    )


def _breakaway(paper: Paper) -> Verdict:
    rate = acceleration_at_rest(paper)
    time = symbol("t")
    position = sp.Function("y")
    still = {position(0): symbol("y"), position(time).diff(time).subs(time, 0): 0}
    motion = sp.dsolve(position(time).diff(time, 2) - rate, ics=still).rhs if rate == 0 else sp.nan
    current, area = symbols("i S_1")
    return found(
        "33",
        "wrong premise" if rate == 0 else "holds",
        paper["33"].text,
        "break away when Abs(F_p + F_k) > F_s",
        (
            f"(33) at v = 0: acceleration {label(rate)}, whatever {label(current)} and {label(area)} P_b are",
            f"from rest y(t) = {label(motion)}: the stem never moves",
            "states 2 and 4 of the text let it move by F_p + F_k against F_s, which (33) does not contain",
        ),
        "A resting stem breaks away when abs(F_p + F_k) exceeds F_s; (33) never lets it.",
    )
