"""Columns that are called otherwise in a file: told by name, with their unit; and what an error says of likely ones."""

import numpy as np
import pandas
import pytest

from valvemodel import InputError, read_record

ROWS = "\n".join(f"{0.1 * n:.1f};{4 + 0.01 * n:.2f};{2.0 * n:.1f}" for n in range(60))


def written(folder, header, rows=ROWS, title=""):
    path = folder / "logger.csv"
    path.write_text(f"{title}{header}\n{rows}\n", encoding="utf-8")
    return path


def test_columns_are_found_by_what_they_are_called(tmp_path):
    path = written(tmp_path, "Zeit [s];Strom [mA];Stellung [mm]", title="Valve 12\n")
    record = read_record(path, columns={"time": "Zeit", "current": "Strom [mA]", "position": "stellung"})
    assert record.time[1] == pytest.approx(0.1)
    assert record.current[0] == pytest.approx(4e-3)
    assert record.position[-1] == pytest.approx(0.118)


def test_a_unit_that_is_told_counts(tmp_path):
    path = written(tmp_path, "t [s];OP;PV [%]")
    record = read_record(path, columns={"time": "t", "current [mA]": "OP", "position [mm]": "PV [%]"})
    assert record.current[0] == pytest.approx(4e-3)
    assert record.position[-1] == pytest.approx(0.118)


def test_a_column_that_is_named_goes_before_one_of_that_name(tmp_path):
    rows = "\n".join(f"{0.1 * n:.1f},{4 + 0.01 * n:.2f},7.0,{2.0 * n:.1f}" for n in range(60))
    path = written(tmp_path, "time [s],current [mA],position [mm],travel [mm]", rows)
    assert read_record(path, columns={"position": "travel"}).position[-1] == pytest.approx(0.118)


def test_a_table_of_pandas_has_columns_that_are_called_otherwise():
    table = pandas.DataFrame({"t": np.arange(60) * 0.1, "i": 4 + np.arange(60) * 0.01, "y": 2.0 * np.arange(60)})
    record = read_record(table, columns={"time [s]": "t", "current [mA]": "i", "position [mm]": "y"})
    assert record.position[-1] == pytest.approx(0.118)


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ({"strom": "Strom"}, "a column must be one of the known ones"),
        ({"current": "Storm [mA]"}, "did you mean 'Strom"),
        ({"current": "Strom", "current [mA]": "Stellung"}, "current came twice"),
        ({"current": "Strom", "position": "strom"}, "came as current and position"),
    ],
)
def test_what_is_not_there_is_said(tmp_path, columns, said):
    path = written(tmp_path, "Zeit [s];Strom [mA];Stellung [mm]")
    with pytest.raises(InputError, match=said):
        read_record(path, columns=columns)


def test_all_likely_columns_are_named_at_once(tmp_path):
    path = written(tmp_path, "Zeit [s];Strom [mA];Stellung [mm]")
    with pytest.raises(InputError) as error:
        read_record(path)
    for told in ("'time=Zeit [s]'", "'current=Strom [mA]'", "'position=Stellung [mm]'"):
        assert told in error.value.remedy


def test_a_unit_that_is_there_is_kept_in_the_remedy(tmp_path):
    path = written(tmp_path, "time [s];OP [%];position [%]")
    with pytest.raises(InputError, match=r"'current \[%\]'"):
        read_record(path)
