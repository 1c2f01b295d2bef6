"""Eqs. (34)-(41): controller and self-calibration."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from derivations import self_calibration
from derivations.checks.finding import compared, found
from derivations.dimensions import fault
from derivations.glossary import LETTERS, label, symbol, symbols
from derivations.paper import Paper
from derivations.verdict import Verdict

_FALLING = dict(zip(symbols("I_1 I_2 I_3 Y_1 Y_2 Y_3"), symbols("I_4 I_5 I_6 B_1 B_2 B_3"), strict=True))


def verdicts(paper: Paper) -> Iterator[Verdict]:
    """Yield what is found of (34)-(41)."""
    yield _controller(paper, "34")
    yield _slope(paper, "35", {})
    yield _slope(paper, "36", _FALLING)
    yield compared(paper, "37", self_calibration.mean_slope(), ("the slope nearest to k_1 and k_2 by least squares",))
    yield _intercept(paper, "38", {})
    yield _intercept(paper, "39", _FALLING)
    yield _width(paper)
    yield _use(paper)
    yield _controller(paper, "41")
    yield _calibrated_current(paper)


def _controller(paper: Paper, equation: str) -> Verdict:
    printed = paper[equation]
    wanted = {"K_P", "K_I", "K_D"}
    needed = sorted(letter.name for letter in printed.right.free_symbols if letter.name in wanted)
    missing = [letter for letter in needed if letter not in paper.sentences["controller values"]]
    # The sum and the difference of samples hide the sample time: the units of the gains show it.
    per_sample = [letter for letter in missing if "sample" in LETTERS[letter].meaning]
    return found(
        equation,
        "incomplete" if missing else "holds",
        printed.text,
        printed.text,
        (
            fault(printed.left, printed.right) or "both sides have the same dimension",
            f"values that are needed to repeat Figure 9 and are not given: {', '.join(missing) or 'none'}",
            f"gains that mean nothing without the sample time: {', '.join(per_sample) or 'none'}",
            "set points of Figure 9 are not given either",
        ),
        "Gains, set points and sample time have to be chosen; Figure 9 cannot be repeated.",
    )


def _slope(paper: Paper, equation: str, letters: dict) -> Verdict:
    fit = self_calibration.least_squares_slope()
    i_1, i_2, i_3, step = *symbols("I_1 I_2 I_3"), sp.Symbol("h", positive=True)
    even = {i_2: i_1 + step, i_3: i_1 + 2 * step}
    gap = sp.simplify((fit - self_calibration.branch_slope()).subs(even))
    skew = sp.simplify((fit - self_calibration.branch_slope()).subs({i_2: i_1 + step, i_3: i_1 + 3 * step}))
    return compared(
        paper,
        equation,
        self_calibration.branch_slope().subs(letters, simultaneous=True),
        (
            "mean of the two secants through three records",
            f"step 3 asks for a linear fit; least squares less this, currents evenly spaced: {label(gap)}",
            f"currents spaced 1 to 2: {label(skew)}, so there it is not the best fit, though exact on a straight line",
        ),
    )


def _intercept(paper: Paper, equation: str, letters: dict) -> Verdict:
    derived = self_calibration.branch_intercept().subs(letters, simultaneous=True)
    return compared(paper, equation, derived, ("least squares in the intercept with the slope k fixed",))


def _width(paper: Paper) -> Verdict:
    return compared(
        paper,
        "40",
        self_calibration.loop_width(),
        (
            "rising branch y = k i + b_1, falling branch y = k i + b_2, b_2 > b_1",
            "at one y: i_rising - i_falling = (y - b_1)/k - (y - b_2)/k",
            "that is the full width of the loop in current",
        ),
    )


def base_lines() -> dict[str, tuple[sp.Expr, sp.Expr]]:
    """What has to be added to the current from each base line, up and down, in units of the full width."""
    y, k, rising, falling = symbols("y k_m b_1 b_2")
    up, down = (y - rising) / k, (y - falling) / k
    width = self_calibration.loop_width()
    lines = {"rising branch": up, "falling branch": down, "mean line": (up + down) / 2}
    return {
        name: (sp.simplify((up - line) / width), sp.simplify((line - down) / width)) for name, line in lines.items()
    }


def _use(paper: Paper) -> Verdict:
    """i_SC = i + I_threshold when rising, i - I_threshold when falling: from which line is that right?"""
    printed = paper.sentences["use of the threshold"]
    needed = base_lines()
    fitting = [name for name, shares in needed.items() if shares == printed]
    return found(
        "40",
        "holds" if fitting else "wrong premise",
        f"i_SC = i + {printed[0]}*I_threshold rising, i - {printed[1]}*I_threshold falling",
        "i +- I_threshold/2 from the mean line, or +- I_threshold once at each reversal",
        (
            *(
                f"i from the {name}: add {label(up)} I_threshold when rising, take {label(down)} when falling"
                for name, (up, down) in needed.items()
            ),
            f"lines from which both printed amounts {printed} are right: {', '.join(fitting) or 'none'}",
            "up and down together are always one full width, printed two; "
            "added once at each reversal, from a branch line, the full width is right",
        ),
        "The full width belongs to a reversal from a branch line; from the mean line it must be half.",
    )


def _calibrated_current(paper: Paper) -> Verdict:
    """The i in i_SC = i +- I_threshold: two readings, two controllers."""
    controller, threshold, forward = sp.Symbol("PID"), symbol("W"), sp.Symbol("feedforward")
    shared = paper["41"].right - paper["34"].right
    readings = {
        "the current of the calibrated line": controller + shared.subs(symbol("i_SC"), forward + threshold),
        "the output of the PID": controller + shared.subs(symbol("i_SC"), controller + threshold),
    }
    first, second = readings.values()
    difference = sp.expand(second - first)
    return found(
        "41",
        "not determined" if difference != 0 else "holds",
        paper["41"].text,
        "u' = PID + i_line(y) +- I_threshold/2",
        (
            *(f"i is {name}: u' = {label(value)}" for name, value in readings.items()),
            f"the two differ by {label(difference)}",
            "the text says both 'the current i' and 'the control current signal can be calculated' from the line",
        ),
        "Whether i in i_SC is a feedforward or the PID's output has to be said; the toolkit takes the feedforward.",
    )
