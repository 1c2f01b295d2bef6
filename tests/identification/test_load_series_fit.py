"""A load that varies at will is found as a series of waves, and only where one wave does not do."""

import numpy as np
import pytest
from blind_fits import base_of_plant, fits_to_plant

from diagnosis.blindtest.chain.clock import clock_of
from diagnosis.blindtest.chain.stem import load_force
from diagnosis.blindtest.plants import draw_plant, measure, write_record
from diagnosis.trying.candidates import SERIES, freedom_of
from identification.determined.uncertainty import blocks_of
from identification.extending.extension import extend
from identification.extending.forms import adds_series
from identification.fitting import fit_records
from identification.results.display import determined_lines, parameter_table
from identification.starting.joining import joined
from identification.starting.load_series import series_over, sizes_of
from identification.starting.screening import screened
from valvemodel.effects import effect_of_key
from valvemodel.model import Model
from valvemodel.records import read_record
from valvemodel.stages.load import MOST_WAVES, load
from valvemodel.valves import read_valve

LOAD = effect_of_key("load_force")
SEEDS = [9224, 9226]


@pytest.mark.parametrize("seed", SEEDS)
def test_a_wandering_load_is_explained_to_the_noise(seed):
    plant, base, found = fits_to_plant(seed, "load_force", nuisance=True)
    assert plant.effects[0].formulation == "wander"
    noise = found.problem.noise_error
    assert base.found.error > 20.0 * noise
    assert found.found.error < 1.1 * noise
    assert found.model.effects["load_force"]["load_waves"] == MOST_WAVES
    assert freedom_of(found) == 3 + SERIES


def test_waves_that_a_glance_asks_for_beyond_their_bounds_begin_at_these():
    """Where half of a record is stuck they were asked to be many times as large, and the diagnosis broke off."""
    _, base = base_of_plant(9226, ("load_force",))
    problem, point = joined(base.problem, base.found.point, LOAD, {**LOAD.typical, "load_cosine": -15e3})
    low = LOAD.parameter("load_cosine").low
    assert problem.model.effects["load_force"]["load_cosine"] == low > -15e3
    assert problem.values(point)["load_cosine"] == pytest.approx(low)


def test_the_load_that_is_found_is_the_one_that_acted():
    plant, _, found = fits_to_plant(9226, "load_force")
    experiment = found.problem.experiments[0]
    clock = clock_of(experiment.time, 1e-3)
    acted = -load_force(clock, tuple(plant.effects))[: len(experiment.time)]
    row = found.model.rows()[0]
    told = np.array([load(row, time) for time in experiment.time])
    # A constant load is another opening of the nozzle, and nothing shows while the stem rests.
    moves = np.abs(np.gradient(experiment.position, experiment.time)) > 0.01
    error = (told - acted)[moves] - np.median((told - acted)[moves])
    assert moves.sum() > 500
    assert np.median(np.abs(error)) < 0.15 * acted.std()


def test_one_wave_is_enough_for_a_periodic_load():
    plant, _, found = fits_to_plant(9208, "load_force", nuisance=True)
    assert plant.effects[0].formulation == "sine"
    assert found.model.effects["load_force"]["load_waves"] == 1.0
    assert freedom_of(found) == 3


def test_a_series_is_not_tried_where_nothing_is_left_or_on_top_of_another():
    _, base, found = fits_to_plant(9226, "load_force")
    assert any(trial.problem.has_series for trial in screened(base, LOAD))
    done = extend(base, "load_force")
    assert done.problem.has_series
    assert not any(trial.problem.has_series and trial.gain > 0.5 * done.found.error for trial in screened(found, LOAD))


def test_a_series_lasts_longer_than_the_record():
    _, base = base_of_plant(9226, ("load_force",))
    lull, names = series_over(base.problem.experiments, LOAD)
    assert lull["load_period"] > base.problem.experiments[0].time[-1]
    assert len(names) == 2 * lull["load_waves"] == len(set(names))
    assert all(lull[name] == 0.0 for name in names)
    block = blocks_of(base)
    assert len(block) == len(base.problem.residuals(base.found.point[None, :])[0])


def test_a_ridge_foretells_blocks_that_it_has_not_seen():
    generator = np.random.default_rng(4)
    block = np.repeat(np.arange(40), 5)
    columns = generator.normal(size=(200, 60))
    truth = np.zeros(60)
    truth[:5] = generator.normal(size=5)
    wanted = columns @ truth + generator.normal(size=200)
    weights = sizes_of(columns, wanted, block)
    plain = np.linalg.lstsq(columns, wanted, rcond=None)[0]
    unseen = generator.normal(size=(1000, 60))
    missed = [np.mean((unseen @ (each - truth)) ** 2) for each in (weights, plain)]
    assert missed[0] < missed[1]


def test_a_table_of_a_fit_folds_the_series(tmp_path):
    path = tmp_path / "record.csv"
    write_record(path, measure(draw_plant(9226, ("load_force",), nuisance=False), 9233))
    valve = read_valve("calibrated")
    found = fit_records([read_record(path)], Model(valve.name, valve.values), effects=["load_force"])
    rows = [row[0] for row in parameter_table(found).rows]
    assert "load_sine" in rows
    assert [name for name in rows if name.startswith("load_sine_")] == ["load_sine_2 .. load_cosine_20"]
    assert not any("load_sine_" in line for line in determined_lines(found.determined))
    assert {each.name: each.std for each in found.parameters}["load_cosine_20"] > 0.0


@pytest.mark.parametrize("key", ["area_variation", "sensor_lag"])
def test_a_fit_with_a_series_bears_one_more_effect(key):
    _, base, found = fits_to_plant(9226, "load_force")
    further = extend(found, key)
    assert further.found.error <= found.found.error
    assert further.model.effects["load_force"]["load_waves"] == MOST_WAVES
    trials = screened(found, effect_of_key(key))
    assert not any(adds_series(found, trial) for trial in trials)
    assert any(adds_series(base, trial) for trial in screened(base, LOAD))
