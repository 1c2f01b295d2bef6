"""What is tried: stand-ins make room for what they stand in for."""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from types import SimpleNamespace

import pytest
from workshops import EMPTY

from diagnosis.choosing import alone as singles
from diagnosis.choosing import ending, proposals, rivals, selection
from diagnosis.choosing.proposals import FAR_BEHIND, NO_GAIN, exchanged, extensions, leaders_of, worthwhile
from diagnosis.trying import candidates, standing
from diagnosis.trying.candidates import Candidate, Work
from diagnosis.trying.explaining import AT_NOISE, explains
from diagnosis.trying.standing import (
    SETTLED_SHARE,
    blunt,
    is_dear,
    is_near_noise,
    is_settled,
    is_worth_its_time,
    values_alone,
    with_better,
)
from diagnosis.trying.workshop import Workshop
from identification.extending.glance import Glance
from valvemodel.effects import are_aliases, differ_by_aliases, effect_of_key


def candidate(misfit: float, *effects: str) -> Candidate:
    values = {key: {"size": misfit} for key in effects}
    model, found = SimpleNamespace(effects=values), SimpleNamespace(error=100.0 * misfit)
    problem = SimpleNamespace(
        is_anchored="stribeck" in effects, is_in_steps="quantisation" in effects, noise_error=100.0
    )
    fit = SimpleNamespace(name="+".join(effects), model=model, found=found, problem=problem)
    return Candidate(effects, fit, SimpleNamespace(misfit=misfit))


def glance(fit: object, error: float, share: float = 0.0) -> Glance:
    return Glance(SimpleNamespace(found=SimpleNamespace(error=error), beside=fit), share, 0.0)


def waves(misfit: float, *effects: str) -> Candidate:
    return replace(candidate(misfit, *effects), has_series=True)


def test_a_whole_series_leads_beside_others_not_in_their_place():
    load, best, near = waves(2.0, "load_force"), candidate(20.0, "coil_lag"), candidate(30.0, "area_variation")
    far = candidate(50.0, "air_leak")
    assert leaders_of([load, best, near, far]) == [load, best, near]
    assert leaders_of([best, near, load]) == [best, near]
    assert leaders_of([load]) == [load]


def test_what_makes_the_stem_jump_leads_as_well_where_it_follows_by_far_the_nearest_what_it_was_fitted_to():
    best, near, unseen_slip = candidate(20.0, "linkage_backlash"), candidate(30.0, "coil_lag"), 45.0
    law = candidate(unseen_slip, "static_friction")
    law.fit.found.error = 0.4 * best.fit.found.error
    assert leaders_of([best, near, law]) == [law, best, near]
    law.fit.found.error = 0.6 * best.fit.found.error
    assert leaders_of([best, near, law]) == [best, near]
    smooth = candidate(unseen_slip, "position_dependent_friction")
    smooth.fit.found.error = 0.1 * best.fit.found.error
    assert leaders_of([best, near, smooth]) == [best, near]
    # Runs that are put anew on the readings follow them in any case.
    law.fit.found.error = 0.1 * best.fit.found.error
    law.fit.problem.is_anchored = True
    assert leaders_of([best, near, law]) == [best, near]


def test_only_three_effects_that_come_nearer_than_two_are_looked_back_from():
    tried = [candidate(90.0), candidate(30.0, "coil_lag"), candidate(20.0, "coil_lag", "end_stop")]
    near, far = candidate(1.4, "coil_lag", "end_stop", "air_leak"), candidate(19.0, "coil_lag", "end_stop", "gap_drift")
    assert selection.worth_a_look_back([*tried, far, near], 3) == [near]
    load = waves(1.0, "coil_lag", "end_stop", "load_force")
    assert selection.worth_a_look_back([*tried, load], 3) == [load]
    assert selection.worth_a_look_back(tried, 3) == []


def test_what_comes_nearer_beside_slips_that_leave_no_trace_is_tried_alone_from_there(monkeypatch):
    alone = [candidate(90.0), candidate(9.0, "linkage_nonlinearity"), candidate(50.0, "static_friction")]
    idle = replace(candidate(0.93, "linkage_nonlinearity", "static_friction"), trace=0.0)
    monkeypatch.setattr(singles, "stops_seen", lambda fit: False)
    monkeypatch.setattr(singles, "speaks_softly_for_slips", lambda alone: False)
    monkeypatch.setattr(singles, "lags_beside_jumps", lambda *_: [])
    for name, made in (("try_by_promise", alone), ("try_widely", alone), ("beside_slips", [idle]), ("nearly", [])):
        monkeypatch.setattr(singles, name, lambda *_, made=made, **__: made)
    monkeypatch.setattr(singles, "blunt", lambda *_: [])
    tried_alone = []

    def try_all(work, *_):
        tried_alone.extend(each.kin for each in work)
        return [candidate(0.94, *each.effects) for each in work]

    monkeypatch.setattr(singles, "try_all", try_all)
    found, together = singles.try_first(alone[0], EMPTY, [])
    assert together is None
    assert tried_alone == [idle.fit] * 2
    assert {each.effects: each.score.misfit for each in found}["linkage_nonlinearity",] == 0.94


@pytest.mark.parametrize(
    ("left", "best", "is_slipping"),
    [(1.2, "chamber_filling", False), (7.0, "chamber_filling", True), (1.2, "static_friction", True)],
)
def test_slips_are_not_looked_at_where_two_smooth_effects_explain_the_record(monkeypatch, left, best, is_slipping):
    """Lines through breakaways took 40 to 60 s in records of which two smooth effects left nothing."""
    alone = [candidate(90.0), candidate(9.0, best), candidate(30.0, "stribeck"), candidate(50.0, "end_stop")]
    alone[0].fit.problem.experiments = [SimpleNamespace(has_stairs=False)]
    pair, asked = candidate(left, "chamber_filling", "end_stop"), []
    for name in ("try_by_promise", "try_widely"):
        monkeypatch.setattr(singles, name, lambda *_, **__: alone)
    for name in ("lags_beside_jumps", "beside_coarse_steps", "nearly", "blunt", "left_alone", "try_all"):
        monkeypatch.setattr(singles, name, lambda *_: [])
    monkeypatch.setattr(singles, "stops_seen", lambda fit: False)
    monkeypatch.setattr(singles, "speaks_for_slips", lambda alone: True)
    monkeypatch.setattr(singles, "try_jointly", lambda *_: [pair])
    monkeypatch.setattr(singles, "beside_slips", lambda *_: asked.append("slips") or [])
    tried, together = singles.try_first(alone[0], EMPTY, [])
    assert bool(asked) == is_slipping
    assert together == ([pair] if best == "chamber_filling" else None)
    # Pairs that are smooth take their place later, beside what comes on top of one effect.
    assert pair not in tried
    monkeypatch.setattr(selection, "try_jointly", lambda *_: asked.append("jointly") or [pair])
    monkeypatch.setattr(selection, "on_top_of_the_best", lambda tried, *_: list(tried))
    monkeypatch.setattr(selection, "with_kindred", lambda tried, *_: list(tried))
    monkeypatch.setattr(selection, "MOST_EFFECTS", 2)
    if together is not None:
        assert pair in selection.try_together(tried, EMPTY, together=together)
        assert "jointly" not in asked


def test_of_two_effects_those_that_make_the_stem_jump_are_looked_back_from():
    tried = [candidate(90.0), candidate(2.1, "static_friction"), candidate(1.2, "asymmetric_friction", "coil_lag")]
    jumps, chaotic = (candidate(1.1, "asymmetric_friction", key) for key in ("static_friction", "stribeck"))
    assert selection.worth_a_look_back([*tried, jumps], 2) == [jumps]
    assert selection.worth_a_look_back([*tried, chaotic], 2) == []
    assert selection.worth_a_look_back(tried, 2) == []


@pytest.mark.parametrize(
    ("single", "pair", "law", "is_out"),
    [
        (92.0, 67.0, "end_stop", True),
        (92.0, 67.0, "static_friction", False),
        (92.0, 5.0, "end_stop", False),
        (3.6, 3.0, "end_stop", False),
        (7.2, 7.1, "end_stop", True),
    ],
)
def test_two_effects_that_leave_much_and_little_less_than_one_are_not_tried_in_other_ways(
    monkeypatch, single, pair, law, is_out
):
    tried = [candidate(150.0), candidate(single, "coil_lag"), candidate(pair, "coil_lag", law)]
    assert selection.is_out_of_reach(tried) == is_out
    asked: list[str] = []
    named = ("exchanged", "on_what_stays", "near_misses", "worth_beginning_again", "jumps_anew", "nearly_together")
    monkeypatch.setattr(selection, "each_in_turn", lambda *_: [])
    monkeypatch.setattr(selection, "sharpen_all", lambda *_: [])
    monkeypatch.setattr(selection, "in_other_forms", lambda _: [])
    for name in named:
        monkeypatch.setattr(selection, name, lambda tried, name=name: asked.append(name) or [])
    selection.with_kindred(tried, EMPTY)
    assert set(asked) == ({"exchanged"} if is_out else {*named})
    monkeypatch.setattr(selection, "extensions", lambda leaders, *_: asked.append("looking back") or [])
    asked.clear()
    monkeypatch.setattr(selection, "reversed_pairs", lambda *_: asked.append("reversed") or [])
    selection.on_top_of_the_best(tried, tried[1:2], EMPTY)
    assert ("reversed" in asked) != is_out


@pytest.mark.parametrize(("left", "is_called"), [(1.1, True), (1.01, False), (9.0, False)])
def test_what_a_pair_shares_with_the_best_begins_with_its_numbers_there(left, is_called):
    """A slow transmitter beside an end stop had stayed at a tenth of the lag that it has beside a saturated core."""
    tried = [candidate(90.0), candidate(2.0, "end_stop"), candidate(80.0, "coil_lag"), candidate(70.0, "sensor_lag")]
    best = candidate(left, "sensor_lag", "magnetic_saturation")
    best.fit.model.effects["sensor_lag"] = {"size": 44.0}
    astray, same = (candidate(1.7 * left, key, "sensor_lag") for key in ("end_stop", "coil_lag"))
    same.fit.model.effects["sensor_lag"] = {"size": 43.0}
    apart = candidate(1.6 * left, "end_stop", "coil_lag")
    (*work,) = proposals.from_numbers_of_the_best([*tried, best, astray, same, apart])
    assert [(each.effects, each.known) for each in work] == [(("end_stop", "sensor_lag"), {"size": 44.0})] * is_called
    assert all(each.fit is tried[1].fit and each.is_known for each in work)


def test_both_effects_of_the_best_pairs_are_searched_for_again_where_nothing_explains():
    tried = [candidate(90.0), candidate(30.0, "coil_lag")]
    pairs = [candidate(5.0, "coil_lag", "static_friction"), candidate(5.5, "coil_lag", "end_stop")]
    pairs += [candidate(6.0, "air_leak", "end_stop")]
    assert selection.worth_trying_anew([*tried, *pairs]) == [pairs[1]]
    # What leaves much lacks more than a form.
    assert selection.worth_trying_anew([*tried, candidate(9.0, "coil_lag", "end_stop")]) == []
    assert selection.worth_trying_anew([*tried, *pairs, candidate(1.1, "gap_drift", "air_leak")]) == []


@pytest.mark.parametrize(("left", "is_searched"), [(1.09, False), (1.2, True)])
def test_beside_a_base_near_the_noise_no_cause_is_searched_for_from_every_start(left, is_searched):
    work = singles.nearly([candidate(left), candidate(1.08, "spring_hardening")])
    assert bool(work) == is_searched


@pytest.mark.parametrize(("left", "is_looked_for"), [(1.05, False), (1.08, True)])
def test_beside_a_single_effect_near_the_noise_no_second_one_is_looked_for(left, is_looked_for):
    tried = [candidate(40.0), candidate(left, "coil_lag")]
    assert ending.is_explained(tried, 2) != is_looked_for


@pytest.mark.parametrize(("alone", "is_looked_for"), [(1.33, True), (2.0, False)])
def test_two_effects_of_which_one_adds_nothing_end_no_search(alone, is_looked_for):
    """Saturation beside a slow transmitter was never tried: static friction beside it left as little as the lag did."""
    tried = [candidate(9.0), candidate(alone, "sensor_lag"), candidate(7.0, "static_friction")]
    tried.append(candidate(1.31, "static_friction", "sensor_lag"))
    assert ending.is_explained(tried, 2) != is_looked_for
    assert ending.is_told(tried) != is_looked_for


def test_single_effects_that_nearly_explain_are_searched_for_from_every_start():
    base, best = candidate(40.0), candidate(1.5, "spring_hardening")
    others = [candidate(3.0, "magnetic_saturation"), waves(2.0, "load_force"), candidate(9.0, "coil_lag")]
    work = singles.nearly([base, best, *others])
    assert [each.effects for each in work] == [("spring_hardening",), ("magnetic_saturation",)]
    assert all(each.follows_all and each.fit is base.fit for each in work)
    assert singles.nearly([base, candidate(1.01, "coil_lag"), *others]) == []
    assert singles.nearly([base, candidate(20.0, "coil_lag"), candidate(18.0, "magnetic_saturation")]) == []


def test_a_pair_with_a_series_is_tried_in_the_other_order():
    load, lag = waves(30.0, "load_force"), candidate(9.0, "coil_lag")
    pair = waves(4.0, "coil_lag", "load_force")
    (work,) = proposals.reversed_pairs([candidate(90.0), load, lag, pair], {"coil_lag": {}, "load_force": {}})
    assert work.effects == ("load_force", "coil_lag")
    assert work.fit is load.fit
    lost = replace(pair, orders=frozenset({pair.effects, pair.effects[::-1]}))
    assert proposals.reversed_pairs([candidate(90.0), load, lag, lost], {"coil_lag": {}, "load_force": {}}) == []


@pytest.mark.parametrize(("left", "orders"), [(1.1, [("air_leak", "coil_lag")]), (2.0, [("air_leak", "coil_lag")] * 2)])
def test_pairs_far_behind_two_that_explain_the_record_are_not_tried_in_the_other_order(left, orders):
    """Unequal filling on top of a tight spot took 25 s, and stayed at nineteen times the noise."""
    alone = [candidate(30.0, "coil_lag"), candidate(40.0, "air_leak"), candidate(50.0, "area_variation")]
    pairs = [candidate(left, "coil_lag", "air_leak"), candidate(9.0, "coil_lag", "area_variation")]
    single = {key: {} for key in ("coil_lag", "air_leak", "area_variation")}
    work = proposals.reversed_pairs([candidate(90.0), *alone, *pairs], single)
    assert len(work) == len(orders)
    assert work[0].effects == orders[0]
    assert all(math.isfinite(each.worth) for each in work)


def test_the_nearest_of_the_same_effects_knows_of_the_order_that_lost():
    pair, other = candidate(4.0, "coil_lag", "air_leak"), candidate(5.0, "air_leak", "coil_lag")
    tried_in = [replace(each, orders=frozenset({each.effects})) for each in (pair, other)]
    (best,) = with_better(tried_in[:1], tried_in[1:])
    assert best.effects == pair.effects
    assert best.orders == {pair.effects, other.effects}
    # Of two that are as near it is the later one.
    (later,) = with_better([pair], [candidate(4.0, "coil_lag", "air_leak")])
    assert later.fit is not pair.fit


@pytest.mark.parametrize(("left", "expected"), [(1.6, ["air_leak", "linkage_backlash"]), (30.0, [])])
def test_what_comes_close_to_no_effect_is_tried_where_little_is_left(monkeypatch, left, expected):
    monkeypatch.setattr(proposals, "stopping_on", lambda *_: [])
    monkeypatch.setattr(proposals, "promises", lambda fit, starts, workshop: dict.fromkeys(starts, 0.0))
    tried = [candidate(40.0), candidate(left, "supply_droop")]
    single = {key: {} for key in ("supply_droop", "coil_lag", "air_leak", "linkage_backlash")}
    work = extensions(tried[1:], tried, single, 0, EMPTY)
    assert [each.effects for each in work] == [("supply_droop", key) for key in expected]


@pytest.mark.parametrize(("left", "expected"), [(1.2, ["coil_lag"]), (20.0, ["coil_lag", "static_friction"])])
def test_what_makes_the_stem_stop_is_searched_for_where_nothing_explains_the_record(monkeypatch, left, expected):
    tried = [candidate(40.0), candidate(25.0, "supply_droop")]
    jobs = [
        Work(tried[1].fit, ("supply_droop", key), is_global=key == "static_friction")
        for key in ("static_friction", "coil_lag")
    ]
    monkeypatch.setattr(selection, "extensions", lambda *_: jobs)
    monkeypatch.setattr(selection, "exchanged", lambda _: [])
    monkeypatch.setattr(selection, "on_what_stays", lambda _: [])
    monkeypatch.setattr(selection, "worth_beginning_again", lambda _: [])
    done = []

    def try_all(work, *_):
        done.extend(each.effects[-1] for each in work)
        return [candidate(left, *each.effects) for each in work]

    monkeypatch.setattr(selection, "try_all", try_all)
    monkeypatch.setattr(selection, "MOST_EFFECTS", 2)
    monkeypatch.setattr(selection, "reversed_pairs", lambda *_: [])
    monkeypatch.setattr(selection, "sharpen_all", lambda *_: [])
    monkeypatch.setattr(selection, "each_in_turn", lambda *_: [])
    monkeypatch.setattr(selection, "try_jointly", lambda *_: [])
    selection.try_together(tried, EMPTY)
    assert list(dict.fromkeys(done)) == expected


def sharpened_all(causes, *_):
    return [replace(each, is_sharpened=True) for each in causes]


def test_no_fit_is_searched_about_twice(monkeypatch):
    """The best two effects and their nearest alias are, each once; so is one that was begun again in vain."""
    asked = []
    monkeypatch.setattr(selection, "try_all", lambda *_: [])
    monkeypatch.setattr(selection, "each_in_turn", lambda *_: [])
    monkeypatch.setattr(selection, "sharpen_all", lambda causes, *_: asked.extend(causes) or sharpened_all(causes))
    monkeypatch.setattr(selection, "worth_beginning_again", lambda tried: tried[1:])
    monkeypatch.setattr(candidates, "begun_again", lambda fit: fit)
    monkeypatch.setattr(selection, "change_all", lambda change, causes, *_: [change(each, None) for each in causes])
    done = replace(candidate(5.0, "coil_lag", "static_friction"), is_sharpened=True)
    pair = candidate(6.0, "coil_lag", "stribeck")
    for rule in (
        "exchanged",
        "on_what_stays",
        "near_misses",
        "worth_trying_anew",
        "jumps_anew",
        "other_laws",
        "in_other_forms",
    ):
        monkeypatch.setattr(selection, rule, lambda *_: [])
    known = selection.with_kindred([candidate(40.0), done, pair], EMPTY)
    assert asked == [pair]
    assert all(each.is_sharpened for each in known[1:])


@pytest.mark.parametrize(("left", "is_asked"), [(0.5, True), (2.0, False)])
def test_a_pair_that_is_off_by_more_than_a_phase_is_not_brought_back_into_it(monkeypatch, left, is_asked):
    monkeypatch.setattr(singles, "sharpen_all", sharpened_all)
    pair = candidate(left * singles.OUT_OF_PHASE, "coil_lag", "stribeck")
    _, found = singles.in_phase([candidate(900.0), pair], EMPTY)
    assert found.is_sharpened == is_asked


@pytest.mark.parametrize(
    ("pair", "is_followed"),
    [
        (candidate(1.1, "coil_lag", "gap_drift"), False),
        (candidate(1.1, "coil_lag", "position_dependent_friction"), True),
        (candidate(1.04, "coil_lag", "position_dependent_friction"), False),
        (waves(1.1, "coil_lag", "load_force"), True),
        (candidate(9.0, "coil_lag", "gap_drift"), True),
    ],
)
def test_two_that_explain_together_end_the_search_unless_one_may_stand_in(monkeypatch, pair, is_followed):
    followed = []
    monkeypatch.setattr(selection, "try_jointly", lambda *_: [pair])
    monkeypatch.setattr(selection, "on_top_of_the_best", lambda tried, *_: followed.append(tried) or tried)
    monkeypatch.setattr(selection, "with_kindred", lambda tried, *_: tried)
    monkeypatch.setattr(selection, "MOST_EFFECTS", 2)
    selection.try_together([candidate(40.0), candidate(20.0, "coil_lag")], EMPTY)
    assert bool(followed) == is_followed


@pytest.mark.parametrize(
    ("pair", "is_tried"),
    [
        (candidate(30.0, "spring_hardening", "load_force"), True),
        (candidate(3.0, "spring_hardening", "load_force"), False),
        (candidate(30.0, "spring_hardening", "coil_lag"), False),
    ],
)
def test_what_is_read_off_a_residual_is_tried_on_top_of_the_fit_that_leaves_it(monkeypatch, pair, is_tried):
    """Its periods beside another fit, as that of the base, are none where that leaves much else."""
    pair = replace(pair, orders=frozenset({pair.effects}))
    key = pair.effects[1]
    monkeypatch.setattr(proposals, "stopping_on", lambda *_: [])
    monkeypatch.setattr(proposals, "shortlist", lambda *_: [key])
    leader = candidate(20.0, "spring_hardening")
    work = extensions([leader], [candidate(90.0), leader, candidate(80.0, key), pair], {key: {"size": 1.0}}, 6, EMPTY)
    assert [each.effects for each in work] == ([pair.effects] if is_tried else [])


@pytest.mark.parametrize(("alone", "is_begun_there"), [(89.0, False), (70.0, True)])
def test_what_an_effect_came_to_alone_is_no_start_where_it_explained_nothing(monkeypatch, alone, is_begun_there):
    """Choked flow beside a tight spot had ended at seven times the noise from there, and its own starts lead to one."""
    monkeypatch.setattr(proposals, "stopping_on", lambda *_: [])
    monkeypatch.setattr(proposals, "shortlist", lambda *_: ["choked_flow", "quantisation"])
    leader, single = candidate(20.0, "position_dependent_friction"), {"choked_flow": {"size": alone}}
    tried = [candidate(90.0), leader, candidate(alone, "choked_flow"), candidate(95.0, "quantisation")]
    work = extensions([leader], tried, single | {"quantisation": {"size": 95.0}}, 6, EMPTY)
    # What is read off the record is as it was read.
    assert [each.known for each in work] == [single["choked_flow"] if is_begun_there else None, {"size": 95.0}]


def test_a_load_of_one_wave_that_was_followed_together_is_tried_on_top_as_many(monkeypatch):
    monkeypatch.setattr(proposals, "stopping_on", lambda *_: [])
    monkeypatch.setattr(proposals, "shortlist", lambda *_: ["load_force"])
    tight, load = candidate(20.0, "position_dependent_friction"), waves(30.0, "load_force")
    together = candidate(8.0, "position_dependent_friction", "load_force")
    single = {"load_force": {"size": 1.0}}
    (work,) = extensions([tight], [candidate(90.0), tight, load, together], single, 6, EMPTY)
    assert work.effects == together.effects
    on_top = replace(together, orders=frozenset({together.effects}))
    assert extensions([tight], [candidate(90.0), tight, load, on_top], single, 6, EMPTY) == []


@pytest.mark.parametrize(
    ("alone", "is_asked"),
    [
        (candidate(1.02, "coil_lag"), False),
        (candidate(1.1, "coil_lag"), True),
        (candidate(1.02, "position_dependent_friction"), True),
        (waves(1.01, "load_force"), True),
        (candidate(9.0, "static_friction"), False),
        (candidate(9.0, "quantisation"), False),
        (candidate(9.0, "coil_lag"), True),
    ],
)
def test_two_are_tried_jointly_where_none_alone_explains_or_what_does_may_stand_in(monkeypatch, alone, is_asked):
    asked = []
    monkeypatch.setattr(selection, "try_jointly", lambda *_: asked.append(1) or [])
    monkeypatch.setattr(selection, "on_top_of_the_best", lambda tried, *_: tried)
    monkeypatch.setattr(selection, "MOST_EFFECTS", 2)
    selection.try_together([candidate(40.0), alone], EMPTY)
    assert bool(asked) == is_asked


def test_a_whole_series_is_laid_on_top_of_the_other_effect_and_bears_no_third(monkeypatch):
    monkeypatch.setattr(proposals, "stopping_on", lambda *_: [])
    monkeypatch.setattr(proposals, "shortlist", lambda *_: ["coil_lag"])
    load, lag = waves(2.0, "load_force"), candidate(9.0, "coil_lag")
    tried = [candidate(20.0), load, lag]
    single = {each.effects[0]: {"size": each.score.misfit} for each in (load, lag)}
    (work,) = extensions([load], tried, single, 6, EMPTY)
    assert work.effects == ("coil_lag", "load_force")
    assert work.fit is lag.fit
    assert work.known == {"size": 2.0}
    assert work.is_known
    (plain,) = extensions([candidate(8.0, "air_leak")], tried, single, 6, EMPTY)
    assert plain.effects == ("air_leak", "coil_lag")
    assert extensions([waves(1.5, "air_leak", "load_force")], tried, single, 6, EMPTY) == []
    with_one_wave = candidate(8.5, "coil_lag", "load_force")
    assert [each.effects for each in extensions([load], [*tried, with_one_wave], single, 6, EMPTY)] == [work.effects]
    assert extensions([load], [*tried, replace(with_one_wave, has_series=True)], single, 6, EMPTY) == []


def test_what_is_read_off_the_record_is_laid_on_top_of_all_others(monkeypatch):
    monkeypatch.setattr(proposals, "promises", lambda *_: {})
    reading, lag = candidate(5.0, "quantisation"), candidate(19.9, "coil_lag")
    bristles, worse = candidate(9.0, "presliding"), candidate(21.0, "supply_droop")
    tried = [candidate(20.0), reading, lag, bristles, worse]
    single = values_alone(tried)
    work = extensions([reading], tried, single, 0, EMPTY)
    assert [each.effects[0] for each in work] == ["presliding", "coil_lag", "supply_droop"]
    assert all(each.effects[1] == "quantisation" and each.is_known for each in work)
    assert all(each.known == {"size": 5.0} for each in work)
    assert work[1].fit is lag.fit
    # Bristles that explain little take too long.
    slow = [tried[0], reading, candidate(19.9, "presliding")]
    assert extensions([reading], slow, values_alone(slow), 0, EMPTY) == []


@pytest.mark.parametrize(("left", "count"), [(5.0, 1), (1.0, 0)])
def test_beside_a_coarse_reading_all_is_tried_where_it_leaves_something(monkeypatch, left, count):
    def try_all(work, *_):
        return [candidate(left - 2.0, *each.effects) for each in work]

    monkeypatch.setattr(singles, "try_all", try_all)
    monkeypatch.setattr(singles, "sharpen_all", lambda causes, *_: [replace(each, trace=9.0) for each in causes])
    monkeypatch.setattr(singles, "with_better", lambda tried, others: [*others] or [*tried])
    monkeypatch.setattr(proposals, "promises", lambda *_: {})
    tried = [candidate(20.0), candidate(left, "quantisation"), candidate(19.0, "static_friction")]
    found = singles.beside_reading(tried, EMPTY)
    assert [each.trace for each in found] == [9.0] * count  # searched about
    assert singles.beside_reading(tried[::2], EMPTY) == []


@pytest.mark.parametrize(("key", "is_blunt"), [("static_friction", True), ("coil_lag", False)])
def test_readings_in_coarse_steps_are_searched_about_where_the_stem_jumps_beside_them(key, is_blunt):
    pair = candidate(9.0, key, "quantisation")
    assert blunt([pair], candidate(200.0)) == [pair] * is_blunt


@pytest.mark.parametrize(("error", "is_enough"), [(90.0, True), (700.0, False)])
def test_coarse_readings_are_all_only_if_they_leave_noise_of_what_was_fitted(error, is_enough):
    """A slow transmitter behind them had left little of what was kept back."""
    reading = candidate(1.2, "quantisation")
    reading.fit.found.error = error
    assert ending.is_enough(reading, candidate(90.0)) is is_enough
    spring = candidate(1.2, "spring_hardening")
    spring.fit.found.error = error
    assert ending.is_enough(spring, candidate(90.0))


@pytest.mark.parametrize(("left", "expected"), [(1.2, ["air_leak", "linkage_backlash"]), (1.01, []), (9.0, [])])
def test_what_comes_close_to_none_is_tried_on_top_of_one_effect_that_explains_but_leaves_some(left, expected):
    tried = [candidate(40.0), candidate(left, "supply_droop"), candidate(39.0, "coil_lag")]
    tried += [candidate(40.0, "air_leak"), candidate(40.0, "linkage_backlash")]
    work = proposals.on_what_explains(tried)
    assert [each.effects for each in work] == [("supply_droop", key) for key in expected]
    assert all(each.fit is tried[1].fit for each in work)
    more = [*tried, candidate(left, "air_leak", "supply_droop")]
    assert [each.effects[1] for each in proposals.on_what_explains(more)] == expected[1:]


@pytest.mark.parametrize(("left", "is_searched"), [(1.2, True), (1.01, False), (9.0, False)])
def test_the_nearest_pairs_are_searched_for_from_every_start_in_either_order_where_little_is_left(left, is_searched):
    """A pair that is right had ended in a side minimum, and came to the noise in the other order."""
    alone = [candidate(70.0, "sensor_drift"), candidate(80.0, "area_variation"), candidate(75.0, "presliding")]
    pairs = [candidate(left, "sensor_drift", "area_variation"), candidate(1.1 * left, "sensor_drift", "presliding")]
    work = proposals.nearly_together([candidate(90.0), *alone, *pairs, candidate(4.0 * left, "coil_lag", "air_leak")])
    expected = [("sensor_drift", "area_variation"), ("area_variation", "sensor_drift")] * is_searched
    assert [each.effects for each in work] == expected
    assert all(each.follows_all for each in work)
    assert [each.fit for each in work] == [each.fit for each in alone[:2]][: len(work)]


@pytest.mark.parametrize(("error", "is_searched"), [(101.0, False), (105.0, True)])
def test_what_was_fitted_to_the_noise_is_in_no_side_minimum(error, is_searched):
    """Unseen data may show a little more than noise all the same."""
    base, best = candidate(90.0), candidate(1.2, "air_leak")
    best.fit.found.error = error
    assert bool(singles.nearly([base, best])) == is_searched
    pair = candidate(1.2, "air_leak", "end_stop")
    pair.fit.found.error = error
    assert bool(proposals.nearly_together([base, best, candidate(50.0, "end_stop"), pair])) == is_searched


@pytest.mark.parametrize(("left", "promises"), [(1.05, [0.0]), (1.2, [0.0, proposals.PROMISE_IF_SLOW])])
def test_on_what_takes_long_to_run_another_is_tried_only_where_it_may_come_nearer(left, promises):
    alone = [candidate(60.0, "presliding"), candidate(50.0, "area_variation"), candidate(70.0, "sensor_drift")]
    best, behind = candidate(left, "presliding", "area_variation"), candidate(2.0, "sensor_drift", "presliding")
    other = candidate(2.1, "sensor_drift", "area_variation")
    known = [replace(each, orders=frozenset({each.effects})) for each in (best, behind, other)]
    work = proposals.near_misses([candidate(90.0), *alone, *known])
    assert [each.promise for each in work if each.effects[0] != "sensor_drift"] == promises[::-1]
    assert {each.effects for each in work} >= {("area_variation", "sensor_drift")}
    assert (("presliding", "sensor_drift") in {each.effects for each in work}) == (len(promises) > 1)


def test_what_is_dear_to_run_is_not_tried_on_top_of_what_makes_fits_long():
    """Unequal filling on top of a tight spot took 21 s, beside two that were at the noise."""
    alone = [candidate(60.0, "position_dependent_friction"), candidate(50.0, "asymmetric_filling")]
    alone += [candidate(70.0, "area_variation")]
    best = candidate(1.2, "area_variation", "asymmetric_filling")
    behind = candidate(2.0, "asymmetric_filling", "position_dependent_friction")
    other = candidate(2.1, "area_variation", "position_dependent_friction")
    known = [replace(each, orders=frozenset({each.effects})) for each in (best, behind, other)]
    work = {each.effects for each in proposals.near_misses([candidate(90.0), *alone, *known])}
    assert ("position_dependent_friction", "area_variation") in work
    assert ("position_dependent_friction", "asymmetric_filling") not in work


@pytest.mark.parametrize(
    ("left", "fitted", "promise"), [(1.2, 1.02, proposals.PROMISE_IF_SLOW), (1.2, 1.2, 0.0), (9.0, 9.0, 0.0)]
)
def test_on_what_has_many_numbers_another_must_promise_something_where_two_explain(monkeypatch, left, fitted, promise):
    """Eight more on a tight spot that left a hundred took 12 s, though play beside it left little more than noise.

    Where the two leave some of what they were fitted to they may stand in: saturation did for choked flow.
    """
    asked: list[Work] = []
    alone = [candidate(60.0, "position_dependent_friction"), candidate(80.0, "linkage_backlash")]
    tried = [candidate(90.0), *alone, candidate(left, "position_dependent_friction", "linkage_backlash")]
    tried[-1].fit.found.error = 100.0 * fitted
    work = [Work(each.fit, (*each.effects, "air_leak"), is_global=False) for each in alone]
    monkeypatch.setattr(selection, "extensions", lambda *_: work)
    monkeypatch.setattr(selection, "try_all", lambda work, *_: asked.extend(work) or [])
    selection.on_top_of_the_best(tried, tried[1:2], EMPTY)
    assert [each.promise for each in asked[:2]] == [promise, 0.0]
    # A third one takes longest of all.
    work = [replace(each, effects=(*each.effects, "coil_lag")) for each in work]
    asked.clear()
    selection.on_top_of_the_best(tried, tried[3:4], EMPTY)
    assert [each.promise for each in asked[:2]] == [proposals.PROMISE_IF_SLOW, 0.0]


@pytest.mark.parametrize(("nearer", "is_followed"), [(1.65, False), (2.4, True)])
def test_what_gains_nothing_over_a_single_effect_as_that_came_nearest_is_not_followed(monkeypatch, nearer, is_followed):
    """All on top of static friction took 50 s: beside unequal filling it had led that one out of a side minimum."""
    alone = [candidate(2.5, "asymmetric_filling"), candidate(80.0, "static_friction")]
    pair, leaders = candidate(1.6, "asymmetric_filling", "static_friction"), []
    tried = [candidate(90.0), *alone, pair]
    monkeypatch.setattr(selection, "extensions", lambda causes, *_: leaders.append(causes) or [])
    monkeypatch.setattr(selection, "left_alone", lambda _: ["nearer"])
    for name in ("ended_at_nothing", "reversed_pairs", "sharpen_all"):
        monkeypatch.setattr(selection, name, lambda *_: [])
    monkeypatch.setattr(
        selection, "try_all", lambda work, *_: [candidate(nearer, "asymmetric_filling")] if "nearer" in work else []
    )
    found = selection.on_top_of_the_best(tried, alone[:1], EMPTY)
    assert [alone[1]] in leaders if is_followed else [alone[1]] not in leaders
    assert standing.as_tried(alone[0], found).score.misfit == nearer


@pytest.mark.parametrize(("left", "behind", "is_tried"), [(1.1, 4.1, True), (1.1, 1.11, False), (3.0, 9.0, False)])
def test_an_alias_is_tried_from_where_the_best_two_came(left, behind, is_tried):
    """A hardening spring alone had been bent to an end stop: beside that it led nowhere, and a bowed linkage won."""
    alone = [candidate(50.0, "end_stop"), candidate(47.0, "spring_hardening"), candidate(60.0, "linkage_nonlinearity")]
    best, other = candidate(left, "end_stop", "linkage_nonlinearity"), candidate(behind, "end_stop", "spring_hardening")
    work = proposals.from_the_best([candidate(90.0), *alone, best, other])
    assert [(each.effects, each.fit, each.kin) for each in work] == [
        (("end_stop", "spring_hardening"), alone[0].fit, best.fit)
    ] * is_tried


@pytest.mark.parametrize(("behind", "is_tried"), [(12.0, True), (1.05, False)])
def test_what_a_law_of_many_numbers_explains_is_tried_with_the_one_in_closed_form(behind, is_tried):
    """A dead time beside static friction had been left at twelve times the noise, and Stribeck's law was named."""
    alone = [candidate(200.0, "static_friction"), candidate(300.0, "stribeck"), candidate(150.0, "transport_delay")]
    pair = ("transport_delay", "stribeck")
    best, other = candidate(1.04, *pair), candidate(behind, "static_friction", "transport_delay")
    work = proposals.law_in_closed_form([candidate(440.0), *alone, best, other])
    assert [(each.effects, each.is_global, each.kin) for each in work] == [
        (("transport_delay", "static_friction"), True, best.fit)
    ] * is_tried
    assert proposals.law_in_closed_form([candidate(440.0), *alone, candidate(90.0, *pair)]) == []
    assert proposals.law_in_closed_form([candidate(440.0), *alone]) == []


def test_what_is_dear_to_run_is_not_searched_for_from_every_start_beside_another():
    alone = [candidate(60.0, "sensor_lag"), candidate(1.7, "asymmetric_filling")]
    work = proposals.nearly_together([candidate(90.0), *alone, candidate(1.4, "asymmetric_filling", "sensor_lag")])
    assert {each.effects[1]: each.follows_all for each in work} == {"sensor_lag": True, "asymmetric_filling": False}


def test_what_an_effect_may_stand_in_for_is_tried_on_top_of_what_stays():
    """Saturation as fitted alone had gone astray beside a drift: on top of the drift it comes to the noise."""
    alone = [candidate(1.6, "friction_drift"), candidate(97.0, "magnetic_saturation"), candidate(88.0, "choked_flow")]
    alone += [candidate(89.0, "coil_lag"), candidate(90.0, "linkage_backlash"), candidate(89.5, "static_friction")]
    best, behind = candidate(1.15, "friction_drift", "choked_flow"), ("magnetic_saturation", "friction_drift")
    tried = [candidate(90.0), *alone, best]
    expected = [("friction_drift", "magnetic_saturation"), ("friction_drift", "linkage_backlash")]
    for known, kept in (([], 0), ([candidate(1.5, *behind)], 0), ([candidate(1.16, *behind)], 1)):
        work = proposals.on_what_stays([*tried, *known])
        assert [each.effects for each in work] == expected[kept:]
        assert all(each.fit is alone[0].fit for each in work)
    assert proposals.on_what_stays([*tried, candidate(1.5, *behind[::-1])])[0].effects == expected[1]
    # At the noise nothing comes nearer, but an alias may come as near.
    at_noise = proposals.on_what_stays([*tried[:-1], candidate(1.01, "friction_drift", "choked_flow")])
    assert [each.effects for each in at_noise] == expected[:1]


BEHIND_BEST = ("spring_hardening", "air_leak")


@pytest.mark.parametrize(
    ("left", "orders", "expected"),
    [
        (3.1, {BEHIND_BEST}, [BEHIND_BEST[::-1]]),
        (3.1, {BEHIND_BEST[::-1]}, [BEHIND_BEST]),
        (3.1, set(), [BEHIND_BEST[::-1], BEHIND_BEST]),
        (3.1, {BEHIND_BEST, BEHIND_BEST[::-1]}, []),
        (1.01, set(), []),
        (9.0, set(), []),
    ],
)
def test_what_lies_not_far_behind_the_best_two_is_tried_in_the_orders_that_it_was_not_tried_in(left, orders, expected):
    """One that was followed from amiss, or lacked but another form, came nearer than what was at the noise."""
    alone = [candidate(30.0, "area_variation"), candidate(170.0, "spring_hardening"), candidate(175.0, "air_leak")]
    best, behind = candidate(1.0, "spring_hardening", "area_variation"), candidate(left, *BEHIND_BEST)
    tried = [candidate(240.0), *alone, best, replace(behind, orders=frozenset(orders))]
    work = proposals.near_misses(tried)
    assert [each.effects for each in work] == expected
    assert [each.fit.name for each in work] == [first for first, _ in expected]
    assert not any(each.is_known for each in work), "searched for from all starts"
    unexplained = [candidate(3.0, *best.effects), candidate(3.3, *BEHIND_BEST)]
    assert proposals.near_misses([*tried[:-2], *unexplained]) == []


@pytest.mark.parametrize("others", [("coil_lag", "gap_drift"), ("position_dependent_friction", "spring_hardening")])
def test_what_shares_no_effect_with_the_best_or_takes_a_global_search_is_no_near_miss(others):
    keys = ("area_variation", "spring_hardening", "coil_lag", "gap_drift", "position_dependent_friction")
    alone = [candidate(170.0, key) for key in keys]
    best, behind = candidate(1.0, "spring_hardening", "area_variation"), candidate(2.0, *others)
    behind = replace(behind, orders=frozenset({others}))
    assert proposals.near_misses([candidate(240.0), *alone, best, behind]) == []


@pytest.mark.parametrize(
    ("left", "known", "is_searched"),
    [(60.0, 99.0, True), (130.0, 99.0, True), (140.0, 99.0, False), (60.0, 1.1, False)],
)
def test_jumps_that_gained_are_searched_for_thoroughly(left, known, is_searched):
    """Static friction beside a seal's, in ramps too quick for stops to be seen: it had been followed down only.

    Beside a core's loop it had been searched for in haste, and came to 16 where 1.3 was there.
    """
    seal, pair = (("pressure_dependent_friction",), ("pressure_dependent_friction", "static_friction"))
    tried = [candidate(230.0), candidate(150.0, *seal), candidate(216.0, "static_friction")]
    tried += [candidate(known, "coil_lag"), candidate(left, *pair)]
    work = proposals.jumps_anew(tried)
    assert [(each.effects, each.is_global, each.is_thorough) for each in work] == [(pair, True, True)] * is_searched
    assert all(each.fit is tried[1].fit for each in work)


@pytest.mark.parametrize(("left", "known", "is_tried"), [(60.0, 99.0, True), (140.0, 99.0, False), (60.0, 1.1, False)])
def test_a_law_that_gained_beside_another_effect_leads_another_law_there(left, known, is_tried):
    """A tight spot beside static friction had come to 8.6 of the noise, and beside the true law nowhere near it."""
    spot, pair = "position_dependent_friction", ("position_dependent_friction", "static_friction")
    tried = [candidate(230.0), candidate(150.0, spot), candidate(216.0, "static_friction"), candidate(90.0, "stribeck")]
    tried += [candidate(known, "coil_lag"), candidate(left, *pair)]
    work = proposals.other_laws(tried)
    assert [(each.effects, each.is_global) for each in work] == [((spot, "stribeck"), True)] * is_tried
    assert all(each.fit is tried[1].fit and each.kin is tried[-1].fit for each in work)


def test_a_law_beside_one_wave_does_not_lead_another_law_to_a_whole_series():
    """The series had 35 numbers more than the fit that was to lead, and the diagnosis ended in an error."""
    tried = [candidate(230.0), waves(150.0, "load_force"), candidate(216.0, "static_friction")]
    tried += [candidate(90.0, "stribeck"), candidate(60.0, "load_force", "static_friction")]
    assert proposals.other_laws(tried) == []
    tried[-1] = waves(60.0, "load_force", "static_friction")
    assert [each.effects for each in proposals.other_laws(tried)] == [("load_force", "stribeck")]


def test_what_loses_the_phase_of_its_slips_is_searched_about_where_it_leaves_much():
    base, pair, far = candidate(90.0), candidate(8.0, "end_stop", "stribeck"), candidate(20.0, "air_leak", "stribeck")
    assert blunt([pair, far], base) == [pair]
    assert blunt([candidate(1.1, "end_stop", "stribeck")], base) == []
    alone = candidate(8.0, "stribeck")
    assert blunt([alone], base) == [alone]
    assert blunt([waves(8.0, "load_force", "stribeck"), waves(9.0, "load_force", "quantisation")], base) == []


def test_a_smooth_effect_beside_jumps_is_tried_in_its_other_forms():
    """Alone the seal's friction by the square of the pressure had come as near as that by the pressure."""
    seal, best = candidate(150.0, "pressure_dependent_friction"), ("pressure_dependent_friction", "static_friction")
    tried = [candidate(230.0), seal, candidate(216.0, "static_friction"), candidate(12.0, *best)]
    law = {"friction_area": 3e-3, "friction_pressure_order": 2.0}
    tried[-1].fit.model.effects["pressure_dependent_friction"] = law
    (work,) = proposals.in_other_forms(tried)
    assert work.effects == ("pressure_dependent_friction",)
    assert work.known == {**law, "friction_pressure_order": 1.0}
    assert work.is_known
    assert work.fit is tried[0].fit
    (again,) = proposals.with_jumps([seal], tried)
    assert (again.effects, again.fit, again.is_global, again.is_thorough) == (best, seal.fit, True, True)
    assert proposals.in_other_forms([*tried, candidate(1.1, "gap_drift", "air_leak")]) == []
    assert proposals.in_other_forms([*tried, candidate(9.0, "gap_drift", "air_leak")]) == []
    reading = candidate(9.0, "static_friction", "quantisation")
    reading.fit.model.effects["quantisation"] = {"resolution": 5e-3, "resolution_offset": 1e-3}
    assert proposals.in_other_forms([*tried, reading]) == []


@pytest.mark.parametrize(("trace", "alone", "expected"), [(0.2, 30.0, 1), (3.0, 30.0, 0), (0.2, 1.05, 0)])
def test_an_effect_is_tried_alone_again_from_where_another_beside_it_left_no_trace(trace, alone, expected):
    pair = replace(candidate(1.0, "sensor_lag", "asymmetric_viscous_friction"), trace=trace)
    far = replace(candidate(9.0, "sensor_lag", "coil_lag"), trace=0.1)
    base = candidate(36.0)
    tried = [base, candidate(alone, "sensor_lag"), candidate(1.1, "asymmetric_viscous_friction")]
    tried += [candidate(35.0, "coil_lag"), far, pair]
    work = proposals.left_alone(tried)
    assert [each.effects for each in work] == [("sensor_lag",)] * expected
    assert all(each.fit is base.fit and each.kin is pair.fit and each.known == {"size": 1.0} for each in work)


@pytest.mark.parametrize(("misfit", "expected"), [(0.99 * AT_NOISE, True), (1.01 * AT_NOISE, False)])
def test_a_whole_series_explains_a_record_at_its_noise_alone(misfit, expected):
    base = candidate(90.0)
    assert explains(candidate(misfit, "load_force"), base)
    assert explains(waves(misfit, "load_force"), base) == expected


def test_a_cause_is_settled_at_the_noise_or_as_near_as_another_form_of_it_comes():
    assert is_settled(candidate(AT_NOISE, "coil_lag", "end_stop"), candidate(2.0))
    assert not is_settled(candidate(1.1, "coil_lag", "end_stop"), candidate(2.0))
    far = candidate(1001.0)
    assert is_settled(candidate(AT_NOISE + 999.0 * SETTLED_SHARE**2, "coil_lag", "end_stop"), far)
    assert not is_settled(candidate(AT_NOISE + 1001.0 * SETTLED_SHARE**2, "coil_lag", "end_stop"), far)
    # A whole series may come there in the place of something else, and so may an effect of many numbers.
    assert not is_settled(waves(1.0, "coil_lag", "load_force"), far)
    assert not is_settled(candidate(1.0, "coil_lag", "position_dependent_friction"), far)
    assert is_settled(candidate(1.0), far)
    assert all(is_near_noise(each, far) for each in (waves(1.0, "load_force"), candidate(1.0, "magnetic_saturation")))


@pytest.mark.parametrize(("key", "expected"), [("presliding", True), ("chamber_filling", True), ("coil_lag", True),
                                               ("sensor_lag", False), ("choked_flow", False)])  # fmt: skip
def test_runs_are_dear_where_the_pressure_moves_between_samples_or_bristles_do(key, expected):
    assert is_dear(key) == expected


def test_beside_a_settled_pair_only_its_own_aliases_are_looked_for():
    keys = ("sensor_lag", "magnetic_saturation", "choked_flow", "gap_drift", "sensor_drift")
    alone = [candidate(9.0, key) for key in keys]
    near = candidate(1.5, "gap_drift", "sensor_lag")

    def causes(misfit: float) -> set[frozenset[str]]:
        best = candidate(misfit, "magnetic_saturation", "sensor_lag")
        best.fit.model.effects.update({key: effect_of_key(key).typical for key in best.effects})
        return {frozenset(each.effects) for each in exchanged([candidate(2.0), *alone, best, near])}

    own = {frozenset(("choked_flow", "sensor_lag"))}
    assert causes(1.0) == own
    assert causes(1.2) == own | {frozenset(("sensor_drift", "sensor_lag"))}


def test_effects_of_the_best_pair_are_exchanged_for_their_aliases():
    keys = ("sensor_lag", "magnetic_saturation", "choked_flow", "coil_lag", "static_friction", "load_force")
    alone = [candidate(9.0, key) for key in keys]
    pair = candidate(2.0, "magnetic_saturation", "sensor_lag")
    work = exchanged([candidate(20.0), *alone, pair])
    causes = {frozenset(each.effects): each for each in work}
    assert set(causes) == {
        frozenset(("choked_flow", "sensor_lag")),
        frozenset(("magnetic_saturation", "coil_lag")),
    }
    # The alias is fitted alone; what stays comes on top of it, with its numbers in the pair.
    assert all(each.fit.name == each.effects[0] for each in work)
    assert causes[frozenset(("choked_flow", "sensor_lag"))].effects == ("choked_flow", "sensor_lag")
    assert all(each.known == {"size": 2.0} and each.is_known for each in work)
    # One that comes nowhere near the pair is not followed to its end.
    assert all(each.worth == pytest.approx(min(NO_GAIN * 900.0, FAR_BEHIND * 200.0)) for each in work)


@pytest.mark.parametrize(("behind", "count"), [(2.9, 0), (3.1, 1)])
def test_pair_that_was_tried_is_tried_again_where_it_lies_far_behind(behind, count):
    keys = ("sensor_lag", "magnetic_saturation", "choked_flow")
    tried = [candidate(20.0), *(candidate(9.0, key) for key in keys)]
    tried += [candidate(2.0, "magnetic_saturation", "sensor_lag"), candidate(behind, "choked_flow", "sensor_lag")]
    assert len(exchanged(tried)) == count


def test_errors_of_re_anchored_runs_say_nothing_of_free_ones():
    tried = [candidate(20.0), candidate(9.0, "static_friction"), candidate(0.9, "stribeck")]
    work = [Work(each.fit, (*each.effects, "coil_lag"), is_global=False) for each in tried[1:]]
    assert [each.worth for each in worthwhile(work, tried)] == [NO_GAIN * 900.0, NO_GAIN * 90.0]


def test_where_nothing_was_tried_alone_nothing_is_tried_together():
    assert selection.try_together([candidate(20.0)], EMPTY) == [candidate(20.0)]


def test_a_series_that_comes_nearest_does_not_hide_a_cause_that_explains():
    tried = [candidate(40.0), waves(1.07, "load_force"), candidate(1.1, "coil_lag")]
    work = [
        Work(tried[2].fit, ("coil_lag", key), is_global=key == "static_friction")
        for key in ("static_friction", "air_leak")
    ]
    assert selection.still_called_for(work, tried) == work[1:]
    assert selection.still_called_for(work, tried[:2]) == work


def test_a_coarse_reading_takes_no_global_search(monkeypatch):
    monkeypatch.setattr(proposals, "stopping_on", lambda *_: ["quantisation", "static_friction"])
    monkeypatch.setattr(proposals, "promises", lambda *_: {})
    tried = [candidate(40.0), candidate(20.0, "supply_droop")]
    single = {key: {} for key in ("supply_droop", "quantisation", "static_friction")}
    work = extensions(tried[1:], tried, single, 0, EMPTY)
    assert [(each.effects[1], each.is_global) for each in work] == [("quantisation", False), ("static_friction", True)]


def test_a_series_makes_room_for_what_goes_with_time():
    """Growing friction beside choked flow was never tried: a load at will came nearest, which takes in all of that."""
    alone = [candidate(19.0, "friction_drift"), candidate(40.0, "choked_flow"), waves(15.0, "load_force")]
    tried = [candidate(68.0), *alone, waves(1.5, "choked_flow", "load_force")]
    tried[1:1] = [candidate(50.0, key) for key in ("spring_hardening", "air_leak")]
    work = {each.effects for each in exchanged(tried)}
    assert ("friction_drift", "choked_flow") in work
    # What acts in time is no link between others.
    assert work.isdisjoint({("spring_hardening", "load_force"), ("air_leak", "choked_flow")})
    tried[-1] = replace(tried[-1], has_series=False)
    assert ("friction_drift", "choked_flow") not in {each.effects for each in exchanged(tried)}


def test_a_series_is_not_exchanged_for():
    tried = [candidate(20.0), candidate(9.0, "gap_drift"), candidate(12.0, "coil_lag"), waves(11.0, "load_force")]
    tried.append(candidate(2.0, "coil_lag", "gap_drift"))
    assert "load_force" not in {key for each in exchanged(tried) for key in each.effects}


def test_nearest_of_the_same_effects_is_kept():
    tried = [candidate(20.0), candidate(5.0, "coil_lag", "end_stop")]
    others = [candidate(4.0, "end_stop", "coil_lag"), candidate(6.0, "coil_lag", "end_stop")]
    others.append(candidate(7.0, "air_leak"))
    assert [each.score.misfit for each in with_better(tried, others)] == [20.0, 4.0, 7.0]


@pytest.mark.parametrize(
    ("effects", "others", "expected"),
    [
        (("coil_lag",), ("sensor_lag",), True),
        (("coil_lag",), ("end_stop",), False),
        (("coil_lag", "end_stop"), ("end_stop", "sensor_lag"), True),
        (("coil_lag", "end_stop"), ("sensor_lag", "magnetic_saturation"), False),
        ((), ("linkage_backlash",), True),
        ((), ("coil_lag",), False),
        (("coil_lag", "linkage_backlash"), ("coil_lag",), True),
    ],
)
def test_causes_that_differ_by_aliases(effects, others, expected):
    assert differ_by_aliases(effects, others) == expected
    assert differ_by_aliases(others, effects) == expected


@pytest.mark.parametrize(("misfit", "key", "expected"), [(9.0, "presliding", True), (11.0, "presliding", False),
                                                          (19.0, "coil_lag", True)])  # fmt: skip
def test_slow_effects_must_explain_much_to_be_built_upon(misfit, key, expected):
    assert is_worth_its_time(candidate(misfit, key), candidate(20.0)) == expected


@pytest.mark.parametrize(("pairs", "expected"), [([], NO_GAIN * 900.0), ([2.0], FAR_BEHIND * 200.0)])
def test_a_fit_is_followed_to_its_end_where_it_gains_and_comes_near_the_best(pairs, expected):
    tried = [candidate(20.0), candidate(9.0, "coil_lag")]
    tried += [candidate(misfit, "coil_lag", "end_stop") for misfit in pairs]
    (work,) = worthwhile([Work(tried[1].fit, ("coil_lag", "load_force"), is_global=False)], tried)
    assert work.worth == pytest.approx(expected)


def test_another_law_of_stick_slip_is_tried_though_one_explains(monkeypatch):
    def try_all(work, *_):
        asked.append([each.effects[0] for each in work])
        return [candidate(1.1 if each.effects[0] == "static_friction" else 20.0, *each.effects) for each in work]

    asked: list[list[str]] = []
    monkeypatch.setattr(singles, "try_all", try_all)
    monkeypatch.setattr(singles, "glances", lambda fit, keys, workshop: {key: glance(fit, 2000.0) for key in keys})
    monkeypatch.setattr(singles, "try_in_turn", lambda work, _, *others: try_all(work, *others))
    monkeypatch.setattr(singles, "stops_seen", lambda fit: True)
    monkeypatch.setattr(singles, "straight_line", lambda fit: None)
    found, problem = SimpleNamespace(error=2000.0), SimpleNamespace(noise_error=100.0)
    base = Candidate((), SimpleNamespace(found=found, problem=problem), SimpleNamespace(misfit=20.0))
    keys = ("coil_lag", "static_friction", "stribeck", "presliding")
    library = [effect_of_key(key) for key in keys]
    monkeypatch.setattr(singles, "is_explained_with_reading", lambda *_: False)
    for name in ("nearly", "blunt", "beside_slips", "left_alone", "speaks_softly_for_slips"):
        monkeypatch.setattr(singles, name, lambda *_: [])
    singles.try_first(base, EMPTY, library)
    assert [key for round_of in asked for key in round_of] == ["coil_lag", "presliding", "static_friction", "stribeck"]
    asked.clear()
    others = [effect_of_key(key) for key in keys if key != "static_friction"]
    singles.try_first(base, EMPTY, others)
    assert ["stribeck"] in asked


@pytest.mark.parametrize(
    ("key", "is_in_reach", "is_global"),
    [("stribeck", True, True), ("stribeck", False, False), ("static_friction", False, True)],
)
def test_the_dear_law_is_searched_for_alone_only_where_the_breakaways_may_lie_on_a_line(
    monkeypatch, key, is_in_reach, is_global
):
    monkeypatch.setattr(singles, "straight_line", lambda fit: SimpleNamespace(is_in_reach=is_in_reach))
    work = singles.work_on(None, effect_of_key(key), [candidate(20.0), candidate(9.0, "coil_lag")], has_stops=True)
    assert work.is_global == is_global


@pytest.mark.parametrize(
    ("nearest", "with_reading", "is_read"),
    [("supply_droop", 1.0, True), ("supply_droop", 8.0, False), ("quantisation", 1.0, False)],
)
def test_stops_that_a_coarse_reading_on_top_of_the_nearest_explains_speak_for_no_jumps(
    monkeypatch, nearest, with_reading, is_read
):
    alone = [candidate(40.0), candidate(9.0, nearest), candidate(30.0, "coil_lag")]
    alone += [candidate(50.0, "quantisation")] if nearest != "quantisation" else []
    looked_at = []

    def try_all(work, *_):
        assert all(each.known == {"size": 50.0} for each in work), "as read off alone"
        return [candidate(with_reading if "supply_droop" in each.effects else 28.0, *each.effects) for each in work]

    monkeypatch.setattr(singles, "stops_seen", lambda fit: True)
    monkeypatch.setattr(singles, "try_all", try_all)
    monkeypatch.setattr(singles, "try_by_promise", lambda *_: alone)
    monkeypatch.setattr(singles, "try_widely", lambda tried, *_, has_stops: looked_at.append(has_stops) or alone)
    monkeypatch.setattr(singles, "beside_slips", lambda *_: looked_at.append("slips") or [])
    monkeypatch.setattr(singles, "beside_coarse_steps", lambda *_: [])
    monkeypatch.setattr(singles, "speaks_softly_for_slips", lambda alone: False)
    for name in ("nearly", "blunt", "left_alone"):
        monkeypatch.setattr(singles, name, lambda *_: [])
    singles.try_first(alone[0], EMPTY, [])
    assert looked_at == ([False] if is_read else [True, "slips"])


@pytest.mark.parametrize("pool", [None, ThreadPoolExecutor(2)])
def test_what_comes_nearest_at_a_glance_is_tried_first_and_the_rest_as_far_as_it_is_called_for(monkeypatch, pool):
    """What comes to the noise leaves the rest to show something at a glance, but for its aliases."""

    def try_effect(work, _):
        asked[work.effects[0]] = (work.begun, work.worth)
        return candidate(1.0 if work.effects == ("coil_lag",) else 30.0, *work.effects)

    order = [
        "coil_lag",
        "friction_drift",
        "supply_droop",
        "presliding",
        "spring_hardening",
        "end_stop",
        "air_leak",
        "sensor_lag",
        "sensor_drift",
    ]
    base = candidate(40.0)
    shares = {"coil_lag": 0.9, "supply_droop": singles.LEAST_SHARE_DEAR, "spring_hardening": singles.LEAST_SHARE}
    seen = {key: glance(base.fit, 2000.0 + place, shares.get(key, 0.0)) for place, key in enumerate(order)}
    asked: dict[str, tuple[object, float]] = {}
    monkeypatch.setattr(candidates, "try_effect", try_effect)
    monkeypatch.setattr(singles, "glances", lambda fit, keys, workshop: {key: seen[key] for key in keys})
    tried = singles.try_by_promise(base, ["load_force", *order[::-1]], Workshop(None, pool))
    assert [each.effects for each in tried] == [(), *((key,) for key in [*order, "load_force"])]
    assert are_aliases("coil_lag", "sensor_lag")
    assert not are_aliases("coil_lag", "sensor_drift")
    followed = (None, proposals.FAR_BEHIND * 100.0)
    expected = dict.fromkeys(order[: candidates.AT_ONCE], (None, math.inf))
    expected |= {key: (seen[key].fit, 0.0) for key in order[candidates.AT_ONCE :]}
    expected |= dict.fromkeys(["spring_hardening", "sensor_lag", "load_force"], followed)
    # Its runs are dear, and it shows nothing, whatever comes to the noise.
    expected["presliding"] = (seen["presliding"].fit, 0.0)
    assert asked == expected


def test_what_comes_to_the_noise_at_a_glance_is_followed_from_there_alone(monkeypatch):
    errors = {"sensor_lag": 104.0, "spring_hardening": 106.0, "chamber_filling": 104.0}
    base, seen = candidate(40.0), {key: glance(None, error, 0.9) for key, error in errors.items()}
    work = {key: singles.called_for(base, seen, Work(base.fit, (key,), is_global=False), []) for key in seen}
    assert (work["sensor_lag"].begun, work["sensor_lag"].worth) == (seen["sensor_lag"].fit, math.inf)
    # Of what has several forms another may come nearer.
    assert effect_of_key("sensor_lag").has_one_form
    assert not effect_of_key("chamber_filling").has_one_form
    assert work["spring_hardening"].begun is work["chamber_filling"].begun is None


@pytest.mark.parametrize(("worth", "is_followed"), [(105.0, True), (100.0, False)])
def test_a_fit_that_was_begun_is_followed_where_it_is_worth_that(monkeypatch, worth, is_followed):
    begun, followed = candidate(1.0, "coil_lag").fit, candidate(0.9, "coil_lag").fit
    monkeypatch.setattr(candidates, "continued", lambda fit: followed if fit is begun else None)
    monkeypatch.setattr(candidates, "scored", lambda effects, fit, holdout: Candidate(effects, fit, None))
    work = Work(candidate(40.0).fit, ("coil_lag",), is_global=False, begun=begun, worth=worth)
    found = candidates.try_effect(work, None)
    assert found.fit is (followed if is_followed else begun)
    assert found.orders == {("coil_lag",)}


def test_beside_a_base_that_leaves_little_an_effect_must_promise_what_can_be_told():
    base = candidate(1.08)
    seen = {"coil_lag": glance(base.fit, 104.0)}
    work = singles.called_for(base, seen, Work(base.fit, ("coil_lag",), is_global=False), [])
    assert (work.promise, work.worth, work.begun) == (singles.PROMISE_AT_NOISE, math.inf, None)


@pytest.mark.parametrize("is_another", [True, False])
def test_aliases_of_two_effects_that_lead_only_after_a_look_back_are_tried_too(monkeypatch, is_another):
    tried = [candidate(40.0), candidate(20.0, "supply_droop"), candidate(1.1, "supply_droop", "linkage_nonlinearity")]
    asked = Work(tried[1].fit, ("spring_hardening", "supply_droop"), is_global=False)
    monkeypatch.setattr(selection, "exchanged", lambda _: [asked])
    monkeypatch.setattr(selection, "try_all", lambda work, *_: [candidate(1.05, *each.effects) for each in work])
    led = frozenset({"supply_droop", "gap_drift" if is_another else "linkage_nonlinearity"})
    known = selection.exchanged_anew(tried, led, EMPTY)
    assert [each.effects for each in known[3:]] == ([asked.effects] if is_another else [])


def test_two_effects_that_leave_what_one_of_them_leaves_are_that_one():
    """A fast cylinder beside Stribeck friction left what that did alone: 100 s were spent about it in vain."""
    tried = [
        candidate(90.0),
        candidate(3.2, "stribeck"),
        candidate(60.0, "chamber_filling"),
        candidate(9.0, "end_stop"),
        candidate(50.0, "static_friction"),
    ]
    idle, both = candidate(3.15, "stribeck", "chamber_filling"), candidate(2.0, "end_stop", "stribeck")
    assert rivals.two_that_gain([*tried, idle, both]) == [both]
    assert rivals.two_that_gain([*tried, idle]) == rivals.rivals_of_best([*tried, idle]) == []
    assert proposals.in_other_forms([*tried, idle]) == []
    assert {each.effects for each in proposals.other_laws([*tried, idle, both])} >= {("end_stop", "static_friction")}
    for proposed in (proposals.jumps_anew, proposals.other_laws):
        assert {key for each in proposed([*tried, idle, both]) for key in each.effects} <= {
            "end_stop",
            "stribeck",
            "static_friction",
        }


@pytest.mark.parametrize(
    ("best", "behind", "is_near"),
    [(1.2, 1.4, True), (1.2, 1.6, False), (1.2, 3.9, False), (2.0, 3.9, True), (2.0, 4.1, False)],
)
def test_aliases_of_the_best_two_are_searched_about_where_they_may_come_as_near(best, behind, is_near):
    tried = [
        candidate(40.0),
        candidate(30.0, "coil_lag"),
        candidate(35.0, "static_friction"),
        candidate(32.0, "stribeck"),
    ]
    alias, other = (candidate(best * behind, *each) for each in (("coil_lag", "stribeck"), ("coil_lag", "end_stop")))
    nearest = candidate(best, "coil_lag", "static_friction")
    known = [*tried, nearest, alias, other]
    assert rivals.aliases_of_best(known) == [alias] * is_near
    assert rivals.rivals_of_best(known) == [nearest, *[alias, other] * is_near]


def test_rivals_that_jump_are_searched_about_though_they_explain_where_they_left_some_of_what_they_were_fitted_to():
    """Where the error is jagged a right pair ends a little above a wrong one that was lucky."""
    known = [candidate(40.0), candidate(30.0, "area_variation"), candidate(35.0, "static_friction")]
    lucky, right = candidate(1.02, "area_variation", "static_friction"), candidate(1.1, "coil_lag", "static_friction")
    known += [lucky, right, candidate(1.2, "coil_lag", "area_variation"), candidate(1.2, "coil_lag", "stribeck")]
    assert rivals.short_of_noise(known) == [right]
    assert rivals.short_of_noise([*known[:-3], replace(right, is_sharpened=True)]) == []
    many = [candidate(1.1, key, "static_friction") for key in ("air_leak", "coil_lag", "gap_drift", "supply_droop")]
    assert rivals.short_of_noise([*known[:4], *many]) == many[: rivals.SHORT_OF_NOISE]


def test_what_makes_a_stem_jump_beside_the_best_alone_is_searched_about_where_its_search_ended_at_nothing():
    base, best = candidate(40.0), candidate(11.8, "asymmetric_viscous_friction")
    idle = replace(candidate(11.8, "asymmetric_viscous_friction", "static_friction"), trace=0.0)
    tried = [base, best, candidate(39.0, "static_friction"), candidate(20.0, "coil_lag"), idle]
    assert rivals.ended_at_nothing(tried) == [idle]
    assert rivals.ended_at_nothing([*tried[:-1], replace(idle, trace=5.0)]) == []
    assert rivals.ended_at_nothing([*tried[:-1], replace(idle, is_sharpened=True)]) == []
    assert rivals.ended_at_nothing([base, candidate(1.0, "asymmetric_viscous_friction"), idle]) == []
    # A law of which a run takes long is searched for by itself, and nothing on top of another that stops the stem.
    slow = replace(candidate(11.8, "asymmetric_viscous_friction", "stribeck"), trace=0.0)
    assert rivals.ended_at_nothing([base, best, slow]) == []
    tight = candidate(11.7, "position_dependent_friction")
    beside = replace(candidate(11.7, "position_dependent_friction", "static_friction"), trace=0.0)
    assert rivals.ended_at_nothing([base, tight, beside]) == []


@pytest.mark.parametrize(("left", "is_asked"), [(5.0, True), (6.0, False)])
def test_what_jumps_alone_is_searched_about_where_it_may_explain_the_record(monkeypatch, left, is_asked):
    alone, asked = [candidate(40.0), candidate(left, "static_friction"), candidate(38.0, "coil_lag")], []
    monkeypatch.setattr(singles, "stops_seen", lambda fit: False)
    monkeypatch.setattr(singles, "try_all", lambda *_: [])
    monkeypatch.setattr(singles, "sharpen_all", lambda causes, *_: asked.extend(causes) or [])
    monkeypatch.setattr(singles, "lags_beside_jumps", lambda *_: [])
    monkeypatch.setattr(singles, "speaks_softly_for_slips", lambda alone: False)
    for name, made in (("try_by_promise", alone), ("try_widely", alone), ("beside_slips", []), ("nearly", [])):
        monkeypatch.setattr(singles, name, lambda *_, made=made, **__: made)
    singles.try_first(alone[0], EMPTY, [])
    assert asked == alone[1:2] * is_asked


@pytest.mark.parametrize("in_form", [1.1, 4.0])
def test_the_right_form_beside_jumps_is_looked_for_before_what_comes_on_top_of_one_effect(monkeypatch, in_form):
    """It was, after as much time as all that went before, and what came on top of one effect was in vain."""
    single, pair = candidate(20.0, "linkage_nonlinearity"), candidate(5.0, "linkage_nonlinearity", "static_friction")
    asked: list[object] = []
    monkeypatch.setattr(selection, "in_other_forms", lambda tried: asked.append("forms") or [])
    monkeypatch.setattr(selection, "with_jumps", lambda alone, tried: ["other form"])
    monkeypatch.setattr(
        selection,
        "try_all",
        lambda work, *_: [candidate(in_form, *pair.effects)] if list(work) == ["other form"] else [],
    )
    monkeypatch.setattr(selection, "try_jointly", lambda *_: [])
    monkeypatch.setattr(selection, "on_top_of_the_best", lambda tried, *_: asked.append("on top") or list(tried))
    monkeypatch.setattr(selection, "each_in_turn", lambda *_: [])
    monkeypatch.setattr(selection, "sharpen_all", lambda *_: [])
    rules = ("exchanged", "on_what_stays", "near_misses", "worth_beginning_again", "jumps_anew", "other_laws")
    for rule in (*rules, "nearly_together"):
        monkeypatch.setattr(selection, rule, lambda *_: [])
    found = selection.try_together([candidate(90.0), single, pair], EMPTY)
    assert min(each.score.misfit for each in found) == min(in_form, 5.0)
    assert asked.count("forms") == 1, "not once more where nothing has changed"
    assert ("on top" in asked) == (in_form > 2.0)


@pytest.mark.parametrize(("best", "is_tried"), [("static_friction", True), ("load_force", False)])
def test_where_no_stops_are_seen_a_law_whose_slips_hang_by_a_hair_is_tried_if_another_is_the_best(
    monkeypatch, best, is_tried
):
    """Stairs of the current: the stem rests on each by itself, and jumps onto the next."""
    asked = []
    monkeypatch.setattr(singles, "beside_reading", lambda *_: [])
    monkeypatch.setattr(singles, "work_on", lambda base, effect, *_, **__: effect.key)
    monkeypatch.setattr(
        singles,
        "try_all",
        lambda work, *_: asked.extend(work) or [candidate(30.0 if key == best else 50.0, key) for key in work],
    )
    tried = [candidate(90.0), candidate(40.0, "load_force")]
    singles.try_widely(tried, [["static_friction"], ["stribeck"]], EMPTY, has_stops=False)
    assert asked == ["static_friction"] + ["stribeck"] * is_tried


@pytest.mark.parametrize(("effects", "found", "kept"), [(1, ["slip"], ["slip"]), (1, [], None), (2, ["slip"], None)])
def test_what_a_law_alone_makes_of_the_slips_stays_with_it(monkeypatch, effects, found, kept):
    asked = []
    work = Work(SimpleNamespace(), ("coil_lag", "static_friction")[-effects:], is_global=True)
    made = candidate(9.0, *work.effects)
    monkeypatch.setattr(candidates, "slips_asked", lambda fit, effect, how: found)
    monkeypatch.setattr(candidates, "extend", lambda fit, key, how: asked.append(how.slips) or made.fit)
    monkeypatch.setattr(candidates, "scored", lambda effects, fit, holdout: made)
    tried = candidates.try_effect(work, None)
    assert asked == [found]
    assert tried.slips == kept
    monkeypatch.setattr(candidates, "sharpened", lambda fit: fit)
    monkeypatch.setattr(candidates, "scored", lambda effects, fit, holdout: candidate(8.0, *effects))
    sharper = candidates.sharpen(tried, None)
    assert (sharper.score.misfit, sharper.slips) == (8.0, kept)
