"""`valvemodel effects` shows what the declarations hold, all of it."""

import json

import pytest

from valvemodel.declarations import STAGES
from valvemodel.stages import EFFECTS


def test_list_has_every_effect_and_parameter_by_stage(command):
    output = command("effects").output
    for effect in EFFECTS:
        assert effect.key in output
        for parameter in effect.shown:
            assert f"{parameter.name} [{parameter.unit}]" in output
    assert [line.strip() for line in output.splitlines() if line.strip() in STAGES] == list(STAGES)


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.key)
def test_one_effect_is_shown_whole(command, effect):
    output = " ".join(command("effects", effect.key).output.split())
    for text in (effect.title, effect.meaning, effect.source, *(each.name for each in effect.shown)):
        assert text in output
    equation = output.split(" equation ")[1].split(" source ")[0]
    assert not set(equation) & set("\\{}"), "an equation on a terminal is no LaTeX"


def test_exponent_of_several_parts_keeps_its_brackets(command):
    assert "(P/P_1)^(n - 1)" in command("effects", "pressure_dependent_friction").output


def test_json_is_for_machines(command):
    content = json.loads(command("effects", "--json").output)
    assert content["schema"] == "valvemodel.effects/1"
    assert [each["key"] for each in content["effects"]] == [effect.key for effect in EFFECTS]
    stop = next(each for each in content["effects"] if each["key"] == "end_stop")
    assert stop["parameters"]["upper_stop"]["neutral"] is None
