"""`valvemodel linearise` and `valvemodel figures` write what they say."""

import json
import math

import numpy as np
import pytest


def test_linearisation_is_printed_and_written(command, tmp_path):
    result = command(
        "linearise", "--at", "12 mA", "--mode", "rising", "--effect", "coil_lag", "--effect", "static_friction",
        "--json", "linear.json",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    assert "not linearised" in result.output
    content = json.loads((tmp_path / "linear.json").read_text())
    (found,) = content["linearisations"]
    assert content["schema"] == "valvemodel.linearise/1"
    assert found["transfer_functions"]["current_to_position"]["static_gain"] == {
        "value": pytest.approx(12.6396, rel=1e-4), "unit": "m/A",
    }  # fmt: skip
    poles = np.linalg.eigvals(np.array(found["state_space"]["A"]))
    assert np.allclose(np.sort(poles.real), np.sort([pole["pole"][0] for pole in found["poles"]]))
    assert found["effects"]["static_friction"]["is_linear"] is False
    assert found["margins"]["phase_margin"] > math.pi / 3


def test_figures_and_limit_cycle_are_written_together(command, tmp_path):
    result = command(
        "linearise", "--at", "12 mA", "--valve", "linear", "--effect", "static_friction", "--limit-cycle",
        "--kp", "0 mA/mm", "--ki", "0.8 mA/(mm*s)", "--out", "made",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    names = {path.name for path in (tmp_path / "made").iterdir()}
    figures = ("bode", "root_locus", "margins", "limit_cycle")
    assert names == {"linearise.json", *(f"{name}.{kind}" for name in figures for kind in ("png", "svg"))}
    content = json.loads((tmp_path / "made" / "linearise.json").read_text())["limit_cycle"]
    assert abs(content["errors"]["return_map"]["period"]) < 0.01
    assert content["errors"]["describing_function"]["period"] > 0.1


@pytest.mark.parametrize(
    ("words", "rule"),
    [
        (("--at", "12"), "a quantity has a unit"),
        (("--at", "12 kPa"), "converts to A"),
        (("--at", "12 mA", "--effect", "end_stop:upper_stop=0.1 m"), "within the travel"),
        (("--at", "12 mA", "--limit-cycle", "--ki", "0 A/(m*s)"), "needs integral action"),
        (("--at", "12 mA", "--effect", "coil_lag", "--limit-cycle"), "without memory"),
    ],
)
def test_mistakes_end_with_a_message_and_no_files(command, tmp_path, words, rule):
    result = command("linearise", *words, "--out", "made")
    assert result.exit_code == 2
    assert rule in result.output
    assert not (tmp_path / "made").exists()


def test_figures_of_the_paper(command, tmp_path, monkeypatch):
    monkeypatch.setattr("valvemodel.paper_figures.comparison.BUDGET", 40)
    result = command("figures", "--out", "made")
    assert result.exit_code == 0, result.output
    content = json.loads((tmp_path / "made" / "figures.json").read_text())
    for name in content:
        if name != "schema":
            for kind in ("png", "svg"):
                assert (tmp_path / "made" / f"{name}.{kind}").stat().st_size > 10_000
    for name in ("figure_5", "figure_6"):
        printed = content[name]["as_printed"]
        assert max(printed["pressure"]["value"]) < 7.0
        assert max(printed["position"]["value"]) == 0.0
    text = content["figure_5"]["through_the_points_of_the_text"]
    current, position, part = (
        np.array(text[key]["value"] if key != "part" else text[key]) for key in ("current", "position", "part")
    )
    assert position[part == 0][-1] == pytest.approx(0.263, abs=2e-6)
    assert position[(part == 1) & np.isclose(current, 7e-3)][0] == pytest.approx(0.2131, abs=2e-6)
    courses = content["figure_9"]["courses"]
    assert len(courses["pid"]["value"]) == len(courses["time"]["value"]) > 1000
    loops = content["figure_7"]
    width = loops["linear"]["true_width"]["middle"]["value"]
    assert loops["linear"]["threshold"]["value"] == pytest.approx(width, rel=0.01)
    bent = loops["calibrated"]["true_width"]
    assert bent["low"]["value"] > 1.8 * bent["high"]["value"]
