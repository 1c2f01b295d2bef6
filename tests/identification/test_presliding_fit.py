"""A blind valve that gives way before it slides is explained to the noise, whichever law it follows."""

import pytest
from blind_fits import fits_to_plant


@pytest.mark.parametrize(("seed", "law"), [(9001, "lugre"), (9019, "dahl"), (9000, "iwan")])
def test_presliding_of_every_law_is_explained_to_the_noise(seed, law):
    plant, base, found = fits_to_plant(seed, "presliding")
    assert plant.effects[0].formulation == law
    assert base.found.error > 10.0 * base.problem.noise_error
    assert found.found.error < 1.15 * found.problem.noise_error
    compliance = found.model.effects["presliding"]["presliding_compliance"]
    assert compliance == pytest.approx(plant.effects[0].parameters["compliance"], rel=0.2)
