"""How far an effect is followed on top of a fit: not on from where it can come to nothing."""

from types import SimpleNamespace

import numpy as np
import pytest

from identification.extending import extension, following
from identification.extending.following import HOPELESS, IN_REACH, best_descended, hopeless_from, starts_from
from identification.search import Found
from identification.starting.screening import Trial
from valvemodel.effects import effect_of_key


def fit_of(error: float, *effects: str) -> SimpleNamespace:
    problem = SimpleNamespace(noise_error=10.0, within=0.5, is_in_steps="quantisation" in effects)
    return SimpleNamespace(
        found=Found(np.zeros(1), error), problem=problem, model=SimpleNamespace(effects={key: {} for key in effects})
    )


@pytest.mark.parametrize(
    ("error", "worth", "expected"),
    [(900.0, 400.0, HOPELESS * 400.0), (900.0, np.inf, HOPELESS * 900.0), (900.0, 11.0, IN_REACH * 10.0)],
)
def test_what_is_far_above_what_is_worth_it_and_above_the_noise_is_hopeless(error, worth, expected):
    assert hopeless_from(fit_of(error, "coil_lag"), worth) == expected
    assert hopeless_from(fit_of(error), worth) == np.inf


@pytest.mark.parametrize(("hopeless", "asked"), [(2.9, [6, 6]), (3.0, [6, 6, 10]), (np.inf, [6, 6, 10])])
def test_the_best_start_is_followed_further_unless_it_is_hopeless(monkeypatch, hopeless, asked):
    points = []

    def descend(problem, point, *, evaluations, renewed, precision=None):
        points.append(evaluations)
        return Found(point, float(point[0]) - (2.0 if evaluations == 10 else 0.0))

    for search in ("descend", "descend_roughly"):
        monkeypatch.setattr(following, search, descend)
    starts = [("far", np.array([4.0])), ("near", np.array([3.0]))]
    problem, best = best_descended(starts, first=6, further=10, precision=1e-3, hopeless=hopeless)
    assert (problem, best.error) == ("near", 1.0 if len(asked) == 3 else 3.0)
    assert points == asked


@pytest.mark.parametrize(
    ("beside", "is_off", "expected"),
    [
        ((), False, [1.0, 2.0, -1.0]),
        (("end_stop",), False, [1.0, 2.0]),
        (("end_stop",), True, [1.0, 2.0, -1.0]),
    ],
)
def test_the_valve_as_given_is_a_start_alone_or_where_the_mass_is_far_off(monkeypatch, beside, is_off, expected):
    monkeypatch.setattr(following, "as_given", lambda fit, point: -point)
    monkeypatch.setattr(following, "is_far_off", lambda fit: is_off)
    for choice in ("of_another_form", "of_another_side", "starts_traded", "form_of"):
        monkeypatch.setattr(following, choice, lambda *_: [])
    group = [Trial("problem", np.array([place]), 0.0) for place in (1.0, 2.0, 3.0)]
    starts = starts_from(fit_of(900.0, *beside), effect_of_key("spring_hardening"), group)
    assert [point[0] for _, point in starts] == expected


@pytest.mark.parametrize(
    ("beside", "expected"),
    [("static_friction", [1.0, 5.0, 7.0]), ("stribeck", [1.0, 5.0]), ("spring_hardening", [1.0, 5.0])],
)
def test_where_a_lag_takes_over_from_slips_that_last_is_searched_about(monkeypatch, beside, expected):
    for choice in ("of_another_form", "of_another_side", "form_of"):
        monkeypatch.setattr(following, choice, lambda *_: [])
    monkeypatch.setattr(following, "is_far_off", lambda fit: False)
    monkeypatch.setattr(following, "starts_traded", lambda *_: [("traded", np.array([5.0]))])
    monkeypatch.setattr(following, "searched_from", lambda problem, point: (problem, point + 2.0))
    group = [Trial("problem", np.array([1.0]), 0.0)]
    starts = starts_from(fit_of(900.0, beside), effect_of_key("sensor_lag"), group)
    assert [point[0] for _, point in starts] == expected


@pytest.mark.parametrize(("left", "is_followed"), [(899.0, True), (901.0, False)])
def test_what_is_no_nearer_within_coarse_steps_is_left(monkeypatch, left, is_followed):
    followed = []
    monkeypatch.setattr(
        extension, "replace", lambda problem, within: SimpleNamespace(**vars(problem) | {"within": within})
    )
    monkeypatch.setattr(extension, "errors", lambda problem, points: np.array([left if problem.within else 5000.0]))
    monkeypatch.setattr(extension, "finished", lambda problem, found: SimpleNamespace(problem=problem, found=found))
    monkeypatch.setattr(extension, "at_neutral", lambda fit, effect: (fit.problem, fit.found))
    # Far nearer as if the steps were noise.
    monkeypatch.setattr(extension, "extended", lambda *_, **__: fit_of(100.0, "quantisation"))

    def released_at_end(problem, point):
        followed.append(problem.within)
        return problem, Found(point, 1.0)

    monkeypatch.setattr(extension, "released_at_end", released_at_end)
    monkeypatch.setattr(extension, "in_best_form", lambda effect, problem, ended: (problem, ended))
    fit, effect = fit_of(900.0, "quantisation"), effect_of_key("coil_lag")
    found = extension.beside_steps(fit, effect, extension.Extension(is_global=False))
    assert followed == ([0.5] if is_followed else [])
    assert found.found.error == (1.0 if is_followed else 900.0)
