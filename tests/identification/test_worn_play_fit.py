"""A blind valve whose linkage has a worn joint is explained to the noise, and a sharp play is not taken for one."""

from dataclasses import replace

import numpy as np
import pytest
from blind_fits import fits_to_plant

from identification.fit import Fit
from identification.screening import joined
from identification.search import descend
from valvemodel.effects import effect_of_key


def error_of_sharp_play(base: Fit, half_width: float) -> float:
    """Error of the fit with a play that is not worn, from a width on."""
    start = {"backlash_half_width": half_width, "backlash_start": 0.0, "backlash_wear": 0.0}
    problem, point = joined(base.problem, base.found.point, effect_of_key("linkage_backlash"), start)
    is_free = np.array([unknown.name != "backlash_wear" for unknown in problem.unknowns])
    free = [unknown for unknown, free in zip(problem.unknowns, is_free, strict=True) if free]
    return descend(replace(problem, unknowns=free), point[is_free], evaluations=40, precision=1e-6).error


def test_worn_joint_is_explained_to_the_noise_where_a_sharp_play_is_not(tmp_path):
    plant, base, found = fits_to_plant(9403, "linkage_backlash", tmp_path)
    truth, noise = plant.effects[0], found.problem.noise_error
    assert truth.formulation == "worn_play"
    half_widths = [1e-3, 4e-3, 0.5 * truth.parameters["play"]]
    assert min(error_of_sharp_play(base, half_width) for half_width in half_widths) > 5.0 * noise
    assert found.found.error < 1.05 * noise
    numbers = found.model.effects["linkage_backlash"]
    assert numbers["backlash_wear"] == pytest.approx(0.3, abs=0.03)
    assert 2.0 * numbers["backlash_half_width"] == pytest.approx(truth.parameters["play"], rel=0.06)


def test_sharp_play_is_found_without_wear(tmp_path):
    plant, base, found = fits_to_plant(9412, "linkage_backlash", tmp_path)
    assert plant.effects[0].formulation == "play"
    assert base.found.error > 1.4 * base.problem.noise_error
    assert found.found.error < 1.05 * found.problem.noise_error
    assert found.model.effects["linkage_backlash"]["backlash_wear"] < 0.03
