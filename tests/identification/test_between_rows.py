"""A current that moves on between the rows of a slow logger is told from one that is held, and followed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.blindtest.plants import draw_plant, measure
from diagnosis.trying.unrecorded import with_unrecorded
from identification.driving import between_rows
from identification.driving.between_rows import (
    COUNTS,
    FAR_APART,
    answers_in_row,
    doubts_of,
    followed_anew,
    jumps_between,
    lates_of,
    moving_between_rows,
    moving_on,
    said_of_motion,
    unknown_if_held,
)
from identification.driving.timing import END_OF_PERIOD, are_read_at_end, experiments_of
from identification.experiment import Experiment, score_rows, simulate_rows
from identification.fit import Fit, fit_base
from identification.fitting import fit_records
from identification.problem import SEARCH_TOLERANCE
from valvemodel.model import Model
from valvemodel.periods import finer, jumps, passing, passing_otherwise
from valvemodel.records import Record
from valvemodel.valves import read_valve

SEED, PROFILE, SLOWER = 21, 8, 5


def record_of(signals: dict[str, np.ndarray], every: int = 1) -> Record:
    return Record.from_arrays(name="slow", **{name: values[::every] for name, values in signals.items()})


@pytest.fixture(scope="module")
def given() -> Model:
    valve = read_valve("calibrated")
    return Model(valve.name, valve.values)


@pytest.fixture(scope="module")
def driven() -> dict[str, np.ndarray]:
    """What a plant without an effect does, driven and read fifty times a second."""
    return measure(draw_plant(SEED, ()), PROFILE, duration=90.0)


@pytest.fixture(scope="module")
def slow(driven) -> Record:
    """The same, every fifth row of it."""
    return record_of(driven, SLOWER)


def held_and_base(record: Record, given: Model) -> tuple[list[Experiment], Fit]:
    experiments, _ = experiments_of([record])
    return experiments, fit_base(given, experiments)


def missed(experiment: Experiment, given: Model) -> float:
    """Return what a base fitted to an experiment misses of it. [m]"""
    run = fit_base(given, [experiment]).simulated_on(experiment)
    return float(np.sqrt(np.nanmean((experiment.position - run.position[0]) ** 2)))


def test_a_curve_through_samples_is_near_what_was_sampled_and_follows_ramps():
    places = np.arange(60.0)
    middles = np.append((np.arange(59 * 4) + 0.5) / 4.0, 59.0)
    wave = passing(np.sin(places / 4.0), 4)
    assert np.abs(wave - np.sin(middles / 4.0)).max() < 4e-3
    straight = np.interp(middles, places, np.sin(places / 4.0))
    assert np.abs(wave - np.sin(middles / 4.0)).max() < 0.6 * np.abs(straight - np.sin(middles / 4.0)).max()
    ramp = np.abs(places - 30.0)
    off = np.abs(passing(ramp, 4) - np.abs(middles - 30.0))
    assert off.max() < 0.15
    assert off[np.abs(middles - 30.0) > 1.0] == pytest.approx(0.0, abs=1e-9)


def test_a_late_signal_is_the_same_later():
    ramp = np.arange(30.0)
    assert passing(ramp, 2, 0.5)[1:-1] == pytest.approx(passing(ramp, 2)[1:-1] - 0.5)


def test_a_jump_is_no_curve_and_may_come_at_once_or_at_the_last():
    signal = np.where(np.arange(20) < 9, 0.0, 1.0) + 1e-3 * np.sin(np.arange(20.0))
    assert np.flatnonzero(jumps(signal)).tolist() == [8]
    assert passing(signal, 4)[32:36] == pytest.approx([0.125, 0.375, 0.625, 0.875], abs=2e-3)
    straight, _, at_once, at_last = passing_otherwise(signal, 4)
    assert straight[32:36] == pytest.approx(passing(signal, 4)[32:36])
    before, after = signal[8] - signal[7], signal[10] - signal[9]
    assert at_once[32:36] == pytest.approx(signal[9] - after * np.array([0.875, 0.625, 0.375, 0.125]))
    assert at_last[32:36] == pytest.approx(signal[8] + before * np.array([0.125, 0.375, 0.625, 0.875]))
    assert at_once[:32] == pytest.approx(passing(signal, 4)[:32])


def test_a_sharp_turn_may_go_on_to_its_tip_and_a_round_one_does_not():
    places = np.arange(40.0)
    _, tipped, *_ = passing_otherwise(-np.abs(places - 20.5), 4)
    assert tipped.max() == pytest.approx(0.0, abs=1e-9)
    assert passing(-np.abs(places - 20.5), 4).max() < -0.2
    round_turn = np.cos((places - 20.5) / 4.0)
    straight, tipped, *_ = passing_otherwise(round_turn, 4)
    assert np.array_equal(tipped, straight)


def test_a_run_stands_at_the_rows_of_a_finer_one(slow, given):
    (held,), _ = experiments_of([slow])
    moved = replace(moving_on(held), late=0.2)
    time, current = moved.drive
    assert time == pytest.approx(finer(moved.time, SLOWER))
    nothing = np.full(len(time), np.nan)
    fine = replace(
        moved, time=time, current=current, position=nothing, block=np.zeros(len(time), int), parts=1, late=0.0
    )
    rows = given.rows(start_position=moved.first_reading)
    run = simulate_rows(moved, rows.copy(), tolerance=SEARCH_TOLERANCE, with_pressure=True)
    finely = simulate_rows(fine, rows.copy(), tolerance=SEARCH_TOLERANCE, with_pressure=True)
    for name in ("position", "pressure", "mode"):
        assert np.array_equal(getattr(run, name), getattr(finely, name)[:, ::SLOWER])
    square = np.sum(((moved.position - run.position[0]) / moved.noise) ** 2)
    used = np.ones(len(moved.time), bool)
    assert score_rows(moved, used, rows.copy(), tolerance=SEARCH_TOLERANCE)[0] == pytest.approx(square, rel=1e-6)


def test_a_current_that_moved_on_unseen_is_followed_to_the_noise(driven, slow, given):
    (as_driven,), _ = experiments_of([record_of(driven)])
    experiments, base = held_and_base(slow, given)
    assert jumps_between(moving_on(experiments[0]))
    (moved,) = moving_between_rows(experiments, base)
    (note,) = said_of_motion([END_OF_PERIOD], [moved], experiments)
    assert "between the rows" in note
    assert np.array_equal(moved.current, slow.current)
    assert moved.record_time == pytest.approx(slow.time)
    kept = np.isfinite(moved.position)
    assert np.array_equal(moved.position[kept], slow.position[kept])
    assert kept.mean() > 0.5
    assert moved.late == pytest.approx(0.5 / SLOWER, abs=0.05)
    assert missed(experiments[0], given) > 5.0 * as_driven.noise
    assert missed(moved, given) < 1.2 * as_driven.noise


@pytest.mark.parametrize("rate", [1.0, 5.0, 10.0, 50.0])
@pytest.mark.parametrize("reads_at_end", [False, True])
def test_a_current_that_is_held_from_row_to_row_stays_so(rate, reads_at_end, given):
    signals = measure(draw_plant(SEED, ()), PROFILE, duration=90.0, rate=rate)
    if reads_at_end:
        signals = {name: values[1:] if name == "position" else values[:-1] for name, values in signals.items()}
    experiments, base = held_and_base(record_of(signals), given)
    assert rate == 1.0 or len(answers_in_row(moving_on(experiments[0]))) >= 3
    assert moving_between_rows(experiments, base) == experiments
    assert said_of_motion([END_OF_PERIOD], experiments, experiments) == [END_OF_PERIOD] * reads_at_end


def test_rows_that_miss_what_the_current_did_say_nothing_of_a_record_at_another_pace(driven, slow):
    as_driven = record_of(driven)
    without_steps = Record.from_arrays(
        name="calm", time=as_driven.time[:400], current=np.full(400, 8e-3), position=as_driven.position[:400]
    )
    assert are_read_at_end([as_driven, slow]) == [False, True]
    assert are_read_at_end([slow, slow]) == [True, True]
    assert are_read_at_end([without_steps, slow]) == [True, True]
    assert are_read_at_end([without_steps, as_driven]) == [False, False]


def test_what_one_record_shows_is_true_of_another_at_its_pace(driven, slow, given):
    still = record_of({name: values[5 : 5 * 300 : 5] for name, values in driven.items()})
    (first, second), _ = experiments_of([slow, still])
    base = fit_base(given, [first])
    alone = replace(second, current=np.full(len(second.time), second.current[0]), reads_at_end=False)
    assert [each.parts for each in moving_between_rows([first, alone], base)] == [SLOWER, SLOWER]
    assert [each.parts for each in moving_between_rows([alone], base)] == [1]
    faster = replace(alone, time=0.2 * alone.time)
    assert [each.parts for each in moving_between_rows([first, faster], base)] == [SLOWER, 1]


def test_the_pressure_that_hangs_on_it_is_left_out_too(given):
    signals = measure(draw_plant(SEED, ()), PROFILE, duration=90.0, with_pressure=True)
    experiments, base = held_and_base(record_of(signals, SLOWER), given)
    (moved,) = moving_between_rows(experiments, base)
    assert np.array_equal(np.isfinite(moved.pressure), np.isfinite(moved.position))
    run = fit_base(given, [moved]).simulated_on(moved)
    assert np.sqrt(np.nanmean((moved.pressure - run.pressure[0]) ** 2)) < 1.5 * moved.pressure_noise


@pytest.fixture(scope="module")
def very_slow(given) -> tuple[Experiment, Experiment, Fit]:
    """A valve with a bowed linkage read five times a second, its currents held and moving on, and the base for it held.

    Whether they were held does not show.
    """
    record = record_of(measure(draw_plant(8, ("linkage_nonlinearity",)), 4), 10)
    held, base = held_and_base(record, given)
    return held[0], moving_between_rows(held, base)[0], base


def test_of_slow_rows_that_is_kept_which_hangs_little_on_the_way_of_the_current(monkeypatch, very_slow, given):
    """A held current would leave it unknown by millimetres, in which the gap went unseen."""
    held, moved, base = very_slow
    assert held.parts == 1 < moved.parts
    assert unknown_if_held(held, base) > 10.0 * held.noise
    assert moved.sampling_error < COUNTS * held.noise
    assert np.isfinite(moved.position).mean() > 0.4
    (note,) = said_of_motion([], [moved], [held])
    assert FAR_APART in note
    monkeypatch.setattr(between_rows, "unknown_if_held", lambda *_: 0.0)
    assert moving_between_rows([held], base) == [held]


def test_a_base_that_misses_far_less_than_a_ramp_would_shift_shows_that_the_current_was_held(given):
    """A valve without an effect whose current is set five times a second lost all but its largest effects in that."""
    experiments, base = held_and_base(record_of(measure(draw_plant(SEED, ()), PROFILE, duration=90.0, rate=5.0)), given)
    assert not experiments[0].reads_at_end
    assert unknown_if_held(experiments[0], base) == 0.0
    soft = Model("soft", {**base.model.values, "spring_rate": 0.8 * base.model.values["spring_rate"]})
    assert unknown_if_held(experiments[0], replace(base, model=soft)) > 10.0 * experiments[0].noise
    early = replace(experiments[0], reads_at_end=True)
    assert unknown_if_held(early, base) > 10.0 * experiments[0].noise


def test_what_nobody_knows_of_one_record_says_nothing_of_another_at_its_pace(very_slow, given):
    held, _, base = very_slow
    stepped = replace(held, current=np.where(held.time < 60.0, 8e-3, 12e-3))
    first, second = moving_between_rows([held, stepped], base)
    assert first.parts > 1
    assert second is stepped


def test_what_hangs_on_the_current_is_told_by_the_fit_that_left_out_what_hangs_on_it_most(very_slow):
    """The base alone may be so lively that most hangs on it: that counted as noise, and no gap was left."""
    _, moved, base = very_slow
    lively = Model("lively", {**base.model.values, "viscous_friction": 100.0, "stem_mass": 8.0})
    doubts, _ = doubts_of(moved, replace(base, model=lively))
    assert np.sqrt(np.nanmean(doubts**2)) > 10.0 * moved.noise
    assert with_unrecorded([moved], replace(base, model=lively)) == ([moved], [])


@pytest.mark.parametrize(("unseen", "is_taken"), [(0.9, True), (1.1, False)])
def test_a_fit_by_which_more_would_go_unseen_tells_nothing_anew(monkeypatch, very_slow, unseen, is_taken):
    held, moved, base = very_slow
    anew = replace(moved, late=moved.late + 0.1, sampling_error=unseen * moved.noise)
    monkeypatch.setattr(between_rows, "followed", lambda whole, near, lates: (anew, near))
    assert followed_anew([moved], [held], base) == [anew if is_taken else moved]


def test_rows_so_slow_that_the_current_may_be_held_may_come_late_by_half_of_one(slow, very_slow):
    """A held one does, in the mean: taken for one that comes a quarter late it was given a lag beside what is there."""
    held, *_ = very_slow
    (quick,), _ = experiments_of([slow])
    assert (lates_of(held)[-1], lates_of(quick)[-1]) == (0.5, 0.25)


@pytest.mark.parametrize(("key", "count"), [("presliding", 1), ("choked_flow", 0)])
def test_what_takes_long_to_run_is_fitted_for_one_lateness(monkeypatch, very_slow, key, count):
    held, moved, base = very_slow
    near = replace(base, model=base.model.with_effect(key))
    asked = []
    monkeypatch.setattr(between_rows, "fitted_to_all", lambda fit, *_, **__: fit)
    monkeypatch.setattr(between_rows, "followed", lambda whole, near, lates: asked.append(lates) or (moved, near))
    followed_anew([moved], [held], near)
    assert [len(each) for each in asked] == [count]


@pytest.mark.parametrize("route", ["exact", "smooth"])
def test_a_fit_follows_it_and_says_so(route, slow, given):
    outcome = fit_records([slow], given, route=route)
    assert any("between the rows" in each for each in outcome.warnings)
    assert END_OF_PERIOD not in outcome.warnings
    assert outcome.rms_fitted < 1.2 * outcome.noise
    truth = draw_plant(SEED, ()).base
    found = {each.name: each for each in outcome.parameters}
    for name, error in {"spring_rate": 0.01, "coulomb_friction": 0.03}.items():
        assert found[name].value == pytest.approx(truth[name], rel=error), name
    assert found["coulomb_friction"].std > 0.0
    assert found["viscous_friction"].std is None


def test_what_hangs_on_it_is_found_without_the_steps_of_a_coarse_reading(driven, slow, given, recwarn):
    coarse = {**driven, "position": 1e-3 * np.round(1e3 * driven["position"])}
    experiments, base = held_and_base(record_of(coarse, SLOWER), given)
    (moved,) = moving_between_rows(experiments, base)
    stepped = Model("coarse", {**base.model.values}, {"quantisation": {"resolution": 1e-3, "resolution_offset": 0.0}})
    near = replace(base, model=stepped)
    smooth, with_steps = doubts_of(moved, base)[0], doubts_of(moved, near)[0]
    assert with_steps == pytest.approx(smooth, abs=1e-9)
    assert not [each for each in recwarn if issubclass(each.category, RuntimeWarning)]
