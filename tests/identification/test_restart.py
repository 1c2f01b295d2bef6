"""A fit that was led into a side minimum by a mass that is many times off comes out of it."""

import numpy as np
import pytest
from blind_fits import base_of_plant, base_of_record

from diagnosis.blindtest.plants import Plant, measure
from diagnosis.blindtest.truth import Truth
from identification.extending.extension import extend
from identification.extending.restart import begun_again, is_far_off
from identification.fit import finished
from identification.search import descend
from identification.starting.joining import joined
from valvemodel.effects import effect_of_key

BASE = {
    "stem_mass": 1.52, "spring_rate": 60860.0, "diaphragm_area": 0.063, "supply_pressure": 295500.0,
    "viscous_friction": 502.0, "coulomb_friction": 1437.0, "spring_preload": 0.0, "flow_ratio": 1.0437e9,
    "gap_offset": 1.187e-4, "gap_gain": 7.014e-4,
}  # fmt: skip
BRISTLES = Truth("presliding", "stem", "lugre", {"bristle_damping": 777.5, "compliance": 2.76e-6})
STOP = Truth("end_stop", "stem", "rigid", {"side": -1.0, "reference_travel": 0.0735, "depth": 4.1e-3})


@pytest.fixture(scope="module")
def fits():
    plant = Plant(2030783989, (BRISTLES, STOP), BASE, noise=1.24e-4)
    base = base_of_record(measure(plant, 1067357766))
    return base, extend(extend(base, "presliding"), "end_stop")


def test_a_fit_comes_out_of_a_side_minimum(fits):
    _, found = fits
    point = found.found.point.copy()
    point[[each.name == "stem_mass" for each in found.unknowns]] = np.log(0.1)
    lost = finished(found.problem, descend(found.problem, point, evaluations=60))
    assert is_far_off(lost)
    assert lost.found.error > 2.0 * lost.problem.noise_error
    again = begun_again(lost)
    assert again.found.error < 1.06 * again.problem.noise_error
    assert not is_far_off(again)
    assert again.model.values["stem_mass"] == pytest.approx(1.04 * 1.52, rel=0.1)
    assert again.model.effects["end_stop"]["stop_compliance"] == 0.0


def test_a_fit_that_is_at_its_best_is_no_worse_for_it(fits):
    for fit in fits:
        assert begun_again(fit).found.error <= fit.found.error


def test_two_effects_are_found_though_all_forces_of_the_valve_with_one_were_many_times_too_small():
    keys = ("position_dependent_friction", "pressure_dependent_friction")
    plant, base = base_of_plant(1032550951, keys, profile=1408653389, nuisance=True)
    tight = extend(base, keys[0])
    assert tight.model.values["spring_rate"] < 0.2 * plant.base["spring_rate"]
    assert is_far_off(tight)
    found = extend(tight, keys[1])
    assert found.found.error < 1.05 * found.problem.noise_error
    assert found.model.values["spring_rate"] == pytest.approx(plant.base["spring_rate"], rel=0.1)

    growing = effect_of_key(keys[1])
    values = {each.name: each.neutral for each in growing.parameters} | {"friction_area": 1e-3}
    problem, astray = joined(tight.problem, tight.found.point, growing, values)
    lost = finished(problem, descend(problem, astray, evaluations=60))
    assert lost.found.error > 50.0 * problem.noise_error
    assert begun_again(lost).found.error < 1.3 * problem.noise_error
