"""What hides beside a cause is said, and only what is declared to come close to none."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from workshops import EMPTY

from diagnosis.judging import hiding, judgement
from diagnosis.judging.hiding import strongest_start, with_hidden
from diagnosis.judging.judgement import judge
from diagnosis.score import Errors, Score
from diagnosis.trials.marking import mark
from diagnosis.trying.candidates import Candidate
from diagnosis.trying.explaining import WORTH_MORE, WORTH_ONE, leaves_nothing_to_tell
from valvemodel.effects import effect_of_key


def candidate(misfit: float, *effects: str, trace: float = 5.0) -> Candidate:
    counts = np.full(12, 100)
    errors = Errors(misfit * counts, misfit * counts, counts, counts, 1.0)
    experiment = SimpleNamespace(has_stairs=False)
    model = SimpleNamespace(effects=dict.fromkeys(effects))
    problem, found = SimpleNamespace(experiments=[experiment], noise_error=100.0), SimpleNamespace(error=100.0 * misfit)
    fit = SimpleNamespace(model=model, problem=problem, found=found, name="+".join(effects))
    return Candidate(effects, fit, Score(errors, errors), trace)


def beside(tried: list[Candidate], misfits: dict[str, float], monkeypatch) -> tuple[list[Candidate], list[str]]:
    """What hides, where fits beside the best cause come out with these misfits by the effect that is added."""

    def try_all(work, *_):
        return [candidate(misfits[each.effects[-1]], *each.effects) for each in work]

    monkeypatch.setattr(hiding, "try_all", try_all)
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    return with_hidden(tried, EMPTY)


def test_what_leaves_a_cause_as_good_as_it_is_is_said_to_hide_beside_it(monkeypatch):
    tried = [candidate(40.0), candidate(1.0, "presliding"), candidate(39.0, "air_leak"), candidate(39.0, "coil_lag")]
    tried.append(candidate(38.0, "linkage_backlash"))
    causes, hiding = beside(tried, {"air_leak": 1.0, "linkage_backlash": 1.5}, monkeypatch)
    assert hiding == ["air_leak"]
    assert causes == tried


@pytest.mark.parametrize(("key", "hidden"), [("position_dependent_friction", ["air_leak"]), ("presliding", [])])
def test_where_a_stem_sticks_what_was_fitted_tells_whether_an_effect_hides(monkeypatch, key, hidden):
    """A hair may decide on a stretch that was kept back."""
    tried = [candidate(40.0), candidate(1.2, key), candidate(39.0, "air_leak")]

    def try_all(work, *_):
        made = [candidate(7.0, *each.effects) for each in work]
        return [replace(each, fit=SimpleNamespace(**vars(each.fit) | {"found": found})) for each in made]

    found = SimpleNamespace(error=101.0)
    monkeypatch.setattr(hiding, "try_all", try_all)
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    assert with_hidden(tried, EMPTY)[1] == hidden
    found.error = 110.0
    assert with_hidden(tried, EMPTY)[1] == []


def test_what_comes_no_nearer_than_can_be_told_hides_too(monkeypatch):
    tried = [candidate(40.0), candidate(1.5, "sensor_lag"), candidate(1.35, "sensor_lag", "linkage_backlash")]
    tried.append(candidate(1.3, "sensor_lag", "coil_lag"))
    causes, hiding = beside(tried, {}, monkeypatch)
    assert causes == tried
    assert hiding == ["linkage_backlash"]
    unfelt = candidate(1.35, "sensor_lag", "linkage_backlash", trace=0.5)
    assert beside([*tried[:2], unfelt], {}, monkeypatch)[1] == []


def test_what_hides_in_the_base_stands_among_the_causes_at_its_strength(monkeypatch):
    tried = [candidate(1.0), candidate(1.0, "air_leak", trace=0.0), candidate(0.99, "linkage_backlash", trace=0.1)]
    causes, hiding = beside(tried, {"air_leak": 1.01, "linkage_backlash": 1.4}, monkeypatch)
    assert hiding == []
    traces = {each.effects: each.trace for each in causes}
    assert traces == {(): 5.0, ("air_leak",): 5.0, ("linkage_backlash",): 0.1}


def test_nothing_is_said_to_hide_where_nothing_explains_the_record(monkeypatch):
    tried = [candidate(40.0), candidate(30.0, "presliding"), candidate(39.0, "air_leak")]
    assert beside(tried, {"air_leak": 30.0}, monkeypatch) == (tried, [])


@pytest.mark.parametrize(("left", "hidden"), [(1.1, ["linkage_backlash"]), (1.6, [])])
def test_what_a_load_at_will_leaves_may_be_what_hides_beside_it(monkeypatch, left, hidden):
    load = replace(candidate(left, "load_force"), has_series=True)
    tried = [candidate(17.0), load, candidate(16.0, "linkage_backlash")]
    assert beside(tried, {"linkage_backlash": 1.05}, monkeypatch) == (tried, hidden)


def test_an_unknown_cause_is_credited_with_no_more_than_a_known_one_that_leaves_nothing(monkeypatch):
    """What is gained in a single block counts for no cause, so that it counts for none that is unknown either."""
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    base, known, short = candidate(1.0), candidate(1.0, "linkage_backlash"), candidate(3.0, "coil_lag")
    base.score.free.weighted[5] *= 40.0
    assert judge([base, short]).unknown > 0.5
    assert judge([base, short, known]).unknown < 0.2


def test_what_leaves_nothing_of_a_small_gap_is_believed_before_an_unknown_cause(monkeypatch):
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    effects = ("magnetic_saturation", "sensor_drift")
    known, near = (replace(candidate(left, *effects), freedom=5) for left in (1.0, 1.1))
    assert judge([candidate(2.5), known]).unknown < 0.25
    assert judge([candidate(2.5), near]).unknown > 0.5


@pytest.mark.parametrize(("left", "is_unknown"), [(1.05, False), (1.8, True)])
def test_a_load_at_will_that_leaves_some_is_rather_an_unknown_cause_that_it_stands_in_for(
    monkeypatch, left, is_unknown
):
    """Growing friction, left out of the candidates, was taken for a load: waves take in most of what goes with time."""
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    load = replace(candidate(left, "load_force"), has_series=True, freedom=2)
    assert (judge([candidate(68.0), load]).unknown > 0.5) == is_unknown


def test_a_load_at_will_beside_a_law_of_jumps_is_judged_as_slips_are(monkeypatch):
    """What an unknown cause leaves beside slips is more: waves were judged as in a smooth record there as well."""
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    load = replace(candidate(2.5, "load_force", "static_friction"), has_series=True, freedom=4)
    unknown = {}
    for makes in (True, False):
        monkeypatch.setattr(judgement, "makes_slips", lambda each, makes=makes: makes and each is load)
        unknown[makes] = judge([candidate(68.0), load]).unknown
    assert unknown[True] < 0.3 < 0.5 < unknown[False]


def test_a_law_of_jumps_that_brings_a_load_at_will_no_nearer_lends_it_no_form_of_slips(monkeypatch):
    """A supply that droops, left out of the candidates, was taken for both, at six times the noise."""
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    monkeypatch.setattr(judgement, "makes_slips", lambda each: "static_friction" in each.effects)
    load = replace(candidate(38.7, "load_force"), has_series=True, freedom=5)
    for left, is_unknown in ((44.4, True), (38.7, True), (11.0, False)):
        jumping = replace(candidate(left, "load_force", "static_friction"), has_series=True, freedom=7)
        judged = judge([candidate(350.0), load, jumping])
        assert (judged.unknown > 0.8) == is_unknown
        assert (judged.evidence[2] <= judged.evidence[1]) == is_unknown


def test_what_explains_the_gap_needs_no_stops(monkeypatch):
    """Friction below notice lets the stem rest on its way as well."""
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: True)
    base, spot = candidate(90.0), candidate(1.2, "position_dependent_friction")
    assert judge([base, spot]).probabilities[1] > 0.9
    short = candidate(1.8, "position_dependent_friction")
    assert judge([base, short]).unknown > 0.5


def test_of_causes_that_explain_the_gap_the_nearest_of_as_many_effects_is_the_most_probable(monkeypatch):
    """By a factor e a hundredth of the noise, up to a bound; what has more effects is apart, none far behind one."""
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    tried = [candidate(90.0), candidate(1.01, "area_variation"), candidate(1.02, "spring_hardening")]
    tried += [candidate(1.3, "air_leak"), candidate(80.0, "coil_lag"), candidate(1.0, "air_leak", "coil_lag")]
    judged = judge(tried)
    support = np.log(judged.probabilities)
    lost = support - judged.evidence - [judgement.log_prior(each) for each in tried]
    assert lost[[2, 3, 4]] - lost[1] == pytest.approx([-1.0, -judgement.MOST_BEHIND, -judgement.MOST_BEHIND])
    assert lost[[0, 5]] - lost[1] == pytest.approx([-judgement.MOST_BEHIND, 0.0])
    most = judgement.MOST_BEHIND
    assert judged.lost == pytest.approx([most, 0.0, 1.0, most, most, 0.0])
    assert judged.evidence[1] - judged.evidence[2] < 0.2


def test_a_great_gap_lets_causes_of_as_many_effects_differ_by_their_form(monkeypatch):
    """By a factor e a ten-thousandth of what the base leaves, where that is more: saturation stood for friction."""
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    near, behind = (
        candidate(left, key, "asymmetric_filling") for left, key in ((1.09, "coil_lag"), (1.17, "gap_drift"))
    )
    for gap, lost in ((400.0, 2.0), (1000.0, 0.8), (50.0, judgement.MOST_BEHIND)):
        assert judge([candidate(gap), near, behind]).lost[2] == pytest.approx(lost)


def test_what_another_form_may_leave_excuses_little_where_a_second_effect_takes_it_in_to_the_noise(monkeypatch):
    """A base at 500 times the noise allows one effect 2.5 for its form; beside two at the noise, a fiftieth."""
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    single, pair = ("friction_drift",), ("friction_drift", "magnetic_saturation")
    tried = [candidate(485.0), candidate(1.39, *single), replace(candidate(1.01, *pair), freedom=5)]
    judged = judge(tried)
    assert judged.lost == pytest.approx([judgement.MOST_BEHIND] * 2 + [0.0])
    assert judged.probabilities[2] > judged.probabilities[1]
    assert judge([tried[0], candidate(1.1, *single), tried[2]]).lost[1] == 0.0


def test_which_cause_leaves_less_of_a_coarse_reading_than_the_noise_tells_nothing(monkeypatch):
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    pairs = [("area_variation", "quantisation"), ("spring_hardening", "quantisation"), ("gap_drift", "quantisation")]
    tried = [candidate(90.0), *(candidate(misfit, *pair) for misfit, pair in zip((0.1, 0.6, 1.1), pairs, strict=True))]
    assert judge(tried).lost[1:] == pytest.approx([0.0, 0.0, 1.0])
    # Nor does what lies behind only in what was kept back, few steps of which tell: a lag beside steps had won.
    tried[3].fit.found.error = 40.0
    assert judge(tried).lost[1:] == pytest.approx([0.0, 0.0, 0.0])


def test_what_lies_behind_by_more_than_the_error_cannot_be_taken_for_a_cause(monkeypatch):
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    tried = [candidate(90.0), candidate(1.01, "area_variation"), candidate(1.02, "spring_hardening")]
    tried.append(candidate(1.3, "magnetic_saturation"))
    judged = judge(tried)
    assert judged.evidence[1] - judged.evidence[3] < judgement.WITHIN_ERROR
    assert judgement.rivals_of(1, tried, judged) == [("spring_hardening",)]


def test_a_law_of_slips_loses_less_behind_another_law_than_an_effect_behind_another(monkeypatch):
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    base, law = candidate(19.0), candidate(1.0, "spring_hardening", "stribeck")
    others = candidate(1.2, "spring_hardening", "static_friction"), candidate(1.2, "air_leak", "stribeck")
    assert judge([base, law, *others]).lost[1:] == pytest.approx([0.0, 2.0, judgement.MOST_BEHIND])
    assert judge([base, law, candidate(1.2, "air_leak", "static_friction")]).lost[2] == judgement.MOST_BEHIND
    # Behind in what was kept back alone, which a hair may decide, it loses nothing.
    fitted = [replace(each, fit=SimpleNamespace(**vars(each.fit) | {"found": law.fit.found})) for each in others]
    assert judge([base, law, *fitted]).lost[1:] == pytest.approx([0.0, 0.0, judgement.MOST_BEHIND])
    single, sham = candidate(1.0, "static_friction"), replace(candidate(1.2), effects=("sham",))
    for other in (candidate(1.2, "coil_lag"), sham):
        assert judge([base, single, other]).lost[2] == judgement.MOST_BEHIND


@pytest.mark.parametrize(("numbers", "lost"), [(3, 4.0), (4, 0.0)])
def test_what_comes_nearer_by_many_more_numbers_takes_nothing_from_others(monkeypatch, numbers, lost):
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    spot = replace(candidate(1.0, "position_dependent_friction"), freedom=numbers)
    curve = replace(candidate(1.1, "pressure_dependent_friction"), freedom=1)
    assert judge([candidate(90.0), spot, curve]).lost[2] == pytest.approx(lost)


@pytest.mark.parametrize(
    ("second", "left", "lost"),
    [
        ("asymmetric_friction", 1.3, judgement.MOST_IMITATED),
        ("asymmetric_friction", 1.12, 2.0),
        ("asymmetric_friction", 1.09, 0.0),
        ("position_dependent_friction", 1.3, 0.0),
        ("quantisation", 1.3, 0.0),
    ],
)
def test_beside_what_hides_in_the_base_an_effect_may_imitate_another(monkeypatch, second, left, lost):
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    base, pair = candidate(400.0), candidate(left, "magnetic_saturation", second)
    judged = judge([base, pair])
    assert judged.lost[1] == pytest.approx(lost)
    assert (judged.unknown > 0.3) == (lost == judgement.MOST_IMITATED)


@pytest.mark.parametrize("least", [1.0, 0.9])
def test_what_is_not_searched_for_could_not_win(monkeypatch, least):
    """Noise that was taken too large leaves all that is right below 1."""
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    best = replace(candidate(least, "magnetic_saturation"), freedom=1)
    near = [candidate(0.999 * WORTH_ONE * least), best]
    assert leaves_nothing_to_tell(near[0], near)
    assert judge(near).probabilities[0] > 2.0 * judge(near).probabilities[1]
    single = replace(candidate(0.999 * WORTH_MORE * least, "magnetic_saturation"), freedom=1)
    pair = replace(candidate(least, "magnetic_saturation", "coil_lag"), freedom=2)
    tried = [candidate(40.0), single, pair]
    assert leaves_nothing_to_tell(single, tried)
    assert judge(tried).probabilities[1] > 2.0 * judge(tried).probabilities[2]


@pytest.mark.parametrize(("alone", "lost"), [(40.0, 0.0), (2.8, judgement.MOST_IMITATED)])
def test_what_takes_away_all_but_hundredths_of_what_the_other_leaves_imitates_nothing(monkeypatch, alone, lost):
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    single = candidate(alone, "magnetic_saturation")
    pair = candidate(1.25, "magnetic_saturation", "asymmetric_friction")
    assert judge([candidate(400.0), single, pair]).lost[2] == pytest.approx(lost)


@pytest.mark.parametrize(("trace", "lost"), [(2.0, 4.0), (0.5, 0.0)])
def test_a_series_of_waves_loses_to_what_comes_nearer_by_one_more_effect(monkeypatch, trace, lost):
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    waves = replace(candidate(1.04, "load_force"), has_series=True)
    plain = candidate(1.2, "coil_lag", "sensor_lag")
    more = [replace(candidate(1.0, "load_force", "gap_drift", trace=trace), has_series=True)]
    judged = judge([candidate(90.0), waves, plain, *more])
    assert judged.lost[1] == pytest.approx(lost)
    assert judged.lost[2] == pytest.approx(lost)


@pytest.mark.parametrize(("left", "lost"), [(1.0, 4.0), (2.0, 4.0), (2.2, 0.0)])
def test_one_effect_that_leaves_much_loses_to_two_that_take_in_most_of_it_beside_any_gap(monkeypatch, left, lost):
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    single, pair = candidate(4.0, "coil_lag"), candidate(left, "coil_lag", "gap_drift")
    assert judge([candidate(1500.0), single, pair]).lost[1] == pytest.approx(lost)


@pytest.mark.parametrize(("single", "lost"), [(1.04, 0.0), (1.1, 4.0)])
def test_one_effect_loses_to_two_that_come_nearer_than_what_is_below_notice(monkeypatch, single, lost):
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    tried = [candidate(3.0), candidate(single, "coil_lag"), candidate(1.0, "gap_drift", "sensor_lag", trace=2.0)]
    assert judge(tried).lost[1] == pytest.approx(lost)
    # Beside a large gap another form of the one may leave as much.
    assert judge([candidate(800.0), *tried[1:]]).lost[1] == pytest.approx(0.0)


@pytest.mark.parametrize(("misfit", "lost"), [(1.04, 4.0), (1.2, 0.0)])
def test_what_few_numbers_bring_to_the_noise_is_no_series_of_waves(monkeypatch, misfit, lost):
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    waves = replace(candidate(1.0, "load_force"), has_series=True)
    judged = judge([candidate(90.0), waves, candidate(misfit, "gap_drift", "sensor_lag")])
    assert judged.lost[1] == pytest.approx(lost)


@pytest.mark.parametrize(("alone", "is_felt"), [(1.9, True), (1.1, False)])
def test_a_faint_second_effect_is_felt_where_nothing_does_without(monkeypatch, alone, is_felt):
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    tried = [candidate(8.4), candidate(alone, "area_variation")]
    tried.append(candidate(0.94, "area_variation", "end_stop", trace=0.9))
    probabilities = judge(tried).probabilities
    assert (probabilities[2] > 0.7) == is_felt
    assert (probabilities[2] > 0.0) == is_felt


def test_what_its_strongest_start_led_astray_is_tried_from_a_smaller_one(monkeypatch):
    asked: list[float] = []

    def try_all(work, *_):
        asked.extend(each.known["leak_ratio"] for each in work)
        return [candidate(50.0 if each.known["leak_ratio"] > 0.1 else 1.0, *each.effects) for each in work]

    monkeypatch.setattr(hiding, "try_all", try_all)
    monkeypatch.setattr(judgement, "stops_seen", lambda fit: False)
    tried = [candidate(90.0), candidate(1.0, "position_dependent_friction"), candidate(89.0, "air_leak")]
    assert with_hidden(tried, EMPTY)[1] == ["air_leak"]
    assert asked == [0.15, pytest.approx(hiding.SMALLER * 0.15)]


@pytest.mark.parametrize(
    ("key", "expected"),
    [("air_leak", True), ("linkage_backlash", True), ("choked_flow", False), ("coil_lag", False)],
)
def test_only_effects_of_free_strength_that_come_close_to_none_can_hide(key, expected):
    assert effect_of_key(key).hides_in_base == expected


def test_strongest_start_would_be_felt():
    for key in ("air_leak", "linkage_backlash", "asymmetric_friction"):
        effect = effect_of_key(key)
        assert any(strongest_start(effect)[each.name] != each.neutral for each in effect.parameters)
    assert strongest_start(effect_of_key("air_leak"))["leak_chokes"] == 0.0


def test_a_pair_of_which_one_is_said_to_hide_counts_as_declared():
    cause = {
        "effects": ["presliding"], "probability": 0.95, "indistinguishable_from": [], "may_hide_beside": ["air_leak"],
    }  # fmt: skip
    diagnosis = {"verdict": "effect", "where": {"stage": "stem"}, "causes": [cause], "unknown_probability": 0.05}
    assert mark("pair", ("air_leak", "presliding"), diagnosis).outcome == "alias"
    assert mark("pair", ("coil_lag", "presliding"), diagnosis).outcome == "partly"
    assert mark("single", ("presliding",), diagnosis).outcome == "right"
