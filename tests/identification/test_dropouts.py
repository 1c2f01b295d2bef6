"""A current that fails for a few rows stays as it was where the stem does not answer; what drove the valve does not."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.blindtest.plants import draw_plant, measure
from diagnosis.blindtest.valve import integrate
from identification.driving.timing import experiments_of
from identification.mending.dropouts import without_dropouts
from valvemodel.records import Record

PLANT = draw_plant(21, ())
SIGNALS = measure(PLANT, 8, duration=90.0)
STARTS = np.arange(200, len(SIGNALS["time"]) - 100, 431)


def failing(length: int, reading: float) -> np.ndarray:
    """Return the current with failures of so many rows. [A]"""
    current = SIGNALS["current"].copy()
    current[(STARTS[:, None] + np.arange(length)).ravel()] = reading
    return current


def record_of(**signals: np.ndarray) -> Record:
    return Record.from_arrays(name="loose", **{**SIGNALS, **signals})


@pytest.mark.parametrize("length", [1, 3])
@pytest.mark.parametrize("reading", [0.0, 24e-3])
def test_a_current_that_was_not_measured_stays_as_it_was(length: int, reading: float):
    found, (note,) = without_dropouts(record_of(current=failing(length, reading)))
    before = np.repeat(SIGNALS["current"][STARTS - 1], length)
    lost = (STARTS[:, None] + np.arange(length)).ravel()
    assert np.array_equal(found.current[lost], before)
    assert np.array_equal(np.delete(found.current, lost), np.delete(SIGNALS["current"], lost))
    assert f"fails in {len(lost)} row(s)" in note
    (experiment,), notes = experiments_of([record_of(current=failing(length, reading))])
    assert experiment.current.min() > 3.6e-3
    assert note in notes


@pytest.mark.parametrize("length", [1, 3])
@pytest.mark.parametrize("reading", [0.0, 24e-3])
def test_a_failure_of_the_loop_drives_the_valve(length: int, reading: float):
    current = failing(length, reading)
    noise = PLANT.noise * np.random.default_rng(4).standard_normal(len(current))
    position = integrate(PLANT.base, SIGNALS["time"], current)["position"] + noise
    record = record_of(current=current, position=position)
    assert without_dropouts(record) == (record, [])


def test_what_lasts_or_comes_often_is_no_dropout():
    for current in (failing(20, 0.0), np.where(np.arange(len(SIGNALS["time"])) % 25, SIGNALS["current"], 0.0)):
        record = record_of(current=current)
        assert without_dropouts(record) == (record, [])


def test_a_record_that_begins_or_ends_without_a_current_keeps_it_so():
    current = SIGNALS["current"].copy()
    current[:2] = current[-2:] = 0.0
    record = record_of(current=current)
    assert without_dropouts(record) == (record, [])


def test_readings_that_are_missing_tell_nothing():
    position = SIGNALS["position"].copy()
    position[STARTS[1:] - 2] = np.nan
    current = failing(1, 0.0)
    assert (without_dropouts(record_of(current=current, position=position))[0].current > 0.0).all()
    position[STARTS[0] - 2] = np.nan
    record = record_of(current=current, position=position)
    assert without_dropouts(record) == (record, [])
