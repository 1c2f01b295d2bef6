"""Several records of one valve are of one kind, at either door."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis import diagnose
from identification import fit_records
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.records import Record
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
