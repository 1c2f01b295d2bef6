"""Marks follow the rule of each kind, whatever the diagnosis was."""

from dataclasses import replace

import pytest

from diagnosis.trials.marking import mark
from diagnosis.trials.scoring import Result
from diagnosis.trials.summary import calibration_of, closure_of, counts_of, rate_of


def said(verdict: str, causes: dict[str, float], rivals: tuple[str, ...] = (), *, stage: str | None = None) -> dict:
    """Make a diagnosis of causes like "coil_lag+end_stop", the first with rivals; "" is none."""
    keys = {name: [key for key in name.split("+") if key] for name in causes}
    return {
        "verdict": verdict,
        "where": {"stage": stage},
        "causes": [
            {
                "effects": keys[name],
                "probability": probability,
                "indistinguishable_from": [[k for k in each.split("+") if k] for each in rivals] if not number else [],
            }
            for number, (name, probability) in enumerate(causes.items())
        ],
        "unknown_probability": 1.0 - sum(causes.values()),
    }


@pytest.mark.parametrize(
    ("truth", "diagnosis", "outcome", "is_right"),
    [
        ("coil_lag", said("effect", {"coil_lag": 0.9}), "right", True),
        ("coil_lag", said("effect", {"sensor_lag": 0.6, "coil_lag": 0.3}, ("coil_lag",)), "alias", True),
        ("coil_lag", said("effect", {"sensor_lag": 0.9}), "wrong", False),
        ("coil_lag", said("effect", {"coil_lag+end_stop": 0.9}), "partly", False),
        ("coil_lag", said("unknown", {"sensor_lag": 0.3}), "unknown", False),
        ("coil_lag", said("none", {"": 0.9}), "none", False),
        ("linkage_backlash", said("none", {"": 0.9}, ("linkage_backlash",)), "alias", True),
        ("coil_lag+end_stop", said("effect", {"end_stop+coil_lag": 0.9}), "right", True),
        ("coil_lag+end_stop", said("effect", {"end_stop": 0.9}), "partly", False),
        ("", said("none", {"": 0.9}), "right", True),
        ("", said("effect", {"coil_lag": 0.6, "": 0.3}, ("",)), "false alarm", False),
        ("", said("unknown", {"": 0.2}), "unknown", False),
    ],
)
def test_truth_among_the_candidates(truth, diagnosis, outcome, is_right):
    effects = tuple(key for key in truth.split("+") if key)
    found = mark("single" if effects else "none", effects, diagnosis)
    assert (found.outcome, found.is_right) == (outcome, is_right)


def test_declared_set_of_more_than_three_does_not_count():
    rivals = ("transport_delay", "chamber_filling", "coil_lag")
    assert mark("single", ("coil_lag",), said("effect", {"sensor_lag": 0.9}, rivals)).outcome == "wrong"
    assert mark("single", ("coil_lag",), said("effect", {"sensor_lag": 0.9}, rivals[1:])).outcome == "alias"


@pytest.mark.parametrize(
    ("diagnosis", "outcome", "is_right"),
    [
        (said("unknown", {"sensor_lag": 0.2}), "unknown", True),
        (said("effect", {"sensor_lag": 0.9}), "alias", True),
        (said("effect", {"sensor_lag+transport_delay": 0.9}), "alias", True),
        (said("effect", {"sensor_lag+end_stop": 0.9}), "wrong", False),
        (said("effect", {"end_stop": 0.9}), "wrong", False),
        (said("effect", {"end_stop": 0.4, "load_force": 0.3}), "unsure", False),
        (said("none", {"": 0.9}), "none", False),
    ],
)
def test_truth_left_out_of_the_candidates(diagnosis, outcome, is_right):
    found = mark("left-out", ("coil_lag",), diagnosis)
    assert (found.outcome, found.is_right) == (outcome, is_right)
    assert found.is_true == is_right


def test_none_is_right_where_the_left_out_effect_states_it_as_its_alias():
    assert mark("left-out", ("linkage_backlash",), said("none", {"": 0.9})).outcome == "alias"


def test_stage_counts_by_name_and_by_a_set_of_at_most_two():
    diagnosis = said("effect", {"sensor_lag": 0.9}, ("transport_delay",), stage="sensor")
    assert mark("single", ("chamber_filling",), diagnosis).is_stage_right
    assert not mark("single", ("coil_lag",), diagnosis).is_stage_right
    three = said("effect", {"sensor_lag": 0.9}, ("transport_delay", "coil_lag"), stage="sensor")
    assert not mark("single", ("spring_hardening",), three).is_stage_right


def test_probability_is_that_of_the_whole_family():
    diagnosis = said("effect", {"sensor_lag": 0.5, "coil_lag": 0.3, "end_stop": 0.1}, ("coil_lag",))
    found = mark("single", ("coil_lag",), diagnosis)
    assert found.said == pytest.approx(0.8)
    assert found.is_true


def test_wilson_interval_is_the_published_one():
    # Newcombe, Statistics in Medicine 17 (1998), method 3: 81 of 263
    low, high = rate_of([True] * 81 + [False] * 182)["interval"]
    assert (round(low, 4), round(high, 4)) == (0.2553, 0.3662)
    assert rate_of([])["share"] is None


def result_of(outcome_said: float, is_true: bool, closed: float | None = None) -> Result:
    diagnosis = said("effect", {"coil_lag" if is_true else "end_stop": outcome_said})
    found = mark("single", ("coil_lag",), diagnosis)
    closure = {"closed": closed, "closed_free": None if closed is None else closed - 0.5}
    return Result("p", "single", ("coil_lag",), (), 5.0, found, "effect", None, closure)


def test_calibration_error_is_zero_where_frequency_is_what_was_said():
    results = [result_of(0.75, number < 75) for number in range(100)]
    assert calibration_of(results)["expected_calibration_error"] == pytest.approx(0.0)
    sure = [result_of(0.95, number < 75) for number in range(100)]
    assert calibration_of(sure)["expected_calibration_error"] == pytest.approx(0.20)


def test_closure_leaves_out_what_has_no_gap_to_close():
    results = [result_of(0.9, True, closed) for closed in (None, 0.8, 0.9, 1.0)]
    closure = closure_of(results)
    assert closure["plants"] == 3
    assert closure["median"] == pytest.approx(0.9)
    assert closure["lowest_decile"] == pytest.approx(0.82)
    assert closure["lowest_decile_free"] == pytest.approx(0.32)


def test_plants_that_a_refitted_base_imitates_are_told_apart():
    floor = 1e-4
    hidden, seen = (replace(result_of(0.9, False), closure={"base": f * floor, "floor": floor}) for f in (1.01, 1.5))
    assert hidden.is_imitated
    assert not seen.is_imitated
    counts = counts_of([hidden, seen, result_of(0.9, True)])
    assert (counts["right"]["hits"], counts["right"]["of"]) == (1, 3)
    assert (counts["right_where_visible"]["hits"], counts["right_where_visible"]["of"]) == (1, 2)
