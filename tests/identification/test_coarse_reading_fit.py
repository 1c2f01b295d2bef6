"""A blind valve whose transmitter reads in coarse steps is fitted to what its noise leaves at the steps' edges."""

import math

import numpy as np
import pytest
from blind_fits import fits_to_plant

from identification.search import descend, descend_to_end, errors

LEFT_AT_EDGES = 2.0 / 3.0 * math.sqrt(2.0 / math.pi)
"""Mean square beyond half a step that noise leaves of the right model, over the cube of the noise by the step."""


@pytest.mark.parametrize(
    ("seed", "profile", "nuisance"), [(1748376440, 1841907097, True), (9403, None, False), (9404, None, False)]
)
def test_noise_at_the_edges_is_all_that_is_left(seed, profile, nuisance, tmp_path):
    plant, _, found = fits_to_plant(seed, "quantisation", tmp_path, profile=profile, nuisance=nuisance)
    truth = plant.effects[0].parameters
    assert found.model.effects["quantisation"]["resolution"] == pytest.approx(truth["reading_step"], rel=1e-3)
    (experiment,) = found.problem.experiments
    expected = LEFT_AT_EDGES * experiment.noise / truth["reading_step"]
    assert found.found.error / found.problem.noise_error < 1.3 * expected


def test_a_search_to_the_end_passes_by_flat_places_and_ends_no_worse_than_it_began(tmp_path):
    _, base, found = fits_to_plant(1748376440, "quantisation", tmp_path, profile=1841907097, nuisance=True)
    problem = found.problem
    assert problem.is_in_steps
    assert not base.problem.is_in_steps
    start = base.found.point
    plain = descend(problem, start, evaluations=60, precision=1e-8)
    assert descend_to_end(problem, start).error < 0.3 * plain.error
    draws = found.found.point + 0.02 * np.random.default_rng(0).standard_normal((3, len(start)))
    for begun in (found.found.point, *draws):
        assert descend_to_end(problem, begun).error <= float(errors(problem, begun[None, :])[0]) * (1.0 + 1e-9)
