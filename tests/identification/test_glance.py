"""A glance at an effect: a few points down from what promises most, to see which effects are worth a search."""

import pytest
from blind_fits import base_of_plant, fits_to_plant

from identification.extending import extension
from identification.extending.extension import continued, extend
from identification.extending.glance import GLANCE, glanced
from identification.search import descend_roughly


@pytest.mark.parametrize("key", ["sensor_lag", "chamber_filling", "transport_delay"])
def test_what_is_in_the_valve_shows_at_a_glance_though_slopes_promise_little(key):
    _, base = base_of_plant(9302, (key,))
    look = glanced(base, key)
    promised, seen = look.promised, look.fit
    others = [glanced(base, other).fit.found.error for other in ("spring_hardening", "linkage_backlash", "end_stop")]
    assert seen.found.error < 0.5 * min(base.found.error, *others)
    assert 1.0 - seen.found.error / base.found.error > 2.0 * promised


def test_what_comes_to_the_noise_at_a_glance_ends_where_a_whole_search_does():
    _, base, found = fits_to_plant(9302, "sensor_lag")
    seen = glanced(base, "sensor_lag").fit
    assert seen.found.error < 1.05 * base.problem.noise_error
    assert continued(seen).found.error == pytest.approx(found.found.error, rel=0.01)


def test_a_glance_leaves_no_more_than_the_fit_without():
    _, base = base_of_plant(9302, ("sensor_lag",))
    for key in ("asymmetric_friction", "gap_drift", "presliding", "choked_flow"):
        assert glanced(base, key).fit.found.error <= base.found.error


def test_beside_a_fit_that_leaves_little_slopes_tell_all():
    _, base = base_of_plant(9302, ("sensor_lag",))
    found = extend(base, "sensor_lag")
    look = glanced(found, "coil_lag")
    seen = look.fit
    assert look.share == look.promised < 0.01
    assert seen.found.error == found.found.error
    assert seen.model.effects["coil_lag"]["coil_time_constant"] == 0.0


def test_a_glance_takes_few_points(monkeypatch):
    """A start, and what a lag takes over from friction and mass that made up for it."""
    _, base = base_of_plant(9302, ("sensor_lag",))
    asked = []
    monkeypatch.setattr(
        "identification.extending.following.descend_roughly",
        lambda *given, evaluations, **named: (
            asked.append(evaluations) or descend_roughly(*given, evaluations=evaluations, **named)
        ),
    )
    glanced(base, "sensor_lag")
    assert asked == [GLANCE] * len(asked)
    assert 1 <= len(asked) <= 2


def test_what_comes_to_more_than_it_is_worth_is_not_followed_to_its_end(monkeypatch):
    _, base, found = fits_to_plant(9302, "sensor_lag")
    followed = []
    whole = extension.released_at_end
    monkeypatch.setattr(extension, "released_at_end", lambda *given: followed.append(given) or whole(*given))
    values = dict(found.model.effects["sensor_lag"])
    near = extension.extend_from(base, "sensor_lag", values, worth=0.9 * found.found.error)
    assert not followed
    ended_there = extension.extend_from(base, "sensor_lag", values, worth=2.0 * found.found.error)
    assert len(followed) == 1
    assert ended_there.found.error <= near.found.error < base.found.error
