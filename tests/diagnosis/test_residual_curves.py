"""What is left at a stage is told as a curve over what it depends on, in its own unit and of its true size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.blindtest.plants import draw_plant, measure
from diagnosis.report.advice import depends_of
from diagnosis.report.curves import curves_picture
from diagnosis.whereabouts.residual_curves import Curve, curves_against, gap_at, residual_curves
from identification.experiment import Experiment, experiment_of
from identification.fit import Fit, fit_base
from valvemodel.files import finite
from valvemodel.records import Record


def first(curves: list[Curve], signal: str) -> Curve:
    return next(curve for curve in curves if curve.signal == signal)


@pytest.fixture(scope="module")
def measured() -> Experiment:
    """A whole record of a plant without an effect: the minute is too short for friction to be told."""
    taken = measure(draw_plant(3, ()), 7, with_pressure=True)
    return experiment_of(Record.from_arrays(name="whole", **{name: taken[name] for name in taken}))


@pytest.fixture(scope="module")
def fit(measured, given) -> Fit:
    return fit_base(given, [measured])


def test_short_record_tells_no_force(minute, given):
    experiment = experiment_of(minute)
    assert "force" not in {curve.signal for curve in residual_curves([experiment], fit_base(given, [experiment]))}


def test_a_curve_stays_as_it_is_whatever_its_json_is_made_into():
    curve = Curve("position", "m", "stem", "time", "s", np.zeros(3), np.ones(3), np.ones(3), 0.5)
    content = curve.as_json()
    content["share"] = None
    content["mean"][:] = 0.0
    assert curve.share == 0.5
    assert curve.mean.tolist() == [1.0, 1.0, 1.0]


def test_without_pressure_only_the_position_is_told(quiet, given):
    curves = residual_curves([quiet], fit_base(given, [quiet]))
    assert {curve.signal for curve in curves} == {"position"}
    assert {curve.against for curve in curves} == {"current", "position", "speed", "time"}


def test_pressure_that_creeps_is_told_over_time_at_its_stage(measured, fit):
    creep = 3000.0 * (measured.time / measured.time[-1] - 0.5)
    crept = replace(measured, pressure=measured.pressure + creep)
    curves = residual_curves([crept], replace(fit, problem=replace(fit.problem, experiments=[crept])))
    told = first(curves, "pressure")
    assert (told.against, told.unit, told.stage) == ("time", "Pa", "electromagnet or nozzle")
    assert told.share > 0.8
    assert told.mean[-1] - told.mean[0] == pytest.approx(3000.0 * (1.0 - 1.0 / len(told.at)), rel=0.15)
    assert first(curves, "gap").mean[-1] < 0.0, "a smaller gap makes more pressure"


def test_friction_that_grows_is_told_over_time_in_newtons(measured, given, fit):
    # the pressure that moves the stem is higher rising and lower falling by what friction has grown
    side = np.sign(np.gradient(fit.simulated_on(measured).position[0]))
    grown = 200.0 * measured.time / measured.time[-1]
    rougher = replace(measured, pressure=measured.pressure + side * grown / given.values["diaphragm_area"])
    curves = residual_curves([rougher], fit)
    told = first(curves, "friction")
    assert (told.against, told.unit, told.stage) == ("time", "N", "stem")
    assert 80.0 < told.mean[-1] - told.mean[0] < 220.0


def test_share_is_that_of_the_variance():
    generator = np.random.default_rng(2)
    place = generator.uniform(0.0, 1.0, 20000)
    residual = place + np.sqrt(1.0 / 12.0) * generator.standard_normal(20000)
    quantities = {"place": ("m", place), "chance": ("1", generator.permutation(place))}
    along, across = curves_against("force", "N", "stem", residual, quantities)
    assert along.share == pytest.approx(0.5, abs=0.03)
    assert across.share < 0.01
    assert np.all(np.abs(across.mean) < 5.0 * across.error)


def test_gap_is_the_nozzle_law_solved(given):
    gap = np.array([20e-6, 40e-6, 60e-6])
    pressure = given.values["supply_pressure"] / (1.0 + given.values["flow_ratio"] * gap**2)
    assert gap_at(pressure, given) == pytest.approx(gap)
    assert np.isnan(gap_at(np.array([-1.0, 4e5]), given)).all()


def test_curves_are_drawn_and_said(measured, fit):
    curves = [finite(curve.as_json()) for curve in residual_curves([measured], fit)]
    own = [curve for curve in curves if curve["signal"] == "force"]
    for is_wide in (True, False):
        assert curves_picture("left", own, is_wide=is_wide).startswith("<svg")
    sentences = depends_of({"residual_curves": [{**curves[0], "share": 0.62}]})
    assert sentences == (
        f"What is left of the position depends most on {curves[0]['against']}: a curve over it explains 62 % of it.",
    )


def test_too_few_samples_for_a_bin_make_no_curve():
    values = np.linspace(0.0, 1.0, 100)
    assert list(curves_against("force", "N", "stem", np.sin(values), {"position": ("m", values)})) == []
    many = np.linspace(0.0, 1.0, 1000)
    assert len(list(curves_against("force", "N", "stem", np.sin(many), {"position": ("m", many)}))) == 1
