"""Blind valves whose stop gives way, or does not, are explained to the noise, and the stop's stiffness is found."""

import pytest
from blind_fits import fits_to_plant

from identification.starting.hints import other_forms
from valvemodel.effects import effect_of_key


@pytest.mark.parametrize(("seed", "formulation"), [(1, "elastic"), (5, "elastic"), (14, "elastic"), (3, "rigid")])
def test_a_stop_is_found_with_what_it_gives_way(seed, formulation):
    plant, base, found = fits_to_plant(seed, "end_stop")
    truth = plant.effects[0]
    assert truth.formulation == formulation
    assert base.found.error > 30.0 * base.problem.noise_error
    assert found.found.error < 1.02 * found.problem.noise_error
    values, side = found.model.effects["end_stop"], truth.parameters["side"]
    stop = values["upper_stop"] if side > 0.0 else values["lower_stop"]
    assert stop == pytest.approx(truth.parameters["reference_travel"] - side * truth.parameters["depth"], abs=2e-4)
    compliance = 1.0 / truth.parameters["stop_stiffness"] if formulation == "elastic" else 0.0
    assert values["stop_compliance"] == pytest.approx(compliance, abs=4e-8)


def test_a_stop_is_dead_or_gives_way_and_no_fit_turns_one_into_the_other():
    effect = effect_of_key("end_stop")
    dead = effect.typical | {"stop_compliance": 0.0}
    (yielding,) = other_forms(effect, dead)
    assert yielding == dead | {"stop_compliance": 2e-7}
    assert other_forms(effect, yielding) == [dead]
    assert effect.held_at(dead) == {"stop_compliance"}
    assert effect.held_at(yielding) == set()
