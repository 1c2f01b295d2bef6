"""A valve of one's own is a file; every mistake in it is named with its line."""

import math

import pytest

from valvemodel.errors import InputError
from valvemodel.valves import read_valve

ENTRIES = {
    "stem_mass": ("3", "lb"),
    "spring_rate": ("300", "lbf/in"),
    "diaphragm_area": ("100", "in^2"),
    "supply_pressure": ("3", "barg"),
    "viscous_friction": ("3.5", "lbf*s/in"),
    "coulomb_friction": ("320", "lbf"),
    "flow_ratio": ("1.0437e9", "1/m^2"),
    "gap_offset": ("126.3", "um"),
    "gap_gain": ("750.1", "um/sqrt(A)"),
}


def write(tmp_path, entries=ENTRIES, more="", name="mine.toml"):
    path = tmp_path / name
    tables = [f'[{key}]\nvalue = {value}\nunit = "{unit}"\nsource = "test"\n' for key, (value, unit) in entries.items()]
    path.write_text("\n".join(tables) + more, encoding="utf-8")
    return path


def test_file_is_read_in_its_own_units(tmp_path):
    valve = read_valve(write(tmp_path))
    assert valve.name == "mine"
    assert valve.values["stem_mass"] == pytest.approx(1.360777, rel=1e-6)
    assert valve.values["spring_rate"] == pytest.approx(52538.05, rel=1e-6)
    assert valve.values["viscous_friction"] == pytest.approx(612.9439, rel=1e-6)
    assert valve.values["supply_pressure"] == 300e3
    assert valve.values["gap_offset"] == pytest.approx(126.3e-6, rel=1e-12)
    assert valve.values["travel_max"] == math.inf
    assert valve.entries["stem_mass"].value == 3
    assert valve.entries["stem_mass"].unit == "lb"
    assert valve.entries["stem_mass"].is_given
    assert valve.entries["spring_preload"].source.startswith("not given")


def based(tmp_path, names, more="", base="calibrated"):
    path = write(tmp_path, {name: ENTRIES[name] for name in names}, more)
    path.write_text(f'based_on = "{base}"\n' + path.read_text())
    return path


def test_what_a_data_sheet_lacks_is_taken_from_the_set_that_the_file_is_based_on(tmp_path):
    valve, calibrated = read_valve(based(tmp_path, ["spring_rate", "diaphragm_area"])), read_valve("calibrated")
    own = {name: value for name, value in valve.values.items() if value != calibrated.values[name]}
    assert own.keys() == {"spring_rate", "diaphragm_area"}
    assert valve.entries["gap_gain"].source == "not given: as in calibrated"
    assert not valve.entries["gap_gain"].is_given


def test_how_the_current_makes_the_pressure_is_not_mixed_of_two_valves(tmp_path):
    with pytest.raises(InputError, match="lacks gap_offset, gap_gain"):
        read_valve(based(tmp_path, ["flow_ratio"]))
    whole = based(tmp_path, ["flow_ratio", "gap_offset", "gap_gain"], base="linear")
    assert read_valve(whole).values["pressure_per_current"] == 0.0


def test_a_file_is_based_on_a_set(tmp_path):
    with pytest.raises(InputError, match="choose calibrated or linear or table2"):
        read_valve(based(tmp_path, ["spring_rate"], base="mine.toml"))


def test_rated_travel_follows_from_the_stops(tmp_path):
    entries = {**ENTRIES, "travel_min": ("0", "mm"), "travel_max": ("40", "mm")}
    assert read_valve(write(tmp_path, entries)).values["rated_travel"] == pytest.approx(0.04)


def test_printed_form_has_the_factor_of_the_wrong_sign(tmp_path):
    from importlib import resources

    text = (resources.files("valvemodel.valves") / "table2.toml").read_text()
    path = tmp_path / "printed.toml"
    path.write_text(text.replace('equations = "corrected"', 'equations = "as printed"'))
    printed, corrected = read_valve(path), read_valve("table2")
    ratio = printed.values["gap_gain"] / corrected.values["gap_gain"]
    assert ratio == pytest.approx(math.sqrt(3))
    assert "as printed form" in printed.entries["gap_gain"].source


def changed(**changes):
    return {**ENTRIES, **changes}


def without(name):
    return {key: entry for key, entry in ENTRIES.items() if key != name}


MISTAKES = {
    "unknown entry": (changed(spring_rat=("1", "N/m")), "", ["line 46", "did you mean spring_rate?"]),
    "effect's parameter": (changed(static_friction_ratio=("1.5", "1")), "", ["--effect static_friction"]),
    "unknown unit": (
        changed(spring_rate=("1", "N/mx")),
        "",
        ["line 6", "spring_rate", "[N/mx] is not a unit"],
    ),
    "wrong dimension": (changed(spring_rate=("1", "N*m")), "", ["line 6", "something else", "use N/m"]),
    "empty unit": (changed(spring_rate=("1", "")), "", ["line 6", "something else"]),
    "no mass": (changed(stem_mass=("0", "kg")), "", ["line 1", "stem_mass is above zero", "it is 0 kg"]),
    "negative friction": (changed(viscous_friction=("-1", "N*s/m")), "", ["line 21", "not negative"]),
    "negative spring": (changed(spring_rate=("-1", "N/m")), "", ["line 6", "not negative"]),
    "not a number": (changed(spring_rate=("nan", "N/m")), "", ["line 6", "finite"]),
    "text as number": (changed(spring_rate=('"5"', "N/m")), "", ["line 6", "without quotes"]),
    "truth as number": (changed(spring_rate=("true", "N/m")), "", ["line 6", "a value is a number"]),
    "stops crossed": (
        changed(travel_min=("50", "mm"), travel_max=("40", "mm")),
        "",
        ["travel_min is below travel_max", "0.05 m and 0.04 m"],
    ),
    "missing entry": (without("coulomb_friction"), "", ["lacks coulomb_friction", "[coulomb_friction]"]),
    "missing gap": (without("gap_gain"), "", ["lacks gap_gain"]),
    "half a nozzle": (
        without("flow_ratio") | {"nozzle_diameter": ("1", "mm")},
        "",
        ["lacks orifice_flow_coefficient"],
    ),
    "given and derived": (
        changed(coil_turns=("24000", "1")),
        "",
        ["not both", "delete gap_gain, or coil_turns"],
    ),
    "other exponent": (changed(ansatz_exponent=("3", "1")), "", ["the ansatz exponent is 2"]),
    "no unit": (
        ENTRIES,
        "[spring_preload]\nvalue = 1\nsource = 'x'\n",
        ["line 45", "has no unit", "add unit"],
    ),
    "no source": (ENTRIES, "[spring_preload]\nvalue = 1\nunit = 'N'\n", ["line 45", "has no source"]),
    "empty source": (ENTRIES, "[spring_preload]\nvalue = 1\nunit = 'N'\nsource = ' '\n", ["say where"]),
    "more in an entry": (ENTRIES, "[spring_preload]\nvalu = 1\n", ["it has 'valu'"]),
    "plain number": ({}, "spring_preload = 5\n", ["line 1", "it is 5", "write a table [spring_preload]"]),
    "syntax": (ENTRIES, "[spring_preload\n", ["TOML", "line 45"]),
    "wrong form": ({}, "equations = 'printed'\n", ["line 1", "'corrected' or 'as printed'"]),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistake_is_named_with_its_line(mistake, tmp_path):
    entries, more, words = MISTAKES[mistake]
    with pytest.raises(InputError) as error:
        read_valve(write(tmp_path, entries, more))
    for word in words:
        assert word in str(error.value), f"{word!r} not in {error.value}"


def test_unknown_set_and_missing_file(tmp_path):
    with pytest.raises(InputError, match="did you mean calibrated"):
        read_valve("calibrate")
    with pytest.raises(InputError, match="No such file"):
        read_valve(tmp_path / "none.toml")
    with pytest.raises(InputError, match="--model"):
        read_valve(tmp_path / "model.json")
    (tmp_path / "latin.toml").write_bytes(b"what = '\xe9'")
    with pytest.raises(InputError, match="UTF-8"):
        read_valve(tmp_path / "latin.toml")
