"""A blind valve whose linkage has a worn joint is explained to the noise, and a sharp play is not taken for one."""

from dataclasses import replace

import numpy as np
import pytest
from blind_fits import base_of_plant, fits_to_plant

from identification.fit import Fit, simulate_model
from identification.search import descend
from identification.starting.joining import joined
from valvemodel.effects import effect_of_key


def error_of_sharp_play(base: Fit, half_width: float) -> float:
    """Error of the fit with a play that is not worn, from a width on."""
    start = {"backlash_half_width": half_width, "backlash_start": 0.0, "backlash_wear": 0.0}
    problem, point = joined(base.problem, base.found.point, effect_of_key("linkage_backlash"), start)
    is_free = np.array([unknown.name != "backlash_wear" for unknown in problem.unknowns])
    free = [unknown for unknown, free in zip(problem.unknowns, is_free, strict=True) if free]
    return descend(replace(problem, unknowns=free), point[is_free], evaluations=40, precision=1e-6).error


def test_worn_joint_is_explained_to_the_noise_where_a_sharp_play_is_not():
    plant, base, found = fits_to_plant(9403, "linkage_backlash")
    truth, noise = plant.effects[0], found.problem.noise_error
    assert truth.formulation == "worn_play"
    half_widths = [1e-3, 4e-3, 0.5 * truth.parameters["play"]]
    assert min(error_of_sharp_play(base, half_width) for half_width in half_widths) > 5.0 * noise
    assert found.found.error < 1.05 * noise
    numbers = found.model.effects["linkage_backlash"]
    assert numbers["backlash_wear"] == pytest.approx(0.3, abs=0.03)
    assert 2.0 * numbers["backlash_half_width"] == pytest.approx(truth.parameters["play"], rel=0.06)


def test_sharp_play_is_found_without_wear():
    plant, base, found = fits_to_plant(9412, "linkage_backlash")
    assert plant.effects[0].formulation == "play"
    assert base.found.error > 1.4 * base.problem.noise_error
    assert found.found.error < 1.05 * found.problem.noise_error
    assert found.model.effects["linkage_backlash"]["backlash_wear"] < 0.03


def test_where_a_record_began_in_a_loop_is_not_carried_over_to_another():
    key = "magnetic_hysteresis"
    neutral = {each.name: each.neutral for each in effect_of_key(key).parameters}
    _, base = base_of_plant(9412, ("linkage_backlash",))
    fitted = base.problem.experiments[0]
    # One that begins with a long stroke forgets where it began.
    fitted = replace(fitted, current=0.012 + 1.5e-3 * np.sin(0.3 * fitted.time))
    begun = replace(
        base,
        problem=replace(base.problem, experiments=[fitted]),
        model=base.model.with_effect(key, **neutral | {"hysteresis_half_width": 4e-4, "hysteresis_start": 1.0}),
    )
    whole = begun.model.without_starts()
    assert whole.effects[key] == {**begun.model.effects[key], "hysteresis_start": 0.0}
    other = replace(fitted, position=fitted.position + 1e-3)
    at_rest = simulate_model(whole, other, start_position=other.first_reading).position[0]
    assert np.array_equal(begun.simulated_on(other).position[0], at_rest)
    off = begun.simulated_on(fitted).position[0] - replace(begun, model=whole).simulated_on(fitted).position[0]
    assert np.abs(off).max() > 1e-3
