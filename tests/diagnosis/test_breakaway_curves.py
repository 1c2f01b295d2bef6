"""What it takes to break away is told over what makes it differ, and not at all where one force explains it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from diagnosis.blindtest.plants import Plant, draw_plant, measure
from diagnosis.report.advice import breaking_away, next_step_of
from diagnosis.report.curves import curves_picture
from diagnosis.report.pictures import residual_pictures
from diagnosis.whereabouts.breakaway_curves import curves_of_ageing, curves_of_breakaways
from diagnosis.whereabouts.curve import AT_REST, Curve
from identification.experiment import experiment_of
from identification.fit import Fit, fit_base
from valvemodel.files import finite
from valvemodel.records import Record

VISIBILITY = (8.0, 20.0)


def aged(seed: int, bond_time: float) -> Plant:
    """Return a plant whose bonds, which hold the resting stem, take some time to heal; by the blind route's own law."""
    plant = draw_plant(seed, ("static_friction",), visibility=VISIBILITY)
    (truth,) = plant.effects
    assert truth.formulation == "rate_and_state"
    return replace(plant, effects=(truth.scaled("bond_time", bond_time),))


def base_for(plant: Plant, given, *, with_pressure: bool = False, begins: float = 0.0) -> Fit:
    taken = measure(plant, plant.seed, with_pressure=with_pressure)
    taken["time"] = begins + taken["time"]
    return fit_base(given, [experiment_of(Record.from_arrays(name="plant", **taken))])


def curves_for(plant: Plant, given, *, with_pressure: bool = False) -> dict[str, Curve]:
    return {curve.against: curve for curve in curves_of_breakaways(base_for(plant, given, with_pressure=with_pressure))}


@pytest.mark.parametrize("with_pressure", [False, True], ids=["without-pressure", "with-pressure"])
@pytest.mark.parametrize("bond_time", [2.0, 10.0])
def test_friction_that_grows_while_the_stem_rests_is_told_over_the_time_at_rest(given, bond_time, with_pressure):
    curves = curves_for(aged(3, bond_time), given, with_pressure=with_pressure)
    told = curves["time at rest"]
    assert told.share > 0.4
    assert told.share == max(curve.share for curve in curves.values())
    assert told.mean[-3:].mean() > told.mean[:3].mean(), "more force after a longer rest"


def test_how_long_a_stem_had_rested_where_a_record_begins_is_not_known(given):
    bases = (base_for(aged(3, 2.0), given, with_pressure=True, begins=begins) for begins in (0.0, 100.0))
    early, told = (next(each for each in curves_of_breakaways(base) if each.against == AT_REST) for base in bases)
    assert len(told.at) == len(early.at)
    assert told.at == pytest.approx(early.at)


@pytest.mark.parametrize("seed", [11, 13])
def test_friction_that_drifts_is_told_over_the_time_in_the_record(given, seed):
    curves = curves_for(draw_plant(seed, ("friction_drift",), visibility=VISIBILITY), given)
    assert curves["time"].share > 0.8
    assert curves["time at rest"].share < 0.3


def test_friction_that_grows_with_the_pressure_is_told_over_the_pressure(given):
    plant = draw_plant(12, ("pressure_dependent_friction",), visibility=VISIBILITY)
    curves = curves_for(plant, given, with_pressure=True)
    assert max(curves, key=lambda name: curves[name].share) == "pressure"


def test_only_a_force_that_grows_with_the_time_at_rest_is_shown_beside_a_law_of_jumps(given):
    shown = curves_of_ageing(base_for(aged(3, 10.0), given, with_pressure=True))
    assert shown[0].against == "time at rest"
    assert len(shown) == 4
    drifts = draw_plant(11, ("friction_drift",), visibility=VISIBILITY)
    assert curves_of_ageing(base_for(drifts, given)) == []


@pytest.mark.parametrize("key", ["static_friction", "stribeck"])
def test_one_breakaway_force_for_all_has_no_curve(given, key):
    assert curves_for(draw_plant(11, (key,), visibility=VISIBILITY), given) == {}


def test_breakaway_force_is_said_and_drawn(given):
    curves = [finite(curve.as_json()) for curve in curves_for(aged(3, 2.0), given, with_pressure=True).values()]
    assert curves[0]["against"] == "time at rest"
    assert curves_picture("left", curves, is_wide=True).startswith("<svg")
    assert residual_pictures(curves)[0].alternative.startswith(
        "Values of what is left of the breakaway force over time at rest"
    )
    diagnosis = {"verdict": "unknown", "where": {"stage": "stem"}, "residual_curves": curves}
    said = breaking_away(diagnosis)
    assert said.startswith("The force at which the stem breaks away depends on the time at rest, which explains ")
    assert said in next_step_of(diagnosis, ())
    assert breaking_away({**diagnosis, "where": {"stage": "sensor"}}) == ""
    assert breaking_away({**diagnosis, "residual_curves": [{**curves[0], "share": 0.3}]}) == ""
    assert breaking_away({**diagnosis, "verdict": "effect", "where": {"stage": "nozzle"}}) == said
