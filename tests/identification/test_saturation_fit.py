"""A blind valve whose core saturates as a hyperbolic tangent is explained to the noise."""

from blind_fits import fits_to_plant


def test_a_core_that_saturates_as_tanh_is_explained_by_that_law(tmp_path):
    plant, base, found = fits_to_plant(1620215614, "magnetic_saturation", tmp_path, profile=774532524, nuisance=True)
    truth = plant.effects[0]
    assert truth.formulation == "tanh"
    assert base.found.error > 1.4 * base.problem.noise_error
    assert found.found.error < 1.02 * found.problem.noise_error
    numbers = found.model.effects["magnetic_saturation"]
    assert numbers["saturation_law"] == 1.0
    assert abs(numbers["saturation_knee"] - truth.parameters["knee_current"]) < 1e-3
