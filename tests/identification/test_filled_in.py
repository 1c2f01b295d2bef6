"""Rows that an export filled in are told from measured ones, whose noise shows in each of them."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.blindtest.plants import draw_plant, measure
from diagnosis.diagnosing import diagnose
from identification.driving.timing import experiments_of
from identification.mending.filled_in import is_filled_up, measured_rows, spacing, without_filled_in
from identification.noise import noise_level
from valvemodel.model import Model
from valvemodel.records import Record
from valvemodel.valves import read_valve

EVERY = 5

SIGNALS = measure(draw_plant(21, ()), 8, duration=90.0, with_pressure=True)

ROWS = np.arange(len(SIGNALS["time"]))

FILLS = {
    "repeated": lambda signal, rows: signal[rows[np.searchsorted(rows, ROWS, side="right") - 1]],
    "straight": lambda signal, rows: np.interp(ROWS, rows, signal[rows]),
    "straight, rounded": lambda signal, rows: np.round(np.interp(ROWS, rows, signal[rows]), 7),
}

REGULAR = ROWS[::EVERY]

UNEVEN = np.unique(np.append(0, np.cumsum(np.random.default_rng(0).integers(3, 9, len(ROWS) // 5))) % ROWS[-1])


def record_of(**changed: np.ndarray) -> Record:
    return Record.from_arrays(name="filled", **{**SIGNALS, **changed})


@pytest.mark.parametrize("fill", FILLS)
@pytest.mark.parametrize("rows", [REGULAR, UNEVEN], ids=["regular", "uneven"])
def test_measured_rows_are_found(fill: str, rows: np.ndarray):
    is_measured = measured_rows(FILLS[fill](SIGNALS["position"], rows))
    inside = is_measured[1:-1]
    assert not inside[~np.isin(ROWS, rows)[1:-1]].any()
    assert inside[np.isin(ROWS, rows)[1:-1]].mean() > 0.8


@pytest.mark.parametrize("effects", [(), ("stribeck",), ("static_friction", "linkage_backlash"), ("quantisation",)])
def test_of_a_record_as_it_was_logged_all_rows_count(effects: tuple[str, ...]):
    for seed in (3, 4):
        signals = measure(draw_plant(seed, effects), 5)
        assert measured_rows(signals["position"]).all()
        record = Record.from_arrays(name="logged", **signals)
        assert without_filled_in(record) == (record, [])


@pytest.mark.parametrize("rounded", [1e-3, 1e-4, 5e-5, 1e-9])
def test_of_a_coarse_or_noiseless_reading_all_rows_count(rounded: float):
    exact = measure(draw_plant(21, ()), 8, duration=60.0)["position"]
    assert measured_rows(rounded * np.round(exact / rounded)).all()


@pytest.mark.parametrize("fill", FILLS)
def test_a_record_filled_up_as_a_whole_becomes_the_slower_one(fill: str):
    filled = {name: FILLS[fill](SIGNALS[name], REGULAR) for name in ("current", "position")}
    filled["pressure"] = 1e9 * FILLS[fill](1e-9 * SIGNALS["pressure"], REGULAR)
    slower, (note,) = without_filled_in(record_of(**filled))
    for name in ("time", "current", "position", "pressure"):
        assert getattr(slower, name) == pytest.approx(SIGNALS[name][::EVERY], rel=2e-3, abs=1e-7)
    assert "only every 5th row was measured" in note


def test_a_position_filled_up_beside_a_faster_current_is_left_where_it_was_measured():
    filled = FILLS["repeated"](SIGNALS["position"], REGULAR)
    found, (note,) = without_filled_in(record_of(position=filled))
    assert np.array_equal(found.current, SIGNALS["current"])
    assert np.isfinite(found.position).mean() == pytest.approx(1.0 / EVERY, abs=0.03)
    assert "of the rows of the position" in note
    (experiment,), _ = experiments_of([record_of(position=filled)])
    assert experiment.noise == pytest.approx(noise_level(SIGNALS["position"]), rel=0.5)
    anchored = np.isfinite(experiment.anchors)
    assert anchored.sum() > 10
    assert np.abs(experiment.anchors - SIGNALS["position"])[anchored].max() < 4.0 * experiment.noise


def test_a_current_that_moves_otherwise_is_not_filled_up():
    assert is_filled_up(FILLS["straight"](SIGNALS["current"], REGULAR), EVERY, 0)
    assert not is_filled_up(SIGNALS["current"], EVERY, 0)
    assert spacing(measured_rows(FILLS["repeated"](SIGNALS["position"], UNEVEN))) == (1, 0)


@pytest.mark.parametrize("fill", FILLS)
def test_a_valve_without_an_effect_has_none_though_its_record_was_filled_up(fill: str):
    valve = read_valve("calibrated")
    filled = {name: FILLS[fill](SIGNALS[name], REGULAR) for name in ("current", "position")}
    record = Record.from_arrays(name="filled", time=SIGNALS["time"], **filled)
    found = diagnose([record], Model(valve.name, valve.values), jobs=1)
    assert found.verdict == "none"
    assert any("only every 5th row was measured" in warning for warning in found.warnings)
