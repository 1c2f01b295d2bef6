"""Doubtful valves are found by physics: table2 is caught, calibrated and linear are not."""

import math

import numpy as np
import pytest

from valvemodel.base_valve import BASE_PARAMETERS
from valvemodel.valves import Entry, Valve, figures, plausibility, read_valve, valve_names


def calibrated(**changes):
    """Return the calibrated valve under another name with numbers changed."""
    valve = read_valve("calibrated")
    entries = {name: entry for name, entry in valve.entries.items() if name not in changes}
    return Valve("mine", {**valve.values, **changes}, entries)


def checks(valve):
    return {doubt.check for doubt in plausibility(valve)}


def test_table2_is_caught_whatever_it_is_called():
    valve = read_valve("table2")
    renamed = Valve("calibrated", valve.values, valve.entries)
    for one in (valve, renamed):
        assert checks(one) >= {"damping_ratio", "pressure_range", "gap_range", "pounds_as_mass", "dead_band"}
    text = " ".join(doubt.text for doubt in plausibility(valve))
    for words in (
        "0.003",
        "3.5 lbf*s/in",
        "612.9 N*s/m",
        "an inference",
        "stem_mass is 3 lb",
        "100 in^2",
        "320 lbf",
    ):
        assert words in text
    assert "never rises" in text


@pytest.mark.parametrize("name", ["calibrated", "linear"])
def test_plausible_sets_are_clean(name):
    assert plausibility(read_valve(name)) == []


def test_sets_are_listed():
    assert valve_names() == ("calibrated", "linear", "table2")


def test_calibrated_gives_the_converters_range():
    found = figures(read_valve("calibrated"))
    assert found.pressure[0] == pytest.approx(40e3, rel=2e-3)
    assert found.pressure[-1] == pytest.approx(210e3, rel=2e-3)
    assert found.damping_ratio == pytest.approx(1.147, abs=1e-3)
    straight = figures(read_valve("linear")).pressure
    np.testing.assert_allclose(straight, np.linspace(40e3, 210e3, straight.size))


def test_table2_gives_the_designs_gaps_and_pressures():
    # the design's figures for 6..20 mA and n = 1, from the printed form: gaps of 32..19 mm below 1 Pa
    valve = read_valve("table2")
    assert valve.values["flow_ratio"] == pytest.approx(1.0437e9, rel=1e-4)
    assert valve.values["gap_offset"] == pytest.approx(0.3e-3 + 0.4 / 8.4)
    printed = valve.values["gap_gain"] * math.sqrt(3)
    gaps = valve.values["gap_offset"] - printed * np.sqrt([6e-3, 20e-3])
    np.testing.assert_allclose(gaps, [32e-3, 19e-3], atol=0.5e-3)
    # no gap at all needs 160.3 mA with the right sign
    assert (valve.values["gap_offset"] / valve.values["gap_gain"]) ** 2 == pytest.approx(0.1603, rel=1e-3)


DOUBTS = {
    "damping_ratio": ({"viscous_friction": 20.0}, "rings"),
    "time_constant": ({"viscous_friction": 5e5}, "time constant of 9.52 s"),
    "pressure_range": ({"gap_gain": 1e-6}, "never rises"),
    "gap_range": ({"gap_gain": 1e-3}, "from 16 mA on the flapper would be inside the nozzle"),
    "travel": ({"spring_rate": 5.25e3}, "of the rated travel"),
    "dead_band": ({"coulomb_friction": 4000.0}, "73% of the pressure span"),
    "supply_pressure": ({"supply_pressure": 9e5, "gap_offset": 2e-4}, "above 700 kPa"),
    "parameter_range": ({"stem_mass": 250.0}, "stem_mass is 250 kg, outside 0.01 kg..200 kg"),
}


@pytest.mark.parametrize("check", DOUBTS)
def test_each_check_finds_its_doubt(check, request):
    changes, words = DOUBTS[check]
    found = [doubt.text for doubt in plausibility(calibrated(**changes)) if doubt.check == check]
    assert found, f"{check} found nothing"
    assert any(words in text for text in found), found


def test_pressure_above_supply_and_falling_is_found():
    straight = read_valve("linear")
    valve = Valve("mine", {**straight.values, "supply_pressure": 1.5e5})
    assert "above the supply of 150 kPa" in " ".join(doubt.text for doubt in plausibility(valve))
    assert "falls again above" in " ".join(doubt.text for doubt in plausibility(calibrated(gap_gain=1e-3)))


def test_little_damping_alone_is_no_suspicion_of_pounds():
    valve = calibrated()
    entries = {**valve.entries, "viscous_friction": Entry(1.73, "N*s/m", "test")}
    valve = Valve("mine", {**valve.values, "viscous_friction": 1.73}, entries)
    assert "damping_ratio" in checks(valve)
    assert "pounds_as_mass" not in checks(valve)
    metric = {"stem_mass": 1.5, "spring_rate": 5e4, "diaphragm_area": 0.06, "coulomb_friction": 1500.0}
    entries = {name: Entry(value, "SI", "test") for name, value in metric.items()}
    entries["viscous_friction"] = Entry(1.59, "N*s/m", "test")
    valve = Valve("mine", {**valve.values, **metric, "viscous_friction": 1.59}, entries)
    assert "pounds_as_mass" not in checks(valve)


def test_stem_without_spring_has_figures():
    found = figures(calibrated(spring_rate=0.0))
    assert found.damping_ratio == math.inf
    assert found.settling == pytest.approx(1.36 / 612.9)
    assert figures(calibrated(viscous_friction=0.0)).settling == math.inf


def test_every_value_of_a_set_is_a_base_parameter_with_entry():
    for name in valve_names():
        valve = read_valve(name)
        assert list(valve.values) == [parameter.name for parameter in BASE_PARAMETERS]
        assert set(valve.values) <= set(valve.entries)
        assert all(entry.source for entry in valve.entries.values())
