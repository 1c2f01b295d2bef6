"""A blind valve whose core saturates, by whatever law, is explained to the noise."""

import numpy as np
import pytest
from blind_fits import fits_to_plant

from diagnosis.blindtest.chain import electromagnet
from identification.starting.hints import other_forms
from identification.unknowns import effect_unknowns
from valvemodel.effects import effect_of_key
from valvemodel.stages import EFFECTS


def test_a_core_that_saturates_as_tanh_is_explained_by_that_law():
    plant, base, found = fits_to_plant(1620215614, "magnetic_saturation", profile=774532524, nuisance=True)
    truth = plant.effects[0]
    assert truth.formulation == "tanh"
    assert base.found.error > 1.4 * base.problem.noise_error
    assert found.found.error < 1.02 * found.problem.noise_error
    numbers = found.model.effects["magnetic_saturation"]
    assert numbers["saturation_law"] == 1.0
    assert abs(numbers["saturation_knee"] - truth.parameters["knee_current"]) < 1e-3


def test_two_straight_lines_of_any_slope_are_explained_by_that_law(monkeypatch):
    def kinked(current, truth):
        knee, curvature = truth.parameters["knee_current"], truth.parameters["knee_curvature"]
        return np.minimum(current, knee) + np.maximum(current - knee, 0.0) / (1.0 + 0.01 * curvature)

    monkeypatch.setattr(electromagnet, "_saturation", kinked)
    plant, base, found = fits_to_plant(9503, "magnetic_saturation")
    truth = plant.effects[0].parameters
    assert base.found.error > 50.0 * base.problem.noise_error
    assert found.found.error < 1.02 * found.problem.noise_error
    numbers = found.model.effects["magnetic_saturation"]
    assert numbers["saturation_reach"] == numbers["saturation_law"] == 0.0
    assert abs(numbers["saturation_slope"] - 1.0 / (1.0 + 0.01 * truth["knee_curvature"])) < 2e-3
    assert abs(numbers["saturation_knee"] - truth["knee_current"]) < 5e-5


def test_a_law_holds_its_numbers_and_its_other_forms_let_them_go():
    effect = effect_of_key("magnetic_saturation")
    lines = {"saturation_slope": 0.8, "saturation_knee": 0.012, "saturation_rounding": 1e-3}
    lines |= {"saturation_reach": 0.0, "saturation_law": 0.0}
    assert {each.name for each in effect_unknowns(effect.key, lines)} == {
        "saturation_slope", "saturation_knee", "saturation_rounding",
    }  # fmt: skip
    hyperbola, tanh = other_forms(effect, lines)
    assert hyperbola == lines | {"saturation_slope": 0.0, "saturation_reach": 0.05}
    assert tanh == hyperbola | {"saturation_law": 1.0}
    assert {each.name for each in effect_unknowns(effect.key, tanh)} == {
        "saturation_knee", "saturation_rounding", "saturation_reach",
    }  # fmt: skip
    assert other_forms(effect, hyperbola) == [tanh, lines | {"saturation_slope": 0.7}]
    # Of no law that is declared: all may move.
    assert len(effect_unknowns(effect.key, lines | {"saturation_reach": 0.02})) == 4


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.key)
def test_every_form_of_an_effect_has_all_the_others_as_its_other_forms(effect):
    values = {each.name: next((s for s in each.starts if isinstance(s, float)), 1.0) for each in effect.parameters}
    for law in effect.laws or ({},):
        others = other_forms(effect, values | law)
        assert all(each.keys() == values.keys() for each in others)
        assert effect.form_at(values | law) not in map(effect.form_at, others)
        assert len(others) >= len(effect.laws) - 1
