"""The stages side by side, the smallest corrections, and the map of the regimes."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from diagnosis.blindtest.plants import draw_plant, measure
from diagnosis.report.where import half_of_chain, where_section
from diagnosis.whereabouts.corrections import MOST_SAMPLES, PLACES, corrected_at, smallest_correction, stretch_of
from diagnosis.whereabouts.regime_map import COLUMNS, ROWS, regime_map
from diagnosis.whereabouts.stage_gaps import rms, stage_gaps, without_noise
from diagnosis.whereabouts.where import CORRECTED, MEASURED, where_of
from identification.experiment import Experiment, experiment_of
from identification.fit import Fit, fit_base
from valvemodel.declarations import STAGES
from valvemodel.model import Model
from valvemodel.records import Record

FRONT_EFFECTS = ("transport_delay", "asymmetric_filling", "gap_drift", "supply_droop")
BACK_EFFECTS = ("asymmetric_friction", "linkage_nonlinearity", "sensor_drift", "end_stop")


def measured_on(effects: tuple[str, ...], *, seed: int, duration: float = 100.0) -> Experiment:
    taken = measure(draw_plant(seed, effects), seed + 1000, duration=duration, with_pressure=True)
    return experiment_of(Record.from_arrays(name="plant", **taken))


def simulated_on(experiment: Experiment, base: Fit) -> Experiment:
    """Return an experiment that measured what the base simulates."""
    run = base.simulated_on(experiment)
    return replace(experiment, position=run.position[0], pressure=run.pressure[0])


@pytest.fixture(scope="module")
def plain(given: Model) -> tuple[Experiment, Fit]:
    experiment = measured_on((), seed=3)
    return experiment, fit_base(given, [experiment])


@pytest.mark.parametrize("effect", FRONT_EFFECTS)
def test_front_answers_for_its_effects(given: Model, effect: str) -> None:
    experiment = measured_on((effect,), seed=11)
    front, back = stage_gaps([experiment], fit_base(given, [experiment])).shares
    assert front is not None
    assert front > 0.8 > 0.2 > back


@pytest.mark.parametrize("effect", BACK_EFFECTS)
def test_back_answers_for_its_effects(given: Model, effect: str) -> None:
    experiment = measured_on((effect,), seed=12)
    front, back = stage_gaps([experiment], fit_base(given, [experiment])).shares
    assert back is not None
    assert back > 0.8 > 0.2 > front


def test_no_half_answers_where_nothing_is_missing(plain: tuple[Experiment, Fit]) -> None:
    experiment, base = plain
    assert stage_gaps([experiment], base).shares == (None, None)


def test_halves_add_up_to_the_whole_error(given: Model) -> None:
    experiment = measured_on(("gap_drift", "asymmetric_friction"), seed=13)
    gaps = stage_gaps([experiment], fit_base(given, [experiment]))
    whole = gaps.front[0] + gaps.back[0]
    assert rms(gaps.front) ** 2 + rms(gaps.back) ** 2 + gaps.cross_term == pytest.approx(rms([whole]) ** 2)


def test_exact_records_leave_no_gap_in_either_half(plain: tuple[Experiment, Fit]) -> None:
    experiment, base = plain
    exact = simulated_on(experiment, base)
    start = [replace(each) for each in base.unknowns]
    fit = replace(base, problem=replace(base.problem, experiments=[exact], unknowns=start))
    gaps = stage_gaps([exact], fit)
    assert rms(gaps.pressure) < 0.05 * exact.pressure_noise
    assert rms(gaps.back) < 0.05 * exact.noise
    assert rms(gaps.front) < 0.05 * exact.noise


def test_noise_goes_and_steps_stay() -> None:
    generator = np.random.default_rng(2)
    step = np.where(np.arange(2000) < 900, 0.0, 30.0)
    found = without_noise(step + generator.standard_normal(2000), 1.0)
    assert np.sqrt(np.mean((found - step) ** 2)) < 0.3
    assert abs(found[890]) < 2.0
    assert abs(found[910] - 30.0) < 2.0


@pytest.mark.parametrize("place", PLACES)
def test_corrections_find_what_was_added(given: Model, plain: tuple[Experiment, Fit], place: str) -> None:
    """A slow wave of pressure, or of the reading, is laid on top of the base's own run, and noise on all."""
    experiment, base = plain
    quiet = replace(experiment, pressure=None)
    chain_with = corrected_at(quiet, base, base.starts[0], place)
    knots = 12.0 * np.sin(np.linspace(0.0, 9.0, chain_with.hats.shape[1]))
    noise = quiet.noise * np.random.default_rng(5).standard_normal(len(quiet.time))
    waved = replace(quiet, position=chain_with.readings(knots[None, :])[0] + noise)
    missed = rms([waved.position - chain_with.reading])
    found = smallest_correction(waved, base, base.starts[0], place)
    assert missed > 5.0 * quiet.noise
    assert found.left < 1.1 * quiet.noise
    assert np.corrcoef(found.values, chain_with.hats @ knots)[0, 1] > 0.9
    assert found.freedom < 0.8 * len(knots)


def test_no_correction_where_the_noise_is_reached(plain: tuple[Experiment, Fit]) -> None:
    experiment, base = plain
    exact = replace(simulated_on(experiment, base), pressure=None)
    noise = exact.noise * np.random.default_rng(6).standard_normal(len(exact.time))
    noisy = replace(exact, position=exact.position + noise)
    for place in PLACES:
        found = smallest_correction(noisy, base, base.starts[0], place)
        assert found.freedom == 0.0
        assert not found.values.any()


def test_long_records_are_looked_at_where_they_are_missed_most(plain: tuple[Experiment, Fit]) -> None:
    experiment = plain[0]
    count = 3 * MOST_SAMPLES
    long = replace(
        experiment,
        time=0.02 * np.arange(count),
        **{name: np.zeros(count) for name in ("current", "position", "block")},
    )
    error = np.where(np.arange(count) > 2 * MOST_SAMPLES, 1.0, 0.0)
    stretch, first = stretch_of(long, error)
    assert first == 2 * MOST_SAMPLES
    assert len(stretch.time) == MOST_SAMPLES
    assert stretch.time[0] == 0.0


def test_json_names_every_stage_once(given: Model) -> None:
    experiment = measured_on(("asymmetric_friction",), seed=12, duration=60.0)
    for each, method in ((experiment, MEASURED), (replace(experiment, pressure=None), CORRECTED)):
        content = where_of([each], fit_base(given, [each])).as_json()
        json.dumps(content, allow_nan=False)
        assert [stage for entry in content["stages"] for stage in entry["stages"]] == list(STAGES)
        assert {entry["method"] for entry in content["stages"]} == {method}
        section = where_section({"where": content})
        assert len(section.rows) == len(content["stages"])
        assert section.sentences
        assert bool(half_of_chain({"where": content})) == (method == MEASURED)


def test_map_covers_the_record_twice(plain: tuple[Experiment, Fit]) -> None:
    experiment, base = plain
    run = base.simulated_on(experiment)
    found = regime_map([experiment], [experiment.position - run.position[0]], [run.mode[0]])
    assert found.rms.shape == (len(ROWS), len(COLUMNS))
    for half in (found.share[:, :3], found.share[:, 3:], found.time_share[:, :3], found.time_share[:, 3:]):
        assert half.sum() == pytest.approx(1.0)


def test_map_shows_where_an_error_is(plain: tuple[Experiment, Fit]) -> None:
    experiment, base = plain
    mode = base.simulated_on(experiment).mode[0]
    is_late_and_stuck = (mode == 0) & (experiment.time > 0.7 * experiment.time[-1])
    found = regime_map([experiment], [np.where(is_late_and_stuck, 1e-3, 0.0)], [mode])
    assert found.share[ROWS.index("stuck"), COLUMNS.index("late")] == pytest.approx(1.0)
    assert found.rms[ROWS.index("rising, later"), COLUMNS.index("early")] == 0.0
