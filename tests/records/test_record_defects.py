"""Every defect of a record is named with its line, column and value, and with what to do about it."""

import gzip
import math
from pathlib import Path

import numpy as np
import pytest

from valvemodel.errors import InputError
from valvemodel.records import read_record

HEADER = "time [s],current [mA],pressure [kPa],position [mm]"


def rows_of_a_valve(count=60):
    """Return rows of text that read well: a triangle of current, and a stem that follows it."""
    rows = []
    for number in range(count):
        phase = abs(math.remainder(number / 20, 2))
        rows.append(f"{number * 0.02:.2f},{4 + 16 * phase:.4f},{40 + 170 * phase:.3f},{50 + 200 * phase:.3f}")
    return rows


def text_of_a_valve(*, header=HEADER, change=None, count=60):
    """Return a whole file, with some data rows changed: {row from 0: text}."""
    rows = rows_of_a_valve(count)
    for number, text in (change or {}).items():
        rows[number] = text
    return "\n".join([header, *rows]) + "\n"


def cell(row, column, text):
    """Return a data row with one cell replaced."""
    cells = rows_of_a_valve()[row].split(",")
    cells[column] = text
    return {row: ",".join(cells)}


def columns(*names, count=60):
    """Return a file of some of the columns only."""
    header = HEADER.split(",")
    keep = [next(i for i, text in enumerate(header) if text.startswith(name)) for name in names]
    rows = [",".join(row.split(",")[i] for i in keep) for row in [HEADER, *rows_of_a_valve(count)]]
    return "\n".join(rows) + "\n"


def scaled(name, factor, offset=0.0):
    """Return a file with one column scaled, its name kept."""
    number = [text.split()[0] for text in HEADER.split(",")].index(name)
    rows = []
    for row in rows_of_a_valve():
        cells = row.split(",")
        cells[number] = f"{float(cells[number]) * factor + offset:.8g}"
        rows.append(",".join(cells))
    return "\n".join([HEADER, *rows]) + "\n"


ERRORS = {
    "no file content": ("", ["empty"]),
    "blank content": ("\n\n \n", ["empty"]),
    "names only": (HEADER + "\n", ["at least 20 samples", "has 0"]),
    "no names": ("\n".join(rows_of_a_valve()), ["line 1", "put a line like 'time [s]"]),
    "missing unit": (
        text_of_a_valve(header="time [s],current,pressure [kPa],position [mm]"),
        ["column 'current' has none", "'current [mA]'"],
    ),
    "unit outside brackets": (
        text_of_a_valve(header="time [s],current_mA,pressure [kPa],position [mm]"),
        ["column 'current_mA' has none", "'current [mA]'"],
    ),
    "empty unit": (
        text_of_a_valve(header="time [s],current [],pressure [kPa],position [mm]"),
        ["has none", "'current [mA]'"],
    ),
    "unknown unit": (
        text_of_a_valve(header="time [s],current [mX],pressure [kPa],position [mm]"),
        ["'current [mX]'", "[mX] is not a unit", "use mA or A"],
    ),
    "unit in wrong case": (
        text_of_a_valve(header="time [s],current [mA],pressure [KPA],position [mm]"),
        ["'pressure [KPA]'", "did you mean kPa?"],
    ),
    "unit of something else": (
        text_of_a_valve(header="time [s],current [kPa],pressure [kPa],position [mm]"),
        ["'current [kPa]'", "something else", "use mA or A"],
    ),
    "absolute pressure": (
        text_of_a_valve(header="time [s],current [mA],pressure [bara],position [mm]"),
        ["gauge", "[bara] is an absolute pressure", "subtract"],
    ),
    "percent of pressure": (
        text_of_a_valve(header="time [s],current [mA],pressure [%],position [mm]"),
        ["percent is for current", "'pressure [%]'"],
    ),
    "missing column": (
        columns("time", "current", "pressure"),
        ["'position [mm]'", "has 'time [s]', 'current [mA]'"],
    ),
    "misspelt column": (
        text_of_a_valve(header="time [s],current [mA],pressure [kPa],postion [mm]"),
        ["'position [mm]'", "if 'postion [mm]' is the position, rename it, or give --column 'position=postion [mm]'"],
    ),
    "column twice": (
        text_of_a_valve(header="time [s],current [mA],Current [A],position [mm]"),
        ["one column current", "'current [mA]' and 'Current [A]'", "rename or delete"],
    ),
    "text in a number": (
        text_of_a_valve(change=cell(10, 1, "abc")),
        ["line 12", "column 'current [mA]'", "'abc' is text", "correct the cell"],
    ),
    "unit in a cell": (
        text_of_a_valve(change=cell(10, 3, "62 mm")),
        ["line 12", "column 'position [mm]'", "'62 mm'", "a unit stands in the column's name only"],
    ),
    "empty cell": (
        text_of_a_valve(change=cell(7, 2, "")),
        ["line 9", "column 'pressure [kPa]'", "the cell is empty", "drop these rows"],
    ),
    "blank line": (text_of_a_valve(change={5: ""}), ["line 7", "column 'time [s]'", "the cell is empty"]),
    "cut last line": (text_of_a_valve(change={59: "1.18,4.1"}), ["line 61", "the cell is empty"]),
    "NaN": (
        text_of_a_valve(change=cell(7, 3, "NaN")),
        ["line 9", "column 'position [mm]'", "'NaN' is no value"],
    ),
    "historian's word": (text_of_a_valve(change=cell(7, 3, "No Data")), ["line 9", "'No Data' is no value"]),
    "infinite": (text_of_a_valve(change=cell(7, 3, "inf")), ["line 9", "finite", "'inf'"]),
    "many bad cells": (
        text_of_a_valve(change=cell(7, 3, "x") | cell(9, 3, "y")),
        ["line 9", "'x' is text (and 1 more cells like it)"],
    ),
    "comma between thousands": (
        text_of_a_valve(change=cell(7, 2, '"1,234.5"')),
        ["line 9", "column 'pressure [kPa]'", "'1,234.5'", "without marks between thousands"],
    ),
    "two decimal signs": (
        text_of_a_valve(change=cell(7, 2, '"94,25"')),
        ["one decimal sign", "line 9", "'94,25'"],
    ),
    "decimal commas between commas": (
        text_of_a_valve(change={0: "0,00,4,0000,40,000,50,000"}),
        ["line 2", "8 cells, 4 column names", "decimal comma needs ';' or a tab"],
    ),
    "open quote": (text_of_a_valve(change=cell(7, 2, '"94')), ["line 9", "a quote is left open"]),
    "amperes as mA": (scaled("current", 1e-3), ["'current [mA]'", "0.02 mA", "'current [A]'"]),
    "mA as amperes": (
        text_of_a_valve(header="time [s],current [A],pressure [kPa],position [mm]"),
        ["line 22", "'current [A]'", "20 A", "'current [mA]'"],
    ),
    "impossible current": (
        text_of_a_valve(change=cell(7, 1, "9999")),
        ["line 9", "'current [mA]'", "9999 mA", "check the unit and the row"],
    ),
    "negative current": (
        text_of_a_valve(change=cell(7, 1, "-4.2")),
        ["line 9", "'current [mA]'", "-4.2 mA", "swap the wires"],
    ),
    "below vacuum": (
        text_of_a_valve(change=cell(7, 2, "-200")),
        ["line 9", "'pressure [kPa]'", "-200 kPa", "vacuum"],
    ),
    "mm as metres": (
        text_of_a_valve(header="time [s],current [mA],pressure [kPa],position [m]"),
        ["line 22", "'position [m]'", "250 m", "'position [mm]'"],
    ),
    "time goes back": (
        text_of_a_valve(change=cell(10, 0, "0.15")),
        [
            "time must increase",
            "line 12",
            "'time [s]'",
            "0.15 s after 0.18 s",
            "sort the file or drop the row",
        ],
    ),
    "time stands still": (text_of_a_valve(change=cell(10, 0, "0.18")), ["line 12", "0.18 s after 0.18 s"]),
    "whole seconds": (
        "time [s],current [mA],position [mm]\n"
        + "\n".join(f"{i // 10},{4 + i % 7},{50 + 20 * (i % 7)}" for i in range(60)),
        ["time must increase", "line 3", "fractions of a second"],
    ),
    "clock without seconds": (
        "time,current [mA],position [mm]\n"
        + "\n".join(f"01.03.2026 12:{i // 10:02d},{4 + i % 7},{50 + 20 * (i % 7)}" for i in range(60)),
        ["time must increase", "line 3", "fractions of a second"],
    ),
    "midnight": (
        "time,current [mA],position [mm]\n"
        + "\n".join(
            f"{(23 * 3600 + 3590 + i) // 3600 % 24:02d}:{59 if i < 10 else 0:02d}:{(50 + i) % 60:02d},"
            f"{4 + i % 7},{50 + 20 * (i % 7)}"
            for i in range(30)
        ),
        ["time must increase", "line 12", "starts anew at midnight"],
    ),
    "broken clock": (
        "timestamp,current [mA],position [mm]\n"
        + "\n".join(f"2026-03-01T12:00:{i:02d}Z,{4 + i % 7},{50 + 20 * (i % 7)}" for i in range(5))
        + "\n2026-03-01 noon,5,60\n",
        ["line 7", "column 'timestamp'", "'2026-03-01 noon'"],
    ),
    "no such date": (
        "timestamp,current [mA],position [mm]\n2026-02-28 12:00:00,4,50\n2026-02-31 12:00:00,5,60\n",
        ["line 3", "'2026-02-31 12:00:00'"],
    ),
    "day or month": (
        "timestamp,current [mA],position [mm]\n01/03/2026 23:59:59,4,50\n02/03/2026 00:00:00,5,60\n",
        ["day and month", "ISO 8601"],
    ),
    "too short": (text_of_a_valve(count=19), ["at least 20 samples", "has 19", "record for longer"]),
    "too few pairs": (columns("current", "position", count=5), ["at least 6 pairs", "has 5"]),
    "constant current": (
        scaled("current", 0, 12),
        ["current changes", "12 mA in all 60 rows", "drive the valve"],
    ),
    "constant pressure": (
        scaled("pressure", 0, 90),
        ["pressure changes", "90 kPa in all 60 rows", "delete the column"],
    ),
    "nothing moves": (scaled("position", 0, 120), ["the stem moves", "120 mm in all 60 rows", "transmitter"]),
    "times under another name": (
        text_of_a_valve(header=HEADER.replace("time [s]", "Zeit [s]")),
        ["'Zeit [s]' holds times", "rename it to 'time [s]'", "settled loop"],
    ),
    "dates under another name": (
        "\n".join(
            [
                "stamp,current [mA],position [mm]",
                *(f"2026-03-01 10:00:{i:02d},{4 + i % 7},{50 + i % 9}" for i in range(30)),
            ]
        ),
        ["'stamp' holds times", "rename it to 'time'"],
    ),
    "binary": ("time\x00\x01\x02", ["no text", "export it as CSV"]),
}


@pytest.mark.parametrize("defect", ERRORS)
def test_defect_is_an_error_with_place_and_remedy(defect, tmp_path):
    text, words = ERRORS[defect]
    path = tmp_path / "valve.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as error:
        read_record(path)
    for word in words:
        assert word in str(error.value), f"{word!r} not in {error.value}"


def test_undamaged_file_reads_without_warnings(tmp_path):
    path = tmp_path / "valve.csv"
    path.write_text(text_of_a_valve())
    record = read_record(path)
    assert record.kind == "time"
    assert len(record) == 60
    assert record.warnings == ()
    assert record.interval == pytest.approx(0.02)
    np.testing.assert_allclose(record.current[20], 0.020, rtol=1e-15)
    np.testing.assert_allclose(record.pressure[20], 210e3, rtol=1e-15)
    assert not record.position.flags.writeable


WARNINGS = {
    "gap in time": (
        "\n".join([HEADER, *(f"{float(r.split(',')[0]) + (5 if i >= 30 else 0)},{r.split(',', 1)[1]}"
                             for i, r in enumerate(rows_of_a_valve()))]),
        ["1 gap(s) in time", "line 32", "5.6 s after 0.58 s"],
    ),
    "irregular sampling": (
        "\n".join([HEADER, *(f"{float(r.split(',')[0]) + 0.012 * (i % 2)},{r.split(',', 1)[1]}"
                             for i, r in enumerate(rows_of_a_valve()))]),
        ["sampling is irregular"],
    ),
    "slow time": (scaled("time", 1000), ["samples are 20 s apart", "really in s"]),
    "milliseconds that are seconds": (
        text_of_a_valve(header=HEADER.replace("[s]", "[ms]")),
        ["the record lasts 0.00118 s; is the unit of time right?"],
    ),
    "outside 4..20": (scaled("current", 1.2), ["outside 4..20 mA", "line 19", "21.12 mA"]),
    "negative pressure": (scaled("pressure", 1, -45), ["negative", "line 2", "-5 kPa"]),
    "bar as kPa": (scaled("pressure", 0.01), ["is it in bar?"]),
    "absolute pressure": (scaled("pressure", 1, 101.3), ["is it absolute?"]),
    "metres as mm": (scaled("position", 1e-3), ["is it in metres?"]),
    "misspelt pressure": (
        text_of_a_valve(header="time [s],current [mA],presure [kPa],position [mm]"),
        ["'presure [kPa]' is not read", "rename it"],
    ),
    "at rest": (
        text_of_a_valve(change={i: f"{i * 0.02:.2f},{4 + i * 0.1:.3f},{40 + i},{250 if i > 55 else 50}"
                                for i in range(60)}),
        ["nearly unchanged over"],
    ),
    "coarse": (
        text_of_a_valve(change={i: f"{i * 0.02:.2f},{4 + i * 0.1:.3f},{40 + i},{50 + 40 * (i // 10)}"
                                for i in range(60)}),
        ["position is coarse: 6 different readings, 40 mm apart"],
    ),
    "clipped": (
        text_of_a_valve(change={i: f"{i * 0.02:.2f},{4 + i * 0.1:.3f},{40 + i},{min(50 + 4.1 * i, 200)}"
                                for i in range(60)}),
        ["position holds its highest value 200 mm", "is it clipped?"],
    ),
    "one way": (
        text_of_a_valve(change={i: f"{i * 0.02:.2f},{4 + i * 0.1:.3f},{40 + i},{50 + 3 * i}"
                                for i in range(60)}),
        ["current runs one way only"],
    ),
    "one turn": (text_of_a_valve(count=38), ["current turns only once"]),
    "reverse acting": (
        scaled("position", -1, 300),
        ["position falls while current rises", "the end of the travel less"],
    ),
    "force misread in a time record": (
        text_of_a_valve(header="time [s],current [mA],force [kPa],position [mm]"),
        ["column 'force [kPa]' is left out"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("doubt", WARNINGS)
def test_doubt_is_a_warning(doubt, tmp_path):
    text, words = WARNINGS[doubt]
    path = tmp_path / "valve.csv"
    path.write_text(text)
    said = "\n".join(read_record(path).warnings)
    for word in words:
        assert word in said, f"{word!r} not in {said}"


def test_a_stem_that_swings_against_its_force_is_no_reverse_acting_valve(tmp_path):
    """A mass that a force swings without a spring goes against it."""
    swing = [math.sin(0.06 * number) for number in range(500)]
    rows = [f"{0.02 * number:.2f},{-100 * each:.3f},{100 + 50 * each:.3f}" for number, each in enumerate(swing)]
    path = tmp_path / "stem.csv"
    path.write_text("\n".join(["time [s],force [N],position [mm]", *rows]) + "\n")
    assert not any("reverse" in warning for warning in read_record(path).warnings)


def test_noise_alone_is_no_motion(tmp_path):
    noise = np.random.default_rng(1).normal(120, 0.15, 400)
    rows = [f"{i * 0.02:.2f},{12 + 8 * math.sin(i / 40):.4f},{noise[i]:.3f}" for i in range(400)]
    path = tmp_path / "valve.csv"
    path.write_text("\n".join(["time [s],current [mA],position [mm]", *rows]))
    with pytest.raises(InputError, match=r"position is noise alone.*check the position transmitter"):
        read_record(path)


class TestInputOfSimulation:
    """A simulation needs time and current only."""

    def read(self, tmp_path: Path, text: str):
        path = tmp_path / "input.csv"
        path.write_text(text)
        return read_record(path, needs=("time", "current"))

    def test_constant_current_of_two_rows_will_do(self, tmp_path):
        record = self.read(tmp_path, "time [s],current [mA]\n0,12\n10,12\n")
        assert len(record) == 2
        assert record.position is None
        assert record.warnings == ()

    def test_one_row_will_not(self, tmp_path):
        with pytest.raises(InputError, match="at least 2 rows"):
            self.read(tmp_path, "time [s],current [mA]\n0,12\n")

    def test_time_is_needed(self, tmp_path):
        with pytest.raises(InputError, match=r"needs the column 'time \[s\]'"):
            self.read(tmp_path, "current [mA],position [mm]\n4,50\n5,60\n")

    @pytest.mark.parametrize("bad", ["NaN", "abc", ""])
    def test_bad_position_is_left_out_with_a_warning(self, tmp_path, bad):
        record = self.read(tmp_path, f"time [s],current [mA],position [mm]\n0,12,50\n10,12,{bad}\n")
        assert record.position is None
        assert "column 'position [mm]' is left out" in record.warnings[0]
        assert "line 3" in record.warnings[0]

    def test_bad_current_is_an_error(self, tmp_path):
        with pytest.raises(InputError, match="line 3"):
            self.read(tmp_path, "time [s],current [mA]\n0,12\n10,x\n")


def test_time_can_be_demanded(tmp_path):
    path = tmp_path / "loop.csv"
    path.write_text(columns("current", "position"))
    assert read_record(path).kind == "loop"
    with pytest.raises(InputError, match="needs the column 'time"):
        read_record(path, allow_loop=False)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("book.csv", b"PK\x03\x04rest", "Excel workbook"),
        ("packed.csv", gzip.compress(b"time", mtime=0), "gzip"),
        ("broken.parquet", b"PAR1 and no more", "a Parquet file is whole"),
        ("text.parquet", b"time [s],current [mA]", "a Parquet file is whole"),
        ("broken.mat", b"MATLAB 5.0 MAT-file" + b"\x00" * 200, "a MAT file is whole"),
        ("new.mat", b"\x89HDF\r\n\x1a\n", "-v7"),
    ],
)
def test_other_kinds_of_file_are_named(tmp_path, name, content, words):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(InputError, match=words):
        read_record(path)


def test_many_rows_are_a_warning(tmp_path, monkeypatch):
    monkeypatch.setattr("valvemodel.records.doubts._MANY_ROWS", 50)
    path = tmp_path / "valve.csv"
    path.write_text(text_of_a_valve())
    assert read_record(path).warnings == ("60 rows take long; a tenth of them may say as much",)


def test_missing_file_and_folder_are_errors(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        read_record(tmp_path / "nothing.csv")
    with pytest.raises(InputError, match="is a folder") as caught:
        read_record(tmp_path)
    assert caught.value.arrived == f"{tmp_path} is a folder"
    with pytest.raises(InputError, match="is a device"):
        read_record("/dev/null")


def test_huge_file_is_refused_before_it_is_read(tmp_path):
    path = tmp_path / "huge.csv"
    with path.open("wb") as file:
        file.truncate(3 * 1024**3)
    with pytest.raises(InputError, match=r"at most 2 GiB.*3.0 GiB"):
        read_record(path)


def test_line_is_right_behind_a_cell_of_two_lines(tmp_path):
    rows = rows_of_a_valve()
    text = "\n".join(["note," + HEADER, f'"two\nlines",{rows[0]}', *(f",{row}" for row in rows[1:10]), ",x,1,2,3"])
    path = tmp_path / "valve.csv"
    path.write_text(text)
    with pytest.raises(InputError, match="line 13"):
        read_record(path)
