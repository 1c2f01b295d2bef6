"""A blind valve whose transmitter reads in coarse steps is fitted to what its noise leaves at the steps' edges."""

from dataclasses import replace

import numpy as np
import pytest
from blind_fits import base_of_plant, fits_to_plant

from identification.extending.extension import extend
from identification.search import descend_to_end

FRICTION = "pressure_dependent_friction"


@pytest.mark.parametrize(
    ("seed", "profile", "nuisance"), [(1748376440, 1841907097, True), (9403, None, False), (9404, None, False)]
)
def test_noise_at_the_edges_is_all_that_is_left(seed, profile, nuisance):
    plant, _, found = fits_to_plant(seed, "quantisation", profile=profile, nuisance=nuisance)
    truth = plant.effects[0].parameters
    assert found.model.effects["quantisation"]["resolution"] == pytest.approx(truth["reading_step"], rel=1e-3)
    assert found.found.error < 1.3 * found.problem.noise_error


def test_noise_leaves_as_much_beyond_half_a_step_as_is_said():
    _, _, found = fits_to_plant(9403, "quantisation")
    problem, (experiment,) = found.problem, found.problem.experiments
    generator = np.random.default_rng(1)
    places = generator.uniform(-0.5, 0.5, 400_000) * problem.step
    noisy = places + experiment.noise * generator.standard_normal(len(places))
    beyond = np.maximum(np.abs(problem.step * np.round(noisy / problem.step) - places) - 0.5 * problem.step, 0.0)
    expected = 0.5 * problem.used[0].sum() * np.mean((beyond / experiment.noise) ** 2)
    assert problem.noise_error == pytest.approx(expected, rel=0.03)


def test_noise_beyond_steps_is_that_of_the_records_that_come_in_them():
    _, _, found = fits_to_plant(9403, "quantisation")
    problem, (coarse,) = found.problem, found.problem.experiments
    fine = replace(coarse, position=coarse.position + 1e-3 * np.random.default_rng(0).standard_normal(len(coarse.time)))
    both = replace(problem, experiments=[coarse, fine], used=[problem.used[0]] * 2)
    assert both.is_in_steps
    assert both.noise_error == pytest.approx(problem.noise_error + 0.5 * problem.used[0].sum())


def test_a_search_within_coarse_steps_ends_at_the_same_least_error_wherever_it_begins():
    _, base, found = fits_to_plant(1748376440, "quantisation", profile=1841907097, nuisance=True)
    problem = found.problem
    assert problem.is_in_steps
    assert not base.problem.is_in_steps
    draws = found.found.point + 0.02 * np.random.default_rng(0).standard_normal((3, len(found.found.point)))
    ends = [descend_to_end(problem, begun).error for begun in (base.found.point, found.found.point, *draws)]
    assert max(ends) < 1.01 * min(ends)
    assert max(ends) < problem.noise_error


def test_slopes_at_the_edges_of_coarse_steps_are_those_of_either_side():
    _, _, found = fits_to_plant(9403, "quantisation")
    problem, point = found.problem, found.found.point
    missed = problem.residuals(point[None, :])[0]
    nudge = 1e-6 * np.eye(len(point))
    near = (problem.residuals(point + nudge) - problem.residuals(point - nudge)).T / 2e-6
    slopes = problem.jacobian(point)
    is_beyond = np.abs(missed) > 0.01
    is_beyond[-len(point) :] = False
    assert is_beyond.sum() > 50
    assert np.linalg.norm(slopes[is_beyond] - near[is_beyond]) < 0.02 * np.linalg.norm(near[is_beyond])
    is_within = missed == 0.0
    is_within[-len(point) :] = False
    assert not slopes[is_within].any()


def test_an_effect_is_found_beside_a_coarse_reading_that_is_explained_but_for_few_samples():
    keys = ("spring_hardening", "quantisation")
    plant, base = base_of_plant(2125126519, keys, profile=889430106, nuisance=True)
    coarse = extend(base, "quantisation")
    found = extend(coarse, "spring_hardening")
    assert found.found.error < 0.1 * coarse.found.error
    # Stated at 0.2 m of a stiffening with the square of the travel.
    truth = plant.effects[0].parameters["stiffening"] / 0.2**2
    assert found.model.effects["spring_hardening"]["spring_hardening"] == pytest.approx(truth, rel=0.5)


@pytest.mark.parametrize("order", [("quantisation", FRICTION), (FRICTION, "quantisation")])
def test_steps_that_were_taken_for_noise_hide_no_form_of_what_is_beside_them(order):
    """Friction that grows with the square of the pressure had been taken for one that grows with it, a hair behind."""
    _, base = base_of_plant(1087214335, (FRICTION, "quantisation"), profile=996414304, nuisance=True)
    found = extend(extend(base, order[0]), order[1])
    assert found.model.effects[FRICTION]["friction_pressure_order"] == 2.0
    assert found.found.error < found.problem.noise_error
