"""Hopeless data end with what is missing and what to record next; where a part can be fitted, the rest is said."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.diagnosing import diagnose
from identification.determined.adequacy import clipped_readings, turns, without_clipped
from identification.driving.timing import experiments_of
from identification.experiment import experiment_of
from identification.fitting import fit_records
from identification.results.outcome import Outcome
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.records import Record
from valvemodel.simulation import simulate
from valvemodel.valves import read_valve

TIME = np.arange(0.0, 60.0, 0.02)
TRIANGLES = 5e-3 + 12e-3 * np.abs((TIME / 15.0 + 1.0) % 2.0 - 1.0)
ONE_WAY = 5e-3 + 12e-3 * TIME / TIME[-1]
ONCE = 5e-3 + 12e-3 * (1.0 - np.abs(TIME / 30.0 - 1.0))
SMALL = 12e-3 + 1e-3 * np.sin(TIME)
WAVES = 12e-3 + 3.4e-3 * np.sin(TIME / 3.0)
NOISE = 1e-4  # m


def nominal() -> Model:
    valve = read_valve("calibrated")
    return Model(valve.name, valve.values)


def measured(current: np.ndarray, noise: float = NOISE, rows: int | None = None) -> Record:
    """A record of the nominal valve."""
    position = simulate(nominal(), time=TIME, current=current).position
    position = position + noise * np.random.default_rng(1).standard_normal(len(TIME))
    return Record.from_arrays("record", time=TIME[:rows], current=current[:rows], position=position[:rows])


def clipped(record: Record, low: float, high: float) -> Record:
    assert record.position is not None
    return Record.from_arrays(
        record.name, time=record.time, current=record.current, position=np.clip(record.position, low, high)
    )


HOPELESS = {
    "no motion": (measured(SMALL), "the stem moves in a record", "dead band"),
    "noise larger than travel": (measured(WAVES, 0.05), "more than the noise", "position transmitter"),
    "constant current": (measured(np.full(len(TIME), 0.012)), "current changes", "up and down"),
    "few rows": (measured(TRIANGLES, rows=30), "at least 40 samples", "record for longer"),
    "reverse-acting": (
        Record.from_arrays("record", time=TIME, current=TRIANGLES, position=0.1 - measured(TRIANGLES).position),
        "rises with the current",
        "rated travel less",
    ),
    "a record without its time": (
        Record.from_arrays("record", current=TRIANGLES, position=measured(TRIANGLES).position),
        "at most 2000 settled pairs",
        "'time [s]'",
    ),
    "clipped most of the time": (clipped(measured(TRIANGLES), 0.05, 0.07), "not clipped", "transmitter's range"),
}


@pytest.mark.parametrize("work", [fit_records, diagnose], ids=["fit", "diagnose"])
@pytest.mark.parametrize("case", HOPELESS)
def test_hopeless_record_is_refused_with_what_to_record(case: str, work) -> None:
    record, rule, remedy = HOPELESS[case]
    with pytest.raises(InputError) as caught:
        work([record], nominal())
    assert rule in caught.value.rule
    assert remedy in caught.value.remedy


def fitted(record: Record) -> Outcome:
    return fit_records([record], nominal())


def test_one_direction_gives_friction_no_deviation() -> None:
    outcome = fitted(measured(ONE_WAY))
    std = {each.name: each.std for each in outcome.parameters}
    assert std["coulomb_friction"] is None
    assert std["spring_rate"] is not None
    assert "one way only" in outcome.open["coulomb_friction"]
    assert any("one way only" in text and "up and down" in text for text in outcome.warnings)


def test_one_reversal_is_fitted_and_said() -> None:
    outcome = fitted(measured(ONCE))
    friction = next(each for each in outcome.parameters if each.name == "coulomb_friction")
    assert friction.value == pytest.approx(1423.0, rel=0.02)
    assert any("turns only once" in text and "up and down twice" in text for text in outcome.warnings)


def test_clipped_readings_are_left_out() -> None:
    whole = measured(TRIANGLES)
    outcome = fitted(clipped(whole, -1.0, 0.12))
    for name, value in (("spring_rate", 52500.0), ("coulomb_friction", 1423.0)):
        found = next(each for each in outcome.parameters if each.name == name)
        assert found.value == pytest.approx(value, rel=0.02)
    assert any("clipped and left out" in text and "range" in text for text in outcome.warnings)
    assert not any("clipped and left out" in text for text in fitted(whole).warnings)


def test_noise_is_that_of_what_is_not_clipped() -> None:
    clean, said = without_clipped(experiment_of(clipped(measured(TRIANGLES), -1.0, 0.12)))
    assert len(said) == 1
    assert clean.noise == pytest.approx(NOISE, rel=0.1)


def test_a_stop_and_a_coarse_reading_are_not_clipping() -> None:
    generator = np.random.default_rng(2)
    position = np.minimum(simulate(nominal(), time=TIME, current=TRIANGLES).position, 0.12)
    stopped = position + NOISE * generator.standard_normal(len(TIME))
    coarse = 2e-3 * np.round(position / 2e-3)
    for readings in (stopped, coarse, position):
        record = Record.from_arrays("record", time=TIME, current=TRIANGLES, position=readings)
        assert not clipped_readings(experiment_of(record)).any()


def test_faint_motion_is_said() -> None:
    _, notes = experiments_of([measured(WAVES, 0.01)])
    assert any("times the noise" in note for note in notes)


def test_one_record_that_says_nothing_among_others_is_a_note() -> None:
    experiments, notes = experiments_of([measured(TRIANGLES), measured(SMALL)])
    assert len(experiments) == 2
    assert any("the stem moves in a record" in note for note in notes)


def test_one_record_that_is_mostly_clipped_among_others_is_a_note() -> None:
    whole = measured(TRIANGLES)
    experiments, notes = experiments_of([whole, clipped(whole, 0.05, 0.07)])
    readings = experiments[1].position
    assert np.isfinite(readings).mean() < 0.5
    assert 0.05 < np.nanmin(readings) < np.nanmax(readings) < 0.07
    assert experiments[1].noise == pytest.approx(NOISE, rel=0.3)
    assert sum("not clipped over most of a record" in note for note in notes) == 1


@pytest.mark.parametrize(("current", "count"), [(ONE_WAY, 0), (ONCE, 1), (TRIANGLES, 3)])
def test_turns_of_the_stem(current: np.ndarray, count: int) -> None:
    assert turns(experiment_of(measured(current))) == count
