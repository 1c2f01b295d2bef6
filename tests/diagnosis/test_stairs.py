"""Records with stairs: what counts beside a slip, readings in coarse steps, and errors in a single block."""

from __future__ import annotations

import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from workshops import EMPTY

from diagnosis.blindtest.plants import draw_plant, measure
from diagnosis.choosing import searching
from diagnosis.choosing.stairs import makes_stairs, stairs_beside, with_stairs
from diagnosis.judging.finding import order_of, verdict_of, yardstick_of
from diagnosis.judging.judgement import SUREST_UNKNOWN, Judgement, errors_beyond_noise, judge, rivals_of
from diagnosis.score import Errors, Score, score_fit
from diagnosis.trying.candidates import Candidate
from diagnosis.trying.workshop import Workshop
from identification.experiment import Experiment, Simulated, experiment_of
from identification.extending.extension import extend
from identification.fit import Fit, fit_base
from identification.holdout import hold_out
from identification.problem import Problem
from identification.search import errors
from identification.stick_slip.staircase import stops_on_the_way
from identification.unknowns import base_unknowns
from valvemodel.records import Record
from valvemodel.stages import EFFECTS


def plant_with(seed: int, *effects: str, duration: float = 150.0) -> Experiment:
    taken = measure(draw_plant(seed, effects), seed + 7, duration=duration)
    return experiment_of(Record.from_arrays(name="plant", **taken))


def base_of(given, experiment: Experiment) -> Fit:
    holdout = hold_out([experiment])
    return fit_base(given, holdout.experiments, holdout.fitted)


@pytest.fixture(scope="module")
def sticking() -> Experiment:
    """A plant by Karnopp's law."""
    return plant_with(9003, "static_friction")


def test_stick_slip_is_found_where_single_slips_come_early(given, sticking):
    (stepped,) = with_stairs([sticking], base_of(given, sticking))
    assert math.isfinite(stepped.reach)
    holdout = hold_out([stepped])
    base = base_of(given, stepped)
    assert makes_stairs(base, EFFECTS, EMPTY)
    found = extend(base, "static_friction")
    before, after = score_fit(base, holdout), score_fit(found, holdout)
    assert after.misfit < 0.25 * before.misfit
    assert after.free.rms < 0.3 * before.free.rms
    assert found.model.effects["static_friction"]["stick_speed"] > 1e-4


def test_a_lag_makes_no_stairs(given):
    assert not makes_stairs(base_of(given, plant_with(31, "sensor_lag", duration=60.0)), EFFECTS, EMPTY)


def test_a_reading_in_coarse_steps_makes_no_stairs(given, quiet):
    step = 12.0 * quiet.noise
    stepped = replace(quiet, position=np.round(quiet.position / step) * step)
    (judged,) = with_stairs([stepped], base_of(given, stepped))
    assert math.isfinite(judged.reach)
    assert not makes_stairs(base_of(given, judged), EFFECTS, EMPTY)


def test_a_valve_without_effect_keeps_its_squares(given, quiet):
    assert with_stairs([quiet], base_of(given, quiet)) == [quiet]


@pytest.mark.parametrize("step", [0.0, 3e-3])
@pytest.mark.parametrize("reach", [4.0, math.inf])
@pytest.mark.parametrize("within", [0.5, 0.25])
def test_sum_without_residuals_is_the_sum_of_residuals(given, quiet, reach, step, within):
    grid = np.round(quiet.position / 3e-3) * 3e-3
    experiment = replace(quiet, reach=reach, position=grid if step else quiet.position)
    model = given.with_effect("quantisation", resolution=step, resolution_offset=0.0) if step else given
    problem = Problem(model, [experiment], base_unknowns(given), [np.isfinite(experiment.position)], within=within)
    points = 0.1 * np.random.default_rng(0).standard_normal((3, len(problem.unknowns)))
    assert errors(problem, points) == pytest.approx(0.5 * (problem.residuals(points) ** 2).sum(axis=1), rel=1e-9)


def test_far_errors_count_by_their_logarithm(quiet):
    off = np.full((1, len(quiet.time)), 40.0 * quiet.noise) + quiet.position
    near = np.full((1, len(quiet.time)), 0.1 * quiet.noise) + quiet.position
    tempered = replace(quiet, reach=4.0)
    counted = [tempered.errors_of(Simulated(each, off, off, 0.0, each)) for each in (off, near)]
    assert counted[0] == pytest.approx(-4.0 * math.sqrt(math.log1p(100.0)))
    assert counted[1] == pytest.approx(-0.1, rel=1e-3)


def test_reading_in_steps_is_right_within_half_a_step(quiet):
    step = 40.0 * quiet.noise
    stepped = replace(quiet, position=np.round(quiet.position / step) * step)
    assert stepped.comes_in_steps(step, 0.0)
    assert not quiet.comes_in_steps(step, 0.0)
    # A stem that rests at even places, but for what is far beyond the noise, is no coarse reading.
    uneven = np.random.default_rng(1).uniform(-0.2, 0.2, len(quiet.position)) * step
    assert not replace(stepped, position=stepped.position + uneven).comes_in_steps(step, 0.0)
    run = Simulated(stepped.position, quiet.position, quiet.position, step, quiet.position[None, :])
    assert np.abs(stepped.errors_of(run)).max() < 1e-6


def score_of(*weighted: float) -> Score:
    counts = np.full(len(weighted), 100)
    run = Errors(np.array(weighted), 100.0 * np.array(weighted), counts, counts, 1.0)
    return Score(run, run)


def test_what_is_gained_in_one_block_alone_does_not_count():
    base, mine = score_of(1.0, 1.0, 60.0, 1.0, 1.0, 1.0), score_of(1.0, 1.0, 1.0, 1.0, 1.0, 1.0)
    assert errors_beyond_noise(mine, base) == pytest.approx((0.0, 0.0, 59.0 / 6.0))


def test_in_a_record_with_stairs_a_cause_is_as_far_off_as_the_runs_say_that_do_not_lose_the_phase_of_slips():
    free, anchored, at_rests = (score_of(*[left] * 6).free for left in (9.0, 1.44, 1.0))
    assert Score(free, anchored, at_rests).misfit == pytest.approx(1.2)
    assert Score(free, anchored).misfit == pytest.approx(3.6)


def test_what_is_left_of_the_whole_record_counts_where_it_is_more():
    """A lag shows itself at steps, and these may lie among the fitted samples."""
    unseen, whole = score_of(1.5, 1.0, 1.0, 1.0, 1.0, 1.0), score_of(*[4.0] * 8)
    mine, base = replace(unseen, whole=whole), replace(score_of(*[3.0] * 6), whole=score_of(*[9.0] * 8))
    assert mine.misfit == pytest.approx(4.0)
    assert errors_beyond_noise(mine, base) == pytest.approx((3.0, 8.0 - 5.0 / 8.0, 8.0))
    # A fit that follows its own samples alone is judged by the others.
    followed = replace(unseen, whole=score_of(*[0.5] * 8))
    assert followed.misfit == unseen.misfit
    assert errors_beyond_noise(followed, base)[0] == errors_beyond_noise(unseen, base)[0]


def test_what_is_missed_in_one_block_counts():
    base = score_of(9.0, 9.0, 60.0, 9.0, 9.0, 9.0)
    left, before, full = errors_beyond_noise(score_of(1.0, 1.0, 55.0, 1.0, 1.0, 1.0), base)
    assert left == pytest.approx(9.0)
    assert full == pytest.approx((45.0 + 60.0) / 6.0 - 1.0)
    assert before == pytest.approx((45.0 + 60.0) / 6.0 - 1.0 - 8.0 / 6.0)


def test_a_load_that_varies_at_will_is_spared_the_block_where_it_misses_most():
    base, mine = score_of(*[9.0] * 6), score_of(1.0, 1.0, 55.0, 1.0, 1.0, 3.0)
    assert errors_beyond_noise(mine, base)[0] == pytest.approx(62.0 / 6.0 - 1.0)
    assert errors_beyond_noise(mine, base, spares=True)[0] == pytest.approx(7.0 / 5.0 - 1.0)
    # Nor is it credited with what the base misses there.
    base = score_of(1.0, 1.0, 60.0, 1.0, 1.0, 1.0, 1.0)
    mine = score_of(1.0, 1.0, 55.0, 1.0, 1.0, 1.0, 1.0)
    assert errors_beyond_noise(mine, base, spares=True) == pytest.approx((0.0, 0.0, 0.0))
    few = score_of(9.0, 9.0, 1.0)
    assert errors_beyond_noise(few, few, spares=True) == errors_beyond_noise(few, few)


@pytest.mark.parametrize(("left", "loses"), [(1.0, False), (1.5, True)])
def test_a_whole_series_has_no_other_form_to_excuse_it(quiet, refitted, left, loses):
    base, _ = refitted(quiet)
    tried = [
        Candidate((), base.fit, score_of(*[400.0] * 12)),
        Candidate(("gap_drift",), base.fit, score_of(*[left] * 12), trace=9.0),
        Candidate(("load_force",), base.fit, score_of(*[left] * 12), trace=9.0, has_series=True),
    ]
    evidence = judge(tried).evidence
    assert (evidence[2] < evidence[1] - 1.0) == loses
    assert evidence[2] <= evidence[1]


@pytest.mark.parametrize(("chosen", "rivals"), [(1, [("stribeck",)]), (2, [])])
def test_an_alias_whose_search_comes_to_no_end_stays_a_rival(quiet, refitted, chosen, rivals):
    base, _ = refitted(quiet)
    tried = [
        Candidate((), base.fit, score_of(*[90.0] * 6)),
        Candidate(("static_friction",), base.fit, score_of(*[9.0 if chosen == 2 else 1.0] * 6), trace=9.0),
        Candidate(("stribeck",), base.fit, score_of(*[9.0 if chosen == 1 else 1.0] * 6), trace=9.0),
    ]
    evidence = np.array([0.0, 9.0, 9.0])
    evidence[chosen] = 20.0
    assert rivals_of(chosen, tried, Judgement(np.zeros(3), 0.0, evidence)) == rivals


def test_a_record_of_a_few_samples_shows_no_rests(quiet):
    short = replace(quiet, position=quiet.position[:15])
    assert stops_on_the_way(short, quiet.position[:15]) == 0


def test_a_fit_from_another_process_is_scored_from_its_own_start(quiet, refitted):
    base, _ = refitted(quiet)
    fit = replace(base.fit, starts=tuple(start + 0.01 for start in base.fit.starts))
    returned = pickle.loads(pickle.dumps(fit))
    (experiment,) = fit.problem.experiments
    assert returned.problem.experiments[0] is not experiment
    here, there = (each.simulated_on(experiment).position[0] for each in (fit, returned))
    np.testing.assert_array_equal(here, there)


@pytest.mark.parametrize(
    ("probabilities", "unknown", "verdict"),
    [
        ([0.30, 0.40, 0.25], 0.05, "effect"),
        ([0.40, 0.30, 0.25], 0.05, "none"),
        ([0.20, 0.10, 0.15], 0.55, "unknown"),
        ([0.05, 0.30, 0.25], 0.40, "effect"),
    ],
)
def test_the_verdict_is_that_of_the_most_probable_cause(quiet, refitted, probabilities, unknown, verdict):
    base, _ = refitted(quiet)
    tried = [Candidate(each, base.fit, score_of(*[1.0] * 6)) for each in ((), ("coil_lag",), ("sensor_lag",))]
    judgement = Judgement(np.array(probabilities), unknown, np.zeros(3))
    assert verdict_of(tried, judgement) == verdict
    order = order_of(tried, judgement)
    assert verdict == "unknown" or bool(tried[order[0]].effects) == (verdict == "effect")


def test_beside_no_effect_only_what_hides_in_the_base_cannot_be_told_from_it(quiet, refitted):
    base, _ = refitted(quiet)
    effects = [(), ("transport_delay",), ("air_leak",), ("linkage_backlash",)]
    tried = [Candidate(each, base.fit, score_of(*[1.0] * 6), trace=9.0) for each in effects]
    evidence = np.array([0.0, 0.3, 0.0, 0.1])
    assert rivals_of(0, tried, Judgement(np.zeros(4), 0.0, evidence)) == [("linkage_backlash",), ("air_leak",)]
    assert ("transport_delay",) in rivals_of(2, tried, Judgement(np.zeros(4), 0.0, evidence))


def test_of_causes_that_cannot_be_told_apart_the_most_probable_are_named(quiet, refitted):
    base, _ = refitted(quiet)
    effects = [(), ("coil_lag",), ("chamber_filling",), ("sensor_lag",), ("transport_delay",)]
    tried = [Candidate(each, base.fit, score_of(*[1.0] * 6), trace=9.0) for each in effects]
    evidence = np.array([0.0, 20.0, 20.3, 20.2, 19.9])
    judgement = Judgement(np.array([0.0, 0.4, 0.1, 0.2, 0.3]), 0.0, evidence)
    assert rivals_of(1, tried, judgement) == [("transport_delay",), ("sensor_lag",)]


def test_a_cause_that_is_far_less_probable_is_told_from_the_chosen_one(quiet, refitted):
    base, _ = refitted(quiet)
    effects = [(), ("coil_lag",), ("sensor_lag",), ("transport_delay",)]
    tried = [Candidate(each, base.fit, score_of(*[1.0] * 6), trace=9.0) for each in effects]
    judgement = Judgement(np.array([0.0, 0.9, 0.04, 0.06]), 0.0, np.array([0.0, 20.0, 19.0, 19.0]))
    assert rivals_of(1, tried, judgement) == [("transport_delay",)]


@pytest.mark.parametrize(
    ("alone", "pair", "other", "is_seen"),
    [
        (90.0, 20.0, "static_friction", True),
        (90.0, 50.0, "static_friction", False),
        (2.7, 1.2, "static_friction", False),
        (90.0, 20.0, "load_force", False),
    ],
)
def test_stairs_that_another_effect_hides_are_seen_beside_it(given, sticking, alone, pair, other, is_seen):
    base = base_of(given, sticking)
    tried = [
        Candidate((), base, score_of(*[100.0] * 6)),
        Candidate(("area_variation",), base, score_of(*[alone] * 6)),
        Candidate(("area_variation", other), base, score_of(*[pair] * 6)),
        Candidate(("area_variation", other, "load_force"), base, score_of(*[0.9 * pair] * 6)),
    ]
    holdout = hold_out([sticking], kept=0)
    seen = stairs_beside(tried, [sticking], holdout, given)
    assert (seen is not None) == is_seen
    if seen is not None:
        (stepped,), parted, tempered = seen
        assert math.isfinite(stepped.reach)
        assert tempered.problem.experiments == parted.experiments
        assert parted.kept == 0
        assert stairs_beside(tried, [stepped], parted, given) is None


@pytest.mark.parametrize(("left", "is_known"), [(1.2, True), (9.0, False)])
def test_two_effects_beside_which_stairs_showed_are_kept_and_spare_a_search_where_they_explain(
    given, sticking, monkeypatch, left, is_known
):
    """All that went before had been done once more, for three times as long: their fit led there at once.

    A right pair that had not come to the noise yet was lost, and not found again.
    """
    base = base_of(given, sticking)
    tried = [
        Candidate(effects, base, score_of(*[misfit] * 6))
        for effects, misfit in (
            ((), 100.0),
            (("load_force",), 30.0),
            (("static_friction",), 95.0),
            (("load_force", "static_friction"), 2.0),
            (("load_force", "stribeck"), 3.0),
            (("friction_drift", "stribeck"), 6.0),
        )
    ]
    fitted = []
    monkeypatch.setattr(searching, "fitted_to_all", lambda fit, *parts: fitted.append(parts) or fit)
    monkeypatch.setattr(searching, "scored", lambda effects, fit, _: Candidate(effects, fit, score_of(*[left] * 6)))
    holdout, first = hold_out([sticking], kept=0), Candidate(("coil_lag",), base, score_of(*[90.0] * 6))
    known = []

    def first_again(base, workshop, library, pairs=()):
        known.extend(pairs)
        return [base, first, *pairs], None

    monkeypatch.setattr(searching, "try_first", first_again)
    found, together = searching.try_first_again(tried, tried[0], Workshop(holdout), [])
    assert together is None
    again = [("load_force", "static_friction"), ("load_force", "stribeck"), ("static_friction",)]
    assert [each.effects for each in known] == again * is_known
    assert [each.effects for each in found] == [(), ("coil_lag",), *again]
    assert all(parts == (holdout.experiments, holdout.fitted) for parts in fitted)


@pytest.mark.parametrize(
    ("effects", "yardstick"),
    [
        (("static_friction",), "anchored"),
        (("coil_lag", "stribeck"), "anchored"),
        (("position_dependent_friction",), "free"),
        ((), "free"),
    ],
)
def test_a_gap_is_told_by_re_anchored_runs_where_the_stem_sticks_and_slips(effects, yardstick):
    """A law that was named rightly closed 9 % of the gap of an unseen record by free runs, 59 % by these."""
    assert yardstick_of(Candidate(effects, None, None)) == yardstick


def test_an_unknown_cause_is_never_certain(quiet, refitted):
    base, _ = refitted(quiet)
    tried = [
        Candidate((), base.fit, score_of(*[5000.0] * 6), trace=math.inf),
        Candidate(("coil_lag",), base.fit, score_of(*[4900.0] * 6), trace=9.0),
    ]
    judgement = judge(tried)
    assert judgement.unknown == SUREST_UNKNOWN
    assert judgement.probabilities.sum() == pytest.approx(1.0 - SUREST_UNKNOWN)
    explained = judge([*tried, Candidate(("end_stop",), base.fit, score_of(*[1.0] * 6), trace=9.0)])
    assert explained.unknown < 0.01
    assert explained.probabilities.sum() == pytest.approx(1.0 - explained.unknown)


def test_each_slip_by_itself_judges_in_place_of_the_free_run_where_there_are_stairs():
    free, mine = score_of(*[900.0] * 6).free, score_of(*[4.0] * 6)
    on_stairs = Score(free, mine.free, mine.free)
    base = Score(free, free, score_of(*[100.0] * 6).free)
    anchored, at_rests = 900.0 - 896.0 / 6.0, 100.0 - 96.0 / 6.0
    full = math.sqrt(900.0 * 100.0) - 1.0
    assert errors_beyond_noise(on_stairs, base) == pytest.approx((3.0, math.sqrt(anchored * at_rests) - 1.0, full))
    # What has no such run is judged by the others, and so is the base beside it.
    expected = (59.0, 30.0 * math.sqrt(anchored) - 1.0, 899.0)
    assert errors_beyond_noise(Score(free, mine.free), base) == pytest.approx(expected)
