"""Eqs. (29)-(31): what the circuit says of current and gap, and what it leaves open."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from derivations import electromagnet
from derivations.checks.finding import compared, found
from derivations.compare import swapped_letter
from derivations.dimensions import fault
from derivations.electromagnet import RIGHT, ansatz_factor, gap_of_ansatz
from derivations.glossary import label, symbol, symbols
from derivations.paper import Paper
from derivations.verdict import Verdict


def verdicts(paper: Paper) -> Iterator[Verdict]:
    """Yield what is found of (29)-(31)."""
    yield _short(paper)
    yield _open(paper, "29")
    yield _divided(paper)
    yield _shifted(paper)
    yield _quotient(paper)
    yield _open(paper, "30")
    yield _gap(paper)
    yield _open(paper, "31")
    yield _start(paper)


def _letters() -> dict[sp.Symbol, sp.Expr]:
    """a, b, j, s of (29) in the coil's letters."""
    turns, constant, area, length, voltage, leakage = symbols("N mu_0 S L_m U sigma")
    offset = length * voltage / (turns**2 * constant * area)
    values = (offset, electromagnet.rate_slope(), length, 2 * leakage)
    return dict(zip(symbols("a b j s"), values, strict=True))


def _short_form(rate: sp.Expr) -> sp.Expr:
    """A rate of the current without resistance, in a, b, j, s."""
    slope, length, leakage = symbols("b j s")
    (voltage,) = sp.solve(sp.Eq(slope, _letters()[slope]), symbol("U"))
    bare = sp.expand(rate.subs(symbol("R_s"), 0)).subs(symbol("U"), voltage)
    bare = bare.subs({symbol("L_m"): length, symbol("sigma"): leakage / 2})
    offset = slope * length / leakage
    return sp.expand(bare) - sp.expand(offset) + symbol("a")


def _right_short() -> sp.Expr:
    return _short_form(
        electromagnet.current_rate_of_flux(electromagnet.flux_by_current(), electromagnet.flux_by_air_gap())
    )


def _short(paper: Paper) -> Verdict:
    return compared(
        paper,
        "29",
        _right_short(),
        (
            "(28) with R_s = 0",
            *(f"{label(letter)} = {label(value)}" for letter, value in _letters().items()),
            f"from (28) as printed: {label(_short_form(paper['28'].right))}",
        ),
        "The last term is + s i/(j + s x) dx/dt.",
        inherited=_short_form(paper["28"].right),
    )


def _divided(paper: Paper) -> Verdict:
    """The first form of (30): its sign is judged with (29); here the division by b alone."""
    return compared(
        paper,
        "30",
        sp.expand(paper["29"].right / symbol("b")),
        ("(29) as printed, both sides over b; s/(j + s x) = 1/(j/s + x)",),
        "The denominator is j/s + x, not j/b + x.",
    )


def _in_shifted_gap(rate: sp.Expr) -> sp.Expr:
    """A form of (29) over b, with X = a/b + x and a/b = j/s."""
    shifted, slope, length, leakage = symbols("X b j s")
    put = rate.subs(symbol("x"), shifted - length / leakage).subs(symbol("a"), slope * length / leakage)
    return sp.expand(sp.simplify(put.subs(symbol("w"), symbol("X_t")) / slope))


def _shifted(paper: Paper) -> Verdict:
    chained = _in_shifted_gap(paper["29"].right)
    return compared(
        paper,
        "30",
        _in_shifted_gap(_right_short()),
        ("(29) over b with X = a/b + x = j/s + x, dX/dt = dx/dt", f"from (29) as printed: {label(chained)}"),
        "(1/b) di/dt = X + (1/b)(i/X) dX/dt, which is d(i/X)/dt = b.",
        inherited=chained,
        key="30-right",
    )


def _quotient(paper: Paper) -> Verdict:
    """The sentence under (30): a/b = i/s."""
    printed = paper["30-text"]
    letters = _letters()
    ratio = sp.simplify(letters[symbol("a")] / letters[symbol("b")])
    wrong = fault(printed.left, printed.right)
    is_met = sp.simplify(printed.right.subs(letters) - ratio) == 0
    swap = swapped_letter(printed.right, symbol("j") / symbol("s"))
    return found(
        "30",
        "misprint" if not is_met else "holds",
        printed.text,
        "a/b = j/s",
        (
            f"a/b = {label(ratio)}",
            wrong or "the dimensions agree",
            f"with {swap} it is j/s = {label((symbol('j') / symbol('s')).subs(letters))}"
            if swap
            else f"printed i/s less a/b is 0: {is_met}",
        ),
        "a/b = j/s = L_m/(2 sigma); X = j/s + x.",
    )


def printed_sign(paper: Paper) -> sp.Expr:
    """The factor of (1/b)(i/X) dX/dt in (30), taken to the left side."""
    shifted, slope, current, rate = symbols("X b i X_t")
    return sp.simplify((shifted - paper["30-right"].right) * slope * shifted / (current * rate))


def printed_gap(paper: Paper) -> sp.Expr:
    """The gap that the ansatz gives with (30) as printed."""
    return gap_of_ansatz(ansatz_factor(printed_sign(paper)))


def _gap(paper: Paper) -> Verdict:
    sign = printed_sign(paper)
    right, chained = ansatz_factor(RIGHT), ansatz_factor(sign)
    slope, factor = symbols("b n")
    ours = gap_of_ansatz(right)
    ratio = sp.simplify((right / chained) ** ((symbol("nu") - 1) / symbol("nu")))
    exponent = paper.sentences["exponent v"]
    return compared(
        paper,
        "31",
        ours,
        (
            "i = e t^v, X = n t^(v-1) into (30), divided by t^(v-1), solved for e",
            f"printed sign: e = {label(slope * factor * chained)}",
            f"right sign: e = {label(slope * factor * right)}",
            f"t from i, X from t, delta = delta_max - x, x = X - L_m/(2 sigma); from (30) as printed: "
            f"{label(gap_of_ansatz(chained))}",
            f"gap gain printed over right: {label(ratio)} = "
            f"{float(ratio.subs(symbol('nu'), exponent)):.4f} at v = {exponent}",
        ),
        "With the right sign e = b n, so the factor (2 v - 1) becomes 1.",
        inherited=gap_of_ansatz(chained),
    )


def residual(sign: sp.Expr) -> sp.Expr:
    """What is left when the general solution is put into (30), for a gap X(t) that is any function."""
    time, slope = symbols("t b")
    constant = sp.Symbol("c", real=True)
    gap = sp.Function("X", positive=True)(time)
    if sign == RIGHT:
        current = gap * (slope * time + constant)
    else:
        current = (slope * sp.Integral(gap**2, time) + constant) / gap
    rate = current.diff(time).doit()
    return sp.simplify(rate / slope - gap + sign * current / gap * gap.diff(time) / slope)


def _open(paper: Paper, equation: str) -> Verdict:
    """The circuit holds for any motion of the armature, with either sign."""
    time, slope, factor = symbols("t b n")
    left = {sign: residual(sign) for sign in (RIGHT, printed_sign(paper))}
    is_open = all(rest == 0 for rest in left.values())
    samples = [factor * time, factor * time**2, factor * sp.exp(time)]
    currents = [gap * slope * time for gap in samples]
    met = [sp.simplify(sp.diff(i / gap, time) - slope) == 0 for i, gap in zip(currents, samples, strict=True)]
    return found(
        equation,
        "not determined" if is_open else "holds",
        paper["30-right"].text if equation != "31" else paper["31"].text,
        "d(i/X)/dt = b for any X(t): i = X*(b*t + c)",
        (
            f"one equation, two unknown functions: i(t) and {'x(t)' if equation == '29' else 'X(t)'}",
            f"right sign: i = X(t) (b t + c) leaves {label(left[RIGHT])}: it holds for any X(t), as d(i/X)/dt = b",
            "printed sign: i X = b integral(X^2) dt + c leaves "
            f"{label(left[printed_sign(paper)])}: it holds for any X(t) as well, so this does not "
            "hinge on the sign",
            *(
                f"X = {label(gap)}, i = {label(i)}: d(i/X)/dt = b is {ok}"
                for gap, i, ok in zip(samples, currents, met, strict=True)
            ),
            "three different curves i-X from one coil: v and n are shapes of an ansatz, not constants of the coil",
        ),
        "The circuit alone does not determine i-x; that takes the force balance of the armature.",
    )


def _start(paper: Paper) -> Verdict:
    """At i = 0 (31) asks for a negative air gap."""
    closing = symbol("delta_max") - paper["31"].right.subs(symbol("i"), 0)
    gap = sp.simplify(closing.subs(symbol("nu"), paper.sentences["exponent v"]))
    value = float(gap.subs(paper.numbers()))
    return found(
        "31",
        "wrong premise" if value < 0 else "holds",
        paper["31"].text,
        "x >= 0",
        (
            "x = delta_max - delta by (12)",
            f"(31) at i = 0: x = {label(gap)} = {value * 1e3:.1f} mm",
            "(22) and the words 'when the I/P converter is not working' need x = 0 there",
            "the ansatz X = n t^(v-1) starts at X = 0; x = 0 is X = L_m/(2 sigma)",
        ),
        "X starts at L_m/(2 sigma), which no X = n t^(v-1) does at t = 0; the constant c of the solution is missing.",
    )
