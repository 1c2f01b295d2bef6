"""The noise floor of an unseen record is what no model of the valve gets below."""

import math

import numpy as np
import pytest

from diagnosis.blindtest.plants import draw_plant
from diagnosis.trials.closure import closure_on_unseen
from valvemodel.model import Model
from valvemodel.valves import read_valve


@pytest.fixture
def answer(tmp_path):
    valve = read_valve("calibrated")
    for name in ("base.json", "model.json"):
        Model(valve.name, valve.values).write(tmp_path / name)
    return tmp_path


def test_a_fine_reading_has_the_noise_of_the_plant(answer):
    plant = draw_plant(5, ("spring_hardening",))
    floor = closure_on_unseen(answer, plant, 3, is_anchored=False)["floor"]
    assert floor == pytest.approx(np.hypot(plant.noise, plant.resolution / math.sqrt(12.0)), rel=0.03)


def test_noise_before_a_coarse_converter_shows_as_whole_steps(answer):
    plant = draw_plant(5, ("quantisation",))
    (truth,) = [each for each in plant.effects if each.effect == "quantisation"]
    assert truth.formulation == "converter"
    # The chance that noise takes a reading over the edge of a step is its mean size over the step.
    expected = math.sqrt(truth.parameters["reading_step"] * plant.noise * math.sqrt(2.0 / math.pi))
    floor = closure_on_unseen(answer, plant, 3, is_anchored=False)["floor"]
    assert floor == pytest.approx(expected, rel=0.1)
    assert floor > 2.0 * plant.noise


def test_the_share_of_a_free_run_stands_beside_that_of_the_re_anchored_one(answer):
    plant = draw_plant(5, ("static_friction",))
    valve = read_valve("calibrated")
    sticking = Model(valve.name, valve.values).with_effect("static_friction", static_friction_ratio=1.3)
    sticking.write(answer / "model.json")
    free, anchored = (closure_on_unseen(answer, plant, 3, is_anchored=each) for each in (False, True))
    assert anchored["base"] < free["base"]
    assert anchored["closed"] != pytest.approx(anchored["closed_free"], rel=0.01)
    assert anchored["closed_free"] == free["closed_free"] == free["closed"]
