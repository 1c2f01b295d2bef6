"""Several records of one valve are of one kind, at either door, and each has a name of its own."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis import diagnose
from identification import fit_records
from valvemodel.errors import InputError
from valvemodel.loops import settle_loop
from valvemodel.model import Model
from valvemodel.records import Record
from valvemodel.records.several import told_apart
from valvemodel.valves import read_valve

TIME = np.arange(500) / 50.0
WAY = 0.1 + 0.05 * np.sin(TIME)
RECORDS = {
    "time": Record.from_arrays("timed", time=TIME, current=0.05 * WAY, position=WAY),
    "loop": Record.from_arrays("settled", current=0.05 * WAY, position=WAY),
    "stem": Record.from_arrays("pulled", time=TIME, force=1e3 * WAY, position=WAY),
}


@pytest.mark.parametrize("door", [fit_records, diagnose])
@pytest.mark.parametrize(("first", "second"), [("time", "stem"), ("stem", "time"), ("time", "loop"), ("loop", "stem")])
def test_records_of_several_kinds_are_refused(door, first: str, second: str) -> None:
    valve = read_valve("calibrated")
    with pytest.raises(InputError, match="records of one run have one kind") as caught:
        door([RECORDS[first], RECORDS[second]], Model(valve.name, valve.values))
    for kind in (first, second):
        assert f"{RECORDS[kind].name} is " in caught.value.arrived


@pytest.mark.parametrize("door", [fit_records, diagnose])
def test_no_record_is_refused(door) -> None:
    valve = read_valve("calibrated")
    with pytest.raises(InputError, match="at least one record"):
        door([], Model(valve.name, valve.values))


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (["a", "b"], ["a", "b"]),
        (["r", "r", "s", "r"], ["r", "r (2)", "s", "r (3)"]),
        (["r", "r", "r (2)"], ["r", "r (3)", "r (2)"]),
    ],
)
def test_records_that_are_named_alike_are_told_apart(given: list[str], told: list[str]) -> None:
    records = [Record.from_arrays(name, current=[0.004]) for name in given]
    assert [record.name for record in told_apart(records)] == told


def test_each_record_of_a_fit_has_its_start_though_named_alike() -> None:
    valve = read_valve("calibrated")
    model = Model(valve.name, valve.values)
    currents = [1e-3 * np.concatenate([np.linspace(low, 18.0, 30), np.linspace(18.0, low, 30)]) for low in (6.0, 8.0)]
    loops = [Record.from_arrays("r", current=each, position=settle_loop(model, current=each)) for each in currents]
    content = fit_records(loops, model).as_json()
    assert content["records"] == list(content["start_positions"]) == ["r", "r (2)"]
    first, second = (each["value"] for each in content["start_positions"].values())
    assert first < second
