"""A pressure that was not measured wherever the position was, or of some records only: what is there counts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.blindtest.plants import draw_plant, measure
from diagnosis.score import score_fit
from diagnosis.whereabouts.residual_curves import curves_of_force, residual_curves
from diagnosis.whereabouts.stage_gaps import front_of
from identification.determined.uncertainty import blocks_of
from identification.driving.timing import experiments_of
from identification.experiment import Experiment, experiment_of
from identification.fit import Fit, fit_base, fitted_to_all, measured
from identification.fitting import fit_records
from identification.holdout import hold_out
from identification.smooth_fit.residuals import SmoothResiduals
from valvemodel.model import Model
from valvemodel.records import Record

PLANT = draw_plant(3, ())


def recorded(profile: int, *, with_pressure: bool, name: str = "record") -> Record:
    return Record.from_arrays(name=name, **measure(PLANT, profile, duration=90.0, with_pressure=with_pressure))


@pytest.fixture(scope="module")
def whole() -> Experiment:
    return experiment_of(recorded(7, with_pressure=True))


@pytest.fixture(scope="module")
def fit(whole: Experiment, given: Model) -> Fit:
    return fit_base(given, [whole])


@pytest.fixture(scope="module")
def partly(whole: Experiment) -> Experiment:
    """The same with every fifth pressure only."""
    is_read = np.arange(len(whole.time)) % 5 == 0
    return replace(whole, pressure=np.where(is_read, whole.pressure, np.nan))


def test_what_was_not_measured_counts_for_nothing(fit: Fit, partly: Experiment):
    problem = replace(fit.problem, experiments=[partly])
    residuals = problem.residuals(fit.found.point[None, :])[0]
    error = 0.5 * float(residuals @ residuals)
    assert error == pytest.approx(problem.noise_error, rel=0.1)
    assert problem.noise_error == pytest.approx(0.6 * fit.problem.noise_error, rel=1e-3)
    blocks = blocks_of(fitted_to_all(fit, [partly]))
    assert (blocks >= 0).sum() == len(partly.time) + np.isfinite(partly.pressure).sum()


def test_a_fit_to_a_part_of_the_pressures_finds_the_same_valve(fit: Fit, partly: Experiment, given: Model):
    found = fit_base(given, [partly]).model.values
    for name in ("spring_rate", "coulomb_friction", "gap_gain"):
        assert found[name] == pytest.approx(fit.model.values[name], rel=2e-3)


def test_the_smooth_route_counts_the_same(fit: Fit, partly: Experiment, whole: Experiment):
    smooth = [SmoothResiduals(replace(fit.problem, experiments=[each])) for each in (whole, partly)]
    full, less = (each.residuals(fit.found.point, 1e-4) for each in smooth)
    is_read = np.concatenate([np.ones(len(whole.time), bool), np.isfinite(partly.pressure)])
    assert less[: len(is_read)] == pytest.approx(np.where(is_read, full[: len(is_read)], 0.0))
    slopes = smooth[1].jacobian(fit.found.point, 1e-4)
    assert not slopes[: len(is_read)][~is_read].any()


def test_a_score_is_that_of_the_readings_that_are_there(fit: Fit, whole: Experiment, partly: Experiment):
    for experiment in (whole, partly, replace(whole, pressure=None)):
        other = replace(fit, problem=replace(fit.problem, experiments=[experiment]))
        assert score_fit(other, hold_out([experiment])).misfit == pytest.approx(1.0, abs=0.1)


def test_a_score_on_records_with_and_without_pressure_is_1_at_the_noise(given: Model):
    records = [recorded(8, with_pressure=True, name="with"), recorded(9, with_pressure=False, name="without")]
    holdout = hold_out(experiments_of(records)[0])
    score = score_fit(fit_base(given, holdout.experiments), holdout)
    assert score.misfit == pytest.approx(1.0, abs=0.1)
    assert score.whole.misfit == pytest.approx(1.0, abs=0.1)


def test_a_pressure_that_no_fitted_record_has_judges_nothing():
    records = [recorded(8, with_pressure=False, name="without"), recorded(9, with_pressure=True, name="with")]
    experiments, notes = experiments_of(records)
    assert [each.pressure for each in experiments] == [None, None]
    assert any("with: its pressure is not used" in note for note in notes)
    assert experiments_of(records[::-1])[0][0].pressure is not None


def test_a_position_that_is_missing_takes_nothing_from_the_fit_to_the_pressure(fit: Fit, whole: Experiment):
    spiked = replace(whole, position=np.where(np.arange(len(whole.time)) == 500, np.nan, whole.position))
    begun = replace(fit, found=replace(fit.found, point=fit.found.point + 0.05))
    exact, found = (front_of([each], begun).model.values for each in (whole, spiked))
    assert found["gap_gain"] == pytest.approx(exact["gap_gain"], rel=1e-6)


def test_the_force_is_told_of_signals_that_were_logged_in_turn(given: Model):
    long = experiment_of(Record.from_arrays(name="long", **measure(PLANT, 7, with_pressure=True)))
    is_even = np.arange(len(long.time)) % 2 == 0
    position, pressure = np.where(is_even, long.position, np.nan), np.where(is_even, np.nan, long.pressure)
    for each in (long, replace(long, position=position, pressure=pressure)):
        assert {"force", "friction"} == {curve.signal for curve in curves_of_force([each], given)}


def test_what_a_fit_was_not_to_is_not_said_to_be_determined(given: Model):
    records = [recorded(8, with_pressure=False, name="without"), recorded(9, with_pressure=True, name="with")]
    for given_in_order, signals in ((records, "current, position"), (records[::-1], "current, pressure, position")):
        structure = fit_records(given_in_order, given).determined.structure
        assert structure.signals == signals


def test_the_force_is_told_in_a_record_with_gaps(given: Model):
    experiment = experiment_of(
        Record.from_arrays(name="long", **measure(draw_plant(3, ()), 7, with_pressure=True)), reads_at_end=True
    )
    position = experiment.position.copy()
    position[3000:3003] = np.nan
    spiked = replace(experiment, position=position)
    base = fit_base(given, [spiked])
    assert np.isfinite(measured([spiked])[0]).all()
    assert {"force", "friction"} <= {curve.signal for curve in residual_curves([spiked], base)}
