"""Records that lost rows: the longest stretch in which no movement is lost counts."""

from dataclasses import replace

import numpy as np
import pytest

from identification.experiment import experiment_of
from identification.mending.stretches import longest_stretch
from identification.results.regimes import words_of
from valvemodel.records import Record


def record_without(lost: slice) -> Record:
    """A record of 30 s at 50 Hz in which a steadily moving valve lost some rows."""
    time = np.arange(1500) / 50.0
    noise = 1e-4 * np.random.default_rng(0).standard_normal(len(time))
    signals = {"time": time, "current": 4e-3 + 4e-4 * time, "position": 0.005 * time + noise, "pressure": 1e3 * time}
    return Record("valve", **{name: np.delete(values, lost) for name, values in signals.items()})


@pytest.mark.parametrize(("lost", "kept"), [(slice(400, 900), (18.0, 29.98)), (slice(1000, 1200), (0.0, 19.98))])
def test_longest_stretch_is_kept_and_the_rest_named(lost, kept):
    cut, notes = longest_stretch(record_without(lost))
    assert (cut.time[0], cut.time[-1]) == pytest.approx(kept)
    assert len(cut.position) == len(cut.pressure) == len(cut.current) == len(cut.time)
    assert len(notes) == 1
    assert "1 gap" in notes[0]


def test_a_whole_record_stays_as_it_is():
    record = record_without(slice(0, 0))
    assert longest_stretch(record) == (record, [])


def test_rows_that_were_left_out_because_nothing_changed_are_no_gap():
    record = record_without(slice(0, 0))
    held = np.minimum(record.time, np.maximum(8.0, record.time - 10.0))
    resting = replace(record, current=4e-3 + 4e-4 * held, position=record.position + 0.005 * (held - record.time))
    kept = (record.time <= 8.0) | (record.time > 18.0)
    shorter = Record("valve", **{name: getattr(resting, name)[kept] for name in ("time", "current", "position")})
    assert len(shorter.time) == 1000
    assert longest_stretch(shorter) == (shorter, [])


def test_times_are_told_as_the_record_has_them():
    """A stretch, and a record that does not begin at 0, keep the times of their file."""
    record = record_without(slice(0, 0))
    later = replace(record, time=record.time + 1000.0)
    for reads_at_end in (False, True):
        experiment = experiment_of(later, reads_at_end=reads_at_end)
        assert experiment.time[0] == 0.0
        rows = slice(1, None) if reads_at_end else slice(None)
        assert experiment.record_time[rows] == pytest.approx(later.time, abs=1e-9)
    experiment = experiment_of(later)
    end = 1000.0 + (later.time[-1] - later.time[0]) / 3.0
    assert words_of([experiment])["early"] == f"in the first third of the record, before {end:.0f} s"
