"""`valvemodel valves` lists the sets and says what is doubtful."""

import json

from click.testing import CliRunner

from valvemodel import read_valve
from valvemodel.commands.valves import valves


def run(*arguments):
    result = CliRunner().invoke(valves, list(arguments), catch_exceptions=False)
    assert result.exit_code == 0
    return result.output


def test_list_has_all_sets_and_says_which_has_warnings():
    output = run()
    for name in ("calibrated", "linear", "table2"):
        assert name in output
    assert "8 warnings about table2" in output
    assert "about calibrated" not in output
    assert "warning table2, pounds_as_mass" in run("table2")


def test_named_set_shows_every_entry_with_source():
    output = run("table2")
    for words in ("spring_rate", "kg/s^2", "Table 2, k", "coil_turns", "24000"):
        assert words in output
    assert "the numbers are plausible" in run("calibrated")


def test_json_is_for_machines():
    content = json.loads(run("--json"))
    assert content["schema"] == "valvemodel.valves/1"
    by_name = {valve["name"]: valve for valve in content["valves"]}
    assert by_name["calibrated"]["warnings"] == []
    assert by_name["calibrated"]["parameters"]["spring_rate"] == {"value": 52500.0, "unit": "N/m"}
    assert by_name["calibrated"]["parameters"]["travel_max"]["value"] is None
    assert {"check", "text"} == set(by_name["table2"]["warnings"][0])


def test_file_of_a_set_is_a_form_for_another_valve(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(run("calibrated", "--toml").replace("value = 5.25e4", "value = 300e3"))
    assert read_valve(path).values == {**read_valve("calibrated").values, "spring_rate": 300e3}


def test_toml_is_of_one_set():
    for words in (["--toml"], ["calibrated", "linear", "--toml"], ["calibrated", "--toml", "--json"]):
        assert CliRunner().invoke(valves, words).exit_code == 2


def test_file_cannot_put_markup_on_the_terminal(tmp_path):
    from importlib import resources

    text = (resources.files("valvemodel.valves") / "calibrated.toml").read_text()
    path = tmp_path / "mine.toml"
    path.write_text(text.replace("Table 2, m", "[red]x[/nonsense]\\u001b[31m"))
    output = run(str(path))
    assert "[red]x[/nonsense]" in output
    assert "\x1b" not in output


def test_help_has_an_example():
    assert "valvemodel valves table2" in run("--help")
