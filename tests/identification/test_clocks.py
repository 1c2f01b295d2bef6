"""A position that leaves before its current was logged by another clock, and is refused with what to do."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.blindtest.plants import draw_plant, measure
from identification.driving.timing import experiments_of
from identification.mending import clocks
from identification.mending.clocks import check_clocks, rows_after_steps
from valvemodel.errors import InputError
from valvemodel.records import Record

SIGNALS = measure(draw_plant(21, ()), 8, duration=90.0)


def early(rows: int) -> Record:
    """Return a record whose position is so many rows early."""
    last = len(SIGNALS["time"]) - rows
    cut = {name: values[:last] for name, values in SIGNALS.items()}
    return Record.from_arrays(name="early", **{**cut, "position": SIGNALS["position"][rows:]})


@pytest.mark.parametrize("rows", [3, 10, 20])
def test_a_position_that_is_early_is_refused(rows: int):
    with pytest.raises(InputError, match="two clocks") as caught:
        experiments_of([early(rows)])
    assert float(caught.value.remedy.split(" s later")[0].split()[-1]) == pytest.approx(0.02 * (rows - 1), abs=0.021)


def test_shifted_by_what_is_said_it_is_taken():
    with pytest.raises(InputError) as caught:
        check_clocks(early(10))
    later = float(caught.value.remedy.split(" s later")[0].split()[-1]) + 0.02
    record = early(10)
    shifted = round(later / 0.02)
    check_clocks(
        Record.from_arrays(
            name="shifted",
            time=record.time[shifted:],
            current=record.current[shifted:],
            position=record.position[:-shifted],
        )
    )


def test_what_leaves_before_its_steps_at_any_time_shows_no_other_clock(monkeypatch):
    """A random walk, or readings full of spikes, had been refused with a shift that the median happened to be."""
    monkeypatch.setattr(clocks, "rows_after_steps", lambda record, reach: np.array([-24, -17, -9, -2, 3]))
    check_clocks(early(3))
    monkeypatch.setattr(clocks, "rows_after_steps", lambda record, reach: np.array([-9, -10, -9, 3]))
    with pytest.raises(InputError, match="two clocks"):
        check_clocks(early(3))


@pytest.mark.parametrize(
    "effects", [(), ("transport_delay",), ("stribeck",), ("load_force",), ("static_friction", "linkage_backlash")]
)
def test_a_record_by_one_clock_is_taken(effects: tuple[str, ...]):
    for seed in (3, 4, 5):
        check_clocks(Record.from_arrays(name="one clock", **measure(draw_plant(seed, effects), 5)))


def test_a_dead_time_shows_as_rows_after_the_step():
    late = np.concatenate([np.full(7, SIGNALS["position"][0]), SIGNALS["position"][:-7]])
    record, delayed = (
        Record.from_arrays(name="late", **{**SIGNALS, "position": position}) for position in (SIGNALS["position"], late)
    )
    assert np.median(rows_after_steps(delayed, 50)) == np.median(rows_after_steps(record, 50)) + 7
