"""The measured and blind records that lie beside the project."""

import os
import time
from pathlib import Path

import numpy as np
import pytest

from valvemodel.records import Record, read_record, write_table

DATA = Path(os.environ.get("VALVEMODEL_DATA", Path(__file__).parents[3] / "shared" / "data"))

needs_data = pytest.mark.skipif(not DATA.is_dir(), reason=f"no data: neither VALVEMODEL_DATA nor {DATA}")


@needs_data
@pytest.mark.parametrize("number", range(1, 7))
@pytest.mark.parametrize("part", "ab")
def test_field_record_reads_without_warnings(number, part):
    record = read_record(DATA / "field" / f"field-{number}{part}.csv")
    assert record.kind == "time"
    assert len(record) == 7500
    assert record.interval == pytest.approx(0.02)
    assert (record.pressure is not None) == (number in (4, 5))
    assert record.warnings == ()
    assert 0.003 < record.current.min() < record.current.max() < 0.021


@needs_data
def test_emps_is_a_record_of_the_stem_alone():
    record = read_record(DATA / "emps" / "emps.csv")
    assert record.kind == "stem"
    assert len(record) == 24841
    assert record.interval == pytest.approx(1e-3)
    assert record.force[0] == 89.23443
    assert record.warnings == ()


def test_long_record_reads_in_seconds(tmp_path):
    count = 300_000
    phase = np.abs((np.arange(count) / 5000) % 2 - 1)
    noise = np.random.default_rng(0).normal(0, 0.1, count)
    write_table(
        tmp_path / "long.csv",
        {
            "time [s]": np.arange(count) / 100,
            "current [mA]": 4 + 16 * phase,
            "position [mm]": 50 + 200 * phase + noise,
        },
    )
    start = time.perf_counter()
    assert len(read_record(tmp_path / "long.csv")) == count
    # a million rows take under two seconds on an idle core; the bound leaves room for a busy one
    assert time.perf_counter() - start < 6


def test_some_rows_of_a_record_are_a_record():
    whole = Record.from_arrays("part", time=[0, 1, 2, 3], current=[4, 5, 6, 7], position=[0, 2, 4, 6], warnings=("w",))
    part = whole.at_rows(slice(1, None, 2))
    assert (part.name, part.warnings, part.pressure, len(part)) == ("part", ("w",), None, 2)
    assert [signal.tolist() for signal in (part.time, part.current, part.position)] == [[1, 3], [5, 7], [2, 6]]
