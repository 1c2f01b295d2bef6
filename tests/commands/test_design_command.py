"""`valvemodel design` writes an input that simulate takes, and its promises beside it."""

import json

import pytest


@pytest.fixture
def quick(monkeypatch):
    """A search of few generations."""
    from identification.design import search

    monkeypatch.setattr(search, "GENERATIONS", 3)


@pytest.fixture
def model_file(tmp_path):
    from valvemodel import Model, read_valve

    valve = read_valve("calibrated")
    Model(valve.name, valve.values).write(tmp_path / "model.json")
    return "model.json"


def test_input_and_promises_are_written(command, quick, model_file, tmp_path):
    result = command(
        "design", "--model", model_file, "--for", "k,f_v", "--duration", "30", "--repetitions", "3", "--out", "next.csv"
    )
    assert result.exit_code == 0, result.output
    content = json.loads((tmp_path / "next.json").read_text())
    assert content["schema"] == "valvemodel.design/1"
    assert set(content["parameters"]) == {"spring_rate", "viscous_friction"}
    for each in content["parameters"].values():
        assert each["std_observed"] > 0.0
    damping = content["parameters"]["viscous_friction"]
    assert 0.0 < damping["std_design"] < 0.5 * damping["std_standard_ramp"]
    assert content["limits"]["rate"]["value"] is None
    assert "spring_rate" in result.stdout
    result = command("simulate", "--model", model_file, "--input", "next.csv", "--out", "out.csv")
    assert result.exit_code == 0, result.output


def test_limits_are_kept(command, quick, model_file, tmp_path):
    import polars

    words = ["--range", "8 mA", "16 mA", "--rate", "2 mA/s", "--dwell", "1 s", "--period", "50 ms", "--criterion", "A"]
    result = command("design", "--model", model_file, "--for", "k", "--duration", "40 s", "--repetitions", "0", *words,
                     "--out", "next.csv")  # fmt: skip
    assert result.exit_code == 0, result.output
    table = polars.read_csv(tmp_path / "next.csv")
    assert table.columns == ["time [s]", "current [mA]"]
    assert table["current [mA]"].min() >= 8.0
    assert table["current [mA]"].max() <= 16.0
    assert table["current [mA]"].diff().abs().max() <= 2.0 * 0.05 + 1.01e-4
    assert json.loads((tmp_path / "next.json").read_text())["parameters"]["spring_rate"]["std_observed"] is None


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--for", "S_1", "--out", "next.csv"), "held as given"),
        (("--for", "k", "--range", "20 mA", "4 mA", "--out", "next.csv"), "the lower first"),
        (("--for", "k", "--duration", "a while", "--out", "next.csv"), "number"),
        (("--for", "k", "--noise", "0 mm", "--out", "next.csv"), "noise is positive"),
        (("--for", "k", "--out", "model.csv"), "--model"),
        (("--for", "k", "--out", "next.json"), "two files"),
    ],
)
def test_what_cannot_be_designed_ends_with_2_and_writes_nothing(command, model_file, tmp_path, words, says):
    result = command("design", "--model", model_file, *words)
    assert result.exit_code == 2, result.output
    assert says in result.stderr
    assert "Traceback" not in result.output
    assert [path.name for path in tmp_path.iterdir()] == ["model.json"]
