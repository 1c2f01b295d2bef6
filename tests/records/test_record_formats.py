"""The same record from CSV, Parquet and MAT, in the dialects of spreadsheets and historians."""

import io

import numpy as np
import polars
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from valvemodel.errors import InputError
from valvemodel.records import Record, read_record, write_table

TIME = np.arange(60) * 0.02
PHASE = np.abs((TIME / 0.4 + 1) % 2 - 1)
CURRENT = 4 + 16 * PHASE
PRESSURE = 40 + 170 * PHASE
POSITION = 50 + 200 * PHASE
COLUMNS = {
    "time [s]": TIME,
    "current [mA]": CURRENT,
    "pressure [kPa]": PRESSURE,
    "position [mm]": POSITION,
}


def text(*, separator=",", decimal=".", header=None, end="\n", times=None):
    """Return the record as text in a dialect."""
    rows = []
    for number in range(60):
        cells = [repr(float(values[number])).replace(".", decimal) for values in COLUMNS.values()]
        if times:
            cells[0] = times[number]
        rows.append(separator.join(cells))
    return end.join([header or separator.join(COLUMNS), *rows, ""])


def assert_is_the_record(record, *, rtol=1e-15):
    np.testing.assert_allclose(record.time, TIME, rtol=rtol, atol=1e-12)
    np.testing.assert_allclose(record.current, CURRENT / 1e3, rtol=rtol)
    np.testing.assert_allclose(record.pressure, PRESSURE * 1e3, rtol=rtol)
    np.testing.assert_allclose(record.position, POSITION / 1e3, rtol=rtol)


def read(tmp_path, content, name="valve.csv", **options):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_record(path, **options)


def test_csv_parquet_and_mat_give_the_same_arrays(tmp_path):
    write_table(tmp_path / "valve.csv", COLUMNS)
    write_table(tmp_path / "valve.parquet", COLUMNS)
    names = ("time_s", "current_mA", "pressure_kPa", "position_mm")
    savemat(tmp_path / "valve.mat", dict(zip(names, COLUMNS.values(), strict=True)) | {"comment": "none"})
    for suffix in ("csv", "parquet", "mat"):
        record = read_record(tmp_path / f"valve.{suffix}")
        assert_is_the_record(record)
        for name, column in (("time", TIME), ("current", CURRENT / 1e3), ("position", POSITION / 1e3)):
            np.testing.assert_array_equal(getattr(record, name), column)
        assert record.warnings == ()
        assert record.name == "valve"


DIALECTS = {
    "semicolons": (text(separator=";"), "read with ';' between columns"),
    "German spreadsheet": (
        text(separator=";", decimal=","),
        "read with ';' between columns and ',' as decimal sign",
    ),
    "tabs": (text(separator="\t"), "read with tabs between columns"),
    "declared separator": ("sep=;\n" + text(separator=";"), "skipped 1 line(s)"),
    "comments on top": ("# logger 7\n\n" + text(), "skipped 2 line(s)"),
    "Latin-1": (
        text(header="time [s],current [mA],pressure [kPa],position [mm],Öl").encode("latin-1"),
        "read as Latin-1",
    ),
    "UTF-16": (text().encode("utf-16"), "read as UTF-16"),
    "UTF-16 without mark": (text().encode("utf-16-le"), "read as UTF-16"),
    "byte order mark": (b"\xef\xbb\xbf" + text().encode(), None),
    "Windows line ends": (text(end="\r\n"), None),
    "old Mac line ends": (text(end="\r"), None),
    "blank lines at the end": (text() + "\n\n  \n,,,\n", None),
    "quoted names": (text(header='"time [s]","current [mA]","pressure [kPa]","position [mm]"'), None),
    "round brackets": (text(header="Time (s),CURRENT (mA), Pressure (kPa) ,Position(mm)"), None),
    "spaces": (text(separator=" , "), None),
    "quoted decimal commas": (
        "\n".join([",".join(COLUMNS),
                   *(",".join(f'"{float(values[i])!r}"'.replace(".", ",") for values in COLUMNS.values())
                     for i in range(60))]),
        "read with ',' as decimal sign",
    ),
}  # fmt: skip


@pytest.mark.parametrize("dialect", DIALECTS)
def test_dialect_is_read_and_said(dialect, tmp_path):
    content, said = DIALECTS[dialect]
    record = read(tmp_path, content)
    assert_is_the_record(record)
    if said is None:
        assert record.warnings == ()
    else:
        assert said in "\n".join(record.warnings)


def test_titles_above_the_column_names_are_skipped(tmp_path):
    content = "Valve FV-101; stroke test\nExported 2026-03-01\n\n" + text()
    record = read(tmp_path, content)
    assert_is_the_record(record, rtol=1e-12)
    assert "skipped 3 line(s) before the column names" in record.warnings


def stamps(form):
    """Return the record's times of day from noon on, as a spreadsheet or historian writes them."""
    return [form.format(second=int(t), fraction=round(1000 * (t - int(t)))) for t in TIME]


CLOCKS = {
    "ISO 8601": "2026-03-01T12:00:{second:02d}.{fraction:03d}Z",
    "ISO with zone": "2026-03-01T12:00:{second:02d}.{fraction:03d}+01:00",
    "historian": "2026-03-01 12:00:{second:02d}.{fraction:03d}",
    "German": '"01.03.2026 12:00:{second:02d},{fraction:03d}"',
    "German, short year": '"01.03.26 12:00:{second:02d},{fraction:03d}"',
    "American": "3/1/2026 12:00:{second:02d}.{fraction:03d} PM",
    "PI": "01-Mar-26 12:00:{second:02d}.{fraction:03d}",
    "time of day": "12:00:{second:02d}.{fraction:03d}",
}


@pytest.mark.parametrize("header", ["time [s]", "time", "Timestamp", "Date/Time"])
@pytest.mark.parametrize("clock", CLOCKS)
def test_clock_is_read_and_said(clock, header, tmp_path):
    content = text(times=stamps(CLOCKS[clock]), header=f"{header},current [mA],pressure [kPa],position [mm]")
    record = read(tmp_path, content)
    assert_is_the_record(record, rtol=1e-12)
    assert any("time read as" in warning for warning in record.warnings)


def test_clock_runs_over_midnight_and_leap_day(tmp_path):
    rows = ["2028-02-28 23:59:59.5", "2028-02-29 23:59:59.5", "2028-03-01T00:00:00.25"]
    content = "timestamp,current [mA]\n" + "\n".join(f"{row},12" for row in rows)
    record = read(tmp_path, content, needs=("time", "current"))
    np.testing.assert_array_equal(record.time, [0, 86400, 86400.75])


def test_clock_beside_a_column_of_dates_runs_over_midnight(tmp_path):
    rows = ["2028-02-28,23:59:59.5", "2028-02-29,23:59:59.5", "2028-03-01,00:00:00.25"]
    content = "Date,Time,current [mA]\n" + "\n".join(f"{row},12" for row in rows)
    record = read(tmp_path, content, needs=("time", "current"))
    np.testing.assert_array_equal(record.time, [0, 86400, 86400.75])
    assert any("0 s is 2028-02-28 23:59:59.5" in warning for warning in record.warnings)


def test_a_column_of_dates_that_are_none_is_ignored(tmp_path):
    content = text(
        times=[f"{number},{stamp}" for number, stamp in enumerate(stamps(CLOCKS["time of day"]))],
        header="date,time,current [mA],pressure [kPa],position [mm]",
    )
    assert_is_the_record(read(tmp_path, content), rtol=1e-12)


def test_clock_of_minutes_and_seconds_is_read(tmp_path):
    rows = [("0:58.5", 4), ("1:00.25", 8), ("75:00,000", 12)]
    content = "time;current [mA]\n" + "\n".join(f"{time};{current}" for time, current in rows)
    record = read(tmp_path, content, needs=("time", "current"))
    np.testing.assert_allclose(record.time, [0.0, 1.75, 75 * 60 - 58.5], rtol=1e-15)
    assert any("time read as minutes and seconds" in warning for warning in record.warnings)


def test_parquet_may_hold_instants(tmp_path):
    start = polars.Series([0]).cast(polars.Datetime("us"))[0]
    instants = polars.Series("timestamp", (TIME * 1e6).round().astype(np.int64)).cast(polars.Datetime("us"))
    frame = polars.DataFrame([instants, *(polars.Series(k, v) for k, v in list(COLUMNS.items())[1:])])
    content = io.BytesIO()
    frame.write_parquet(content)
    record = read(tmp_path, content.getvalue(), "valve.parquet")
    assert_is_the_record(record)
    assert start is not None


@pytest.mark.parametrize(
    ("header", "factors"),
    [
        ("time [ms],current [A],pressure [bar],position [m]", (1e3, 1e-3, 1e-2, 1e-3)),
        ("time [min],current [uA],pressure [psi],position [cm]", (1 / 60, 1e3, 1 / 6.894757293168361, 0.1)),
        ("time [h],current [µA],pressure [barg],position [in]", (1 / 3600, 1e3, 1e-2, 1 / 25.4)),
    ],
)
def test_other_units_are_converted(header, factors, tmp_path):
    values = [column * factor for column, factor in zip(COLUMNS.values(), factors, strict=True)]
    write_table(tmp_path / "valve.csv", dict(zip(header.split(","), values, strict=True)))
    assert_is_the_record(read_record(tmp_path / "valve.csv"), rtol=1e-12)


def test_percent_is_of_the_signal_and_of_the_rated_travel(tmp_path):
    write_table(tmp_path / "valve.csv", {"current [%]": 100 * PHASE, "position [%]": 80 * PHASE})
    record = read_record(tmp_path / "valve.csv", rated_travel=0.25)
    np.testing.assert_allclose(record.current, CURRENT / 1e3)
    np.testing.assert_allclose(record.position, 0.2 * PHASE)
    assert record.position_unit == "m"
    record = read_record(tmp_path / "valve.csv")
    np.testing.assert_allclose(record.position, 0.8 * PHASE)
    assert record.position_unit == "%"
    assert "position stays in percent" in "\n".join(record.warnings)


def test_order_case_and_other_columns_do_not_matter(tmp_path):
    columns = {"note": ["a, b"] * 60, **dict(reversed(COLUMNS.items())), "reference [m]": POSITION}
    write_table(tmp_path / "valve.csv", columns)
    record = read_record(tmp_path / "valve.csv")
    assert_is_the_record(record)
    assert record.warnings == ()


def test_kinds_of_record(tmp_path):
    write_table(tmp_path / "loop.csv", {"current [mA]": CURRENT, "position [mm]": POSITION})
    write_table(tmp_path / "stem.csv", {"time [s]": TIME, "force [N]": PRESSURE, "position [m]": POSITION / 1e3})
    assert read_record(tmp_path / "loop.csv").kind == "loop"
    record = read_record(tmp_path / "stem.csv")
    assert record.kind == "stem"
    assert record.current is None
    np.testing.assert_array_equal(record.force, PRESSURE)
    with pytest.raises(InputError, match="two instants"):
        _ = read_record(tmp_path / "loop.csv").interval


def test_matlab_variable_needs_unit_and_one_dimension(tmp_path):
    savemat(tmp_path / "a.mat", {"time_s": TIME, "current": CURRENT, "position_mm": POSITION})
    with pytest.raises(InputError, match="column 'current' has none; write it as 'current_mA'"):
        read_record(tmp_path / "a.mat")
    savemat(tmp_path / "b.mat", {"time_s": TIME, "current_mA": np.ones((3, 20)), "position_mm": POSITION})
    with pytest.raises(InputError, match="current_mA is 3 x 20"):
        read_record(tmp_path / "b.mat")
    savemat(tmp_path / "c.mat", {"time_s": TIME, "current_mA": CURRENT[:-1], "position_mm": POSITION})
    with pytest.raises(InputError, match="current_mA 59"):
        read_record(tmp_path / "c.mat")
    bad = POSITION.copy()
    bad[3] = np.nan
    savemat(tmp_path / "d.mat", {"time_s": TIME, "current_mA": CURRENT, "position_mm": bad})
    with pytest.raises(InputError, match="row 4, column 'position_mm'"):
        read_record(tmp_path / "d.mat")


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=40))
def test_written_numbers_read_back_exactly(tmp_path_factory, numbers):
    path = tmp_path_factory.mktemp("table") / "out.csv"
    write_table(path, {"x [m]": np.array(numbers), "mode": ["stuck"] * len(numbers)})
    frame = polars.read_csv(path, infer_schema=False)
    np.testing.assert_array_equal(np.array([float(cell) for cell in frame["x [m]"]]), numbers)
    np.testing.assert_array_equal(frame["x [m]"].cast(polars.Float64).to_numpy(), numbers)


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.tuples(st.floats(1e-3, 1e3), st.floats(0, 0.1), st.floats(-1, 1)), min_size=20, max_size=60).filter(
        lambda rows: len({row[1] for row in rows}) > 1 and len({row[2] for row in rows}) > 1
    )
)
def test_written_record_reads_back_exactly(tmp_path_factory, rows):
    folder = tmp_path_factory.mktemp("record")
    steps, current, position = (np.array(column) for column in zip(*rows, strict=True))
    columns = {"time [s]": np.cumsum(steps), "current [A]": current, "position [m]": position}
    for name in ("a.csv", "a.parquet"):
        write_table(folder / name, columns)
        record = read_record(folder / name)
        np.testing.assert_array_equal(record.time, columns["time [s]"])
        np.testing.assert_array_equal(record.current, current)
        np.testing.assert_array_equal(record.position, position)


def test_table_appears_whole_or_not_at_all(tmp_path):
    path = tmp_path / "out.csv"
    path.write_text("old")
    with pytest.raises(polars.exceptions.PolarsError):
        write_table(path, {"a [m]": np.zeros(3), "b [m]": np.zeros(2)})
    assert path.read_text() == "old"
    assert [item.name for item in tmp_path.iterdir()] == ["out.csv"]
    with pytest.raises(InputError, match="folder that can be written"):
        write_table(tmp_path / "none" / "out.csv", {"a [m]": np.zeros(3)})


def test_record_of_arrays_checks_lengths_and_copies():
    current = np.array([0.004, 0.012])
    record = Record.from_arrays("two", time=[0, 1], current=current)
    current[0] = 1
    assert record.current[0] == 0.004
    with pytest.raises(ValueError, match="read-only"):
        record.current[0] = 1
    with pytest.raises(InputError, match="time 2, current 3"):
        Record.from_arrays("bad", time=[0, 1], current=[1, 2, 3])
    with pytest.raises(InputError, match="at least one signal"):
        Record.from_arrays("empty")
