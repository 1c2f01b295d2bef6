"""A periodic load is found though a stem with friction answers it by no wave."""

import numpy as np
import pytest
from blind_fits import base_of_plant, fits_to_plant

from identification.starting.hints import nearby, strongest_periods
from identification.starting.screening import residual_positions


@pytest.mark.parametrize("seed", [9204, 9208])
def test_a_periodic_load_is_explained_to_the_noise(seed):
    plant, base, found = fits_to_plant(seed, "load_force", nuisance=True)
    (load,) = plant.effects[:1]
    assert load.formulation == "sine"
    assert base.found.error > 20.0 * base.problem.noise_error
    assert found.found.error < 1.05 * found.problem.noise_error
    values = found.model.effects["load_force"]
    assert values["load_period"] == pytest.approx(load.parameters["load_period"], rel=0.01)
    amplitude = np.hypot(values["load_sine"], values["load_cosine"])
    assert amplitude == pytest.approx(load.parameters["amplitude"], rel=0.2)


def test_the_strongest_period_of_the_residual_is_not_the_load_s():
    plant, base = base_of_plant(9208, ("load_force",), nuisance=True)
    (strongest, *_) = strongest_periods(base.problem.experiments[0].time, residual_positions(base)[0])
    assert abs(strongest / plant.effects[0].parameters["load_period"] - 1.0) > 0.02


def test_periods_beside_one_and_the_lowest_waves_are_tried():
    tried = nearby([5.0], 100.0)
    assert tried == sorted(tried, reverse=True)
    assert {100.0 / count for count in (0.5, 1.0, 15.5, 19.0, 19.25, 20.0, 21.0)} <= set(tried)
    assert min(tried) == pytest.approx(100.0 / 21.0)
    assert len(tried) == 31 + 9
