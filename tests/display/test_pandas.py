"""Tables of pandas go in as a file would, and come out as a file would hold them."""

import builtins

import numpy as np
import pandas as pd
import pytest

from valvemodel import InputError, Record, read_record

SIGNALS = ("time", "current", "pressure", "position")


@pytest.fixture
def frame(run) -> pd.DataFrame:
    return run.to_pandas()


def test_record_comes_back(frame, run):
    record = read_record(frame, name="back")
    assert record.name == "back"
    for name in SIGNALS:
        np.testing.assert_allclose(getattr(record, name), getattr(run, name), rtol=1e-15)
    pd.testing.assert_frame_equal(record.to_pandas(), frame.drop(columns="mode"), rtol=1e-15)


def test_percent_stays_percent():
    time = np.arange(0.0, 3.0, 0.1)
    record = Record.from_arrays(time=time, current=4e-3 + 1e-3 * time, position=0.1 * time, position_unit="%")
    frame = record.to_pandas()
    assert frame["position [%]"].iloc[-1] == pytest.approx(100.0 * record.position[-1])
    assert read_record(frame).position_unit == "%"


@pytest.mark.parametrize(
    "change",
    [
        lambda frame: frame.rename(columns={"current [mA]": "current_mA", "position [mm]": "position_mm"}),
        lambda frame: frame.set_index("time [s]"),
        lambda frame: frame.rename(columns={"time [s]": "time_s"}).set_index("time_s"),
        lambda frame: frame[::-1][::-1].astype({"position [mm]": "Float64"}),
        lambda frame: frame.astype({"current [mA]": str}),
    ],
    ids=["underscores", "index", "named index", "nullable", "text"],
)
def test_forms_of_a_table(frame, run, change):
    record = read_record(change(frame))
    for name in SIGNALS:
        np.testing.assert_allclose(getattr(record, name), getattr(run, name), rtol=1e-12)


def test_instants_are_seconds_from_the_first(frame, run):
    stamped = frame.assign(time=pd.Timestamp("2026-01-01") + pd.to_timedelta(frame.pop("time [s]"), unit="s"))
    np.testing.assert_allclose(read_record(stamped).time, run.time, atol=1e-9)


def test_changed_clock_is_no_gap_where_the_time_zone_is_known(frame, run):
    start = pd.Timestamp("2026-03-29 01:59:50", tz="Europe/Berlin")
    stamped = frame.assign(time=start + pd.to_timedelta(frame["time [s]"], unit="s")).drop(columns="time [s]")
    np.testing.assert_allclose(read_record(stamped).time, run.time, atol=1e-9)


def test_defects_are_named_by_row_and_column(frame):
    frame.loc[7, "position [mm]"] = np.nan
    with pytest.raises(InputError, match=r"table, row 8, column 'position \[mm\]'.*no value"):
        read_record(frame)
    with pytest.raises(InputError, match="file or a DataFrame"):
        read_record([1.0, 2.0])
    with pytest.raises(InputError, match="units are read, not guessed"):
        read_record(frame.rename(columns={"current [mA]": "current"}))


def test_fit_and_diagnosis_come_out_in_si_units(outcome, diagnosis):
    parameters = outcome.to_pandas()
    assert parameters.loc["spring_rate", "value"] == outcome.model.values["spring_rate"]
    determined = parameters[parameters.is_determined]
    assert (determined.low < determined.value).all()
    assert (determined.value < determined.high).all()
    causes = diagnosis.to_pandas()
    assert causes.probability.is_monotonic_decreasing
    assert causes.probability.sum() + diagnosis.unknown_probability == pytest.approx(1.0)
    assert {"none", "spring_hardening", "sensor_drift"} <= set(causes.index)


def test_without_pandas_the_error_says_what_to_install(record, monkeypatch):
    found = builtins.__import__

    def without(name, *others):
        if name == "pandas":
            raise ImportError(name)
        return found(name, *others)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(InputError, match=r"pip install 'valvemodel\[notebooks\]'"):
        record.to_pandas()
