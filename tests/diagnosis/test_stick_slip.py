"""Stick-slip of blind plants: rests, the line through their ends, and the search from the slips on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from workshops import EMPTY

from diagnosis.blindtest.plants import draw_plant, measure
from diagnosis.choosing.stairs import REACH, makes_stairs
from diagnosis.score import score_fit
from identification.experiment import experiment_of
from identification.extending.extension import Extension, extend
from identification.fit import fit_base
from identification.holdout import hold_out
from identification.stick_slip.breakaway import Breakaways, breakaways_of, line_through
from identification.stick_slip.rests import Rest, put_on_rests, rests_of
from identification.stick_slip.slip_laws import forms_of, slips_by
from identification.stick_slip.slip_search import line_of_stairs, search_slips
from valvemodel.effects import effect_of_key
from valvemodel.records import Record
from valvemodel.stages import EFFECTS

NOISE = 1e-4


def plant_and_base(given, seed: int, key: str, *, profile: int | None = None, with_pressure: bool = False):
    """Return a blind plant, what is held out of its record, and the base valve fitted to the rest."""
    plant = draw_plant(seed, (key,), nuisance=profile is not None)
    taken = measure(plant, seed + 7 if profile is None else profile, with_pressure=with_pressure)
    record = Record.from_arrays(name="plant", **taken)
    holdout = hold_out([replace(experiment_of(record), reach=REACH)])
    return plant, holdout, fit_base(given, holdout.experiments, holdout.fitted)


@pytest.fixture(scope="module")
def falling(given):
    """A plant whose friction falls with speed as a bell."""
    return plant_and_base(given, 9102, "stribeck")


@pytest.fixture(scope="module")
def sticking(given):
    """A plant whose bonds break by slip and heal with time."""
    return plant_and_base(given, 9127, "static_friction")


def test_rests_are_seen_where_they_end():
    heights = np.repeat([0.0, 4e-3, 8e-3, 5e-3], [40, 30, 20, 30])
    readings = heights + NOISE * np.random.default_rng(0).standard_normal(len(heights))
    rests = list(rests_of(readings, NOISE))
    assert [rest.last for rest in rests] == [39, 69, 89]
    assert [rest.side for rest in rests] == [1.0, 1.0, -1.0]
    assert [rest.position for rest in rests] == pytest.approx([0.0, 4e-3, 8e-3], abs=5e-5)


def test_a_slow_slide_is_no_rest():
    sliding = 0.8 * NOISE * np.arange(300.0)
    assert not list(rests_of(sliding + NOISE * np.random.default_rng(0).standard_normal(300), NOISE))


@pytest.mark.parametrize(("sides", "count"), [([[1, 1, -1], [-1, -1]], 2), ([[1, 1, -1, -1, -1]], 3), ([[], [1]], 0)])
def test_steps_of_stairs_follow_one_of_their_own_record(monkeypatch, sides, count):
    monkeypatch.setattr(Breakaways, "is_ramped", lambda breakaways, point: np.ones(len(breakaways.side), bool))
    rests = [[Rest(0, 5, 0.0, float(side)) for side in own] for own in sides]
    assert Breakaways(None, rests).on_the_way(np.zeros(1)) == count


def test_runs_are_put_anew_just_before_a_rest_ends(falling):
    (experiment,) = falling[1].experiments
    rested = put_on_rests(experiment, 3.0)
    rests = list(rests_of(experiment.position, experiment.noise))
    assert np.flatnonzero(np.isfinite(rested.anchors)).tolist() == [rest.last - 1 for rest in rests]
    assert (rested.reach, rested.noise) == (3.0, experiment.noise)


def test_the_line_through_breakaways_is_that_of_the_plant(falling):
    plant, _, base = falling
    line = line_through(breakaways_of(base.problem), base.found.point)
    found = base.problem.values(line.point)
    given = base.problem.model.values
    drive = np.prod([plant.base[name] / given[name] for name in ("diaphragm_area", "supply_pressure")])
    ratio = 1.0 + plant.effects[0].parameters["static_excess"]
    assert found["spring_rate"] == pytest.approx(plant.base["spring_rate"] / drive, rel=1e-2)
    assert found["coulomb_friction"] == pytest.approx(ratio * plant.base["coulomb_friction"] / drive, rel=1e-2)
    assert found["gap_offset"] == pytest.approx(plant.base["gap_offset"], rel=1e-2)
    assert found["gap_gain"] == pytest.approx(plant.base["gap_gain"], rel=1e-2)


def test_the_breakaway_force_stays_while_the_slips_change(falling):
    _, _, base = falling
    effect = effect_of_key("static_friction")
    line = line_of_stairs(base.problem, base.found.point)
    (begun,) = search_slips(effect, line, forms_of(base, effect))
    moves = np.random.default_rng(0).uniform(-0.3, 0.3, (20, len(begun.box)))
    points = begun.slips.points_of(begun.found.point, moves)
    force, ratio = begun.slips.problem.unknowns[begun.slips.friction], begun.slips.problem.unknowns[begun.slips.ratio]
    forces = force.value(points[:, begun.slips.friction]) * ratio.value(points[:, begun.slips.ratio])
    assert forces == pytest.approx(np.full(20, base.problem.values(line.point)["coulomb_friction"]), rel=1e-9)
    assert np.ptp(points[:, begun.slips.ratio]) > 0.0


def test_falling_friction_is_explained(falling):
    plant, holdout, base = falling
    assert makes_stairs(base, EFFECTS, EMPTY)
    found = extend(base, "stribeck")
    before, after = score_fit(base, holdout), score_fit(found, holdout)
    assert before.misfit > 20.0
    assert after.misfit < 1.5
    ratio = 1.0 + plant.effects[0].parameters["static_excess"]
    assert found.model.effects["stribeck"]["stribeck_ratio"] == pytest.approx(ratio, abs=0.06)


def test_a_measured_pressure_tells_the_gap_whatever_the_stem_does(given):
    plant, holdout, base = plant_and_base(given, 9102, "stribeck", with_pressure=True)
    line = line_of_stairs(base.problem, base.found.point)
    found = base.problem.values(line.point)
    for name in ("supply_pressure", "gap_offset", "gap_gain"):
        assert found[name] == pytest.approx(plant.base[name], rel=2e-3)
    assert score_fit(extend(base, "stribeck"), holdout).misfit < 1.3


def test_static_friction_of_bonds_is_explained(sticking):
    _, holdout, base = sticking
    assert makes_stairs(base, EFFECTS, EMPTY)
    before, after = score_fit(base, holdout), score_fit(extend(base, "static_friction"), holdout)
    assert after.misfit < 0.4 * before.misfit


def test_a_law_is_searched_for_from_the_slips_though_another_one_explains_them(given):
    """On the line that is held the right law leaves more than the wrong one, whose base valve is another."""
    plant, holdout, base = plant_and_base(given, 2083107776, "stribeck", profile=1718918465)
    kin = extend(base, "static_friction")
    assert kin.found.error < 1.05 * kin.problem.noise_error
    found = extend(base, "stribeck", Extension(kin=kin))
    assert found.found.error < 1.02 * found.problem.noise_error
    assert score_fit(found, holdout).misfit < 0.9 * score_fit(kin, holdout).misfit
    for name in ("viscous_friction", "stem_mass"):
        assert found.model.values[name] == pytest.approx(plant.base[name], rel=0.2)
        assert kin.model.values[name] != pytest.approx(plant.base[name], rel=0.4)


def test_steps_of_a_coarse_reading_are_no_slips(given):
    _, _, base = plant_and_base(given, 9130, "quantisation")
    assert line_of_stairs(base.problem, base.found.point) is None
    assert slips_by(base, effect_of_key("static_friction")) == []
