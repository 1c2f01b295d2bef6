"""A blind valve with a slow transmitter is explained to the noise, whether it lags once or twice."""

import pytest
from blind_fits import fits_to_plant

from identification.extension import extend


@pytest.mark.parametrize(("seed", "order"), [(9302, "first_order"), (9306, "second_order"), (9314, "second_order")])
def test_lag_of_either_order_is_explained_to_the_noise(seed, order, tmp_path):
    plant, base, found = fits_to_plant(seed, "sensor_lag", tmp_path)
    assert plant.effects[0].formulation == order
    assert base.found.error > 4.0 * base.problem.noise_error
    assert found.found.error < 1.15 * found.problem.noise_error
    numbers = found.model.effects["sensor_lag"]
    total = numbers["sensor_time_constant"] + numbers["sensor_second_time_constant"]
    assert total == pytest.approx(plant.effects[0].parameters["time_constant"], rel=0.05)


def test_a_second_lag_is_found_where_the_base_valve_made_up_for_the_first_by_mass_and_damping(tmp_path):
    seed, profile = 1785193381, 946444716
    plant, base, found = fits_to_plant(seed, "sensor_lag", tmp_path, profile=profile, nuisance=True)
    assert plant.effects[0].formulation == "second_order"
    assert base.model.values["stem_mass"] > 5.0 * plant.base["stem_mass"]
    assert found.found.error < 1.05 * found.problem.noise_error
    numbers = found.model.effects["sensor_lag"]
    lag = numbers["sensor_time_constant"] + numbers["sensor_second_time_constant"]
    assert lag == pytest.approx(plant.effects[0].parameters["time_constant"], rel=0.01)


def test_a_lag_is_found_from_where_it_was_fitted_beside_another_effect(tmp_path):
    seed, profile = 1506728585, 827035033
    plant, base, found = fits_to_plant(seed, "sensor_lag", tmp_path, profile=profile, nuisance=True)
    assert found.found.error > 20.0 * found.problem.noise_error
    beside = extend(found, "asymmetric_viscous_friction")
    assert beside.found.error < 1.05 * beside.problem.noise_error
    again = extend(base, "sensor_lag", dict(beside.model.effects["sensor_lag"]), kin=beside)
    assert again.found.error < 1.05 * again.problem.noise_error
    numbers = again.model.effects["sensor_lag"]
    lag = numbers["sensor_time_constant"] + numbers["sensor_second_time_constant"]
    assert lag == pytest.approx(plant.effects[0].parameters["time_constant"], rel=0.01)
