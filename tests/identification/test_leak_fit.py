"""A blind valve with a leak that chokes is explained."""

from blind_fits import fits_to_plant


def test_a_leak_by_which_gas_escapes_is_explained_as_one_that_chokes():
    plant, base, found = fits_to_plant(112781458, "air_leak", profile=1739084046, nuisance=True)
    assert plant.effects[0].formulation == "choked"
    assert base.found.error > 1.15 * base.problem.noise_error
    assert found.found.error < 1.02 * found.problem.noise_error
    assert found.model.effects["air_leak"]["leak_chokes"] == 1.0
