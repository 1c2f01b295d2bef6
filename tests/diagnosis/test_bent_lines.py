"""Stick-slip beside another effect: what bends the line through the breakaways, and the search on top of that."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from workshops import EMPTY

from diagnosis.blindtest.plants import draw_plant, measure
from diagnosis.choosing import beside_slips as slips
from diagnosis.choosing.beside_slips import bends_to_stairs, bent_lines
from diagnosis.choosing.looks import look_alone, look_beside
from diagnosis.choosing.stairs import REACH
from diagnosis.score import score_fit
from diagnosis.trying import candidates
from diagnosis.trying.candidates import Candidate, Work, sharpen, try_effect
from diagnosis.trying.standing import blunt
from diagnosis.trying.workshop import Workshop
from identification.experiment import experiment_of
from identification.extending.extension import Extension, extend
from identification.fit import Fit, fit_base
from identification.holdout import hold_out
from identification.search import errors
from identification.sharpening import sharpened
from identification.starting.hints import coarse_step
from identification.stick_slip import bent_at_will as waving
from identification.stick_slip.bent_at_will import bent_at_will
from identification.stick_slip.bent_lines import LEAST_BREAKAWAYS, bent_afresh, bent_line, on_the_line, straight_line
from identification.stick_slip.breakaway import breakaways_of, counted, line_through, roamed
from identification.stick_slip.rests import rests_of
from identification.stick_slip.slip_laws import slips_beside, slips_by
from identification.stick_slip.slip_search import line_of_stairs
from valvemodel.breakaways import ways_to_breakaway
from valvemodel.effects import effect_of_key
from valvemodel.model import Model
from valvemodel.records import Record


@pytest.fixture(scope="module")
def plant_and_base(given):
    """Return a blind plant, what is held out of its record, and the base valve fitted to the rest, once for each."""

    @cache
    def fitted(seed: int, *keys: str, reach: float = REACH):
        plant = draw_plant(seed, keys)
        record = Record.from_arrays(name="plant", **measure(plant, seed + 7))
        holdout = hold_out([replace(experiment_of(record), reach=reach)])
        return plant, holdout, fit_base(given, holdout.experiments, holdout.fitted)

    return fitted


@pytest.fixture(scope="module")
def drifting(plant_and_base):
    """A plant whose gap drifts beside friction that falls with speed."""
    return plant_and_base(9204, "gap_drift", "stribeck")


@pytest.mark.parametrize("seed", [9403, 9404])
def test_no_line_is_laid_through_the_rests_of_a_coarse_reading(plant_and_base, seed):
    """They say little of where the stem is, and it may move all the time."""
    _, _, base = plant_and_base(seed, "quantisation")
    (experiment,) = base.problem.experiments
    assert len(list(rests_of(experiment.position, experiment.noise))) > LEAST_BREAKAWAYS
    assert coarse_step(experiment) > 0.0
    assert straight_line(base) is None
    assert line_of_stairs(base.problem, base.found.point) is None


@pytest.fixture(scope="module")
def coarse(plant_and_base):
    """A plant that jumps by several steps of a coarse reading, and the base valve that reads in those."""
    plant, holdout, base = plant_and_base(31004, "stribeck", "quantisation")
    return plant, holdout, extend(base, "quantisation")


def test_slips_of_several_steps_lay_a_line_through_a_coarse_reading(coarse):
    plant, _, read = coarse
    assert len(breakaways_of(replace(read.problem, model=read.model.without_effect("quantisation"))).position) == 0
    line = line_of_stairs(read.problem, read.found.point)
    assert line.count > 8 * LEAST_BREAKAWAYS
    assert line.is_explained
    # Each rest is known within a step.
    (step,) = (truth.parameters["reading_step"] for truth in plant.effects if truth.effect == "quantisation")
    assert np.all(line.breakaways.spread == pytest.approx(step / np.sqrt(12.0), rel=0.1))
    values = dict(zip((unknown.name for unknown in read.unknowns), line.point, strict=True))
    stiffness = next(each for each in read.unknowns if each.name == "spring_rate").value(values["spring_rate"])
    # In the units of a valve of the given area.
    assert stiffness / read.model.values["diaphragm_area"] == pytest.approx(
        plant.base["spring_rate"] / plant.base["diaphragm_area"], rel=0.05
    )


def test_what_makes_a_stem_jump_is_found_beside_a_coarse_reading(coarse):
    _, holdout, read = coarse
    found = extend(read, "stribeck")
    assert found.found.error < 0.1 * read.found.error
    alone = [Candidate((), read, score_fit(read, holdout))]
    alone += [replace(alone[0], effects=(key,)) for key in ("quantisation", "static_friction")]
    asked = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(slips, "try_all", lambda work, *_: asked.extend(work) or [])
        slips.beside_coarse_steps(alone, Workshop(holdout))
    assert [each.effects for each in asked] == [("quantisation", "static_friction")]
    assert asked[0].is_global


def test_a_display_is_no_coarse_reading_to_search_on_top_of(drifting, monkeypatch):
    """Its step is far below the noise: all that it shows is tried on a fine reading."""
    _, holdout, base = drifting
    shown = extend(base, "quantisation")
    assert shown.problem.is_in_steps
    assert shown.problem.step < shown.problem.experiments[0].noise
    alone = [Candidate((), base, score_fit(base, holdout))]
    alone += [replace(alone[0], effects=("quantisation",), fit=shown), replace(alone[0], effects=("static_friction",))]
    monkeypatch.setattr(slips, "try_all", lambda work, *_: [pytest.fail("searched")] if work else [])
    assert slips.beside_coarse_steps(alone, Workshop(holdout)) == []


@pytest.fixture(scope="module")
def swaying(plant_and_base):
    """A plant that jumps under a load that varies at will."""
    return plant_and_base(31103, "stribeck", "load_force")


def test_a_load_at_will_brings_breakaways_onto_a_line(swaying):
    plant, _, base = swaying
    (truth,) = (each for each in plant.effects if each.effect == "load_force")
    assert truth.formulation == "wander"
    line, load = straight_line(base), effect_of_key("load_force")
    assert line.error > 20.0 * line.count
    bent = bent_at_will(base, line, load)
    assert bent.line.is_explained
    assert bent.problem.has_series
    # The waves stay while slips are searched for.
    assert set(bent.line.columns) == set(line.columns)
    sizes = [value for name, value in bent.problem.model.effects["load_force"].items() if "sine" in name]
    rms = np.sqrt(0.5 * np.sum(np.square(sizes)))
    assert rms == pytest.approx(truth.parameters["amplitude"], rel=0.4)


def test_waves_that_foretell_no_breakaway_bend_no_line(given, monkeypatch):
    """The breakaways of a law in which a stem creeps before it slips are imitated by them one by one."""
    plant = draw_plant(1971435783, ("stribeck",), nuisance=True)
    holdout = hold_out([experiment_of(Record.from_arrays(name="plant", **measure(plant, 1682012484)))])
    base = fit_base(given, holdout.experiments, holdout.fitted)
    line, load = straight_line(base), effect_of_key("load_force")
    assert not line.is_explained
    assert bent_at_will(base, line, load) is None
    monkeypatch.setattr(waving, "FORETOLD", np.inf)
    assert bent_at_will(base, line, load).line.is_explained


def test_a_load_at_will_bends_no_line_through_few_breakaways(swaying):
    _, _, base = swaying
    line = straight_line(base)
    few = replace(line.breakaways, rests=[line.breakaways.rests[0][:40]])
    assert bent_at_will(base, replace(line, breakaways=few), effect_of_key("load_force")) is None


def test_a_stem_that_rests_here_and_there_is_not_read_coarsely(drifting):
    _, _, base = drifting
    assert not any(map(coarse_step, base.problem.experiments))


def test_the_way_to_a_breakaway_ends_where_friction_just_holds(given):
    effects = {"spring_hardening": {"spring_hardening": 0.0, "spring_progression": 0.8}}
    p = Model("bent", given.values, effects).rows()
    reading, side, pressure = 0.1, 1.0, 1.2e5
    way = np.empty((1, 1))
    sides = np.array([side])
    for _ in range(30):
        ways_to_breakaway(p, np.array([reading]), sides, sides, np.array([[pressure]]), np.zeros(1), way)
        reading += float(way[0, 0])
    stiffness, area = given.values["spring_rate"], given.values["diaphragm_area"]
    spring = stiffness * reading * (1.0 + 0.8 * reading)
    assert abs(way[0, 0]) < 1e-12
    assert area * pressure == pytest.approx(spring + given.values["spring_preload"] + given.values["coulomb_friction"])


def test_play_puts_the_stem_before_the_reading_until_it_turns(given):
    half, pressure, reading = 2e-3, np.array([[1.2e5]]), np.array([0.165])
    rising, falling = np.array([1.0]), np.array([-1.0])

    def way_of(half_width: float, before: np.ndarray, side: np.ndarray) -> float:
        effects = {"linkage_backlash": {"backlash_half_width": half_width}}
        way = np.empty((1, 1))
        rows = Model("loose", given.values, effects).rows()
        ways_to_breakaway(rows, reading, before, side, pressure, np.zeros(1), way)
        return float(way[0, 0])

    assert way_of(half, rising, rising) == pytest.approx(way_of(0.0, rising, rising) - half, abs=1e-12)
    assert way_of(half, falling, falling) == pytest.approx(way_of(0.0, falling, falling) + half, abs=1e-12)
    # The slip that a turned reading shows began anywhere in the play: only what lies outside counts in full.
    turned = way_of(0.0, rising, falling)
    assert 0.005 < abs(turned) < 0.03
    assert way_of(half, rising, falling) == pytest.approx(turned - np.sign(turned) * half, abs=4e-3 * half)
    assert abs(way_of(0.03, rising, falling)) <= 4e-3 * 0.03


def test_what_bends_a_line_much_is_found_beside_the_valve_as_it_was_given(given):
    plant = draw_plant(1427258035, ("static_friction", "position_dependent_friction"), nuisance=True)
    holdout = hold_out([experiment_of(Record.from_arrays(name="plant", **measure(plant, 1400401582)))])
    base = fit_base(given, holdout.experiments, holdout.fitted)
    line, tight = straight_line(base), effect_of_key("position_dependent_friction")
    assert line.error > 50.0 * line.count
    assert bent_line(base, line, tight) is None
    bent = bent_afresh(base, line, tight)
    assert bent.line.is_explained
    (spot,) = (truth for truth in plant.effects if truth.effect == tight.key)
    found = bent.problem.values(bent.line.point)["tight_spot_position"]
    assert found == pytest.approx(spot.parameters["centre"], abs=0.3 * spot.parameters["width"])
    assert bent_afresh(base, line, effect_of_key("area_variation")) is None


def test_play_shows_where_the_reading_turns(plant_and_base):
    plant, _, base = plant_and_base(9210, "linkage_backlash", "stribeck")
    line = straight_line(base)
    bent = bent_line(base, line, effect_of_key("linkage_backlash"))
    assert not line.is_explained
    assert bent.line.is_explained
    half = bent.fit.model.effects["linkage_backlash"]["backlash_half_width"]
    # Within what the breakaways leave open, slips tell the rest.
    assert 0.6 < half / (0.5 * plant.effects[0].parameters["play"]) < 1.6
    off = np.abs(line.breakaways.enclosed(line.point[None, :])[0])
    turns = line.breakaways.before != line.breakaways.side
    assert off[turns].max() > 10.0 * off[~turns].max()


def test_breakaways_of_stick_slip_alone_lie_on_the_line(plant_and_base):
    for seed in (9201, 9203):
        _, _, base = plant_and_base(seed, "stribeck")
        assert straight_line(base).is_explained


def test_the_effect_that_bends_the_line_is_the_plant_s(drifting):
    plant, _, base = drifting
    line = straight_line(base)
    bent = {key: bent_line(base, line, effect_of_key(key)) for key in ("gap_drift", "spring_hardening", "air_leak")}
    assert bent["spring_hardening"] is None
    assert bent["air_leak"] is None
    assert bent["gap_drift"].line.error < 0.01 * line.error
    values = bent["gap_drift"].fit.model.effects["gap_drift"]
    assert np.sign(values["gap_drift_rate"]) == plant.effects[0].parameters["direction"]


def test_effects_that_leave_rests_as_they_are_bend_no_line(drifting):
    _, _, base = drifting
    line = straight_line(base)
    assert not line.is_explained
    for key in ("static_friction", "presliding", "sensor_lag", "asymmetric_viscous_friction"):
        assert bent_line(base, line, effect_of_key(key)) is None


@pytest.mark.parametrize("seed", [9413, 9417, 9422])
def test_what_shapes_slips_is_searched_with_them_on_the_line_as_it_is(plant_and_base, seed):
    plant, holdout, base = plant_and_base(seed, "asymmetric_viscous_friction", "static_friction")
    line, law = straight_line(base), effect_of_key("static_friction")
    shaped = bent_line(base, line, effect_of_key("asymmetric_viscous_friction"))
    assert shaped.line.error == line.error
    beside, alone = slips_by(shaped.fit, law, line=shaped.line), slips_by(base, law, line=line)
    assert beside[0].found.error < 0.5 * alone[0].found.error
    found = extend(shaped.fit, "static_friction", Extension(slips=beside))
    assert score_fit(found, holdout).misfit < 1.3
    excess, direction = (plant.effects[0].parameters[name] for name in ("excess", "direction"))
    if plant.effects[0].formulation == "one_sided":
        asymmetry = found.model.effects["asymmetric_viscous_friction"]["viscous_asymmetry"]
        assert asymmetry == pytest.approx(direction * excess / (2.0 + excess), abs=0.1)


def test_a_reading_that_lags_shows_breakaways_late(plant_and_base):
    _, _, base = plant_and_base(9437, "sensor_lag", "stribeck")
    line, law = straight_line(base), effect_of_key("stribeck")
    assert not line.is_explained
    read = bent_line(base, line, effect_of_key("sensor_lag"))
    assert read.line.is_explained
    assert read.line.breakaways.late > 0
    assert (replace(line.breakaways, late=50).is_ramped(line.point) == line.breakaways.is_ramped(line.point)).all()
    assert slips_by(read.fit, law, line=read.line)
    assert not slips_by(base, law, line=line)


@pytest.mark.filterwarnings("error")
def test_a_line_is_laid_where_no_breakaway_is_on_a_ramp(plant_and_base):
    _, _, base = plant_and_base(9201, "stribeck")
    every, point = breakaways_of(base.problem), base.found.point
    pairs = zip(every.rests[0], every.is_ramped(point), strict=True)
    steps = replace(every, rests=[[rest for rest, is_ramped in pairs if not is_ramped]])
    assert 0 < len(steps.position) < len(every.position)
    line = line_through(steps, point)
    assert line.error <= float(counted(steps.enclosed(point[None, :]))[0])


def test_a_line_is_found_from_beside_it_along_what_it_leaves_open(plant_and_base):
    _, _, base = plant_and_base(9201, "stribeck")
    line = straight_line(base)
    moved = line.point.copy()
    moved[line.columns] += 3.0 * line.slack @ np.ones(len(line.columns))
    astray = replace(line, point=moved, error=float(counted(line.breakaways.enclosed(moved[None, :]))[0]))
    assert not astray.is_explained
    assert roamed(astray).error < 0.5 * astray.error
    assert roamed(line) is line
    hopeless = replace(astray, error=4.0 * line.count)
    assert roamed(hopeless) is hopeless


@pytest.mark.parametrize(("seed", "law"), [(9402, "stribeck"), (9407, "stribeck"), (9403, "static_friction")])
def test_a_dead_time_is_told_by_the_line_to_a_sample(plant_and_base, seed, law):
    plant, _, base = plant_and_base(seed, "transport_delay", law)
    line = straight_line(base)
    assert not line.is_explained
    bent = bent_line(base, line, effect_of_key("transport_delay"))
    assert bent.line.is_explained
    (delay,) = (each.parameters["delay"] for each in plant.effects if each.effect == "transport_delay")
    assert bent.fit.model.effects["transport_delay"]["transport_delay"] == pytest.approx(delay, abs=0.021)
    assert bent_line(base, line, effect_of_key("gap_drift")) is None


def test_a_lag_bends_the_line_as_well(plant_and_base):
    _, _, base = plant_and_base(9401, "coil_lag", "stribeck")
    line = straight_line(base)
    assert not line.is_explained
    bent = bent_line(base, line, effect_of_key("coil_lag"))
    assert bent.line.error < 0.05 * line.error
    assert bends_to_stairs(base, [effect_of_key("coil_lag")], EMPTY)
    assert not bends_to_stairs(base, [effect_of_key("gap_drift")], EMPTY)


def test_no_stairs_are_seen_where_the_line_is_straight(plant_and_base):
    _, _, base = plant_and_base(9201, "stribeck")
    assert not bends_to_stairs(base, [effect_of_key("coil_lag")], EMPTY)


@pytest.mark.parametrize(("bent", "afresh"), [(3.0, ["coil_lag"]), (20.0, ["coil_lag", "gap_drift"])])
def test_lines_are_laid_afresh_with_what_bends_them_already_or_with_all(monkeypatch, bent, afresh):
    def laid(effect, error):
        return SimpleNamespace(effect=effect, line=SimpleNamespace(error=error, is_explained=error <= 1.0))

    asked, errors = [], {"coil_lag": bent, "gap_drift": 25.0}
    monkeypatch.setattr(slips, "bent_line", lambda base, line, effect: laid(effect, errors[effect.key]))
    monkeypatch.setattr(slips, "bent_afresh", lambda base, line, effect: asked.append(effect.key) or laid(effect, 0.5))
    straight, effects = SimpleNamespace(error=100.0, is_explained=False), [effect_of_key(key) for key in errors]
    found = bent_lines(None, straight, effects, EMPTY, is_thorough=True)
    assert asked == afresh
    assert found[0].line.error == 0.5
    asked.clear()
    errors["gap_drift"] = 0.9
    bent_lines(None, straight, effects, EMPTY, is_thorough=True)
    assert asked == [], "one explains the breakaways"


def test_the_slips_tell_what_is_beside_a_law_where_lines_tell_little(plant_and_base):
    """Each of three brings the breakaways onto a line; how far a slip goes tells the plant's from the others."""
    _, _, base = plant_and_base(9409, "asymmetric_friction", "static_friction")
    line = straight_line(base)
    keys = ("asymmetric_friction", "friction_drift", "sensor_drift")
    bent = bent_lines(base, line, [effect_of_key(key) for key in keys], EMPTY)
    assert all(each.line.is_explained for each in bent)
    alone = look_alone(on_the_line(base.problem, line), line, {"static_friction": None}, EMPTY)
    looked = look_beside(bent, ["static_friction"], EMPTY, alone)
    errors_by = {each.work.effects[0]: each.error for each in looked if each.slips}
    assert set(errors_by) == set(keys)
    assert errors_by["asymmetric_friction"] < 0.9 * min(
        errors_by["friction_drift"], errors_by["sensor_drift"], alone[0].error
    )


def test_stick_slip_is_found_on_top_of_what_bends_the_line(plant_and_base):
    plant, holdout, base = plant_and_base(9204, "spring_hardening", "stribeck")
    bent = bent_line(base, straight_line(base), effect_of_key("spring_hardening"))
    found = extend(bent.fit, "stribeck")
    assert score_fit(found, holdout).misfit < 0.3 * score_fit(extend(base, "stribeck"), holdout).misfit
    ratio = 1.0 + plant.effects[1].parameters["static_excess"]
    assert found.model.effects["stribeck"]["stribeck_ratio"] == pytest.approx(ratio, abs=0.06)


def test_a_line_leaves_open_no_more_than_it_may(drifting):
    _, _, base = drifting
    bent = bent_line(base, straight_line(base), effect_of_key("gap_drift")).line
    assert np.abs(bent.slack).max() <= 1.0
    assert bent.count == len(breakaways_of(base.problem).position)
    assert line_through(breakaways_of(base.problem), base.found.point).error > bent.error


def test_a_line_leaves_open_what_few_breakaways_do_not_tell(drifting):
    _, _, base = drifting
    every = breakaways_of(base.problem)
    few = replace(every, rests=[rests[:2] for rests in every.rests])
    columns = straight_line(base).columns
    slack = few.slack(base.found.point, columns)
    assert slack.shape == (len(columns), len(columns))
    assert np.linalg.norm(slack, axis=0).max() == pytest.approx(1.0)


@pytest.mark.parametrize("seed", [9301, 9302, 9306])
def test_a_search_about_a_jagged_fit_comes_nearer_to_what_it_was_given(plant_and_base, seed, monkeypatch):
    _, holdout, base = plant_and_base(seed, "sensor_drift", "static_friction", reach=np.inf)
    drift = try_effect(Work(base, ("sensor_drift",), is_global=False), holdout).fit
    pair = try_effect(Work(drift, ("sensor_drift", "static_friction"), is_global=True), holdout)
    made = []
    monkeypatch.setattr(candidates, "sharpened", lambda fit: made.append(sharpened(fit)) or made[-1])
    kept = sharpen(pair, holdout)
    (sharper,) = made
    assert error_in_both_runs(sharper) < 0.95 * error_in_both_runs(pair.fit)
    assert error_in_both_runs(sharpened(sharper)) <= error_in_both_runs(sharper)
    assert kept.effects == pair.effects
    assert kept.score.misfit <= pair.score.misfit
    assert blunt([pair], pair) == [pair]
    assert blunt([kept], pair) == []


def error_in_both_runs(fit: Fit) -> float:
    """Return the geometric mean of the errors of the free and of the re-anchored run on the fitted samples."""
    free, point = fit.problem, fit.found.point
    both = [errors(each, point[None, :])[0] for each in (free, replace(free, is_anchored=True))]
    return float(np.sqrt(np.prod(both)))


def named(misfit: float, *effects: str) -> Candidate:
    """Return a cause with nothing but its effects and a misfit."""
    score = type("Score", (), {"misfit": misfit})()
    return Candidate(effects, "+".join(effects), score)


def under_the_law(alone: list[Candidate], left: dict[tuple[str, ...], float], monkeypatch) -> list[Work]:
    """The work in which a law comes on top of others, where fits come to these errors by their effects, else to 30."""
    asked: list[Work] = []

    def try_all(work, workshop, what, until):
        done = []
        for each in work:
            asked.append(each)
            done.append(fitted(left.get(each.effects, 30.0) * (0.5 if each.is_thorough else 1.0), *each.effects))
            if until(done[-1]):
                break
        return done

    monkeypatch.setattr(slips, "try_all", try_all)
    slips.on_the_nearest(alone, EMPTY)
    return asked


def fitted(misfit: float, *effects: str, has_series: bool = False) -> Candidate:
    """Return a cause whose fit leaves as much as its misfit."""
    cause = replace(named(misfit, *effects), has_series=has_series)
    return replace(cause, fit=SimpleNamespace(found=SimpleNamespace(error=misfit), name=cause.fit))


@pytest.mark.parametrize(("law_alone", "is_followed"), [(35.0, True), (9.0, False)])
def test_a_law_in_closed_form_comes_on_top_of_those_that_come_nearest_alone(monkeypatch, law_alone, is_followed):
    alone = [fitted(40.0), fitted(law_alone, "static_friction"), fitted(20.0, "sensor_drift"), fitted(30.0, "coil_lag")]
    alone += [fitted(8.0, "stribeck"), fitted(25.0, "position_dependent_friction"), fitted(35.0, "air_leak")]
    alone += [fitted(19.0, "load_force", has_series=True), fitted(18.0, "quantisation"), fitted(36.0, "end_stop")]
    alone += [fitted(37.0, "gap_drift"), fitted(38.0, "choked_flow"), fitted(39.0, "magnetic_saturation")]
    work = under_the_law(alone, {("coil_lag", "static_friction"): 10.0}, monkeypatch)
    keys = ["sensor_drift", "coil_lag", "air_leak", "end_stop", "gap_drift", "choked_flow"]
    assert [each.effects for each in work[:6]] == [(key, "static_friction") for key in keys]
    assert [each.fit.name for each in work[:6]] == keys
    assert all(each.is_global for each in work)
    # Longer on top of the two with which it came nearest, and nearer than alone, but for one whose runs are dear.
    assert [each.is_thorough for each in work] == [False] * 6 + [True] * is_followed
    assert [each.effects[0] for each in work[6:]] == ["sensor_drift"] * is_followed


def test_no_more_is_tried_under_the_law_once_that_explains_the_record(monkeypatch):
    alone = [fitted(40.0), fitted(9.0, "static_friction"), fitted(20.0, "sensor_drift"), fitted(30.0, "air_leak")]
    (work,) = under_the_law(alone, {("sensor_drift", "static_friction"): 1.0}, monkeypatch)
    assert work.effects == ("sensor_drift", "static_friction")


def at_rest(has_stairs: bool) -> SimpleNamespace:
    return SimpleNamespace(problem=SimpleNamespace(experiments=[SimpleNamespace(has_stairs=has_stairs)]))


@pytest.mark.parametrize(
    ("in_stairs", "left", "asked"),
    [
        (True, 30.0, ["line"]),
        (True, math.inf, ["line", "nearest"]),
        (False, 1.0, ["nearest"]),
        (False, 30.0, ["nearest", "line"]),
    ],
)
def test_the_line_tells_in_stairs_and_elsewhere_where_nothing_else_does(monkeypatch, in_stairs, left, asked):
    ways = []

    def way(name):
        return lambda *_: ways.append(name) or [named(left, "air_leak", "static_friction")] * math.isfinite(left)

    monkeypatch.setattr(slips, "speaks_for_slips", lambda alone: True)
    monkeypatch.setattr(slips, "by_the_line", way("line"))
    monkeypatch.setattr(slips, "on_the_nearest", way("nearest"))
    base = replace(named(40.0), fit=at_rest(in_stairs))
    tried = slips.beside_slips([base], EMPTY)
    assert ways == asked
    assert len(tried) == len(asked) * math.isfinite(left)


def test_slips_are_not_looked_at_where_a_coarse_reading_comes_nearer(monkeypatch):
    monkeypatch.setattr(slips, "stops_seen", lambda fit: True)
    monkeypatch.setattr(slips, "straight_line", lambda *_: pytest.fail("looked at"))
    base = replace(named(40.0), fit=at_rest(True))
    alone = [base, named(30.0, "static_friction"), named(10.0, "quantisation"), named(20.0, "area_variation")]
    assert slips.beside_slips(alone, EMPTY) == []


@pytest.mark.parametrize(("alone_by", "is_looked_at"), [(0.95, False), (0.85, True)])
def test_slips_are_looked_at_where_a_law_gains_though_the_line_is_straight(monkeypatch, alone_by, is_looked_at):
    """Another effect may be better alone: what shapes the slips leaves the breakaways on their line."""
    asked = []
    monkeypatch.setattr(slips, "stops_seen", lambda fit: True)
    monkeypatch.setattr(slips, "straight_line", lambda fit: SimpleNamespace(is_explained=True, is_in_reach=True))
    monkeypatch.setattr(slips, "on_the_line", lambda *given: None)
    monkeypatch.setattr(slips, "look_alone", lambda fit, line, laws, workshop: asked.append(list(laws)) or explained)
    explained = [SimpleNamespace(explains=True)]
    base = replace(named(40.0), fit=at_rest(True))
    alone = [base, named(alone_by * 40.0, "static_friction"), named(30.0, "load_force")]
    assert slips.by_the_line(alone, EMPTY) == []
    assert asked == [["static_friction"]] * is_looked_at


@pytest.mark.parametrize(
    ("has_stops", "alone_by", "other", "is_looked_for"),
    [(False, 0.95, 20.0, 0), (False, 0.85, 20.0, 1), (False, 0.85, 6.0, 0), (True, 1.0, 20.0, 1), (True, 1.0, 6.0, 1)],
)
def test_bends_are_looked_for_only_where_something_speaks_for_stick_slip(
    monkeypatch, has_stops, alone_by, other, is_looked_for
):
    looked = []
    monkeypatch.setattr(slips, "stops_seen", lambda fit: has_stops)
    monkeypatch.setattr(slips, "straight_line", lambda *given: looked.append(given))
    monkeypatch.setattr(slips, "on_the_nearest", lambda *given: [])
    base = replace(named(40.0), fit=at_rest(False))
    alone = [base, named(alone_by * 40.0, "static_friction"), named(other, "supply_droop")]
    assert slips.beside_slips(alone, EMPTY) == []
    assert len(looked) == is_looked_for


def looked(error: float, *effects: str):
    """Return a pair whose law comes so near at the slips, or whose slips tell nothing."""
    found = [SimpleNamespace(found=SimpleNamespace(error=error))] if error else []
    return slips.Look(Work("fit", effects, is_global=True), "line", found)


def test_pairs_are_searched_for_whole_that_come_near_the_best_at_the_slips():
    pairs = [
        looked(9000.0, "area_variation", "stribeck"),
        looked(3200.0, "spring_hardening", "stribeck"),
        looked(16000.0, "spring_hardening", "static_friction"),
        looked(4100.0, "linkage_nonlinearity", "stribeck"),
        looked(0.0, "gap_drift", "stribeck"),
    ]
    near = slips.nearest_at_slips(pairs, 20000.0)
    assert [each.effects[0] for each in near] == ["spring_hardening", "linkage_nonlinearity"]
    # The quick look is not taken again.
    assert [each.slips[0].found.error for each in near] == [3200.0, 4100.0]
    # A law that comes nearly as near alone needs no other effect.
    assert [each.effects[0] for each in slips.nearest_at_slips(pairs, 4100.0)] == ["spring_hardening"]
    assert slips.nearest_at_slips(pairs, 3900.0) == []
    # The breakaways themselves call for what alone brings them onto a line.
    near = slips.nearest_at_slips(pairs, 3900.0, "linkage_nonlinearity")
    assert [each.effects[0] for each in near] == ["linkage_nonlinearity"]
    assert slips.nearest_at_slips(pairs, 3900.0, "gap_drift") == []


def test_both_laws_are_searched_for_beside_the_nearest_effect_only():
    keys = ("spring_hardening", "linkage_nonlinearity", "area_variation", "gap_drift")
    pairs = [
        looked(1000.0 + 100.0 * number + extra, key, law)
        for number, key in enumerate(keys)
        for law, extra in (("stribeck", 0.0), ("static_friction", 50.0))
    ]
    near = [each.effects for each in slips.nearest_at_slips(pairs, 20000.0)]
    assert near == [
        ("spring_hardening", "stribeck"),
        ("spring_hardening", "static_friction"),
        ("linkage_nonlinearity", "stribeck"),
        ("area_variation", "stribeck"),
    ]


def test_friction_that_adds_to_coulombs_is_overcome_by_the_same_ratio(plant_and_base):
    plant, _, base = plant_and_base(9206, "pressure_dependent_friction", "stribeck")
    line = straight_line(base)
    bent = bent_line(base, line, effect_of_key("pressure_dependent_friction"))
    assert bent is not None
    (found, *_) = slips_by(bent.fit, effect_of_key("stribeck"), line=bent.line)
    point, names = found.found.point, [unknown.name for unknown in found.slips.problem.unknowns]
    ratio, friction, seal = (
        found.slips.problem.unknowns[names.index(name)].value(point[names.index(name)])
        for name in ("stribeck_ratio", "coulomb_friction", "friction_area")
    )
    on_line = bent.line.point
    for name, value in (("coulomb_friction", friction), ("friction_area", seal)):
        unknown = bent.problem.unknowns[[each.name for each in bent.problem.unknowns].index(name)]
        number = [each.name for each in bent.problem.unknowns].index(name)
        assert value * ratio == pytest.approx(float(unknown.value(on_line[number])), rel=1e-9)
    (true,) = (each for each in plant.effects if each.effect == "stribeck")
    assert float(ratio) - 1.0 == pytest.approx(true.parameters["static_excess"], rel=0.3)


def test_a_law_found_beside_one_effect_is_near_beside_another(plant_and_base):
    _, _, base = plant_and_base(9206, "pressure_dependent_friction", "stribeck")
    line, law = straight_line(base), effect_of_key("stribeck")
    bent = bent_line(base, line, effect_of_key("pressure_dependent_friction"))
    (found, *_) = slips_by(bent.fit, law, line=bent.line)
    (again, *_) = slips_beside(found, bent.fit, law, bent.line)
    assert again.found.error <= 1.01 * found.found.error
    other = bent_line(base, line, effect_of_key("area_variation"))
    (beside, *_) = slips_beside(found, other.fit, law, other.line)
    assert "area_slope" in [unknown.name for unknown in beside.slips.problem.unknowns]
    assert beside.found.error > again.found.error


def test_a_law_that_is_alone_is_looked_at_however_far_the_line_is():
    laws = [replace(named(9.0, "static_friction"), slips=["found"]), named(10.0, "stribeck")]
    seen = slips.to_look_at(laws, SimpleNamespace(is_in_reach=True))
    assert seen == {"static_friction": ["found"], "stribeck": None}
    assert slips.to_look_at(laws, SimpleNamespace(is_in_reach=False)) == {"static_friction": ["found"]}
    assert slips.to_look_at(laws[1:], SimpleNamespace(is_in_reach=False)) == {"stribeck": None}


@pytest.mark.parametrize(
    ("is_in_reach", "has_stops", "is_anew"), [(False, True, True), (True, True, False), (False, False, False)]
)
def test_the_dear_law_is_searched_for_alone_after_all_where_nothing_bends_the_line(
    monkeypatch, is_in_reach, has_stops, is_anew
):
    """Where no stops are seen it was searched for before."""
    line = SimpleNamespace(is_explained=False, is_in_reach=is_in_reach, error=99.0, count=10)
    monkeypatch.setattr(slips, "stops_seen", lambda fit: has_stops)
    monkeypatch.setattr(slips, "straight_line", lambda fit: line)
    monkeypatch.setattr(slips, "on_the_line", lambda *given: None)
    monkeypatch.setattr(slips, "look_alone", lambda *given: [SimpleNamespace(explains=False, error=9.0)])
    monkeypatch.setattr(slips, "bent_lines", lambda *given, **how: [])
    monkeypatch.setattr(slips, "try_all", lambda work, *_: work)
    base = replace(named(40.0), fit=SimpleNamespace(problem=None))
    alone = [base, named(30.0, "static_friction"), named(35.0, "stribeck"), named(20.0, "supply_droop")]
    alone.append(named(19.0, "static_friction", "quantisation"))
    work = slips.by_the_line(alone, EMPTY)
    assert [(each.effects, each.is_global, each.kin) for each in work] == [
        (("stribeck",), True, "static_friction")
    ] * is_anew
