"""Trying: what a search comes to that begins anew, or at every start."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from diagnosis.blindtest.plants import draw_plant, measure
from diagnosis.trials.plan import seeds_of
from diagnosis.trying import candidates
from diagnosis.trying.candidates import Work, try_anew, try_effect
from identification.experiment import experiment_of
from identification.extending import following
from identification.fit import Fit, fit_base
from identification.holdout import Holdout, hold_out
from valvemodel.records import Record


def base_of(given, seed: int, number: int, *keys: str) -> tuple[Fit, Holdout]:
    """Return the refitted base of a plant of a blind test, and what is held out of its record."""
    seeds = seeds_of(seed, number)
    plant = draw_plant(seeds["plant"], keys, nuisance=True)
    holdout = hold_out([experiment_of(Record.from_arrays(name="plant", **measure(plant, seeds["record"])))])
    return fit_base(given, holdout.experiments, holdout.fitted), holdout


def test_a_form_that_is_wrong_alone_is_left_beside_the_other_effect(given):
    # Two lags in series, which look like one as long as the load is left out.
    base, holdout = base_of(given, 2036, 48, "load_force", "sensor_lag")
    load = try_effect(Work(base, ("load_force",), is_global=False), holdout)
    lag = try_effect(Work(base, ("sensor_lag",), is_global=False), holdout)
    on_lag = Work(
        lag.fit,
        ("sensor_lag", "load_force"),
        is_global=False,
        known=dict(load.fit.model.effects["load_force"]),
        is_known=True,
    )
    pair = try_effect(on_lag, holdout)
    anew = try_anew(pair, "sensor_lag", holdout)
    assert anew.effects == ("load_force", "sensor_lag")
    assert pair.fit.found.error > 1.05 * pair.fit.problem.noise_error
    assert anew.fit.found.error < anew.fit.problem.noise_error
    assert anew.score.misfit < 0.8 * pair.score.misfit
    times = [value for name, value in anew.fit.model.effects["sensor_lag"].items() if name.endswith("time_constant")]
    # Two that are nearly alike are hardly told from their mean, twice.
    assert sum(times) == pytest.approx(2.0 * 0.0339, rel=0.01)
    assert times == pytest.approx([0.0339, 0.0339], rel=0.15)


def test_from_every_start_a_side_minimum_is_left(given, monkeypatch):
    # Damped more on the way up, where the two starts that promise most lead down.
    monkeypatch.setattr(following, "of_another_side", lambda *_: [])
    key = "asymmetric_viscous_friction"
    base, holdout = base_of(given, 3010, 13, key)
    few = try_effect(Work(base, (key,), is_global=False), holdout)
    all_starts = try_effect(Work(base, (key,), is_global=False, follows_all=True), holdout)
    assert few.score.misfit > 1.5
    assert all_starts.score.misfit < 1.1


@pytest.mark.parametrize(
    ("law", "left", "unseen", "in_stairs", "hangs"),
    [
        ("static_friction", 0.95, 131.0, False, True),
        ("static_friction", 0.95, 1.0, False, False),
        ("static_friction", 10.0, 131.0, False, False),
        ("static_friction", 0.95, 131.0, True, False),
        ("coil_lag", 0.95, 131.0, False, False),
    ],
)
def test_a_slip_hangs_by_a_hair_where_a_law_is_right_only_where_it_was_fitted(law, left, unseen, in_stairs, hangs):
    fit = SimpleNamespace(
        model=SimpleNamespace(effects=[law]),
        found=SimpleNamespace(error=left * 3000.0),
        problem=SimpleNamespace(noise_error=3000.0),
    )
    score = SimpleNamespace(misfit=unseen, at_rests=object() if in_stairs else None)
    assert candidates.hangs_by_a_hair(fit, score) == hangs
