"""The four states of the text, and the sentences that the equations bear out or not."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from derivations.checks.chain import gap_at, line_of_points, pressure_at, sweep
from derivations.checks.finding import found
from derivations.dimensions import DimensionError, dimension
from derivations.electromagnet import coil_gap, rate_slope
from derivations.glossary import label, symbol
from derivations.nozzle import static_pressure
from derivations.paper import Paper
from derivations.verdict import Verdict


def verdicts(paper: Paper) -> Iterator[Verdict]:
    """Yield what is found of the text."""
    for state in paper.sentences["states"]:
        yield _condition(paper, state)
    yield _never_moves(paper)
    yield _point(paper, "state-2", "upper point")
    yield _point(paper, "state-4", "lower point")
    yield _scale(paper)
    yield _points(paper)
    yield _figure(paper)


def _branch(paper: Paper, speed: float) -> str:
    """The name of the branch of (33) that a velocity selects."""
    names = ("rising", "stuck", "falling")
    numbers = {symbol("v"): speed, symbol("epsilon"): paper.sentences["epsilon"]}
    conditions = (condition for _, condition in paper["33"].right.args)
    return next(name for name, holds in zip(names, conditions, strict=True) if holds.subs(numbers) == sp.true)


def _selected(paper: Paper, condition: sp.Basic) -> list[str]:
    """The branches of (33) that a condition on the velocity lets in."""
    band = paper.sentences["epsilon"]
    speeds = (2 * band, band / 2, 0.0, -band / 2, -2 * band)
    numbers = {symbol("epsilon"): band}
    allowed = [speed for speed in speeds if condition.subs({**numbers, symbol("v"): speed}) == sp.true]
    return sorted({_branch(paper, speed) for speed in allowed})


def _condition(paper: Paper, state: str) -> Verdict:
    """Does the condition name the velocity, and does it select the branch in which the stem is?"""
    condition, wanted = paper.sentences["states"][state]
    wrong = ""
    try:
        dimension(condition)
    except DimensionError as error:
        wrong = str(error)
    of_speed = condition.subs(symbol("y"), symbol("v"))
    selected = _selected(paper, of_speed)
    names = ("rising", "stuck", "falling")
    right = paper["33"].right.args[names.index(wanted)][1]
    is_right = not wrong and selected == [wanted]
    return found(
        state,
        "holds" if is_right else "misprint",
        label(condition),
        label(right),
        (
            wrong or "both sides have the same dimension",
            f"with the velocity it reads {label(of_speed)} and lets in the branches of (33): {', '.join(selected)}",
            f"the stem is {wanted} in this state: the branch is {label(right)}",
        ),
        f"The condition is {label(right)}, with the velocity.",
    )


def _never_moves(paper: Paper) -> Verdict:
    """Force over the sweep against the Coulomb friction."""
    numbers = paper.numbers()
    area, friction = numbers[symbol("S_1")], numbers[symbol("F_c")]
    forces = {n: area * sweep(paper, "printed", n).pressures[1] for n in paper.sentences["factors n"]}
    is_stuck = max(forces.values()) < friction
    return found(
        "state-1",
        "not reproducible" if is_stuck else "holds",
        "with more current the stem rises along curve 1",
        f"S_1 P_b <= {max(forces.values()):.2g} N against F_c = {friction:g} N: the stem does not move",
        tuple(f"n = {n:g}: S_1 P_b at 20 mA = {force:.2g} N, F_c = {friction:g} N" for n, force in forces.items()),
        "With Table 2 and (31) the stem never leaves y = 0; Figures 5 and 6 come from other numbers.",
    )


def _point(paper: Paper, state: str, name: str) -> Verdict:
    current, position, direction = paper.sentences[name]
    pressure = pressure_at(paper, position, direction)
    low, high = paper.table_1["converter output"]
    given = {n: sweep(paper, "printed", n).pressures for n in paper.sentences["factors n"]}
    most = max(max(pair) for pair in given.values())
    is_beyond = not low <= pressure <= high
    word = "rising" if direction > 0 else "falling"
    return found(
        state,
        "not reproducible" if is_beyond or most < pressure else "holds",
        f"y = {position} m at {current * 1e3:g} mA, {word}",
        f"P_b = {pressure / 1e3:.1f} kPa",
        (
            f"{word} to rest: S_1 P_b - k y {'-' if direction > 0 else '+'} F_c = 0 gives P_b = "
            f"{pressure / 1e3:.1f} kPa",
            f"the converter of Table 1 gives {low / 1e3:g}..{high / 1e3:g} kPa: {'outside' if is_beyond else 'inside'}",
            f"(31), (16) with Table 2 give at most {most:.2g} Pa over the sweep",
        ),
        f"This position needs {pressure / 1e3:.1f} kPa, "
        + ("above the converter's own limit." if is_beyond else "which Table 2 does not give."),
    )


def _curvature(paper: Paper, offset: float, gain: float, scale: float) -> float:
    """Largest distance of P_b(n i) from its chord, over its rise."""
    current = symbol("i")
    law = static_pressure().subs(paper.numbers()).subs(symbol("delta"), coil_gap())
    law = law.subs({symbol("c_0"): offset, symbol("E"): gain}).subs(current, scale * current)
    low, high = paper.sentences["sweep currents"]
    curve = sp.lambdify(current, law, "math")
    first, last = curve(low), curve(high)
    steps = [low + (high - low) * j / 40 for j in range(41)]
    bend = max(abs(curve(i) - first - (last - first) * (i - low) / (high - low)) for i in steps)
    return bend / abs(last - first)


def _scale(paper: Paper) -> Verdict:
    """n only multiplies the current: y(i; n) = y(n i; 1)."""
    exponent = paper.sentences["exponent v"]
    current, factor = symbol("i"), symbol("n")
    law = paper["31"].right.subs(symbol("nu"), exponent)
    rest = sp.simplify(law - law.subs(factor, 1).subs(current, factor * current))
    offset, gain = line_of_points(paper)
    low, high = (1e3 * value for value in paper.sentences["sweep currents"])
    bends = {n: _curvature(paper, offset, gain, n) for n in paper.sentences["factors n"]}
    return found(
        "text-n",
        "wrong premise" if rest == 0 else "holds",
        "n and v are determined by the structure of the coil; n = 1 is linear, n = 2 is curved",
        "y(i; n) = y(n*i; 1)",
        (
            f"(31) at v = {exponent}: delta(i; n) - delta(n i; 1) = {label(rest)}",
            "so two values of n are one curve, read over two ranges of the current",
            *(
                f"on a curve through the text's two points, {low * n:g}..{high * n:g} mA: largest distance "
                "from a straight "
                f"line {100 * bend:.0f} % of the rise"
                for n, bend in bends.items()
            ),
        ),
        "'Linear for n = 1, curved for n = 2' is a matter of range; n is a scale of the current.",
    )


def factors_for_points(paper: Paper) -> dict[str, float]:
    """The n that (31) with Table 2 needs at each of the text's points."""
    result = {}
    for name in ("upper point", "lower point"):
        current, position, direction = paper.sentences[name]
        gap = gap_at(paper, pressure_at(paper, position, direction))
        law = paper["31"].right.subs(symbol("nu"), paper.sentences["exponent v"]).subs(symbol("b"), rate_slope())
        numbers = {letter: value for letter, value in paper.numbers().items() if letter != symbol("n")}
        equation = sp.Eq(law.subs(symbol("i"), current).subs(numbers), sp.Float(gap))
        # Rounding makes the solver distrust its own root, so it is not asked to check it.
        result[name] = float(sp.solve(equation, symbol("n"), check=False)[0])
    return result


def _points(paper: Paper) -> Verdict:
    needed = factors_for_points(paper)
    offset, gain = line_of_points(paper)
    upper, lower = needed.values()
    opened = paper.numbers()[symbol("delta_max")]
    return found(
        "text-points",
        "not reproducible" if abs(upper / lower - 1) > 0.01 else "holds",
        "Figures 5, 6 and the states follow from n = 1 or n = 2",
        f"c0 = {offset * 1e6:.1f}e-6 m, E = {gain * 1e6:.0f}e-6 m/sqrt(A)",
        (
            *(
                f"{name}: P_b = {pressure_at(paper, *paper.sentences[name][1:]) / 1e3:.1f} kPa, gap "
                f"{gap_at(paper, pressure_at(paper, *paper.sentences[name][1:])) * 1e6:.2f}e-6 m by (16)"
                for name in needed
            ),
            f"(31) with Table 2 needs n = {upper:.3f} at the upper and {lower:.3f} at the lower point: no n fits both",
            f"delta = c0 - E sqrt(i) through both: c0 = {offset * 1e6:.2f}e-6 m, E = {gain * 1e6:.1f}e-6 m/sqrt(A)",
            f"(31) allows no c0 below delta_max = {opened * 1e6:g}e-6 m: outside: {offset < opened}",
        ),
        "No n fits the text's two points; they need c0 and E of their own, outside (31).",
    )


def _figure(paper: Paper) -> Verdict:
    number, subject = paper.sentences["reference"]
    captions = paper.sentences["captions"]
    alike = {key: len(set(_stems(subject)) & set(_stems(caption))) for key, caption in captions.items()}
    best = max(alike, key=lambda key: alike[key])
    return found(
        "text-figure",
        "holds" if best == number else "misprint",
        f"{subject} is shown in Figure {number}",
        f"{subject} is shown in Figure {best}",
        tuple(f"Figure {key}, '{caption}': {alike[key]} words in common" for key, caption in captions.items()),
        f"The experimental platform is Figure {best}.",
    )


def _stems(sentence: str) -> list[str]:
    return [word[:8] for word in sentence.lower().split() if len(word) > 4]
