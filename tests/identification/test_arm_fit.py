"""A blind valve with a rotary linkage of large angle, or with a zero that creeps on, is explained to the noise."""

import pytest
from blind_fits import fits_to_plant

from identification.fit import finished
from identification.search import descend_to_end
from identification.starting.joining import joined
from valvemodel.effects import effect_of_key


@pytest.mark.parametrize("seed", [9508, 9512])
def test_a_whole_arm_is_told_from_its_third_order(seed):
    plant, base, found = fits_to_plant(seed, "linkage_nonlinearity")
    assert plant.effects[0].formulation in ("tangent", "sine")
    assert found.found.error < 1.1 * found.problem.noise_error
    values = found.model.effects["linkage_nonlinearity"]
    assert values["linkage_arm"] == 1.0
    assert (values["linkage_skew"] > 0.0) == (plant.effects[0].formulation == "sine")
    problem, point = joined(
        base.problem, found.found.point[:-2], effect_of_key("linkage_nonlinearity"), values | {"linkage_arm": 0.0}
    )
    third = finished(problem, descend_to_end(problem, point))
    assert third.found.error > 1.3 * found.found.error


@pytest.mark.parametrize("seed", [9501, 9505])
def test_a_zero_that_creeps_on_is_followed_by_the_logarithm_of_time(seed):
    plant, _, found = fits_to_plant(seed, "sensor_drift")
    assert plant.effects[0].formulation == "logarithmic"
    assert found.found.error < 1.1 * found.problem.noise_error
    values = found.model.effects["sensor_drift"]
    assert values["sensor_drift_creep"] == 1.0
    assert values["sensor_drift_time"] == pytest.approx(plant.effects[0].parameters["time_constant"], rel=0.1)
