"""The findings: each fact of the design against numbers from elsewhere, and each moves with the paper."""

from functools import cache

import pytest
import sympy as sp

import derivations
from derivations import checks, electromagnet, nozzle
from derivations.checks import ansatz, chain, integration, self_calibration, stem, tables, texts
from derivations.checks.nozzle import choked_limits, critical_ratio
from derivations.glossary import symbol, symbols
from derivations.paper import PAPER, Entry


@cache
def _all():
    return tuple(derivations.verdicts())


def _kinds(findings):
    kinds = {}
    for one in findings:
        kinds.setdefault(one.equation, []).append(one.verdict)
    return kinds


EXPECTED = {
    "8": "misprint",
    "15": "holds",
    "16": "holds",
    "25": "holds",
    "26": "holds",
    "27": "sign error",
    "28": "inherits an error",
    "29": "inherits an error",
    "30": "inherits an error",
    "31": "inherits an error",
    "32": "inherits an error",
    "22": "misprint",
    "23": "wrong premise",
    "24": "wrong premise",
    "12": "wrong premise",
    "17": "wrong premise",
    "6": "wrong premise",
    "33": "incomplete",
    "7": "wrong premise",
    "9": "wrong premise",
    "34": "incomplete",
    "41": "not determined",
    "40": "holds",
    "table-1": "wrong premise",
    "table-2": "not reproducible",
    "state-1": "misprint",
    "state-2": "not reproducible",
    "state-4": "not reproducible",
    "text-figure": "misprint",
    "text-n": "wrong premise",
    "text-points": "not reproducible",
}


@pytest.mark.parametrize(("equation", "verdict"), EXPECTED.items())
def test_the_verdict_is_found(equation, verdict):
    assert verdict in _kinds(_all())[equation]


@pytest.mark.parametrize("equation", ["29", "30", "31"])
def test_the_circuit_leaves_the_curve_open(equation):
    assert "not determined" in _kinds(_all())[equation]


def test_every_equation_has_an_entry():
    assert {str(number) for number in range(1, 42)} <= set(_kinds(_all()))


@pytest.mark.parametrize("equation", ["15", "16", "25", "26", "10", "35", "36", "37", "38", "39"])
def test_what_holds_has_no_other_entry(equation):
    assert _kinds(_all())[equation] == ["holds"]


def test_entries_are_complete():
    for one in _all():
        assert one.verdict in derivations.verdict_kinds
        assert all(isinstance(step, str) and step for step in one.steps)
        assert one.printed
        assert one.derived
        assert one.right.endswith(".")


def _text(equation, verdict):
    return " ".join(step for one in _all() if (one.equation, one.verdict) == (equation, verdict) for step in one.steps)


# Mutations: a paper that prints something else gets another verdict.


def _only(part, equation, paper):
    return [one.verdict for one in part.verdicts(paper) if one.equation == equation]


def test_the_right_sign_in_27_moves_the_error_to_28():
    mended = PAPER.with_equation("27", -PAPER["27"].right)
    kinds = _kinds(checks.electromagnet.verdicts(mended))
    assert kinds["27"] == ["holds"]
    assert kinds["28"] == ["sign error"]


def test_a_paper_with_all_signs_right_holds_to_the_end():
    mended = PAPER.with_equation("27", -PAPER["27"].right)
    last = symbol("w") * 2 * symbol("sigma") * symbol("i") / (symbol("L_m") + 2 * symbol("sigma") * symbol("x"))
    mended = mended.with_equation("28", mended["28"].right + 2 * last)
    i, w, s, j, x, X, X_t, b = symbols("i w s j x X X_t b")
    mended = mended.with_equation("29", mended["29"].right + 2 * s * i / (j + s * x) * w)
    mended = mended.with_equation("30-right", X + i / X * X_t / b)
    right = electromagnet.gap_of_ansatz(electromagnet.ansatz_factor(electromagnet.RIGHT))
    mended = mended.with_equation("31", right)
    mended = mended.with_equation("32", nozzle.static_pressure().subs(symbol("delta"), right))
    assert _kinds(checks.electromagnet.verdicts(mended))["28"] == ["holds"]
    kinds = _kinds(ansatz.verdicts(mended))
    assert kinds["29"] == ["holds", "not determined"]
    assert kinds["30"] == ["misprint", "holds", "misprint", "not determined"]
    assert kinds["31"][0] == "holds"
    assert _only(integration, "32", mended) == ["holds"]


def test_a_root_over_all_in_8_holds():
    wrong = PAPER["8"].right
    mended = PAPER.with_equation("8", wrong / sp.sqrt(symbol("dP_1")))
    assert _only(checks.nozzle, "8", mended)[0] == "holds"


@pytest.mark.parametrize("equation", ["9", "10", "11", "15", "16"])
def test_a_spoilt_nozzle_equation_is_found(equation):
    spoilt = PAPER.with_equation(equation, 2 * PAPER[equation].right)
    assert _only(checks.nozzle, equation, spoilt)[0] != "holds"


@pytest.mark.parametrize("equation", ["19", "20", "25", "26"])
def test_a_turned_sign_in_the_electromagnet_is_found(equation):
    spoilt = PAPER.with_equation(equation, -PAPER[equation].right)
    assert "sign error" in _only(checks.electromagnet, equation, spoilt)


@pytest.mark.parametrize("equation", ["35", "36", "37", "38", "39", "40"])
def test_a_turned_sign_in_the_calibration_is_found(equation):
    spoilt = PAPER.with_equation(equation, -PAPER[equation].right)
    assert _only(self_calibration, equation, spoilt)[0] != "holds"


def test_a_spring_that_pulls_is_a_sign_error():
    spoilt = PAPER.with_equation("3", -PAPER["3"].right)
    assert _only(stem, "3", spoilt)[0] == "sign error"


def test_mu_0_in_22_and_j_over_s_in_30_hold():
    x, S, mu_0, a, b, j, s = symbols("x S mu_0 a b j s")
    mended = PAPER.with_equation("22", 2 * x / (mu_0 * S)).with_equation("30-text", j / s)
    i, w = symbols("i w")
    mended = mended.with_equation("30", a / b + x - i / (j / s + x) * w / b)
    assert _only(checks.electromagnet, "22", mended)[0] == "holds"
    assert _only(ansatz, "30", mended)[0] == "holds"
    assert _only(ansatz, "30", mended)[2] == "holds"


def test_leakage_the_right_way_and_iron_in_the_core_hold():
    mended = PAPER.with_equation("23", symbol("phi") / symbol("sigma"))
    mended = mended.with_equation("24", symbol("mu_0") * symbol("mu_r") * symbol("H_m"))
    assert _only(checks.electromagnet, "23", mended) == ["holds"]
    assert _only(checks.electromagnet, "24", mended) == ["holds", "holds"]


def test_half_the_threshold_is_right_from_the_mean_line():
    half = sp.Rational(1, 2)
    mended = PAPER.with_sentence("use of the threshold", (half, half))
    assert _only(self_calibration, "40", mended) == ["holds", "holds"]


def test_a_static_friction_in_table_2_completes_it():
    assert tables.missing_letters(PAPER) == ["F_s"]
    assert tables.missing_letters(PAPER.with_entry(Entry("F_s", "1708", "N"))) == []


def test_a_plausible_viscous_friction_is_no_misprint():
    mended = PAPER.with_entry(Entry("f_v", "612.9", "kg/s"))
    assert "misprint" not in _only(tables, "table-2", mended)


def test_the_states_with_the_velocity_hold():
    v, band = symbols("v epsilon")
    states = {
        "state-1": (v >= band, "rising"),
        "state-2": (sp.Abs(v) < band, "stuck"),
        "state-3": (v <= -band, "falling"),
        "state-4": (sp.Abs(v) < band, "stuck"),
    }
    mended = PAPER.with_sentence("states", states)
    found = [one for one in texts.verdicts(mended) if one.equation in states]
    assert [one.verdict for one in found[:4]] == ["holds"] * 4


# Numbers, worked out by hand and by calculator.


@pytest.mark.parametrize(
    ("sign", "factor", "gaps", "needed"),
    [
        ("printed", 1, (31.9e-3, 18.6e-3), (52.76e-3, 53.43e-3)),
        ("printed", 2, (25.2e-3, 6.5e-3), (26.38e-3, 26.71e-3)),
        ("right", 1, (38.6e-3, 31.0e-3), (158.3e-3, 160.3e-3)),
        ("right", 2, (34.8e-3, 24.0e-3), (79.1e-3, 80.1e-3)),
    ],
)
def test_table_2_misses_the_range(sign, factor, gaps, needed):
    one = chain.sweep(PAPER, sign, factor)
    assert one.gaps == pytest.approx(gaps, abs=0.06e-3)
    assert one.needed == pytest.approx(needed, abs=0.06e-3)
    assert max(one.pressures) < (1 if factor == 1 else 7)


def test_the_positions_of_the_text_need_these_pressures():
    assert chain.pressure_at(PAPER, 0.263, 1) == pytest.approx(236.1e3, abs=50)
    assert chain.pressure_at(PAPER, 0.2131, -1) == pytest.approx(151.4e3, abs=50)


def test_the_points_of_the_text_need_this_gap_law():
    offset, gain = chain.line_of_points(PAPER)
    assert offset == pytest.approx(51.8e-6, abs=0.05e-6)
    assert gain == pytest.approx(252e-6, abs=0.5e-6)
    upper, lower = texts.factors_for_points(PAPER).values()
    assert (upper, lower) == pytest.approx((2.67, 7.62), abs=0.01)


def test_the_damping_ratio_gives_the_pounds_away():
    assert tables.damping_ratio(PAPER, 1.59) == pytest.approx(0.00298, abs=1e-5)
    assert tables.damping_ratio(PAPER, 612.9) == pytest.approx(1.147, abs=1e-3)
    steps = _text("table-2", "misprint")
    for told in ("3 lb", "300 lbf/in", "100 in^2", "320 lbf", "3.5 lb (mass)", "612.9 N s/m", "inference"):
        assert told in steps


def test_the_core_of_air_shifts_the_gap():
    shift = float(electromagnet.rest_shift().subs(PAPER.numbers()))
    assert shift == pytest.approx(0.4 / 8.4)
    assert "47.6 mm" in _text("24", "wrong premise")


def test_the_chokes_close_the_range():
    assert critical_ratio() == pytest.approx(0.52828, abs=1e-5)
    limits = choked_limits(PAPER)
    assert limits["orifice"] == pytest.approx(110.7e3, abs=50)
    assert limits["nozzle"] == pytest.approx(90.5e3, abs=50)


def test_the_coil_has_no_rest_and_would_need_600_ohm():
    steps = _text("17", "wrong premise")
    assert "600 ohm" in steps
    assert "3.32 A/s" in steps


def test_the_factor_is_found_by_solving():
    nu = symbol("nu")
    assert sp.simplify(electromagnet.ansatz_factor(electromagnet.PRINTED) * (2 * nu - 1)) == 1
    assert electromagnet.ansatz_factor(electromagnet.RIGHT) == 1


def test_any_gap_solves_30_with_either_sign():
    assert ansatz.residual(sp.Integer(electromagnet.RIGHT)) == 0
    assert ansatz.residual(sp.Integer(electromagnet.PRINTED)) == 0


def test_the_first_table_gives_too_little_travel():
    assert "0.1966 m" in _text("table-1", "not reproducible")
    assert "24 %" in _text("table-1", "wrong premise")


def test_the_calibration_lines_need_these_shares():
    half = sp.Rational(1, 2)
    assert self_calibration.base_lines() == {
        "rising branch": (0, 1),
        "falling branch": (1, 0),
        "mean line": (half, half),
    }
