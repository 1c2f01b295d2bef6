"""Eqs. (1)-(6): the forces on the stem, its friction, and the paper's velocity band."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from derivations import stem
from derivations.checks.finding import found, stated
from derivations.compare import is_equal
from derivations.glossary import label, symbol, symbols
from derivations.paper import Paper
from derivations.verdict import Verdict

_MINUTE = 60.0


def verdicts(paper: Paper) -> Iterator[Verdict]:
    """Yield what is found of (1)-(6)."""
    yield stated(paper, "1", "Newton's second law: mass times acceleration is the sum of the forces")
    pushes = sp.diff(paper["2"].right, symbol("P_b")).is_positive
    yield stated(paper, "2", "pressure pushes the stem up: dF_p/dP_b > 0", is_met=bool(pushes))
    restores = sp.diff(paper["3"].right, symbol("y")).is_negative
    yield stated(paper, "3", "a spring pushes back: dF_k/dy < 0", is_met=bool(restores))
    yield _preload(paper)
    yield stated(paper, "4", "velocity is the rate of the displacement")
    yield _friction(paper)
    yield _branches(paper)
    yield _band(paper)


def _preload(paper: Paper) -> Verdict:
    """An actuator whose signal range starts above 0 has a spring that is pressed at y = 0."""
    numbers = paper.numbers()
    start, end = paper.table_1["actuator signal"]
    area, friction = numbers[symbol("S_1")], numbers[symbol("F_c")]
    at_rest = paper["3"].right.subs(symbol("y"), 0)
    needed = area * start
    lift = friction / area
    _, position, direction = paper.sentences["upper point"]
    pressure = (numbers[symbol("k")] * position + direction * friction + needed) / area
    is_missing = at_rest == 0 and start > lift
    return found(
        "3",
        "incomplete" if is_missing else "holds",
        paper["3"].text,
        "F_k = -k*y_1 - F_0",
        (
            f"(3) at y = 0 gives F_k = {label(at_rest)}: the stem lifts off at F_c/S_1 = {lift / 1e3:.1f} kPa",
            f"Table 1 starts the actuator at {start / 1e3:g} kPa of {start / 1e3:g}..{end / 1e3:g} kPa",
            f"so the spring is pressed by S_1 * {start / 1e3:g} kPa = {needed:.0f} N at y = 0",
            f"with that preload the text's y = {position} m would need {pressure / 1e3:.1f} kPa, "
            f"above the supply of {numbers[symbol('P_1')] / 1e3:g} kPa",
        ),
        "A preload F_0 belongs into (3); it is a parameter of the base valve, 0 where nothing is known.",
    )


def _friction(paper: Paper) -> Verdict:
    velocity, speed = symbol("v"), sp.Symbol("speed", positive=True)
    slip, stick, break_away = (value for value, _ in paper["5"].right.args)
    powers = [sp.simplify((slip * velocity).subs(velocity, side * speed)) for side in (1, -1)]
    held = sp.expand(stick + symbol("F_p") + symbol("F_k"))
    size = sp.simplify(sp.Abs(break_away.subs(symbol("F_k"), speed - symbol("F_p"))))
    is_right = all(power.is_negative for power in powers) and held == 0 and size == symbol("F_s")
    return stated(
        paper,
        "5",
        "friction takes power from the motion "
        f"(F_f v = {label(powers[0])} up, {label(powers[1])} down), holds a resting stem (rest "
        f"{label(held)}) "
        f"up to F_s (size {label(size)})",
        is_met=bool(is_right),
    )


def _branches(paper: Paper) -> Verdict:
    derived = (
        stem.moving_force(1),
        sp.S.Zero,
        stem.starting_force(1),
        stem.starting_force(-1),
        stem.moving_force(-1),
    )
    printed = tuple(value for value, _ in paper["6"].right.args)
    agree = [is_equal(one, other) for one, other in zip(printed, derived, strict=True)]
    steps = [
        f"branch {number}: derived {label(one)}, printed {label(other)}: {'equal' if same else 'not equal'}"
        for number, (one, other, same) in enumerate(zip(derived, printed, agree, strict=True), 1)
    ]
    return found(
        "6",
        "holds" if all(agree) else "sign error",
        paper["6"].text,
        "; ".join(map(label, derived)),
        ("(1)-(3) with F_g = F_i = 0 and each branch of (5) put in", *steps),
        "The five forces are as printed; for the condition of the second see the other entry.",
    )


def _band(paper: Paper) -> Verdict:
    """Solve the motion that the paper's branch of no acceleration allows."""
    time, band = symbol("t"), paper.sentences["epsilon"]
    start = sp.Symbol("v_0", real=True)
    position = sp.Function("y")
    ends = {position(0): 0, position(time).diff(time).subs(time, 0): start}
    motion = sp.dsolve(position(time).diff(time, 2), ics=ends).rhs
    condition = next(condition for value, condition in paper["6"].right.args if value == 0)
    speed_only = next(part for part in sp.And.make_args(condition) if part.has(symbol("v")))
    is_coasting = speed_only.subs({symbol("v"): band / 2, symbol("epsilon"): band}) == sp.true
    drift = float(motion.subs({start: band, time: _MINUTE}))
    return found(
        "6",
        "wrong premise" if is_coasting else "holds",
        f"m*y'' = 0 if {label(condition)}",
        "y' = 0 if v = 0 and Abs(F_p + F_k) <= F_s",
        (
            f"a speed of epsilon/2 meets the condition {label(speed_only)}: {is_coasting}",
            f"y'' = 0 with y(0) = 0, y'(0) = v_0 gives y = {label(motion)}, which does not stop",
            f"at {band:g} m/s a stem that is called stuck moves {drift * 1e3:g} mm in a minute",
        ),
        "A stuck stem has no velocity; a slip ends when v crosses 0 while the net force is within F_s.",
    )


def acceleration_at_rest(paper: Paper) -> sp.Expr:
    """What (33) gives for a stem at rest, whatever the current."""
    band = {symbol("epsilon"): paper.sentences["epsilon"]}
    force = paper["33"].right.subs(band).subs(symbol("v"), 0)
    mass, acceleration = symbols("m a_y")
    (solution,) = sp.solve(sp.Eq(mass * acceleration, force), acceleration)
    return solution
