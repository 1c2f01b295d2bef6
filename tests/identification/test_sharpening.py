"""Searches about a fit go from afar to near, end no worse than they began, and lead out of a side minimum."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from blind_fits import fits_to_plant

from identification import sharpening
from identification.fit import finished
from identification.search import Found, descend_to_end
from identification.starting.joining import joined
from valvemodel.effects import effect_of_key


@pytest.mark.parametrize(
    ("errors", "rounds", "expected"),
    [([5.0, 4.0, 3.0], 3, 3.0), ([5.0, 0.9, 3.0], 2, 0.9), ([5.0, 4.9, 3.0], 2, 4.9), ([11.0, 5.0], 1, 10.0)],
)
def test_each_round_begins_where_the_best_was_found_and_looks_nearer(monkeypatch, errors, rounds, expected):
    asked = []

    def searched(problem, centre, seed, widest):
        asked.append((float(centre[0]), widest))
        return Found(np.array([errors[seed]]), errors[seed])

    monkeypatch.setattr(sharpening, "searched_about", searched)
    monkeypatch.setattr(sharpening, "descend", lambda problem, point: Found(point, 99.0))
    monkeypatch.setattr(sharpening, "finished", lambda problem, found: found)
    fit = SimpleNamespace(
        problem=SimpleNamespace(is_anchored=True, noise_error=1.0), found=Found(np.array([10.0]), 10.0)
    )
    assert sharpening.sharpened(fit).error == expected
    starts, widths = zip(*asked, strict=True)
    assert len(asked) == rounds
    assert list(widths) == sorted(widths, reverse=True)
    assert list(starts) == [min([10.0, *errors[:number]]) for number in range(rounds)]


def test_a_search_from_afar_leads_out_of_a_side_minimum():
    """Whether the fit itself ends there hangs by the last bit, as processors differ: too much damping leads there."""
    _, _, found = fits_to_plant(30023, "static_friction", nuisance=True)
    near, noise = sharpening.sharpened(found), found.problem.noise_error
    start = near.found.point + np.array([each.name == "viscous_friction" for each in near.unknowns])
    aside = finished(near.problem, descend_to_end(near.problem, start))
    assert aside.found.error > 3.0 * noise
    assert sharpening.sharpened(aside).found.error < 1.02 * noise


@pytest.mark.parametrize(("law", "rounds"), [("static_friction", 5), ("stribeck", 3)])
def test_rounds_in_vain_end_the_search_sooner_where_a_run_takes_long(monkeypatch, law, rounds):
    gained = [10.0, 4.0, 4.0, 4.0, 4.0]
    asked = []

    def searched(problem, centre, seed, widest, *, size):
        asked.append((seed, widest, size))
        return Found(np.array([gained[seed]]), gained[seed])

    monkeypatch.setattr(sharpening, "searched_about", searched)
    monkeypatch.setattr(sharpening, "errors", lambda problem, points: points[:, 0])
    monkeypatch.setattr(sharpening, "error_by_all", lambda problems, point: point[0] ** len(problems))
    monkeypatch.setattr(sharpening, "finished", lambda problem, found: found)
    monkeypatch.setattr(sharpening, "replace", lambda problem, **_: problem)
    fit = SimpleNamespace(
        problem=SimpleNamespace(is_anchored=False, noise_error=1.0),
        found=Found(np.array([20.0]), 20.0),
        model=SimpleNamespace(effects=[law]),
    )
    assert sharpening.sharpened(fit).error == 4.0
    assert len(asked) == 2 * rounds


def test_of_points_as_good_the_one_is_taken_that_does_best_on_all_that_was_measured(monkeypatch):
    """A slip hangs by a hair: with more of the first number than 0.1 it goes where it was not fitted."""
    fitted = SimpleNamespace(name="fitted")

    def errors(problem, points, most=np.inf):
        return 100.0 + 4.0 * (points**2).sum(axis=1)

    monkeypatch.setattr(sharpening, "errors", errors)
    monkeypatch.setattr(sharpening, "directions_at", lambda problem, centre, error: np.eye(2))
    monkeypatch.setattr(sharpening, "points_beside", lambda problem, centre, shape, moves: centre + moves)
    monkeypatch.setattr(
        sharpening,
        "errors_on_all",
        lambda problem, experiments, points, *, is_anchored: (
            errors(problem, points) + 900.0 * (points[:, 0] < 0.1) * (not is_anchored)
        ),
    )
    monkeypatch.setattr(sharpening, "finished", lambda problem, found: SimpleNamespace(problem=problem, found=found))
    found = sharpening.steadied(SimpleNamespace(problem=fitted, found=Found(np.zeros(2), 100.0)), ["one"])
    assert found.problem is fitted
    assert 0.1 <= found.found.point[0] < 0.2
    assert found.found.error <= 100.0 + sharpening.AS_GOOD
    goes = SimpleNamespace(problem=fitted, found=Found(np.array([0.2, 0.0]), 100.16))
    assert sharpening.steadied(goes, ["one"]).found.error <= 100.16


def test_what_was_not_fitted_is_run_as_it_is_scored():
    """All samples of the record that was fitted, and another from its first reading, in the middle of a loop."""
    _, _, found = fits_to_plant(30023, "static_friction", nuisance=True)
    key = "magnetic_hysteresis"
    loop = {each.name: each.neutral for each in effect_of_key(key).parameters} | {"hysteresis_half_width": 4e-4}
    problem, point = joined(found.problem, found.found.point, effect_of_key(key), loop | {"hysteresis_start": 0.9})
    (fitted,) = problem.experiments
    other = replace(fitted, position=fitted.position + 1e-3)
    fit = finished(problem, Found(point, 1.0))
    assert fit.model.effects[key]["hysteresis_start"] == 0.9
    for is_anchored in (False, True):
        both, own = (
            sharpening.errors_on_all(problem, experiments, point[None, :], is_anchored=is_anchored)[0]
            for experiments in ([fitted, other], [fitted])
        )
        for experiment, left in ((fitted, own), (other, both - own)):
            run = fit.simulated_on(experiment, is_anchored=is_anchored).position[0]
            squares = 0.5 * np.nansum(((experiment.position - run) / experiment.noise) ** 2)
            assert left == pytest.approx(squares, rel=1e-3)
