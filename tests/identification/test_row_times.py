"""Times that were rounded become even again, and rows that were lost are put back without a reading."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.blindtest.plants import draw_plant, measure
from identification.mending import mend
from identification.mending.row_times import evenly_timed, with_lost_rows
from identification.mending.stretches import longest_stretch
from valvemodel.records import Record

PLANT = draw_plant(21, ())


def record_of(signals: dict[str, np.ndarray], **changed: np.ndarray) -> Record:
    return Record.from_arrays(name="timed", **{**signals, **changed})


@pytest.mark.parametrize(("rate", "step"), [(60.0, 0.01), (30.0, 0.01), (50.0, 0.015), (12.0, 0.05)])
@pytest.mark.parametrize("rounded", [np.round, np.floor])
def test_rounded_times_come_evenly_again(rate: float, step: float, rounded):
    signals = measure(PLANT, 8, duration=60.0, rate=rate)
    found, (note,) = evenly_timed(record_of(signals, time=step * rounded(signals["time"] / step)))
    off = found.time - signals["time"]
    assert np.ptp(off) < 0.03 * step
    assert np.abs(off).max() < 0.75 * step
    assert f"every {1.0 / rate:.4g} s" in note


def test_lost_rows_of_rounded_times_are_counted():
    signals = measure(PLANT, 8, duration=60.0, rate=60.0)
    kept = np.random.default_rng(0).uniform(size=len(signals["time"])) > 0.02
    rows = {name: values[kept] for name, values in signals.items()}
    found, _ = evenly_timed(record_of(rows, time=np.round(rows["time"], 2)))
    assert np.ptp(found.time - rows["time"]) < 1e-3


@pytest.mark.parametrize("spread", [0.0, 0.3])
def test_times_that_are_exact_or_uneven_stay(spread: float):
    signals = measure(PLANT, 8, duration=60.0)
    time = signals["time"] + 0.02 * spread * np.random.default_rng(0).uniform(-1.0, 1.0, len(signals["time"]))
    record = record_of(signals, time=np.round(time - time[0], 3))
    assert evenly_timed(record) == (record, [])


def test_lost_rows_are_put_back_where_the_current_moved():
    signals = measure(PLANT, 8, duration=60.0)
    kept = np.random.default_rng(1).uniform(size=len(signals["time"])) > 0.01
    kept[[0, -1]] = True
    lost = record_of({name: values[kept] for name, values in signals.items()})
    whole, (note,) = with_lost_rows(lost)
    again = np.isin(np.round(signals["time"], 6), np.round(whole.time, 6))
    assert np.isnan(whole.position).sum() == again.sum() - kept.sum() > 10
    assert f"{np.isnan(whole.position).sum()} row(s) were lost" in note
    jumps = np.abs(np.diff(signals["current"], prepend=signals["current"][0])) > 1e-4
    calm = ~(jumps | np.roll(jumps, -1))[again]
    assert np.abs(whole.current - signals["current"][again])[calm].max() < 5e-5
    (found, notes), (_, gaps) = mend(lost), longest_stretch(lost)
    assert np.array_equal(found.time, whole.time)
    assert notes == [note]
    assert gaps == []


def test_times_that_jitter_by_less_than_a_row_lack_none():
    signals = measure(PLANT, 8, duration=60.0)
    off = np.random.default_rng(3).uniform(-0.4, 0.4, len(signals["time"])) * 0.02
    record = record_of(signals, time=signals["time"] + off)
    assert with_lost_rows(record) == (record, [])


def test_a_logger_that_writes_changes_only_has_lost_nothing():
    signals = measure(PLANT, 8, duration=60.0)
    kept = np.random.default_rng(2).uniform(size=len(signals["time"])) > 0.5
    record = record_of({name: values[kept] for name, values in signals.items()})
    assert with_lost_rows(record) == (record, [])
