"""Readings that leave and come back as no stem does are left out; a stem's own motion never is."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.blindtest.plants import draw_plant, measure
from identification.driving.timing import experiments_of
from identification.mending.spikes import spikes, without_spikes
from valvemodel.records import Record

SIGNALS = measure(draw_plant(21, ()), 8, duration=90.0)


def record_of(position: np.ndarray) -> Record:
    return Record.from_arrays(name="spiky", **{**SIGNALS, "position": position})


@pytest.mark.parametrize("length", [1, 2, 3])
@pytest.mark.parametrize("size", [-0.05, 0.02])
def test_spikes_are_left_out_and_nothing_else(length: int, size: float):
    position = SIGNALS["position"].copy()
    starts = np.arange(100, len(position) - 100, 431)
    rows = (starts[:, None] + np.arange(length)).ravel()
    position[rows] += size
    found, (note,) = without_spikes(record_of(position))
    left_out = np.flatnonzero(np.isnan(found.position))
    assert np.isin(left_out, rows).all()
    assert len(left_out) >= 0.9 * len(rows)
    assert f"{len(left_out)} reading(s)" in note
    (experiment,), notes = experiments_of([record_of(position)])
    assert np.isnan(experiment.position).sum() == len(left_out)
    assert note in notes


@pytest.mark.parametrize("effects", [(), ("stribeck",), ("static_friction", "sensor_lag"), ("quantisation",)])
def test_a_stem_has_no_spikes(effects: tuple[str, ...]):
    for seed in (3, 4):
        signals = measure(draw_plant(seed, effects), 5)
        assert not spikes(signals["position"], signals["current"]).any()


def test_a_pulse_of_the_current_makes_no_spike():
    current, position = np.full(200, 8e-3), np.full(200, 0.05)
    current[100:102] = 16e-3
    position[101:103] = 0.15
    assert not spikes(position, current).any()
    assert spikes(position, np.full(200, 8e-3) + 1e-3 * (np.arange(200) > 150)).sum() == 2


def test_what_comes_often_is_no_fault():
    position = SIGNALS["position"].copy()
    position[::25] += 0.05
    record = record_of(position)
    assert without_spikes(record) == (record, [])
