"""A blind test's plan: the same from the same seed, every effect in turn, more plants on top."""

import pytest

from diagnosis.blindtest.formulations import EFFECTS
from diagnosis.trials.plan import KINDS, Settings, tasks_of
from valvemodel import stages
from valvemodel.errors import InputError


def test_more_plants_leave_the_first_ones_as_they_are():
    few, many = tasks_of(Settings(seed=3), 9), tasks_of(Settings(seed=3), 40)
    assert many[:9] == few
    assert tasks_of(Settings(seed=4), 9) != few


@pytest.mark.parametrize("kind", ["single", "left-out"])
def test_every_effect_comes_before_one_comes_again(kind: str):
    tasks = tasks_of(Settings(kinds=(kind,)), 2 * len(EFFECTS))
    for half in (tasks[: len(EFFECTS)], tasks[len(EFFECTS) :]):
        assert {task.effects for task in half} == {(key,) for key in EFFECTS}
    assert all(task.left_out == (task.effects if kind == "left-out" else ()) for task in tasks)


def test_kinds_take_turns_and_seeds_differ():
    tasks = tasks_of(Settings(), 12)
    assert [task.kind for task in tasks] == [*KINDS] * 3
    assert [len(task.effects) for task in tasks[:4]] == [1, 2, 0, 1]
    seeds = [seed for task in tasks for seed in task.seeds.values()]
    assert len(set(seeds)) == len(seeds)


def test_pairs_have_one_of_the_effects_asked_for():
    tasks = tasks_of(Settings(kinds=("pair",), only=("coil_lag",)), 26)
    assert all("coil_lag" in task.effects for task in tasks)
    assert len({task.effects for task in tasks}) == 26


def test_unknown_kinds_and_effects_are_refused():
    with pytest.raises(InputError, match="a kind of plant"):
        Settings(kinds=("singel",))
    with pytest.raises(InputError, match="coil_lag"):
        Settings(only=("coil_leg",))


def test_plants_and_toolkit_name_the_same_effects():
    assert set(EFFECTS) == {effect.key for effect in stages.EFFECTS}
