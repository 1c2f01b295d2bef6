"""Which laws are looked at beside which effects that bend the line, and where the line is let loose."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from workshops import EMPTY

from diagnosis.choosing import looks
from valvemodel.effects import effect_of_key

HELD = {
    ("spring_hardening", "static_friction"): 5.0,
    ("spring_hardening", "stribeck"): 6.0,
    ("area_variation", "static_friction"): 4.0,
    ("area_variation", "stribeck"): 1.0,
    ("linkage_nonlinearity", "static_friction"): 4.9,
}
"""Errors of a search in all forms, on the line as it is."""

NEAR = {
    ("area_variation", "static_friction"): 4.5,
    ("spring_hardening", "stribeck"): 5.5,
    ("linkage_nonlinearity", "static_friction"): 4.8,
    ("linkage_nonlinearity", "stribeck"): 3.0,
}
"""Errors of a search near the numbers that were found beside another effect."""


class Slip:
    """What stands for a search at the slips: its law's form and the error that it found."""

    def __init__(self, effects: tuple[str, ...], error: float) -> None:
        law = effect_of_key(effects[-1])
        self.effects, self.found = effects, SimpleNamespace(error=error)
        problem = SimpleNamespace(model=SimpleNamespace(effects={law.key: law.typical}), noise_error=1.0)
        self.slips = SimpleNamespace(problem=problem)


@pytest.fixture
def asked(monkeypatch):
    """Stand in for the searches; return what was searched in full, and what was let loose."""
    in_full, loose = [], []

    def searched(work, line):
        in_full.append(work.effects)
        return [Slip(work.effects, HELD[work.effects])]

    def let_loose(slip):
        loose.append(slip.effects)
        return Slip(slip.effects, LOOSE.get(slip.effects, slip.found.error))

    monkeypatch.setattr(looks, "slips_of", searched)
    monkeypatch.setattr(looks, "slips_again", lambda _, look: [Slip(look.work.effects, NEAR[look.work.effects])])
    monkeypatch.setattr(looks, "let_loose", let_loose)
    return in_full, loose


LOOSE = {("linkage_nonlinearity", "static_friction"): 0.5}
"""Errors where the line moves, if that changes them."""


def bent(*keys: str) -> list[SimpleNamespace]:
    return [SimpleNamespace(effect=effect_of_key(key), fit=None, line=None) for key in keys]


def alone_at(error: float, law: str = "static_friction", *, is_straight: bool = False) -> list[looks.Look]:
    """Return what a law makes of the slips alone, on a line that needs a bend or none."""
    line = SimpleNamespace(is_explained=is_straight)
    return [looks.Look(looks.Work(None, (law,), is_global=True), line, [Slip((law,), error)])]


def errors_of(found) -> dict[tuple[str, ...], float]:
    return {each.work.effects: each.error for each in found}


def test_the_laws_are_compared_again_beside_the_effect_where_one_came_nearest(asked, monkeypatch):
    """Beside the effect that bends the line best the wrong law seems the better one."""
    monkeypatch.setitem(LOOSE, ("linkage_nonlinearity", "static_friction"), 4.8)
    found = looks.look_beside(
        bent("spring_hardening", "area_variation", "linkage_nonlinearity"), ["static_friction", "stribeck"], EMPTY
    )
    assert asked[0] == list(HELD)[:4]
    assert errors_of(found) == {**HELD, **NEAR} | {key: HELD[key] for key in list(HELD)[2:4]}
    assert min(found, key=lambda each: each.error).work.effects == ("area_variation", "stribeck")


def test_an_effect_that_looks_worse_while_the_line_is_held_comes_nearest_where_it_moves(asked):
    found = errors_of(
        looks.look_beside(bent("spring_hardening", "linkage_nonlinearity"), ["static_friction"], EMPTY, alone_at(9.0))
    )
    assert found == {("spring_hardening", "static_friction"): 5.0, ("linkage_nonlinearity", "static_friction"): 0.5}


def test_a_line_is_let_loose_once_and_beside_what_comes_near_alone(asked, monkeypatch):
    monkeypatch.setitem(HELD, ("spring_hardening", "stribeck"), 20.0)
    looks.look_beside(bent("spring_hardening"), ["static_friction", "stribeck"], EMPTY, alone_at(9.0))
    assert asked[1] == [("spring_hardening", "static_friction")]
    asked[1].clear()
    looks.look_beside(bent("spring_hardening", "linkage_nonlinearity"), ["static_friction"], EMPTY, alone_at(9.0))
    # The numbers of the first effect are found once; those of the second near by, and then by themselves.
    assert asked[1].count(("spring_hardening", "static_friction")) == 1


@pytest.mark.parametrize(("alone", "is_loose"), [(5.5, True), (4.5, False)])
def test_what_bends_the_line_best_is_let_loose_first_only_if_a_law_alone_is_worse(asked, monkeypatch, alone, is_loose):
    """It is out of the question as soon as another effect comes much nearer."""
    monkeypatch.setitem(NEAR, ("area_variation", "static_friction"), 1.0)
    monkeypatch.setitem(HELD, ("area_variation", "static_friction"), 1.0)
    looks.look_beside(bent("spring_hardening", "area_variation"), ["static_friction"], EMPTY, alone_at(alone))
    assert (("spring_hardening", "static_friction") in asked[1]) == is_loose
    assert ("area_variation", "static_friction") in asked[1]


def test_a_law_alone_that_explains_the_slips_leaves_nothing_to_come_nearer(asked, monkeypatch):
    monkeypatch.setattr(looks, "noise_at_rests", lambda slip: 1.0)
    for error, is_explained in ((1.2, True), (1.3, False)):
        monkeypatch.setitem(HELD, ("static_friction",), error)
        (alone,) = looks.look_alone(None, None, {"static_friction": None}, EMPTY)
        assert alone.error == error
        assert alone.explains == is_explained


def test_what_a_law_made_of_the_slips_before_is_not_searched_for_again(asked):
    known = Slip(("stribeck",), 2.0)
    (nearest,) = looks.look_alone(None, None, {"stribeck": [known]}, EMPTY)
    assert (nearest.work.effects, nearest.error) == (("stribeck",), 2.0)
    assert asked == ([], [("stribeck",)])
    assert looks.look_alone(None, None, {}, EMPTY) == []


@pytest.mark.parametrize(("gained", "is_compared"), [(4.1, False), (3.9, True)])
def test_where_no_bend_is_needed_the_law_alone_leads_beside_all_and_the_other_is_tried_where_it_gains(
    asked, monkeypatch, gained, is_compared
):
    monkeypatch.setitem(NEAR, ("area_variation", "static_friction"), gained)
    monkeypatch.setitem(NEAR, ("spring_hardening", "static_friction"), 4.9)
    alone = [*alone_at(4.6, "stribeck", is_straight=True), *alone_at(5.0, is_straight=True)]
    looks.look_beside(bent("spring_hardening", "area_variation"), ["static_friction", "stribeck"], EMPTY, alone)
    in_full = [("area_variation", "static_friction"), ("area_variation", "stribeck")]
    assert asked[0] == in_full * is_compared, "static friction is about as near, and has a closed form"


def test_the_law_that_is_far_nearer_alone_leads_whatever_it_costs():
    """Beside an effect that gains it is the one that comes nearest."""
    alone = [*alone_at(4.0, "stribeck"), *alone_at(5.1)]
    assert looks.leading(alone).law == "stribeck"
    assert looks.leading([*alone_at(4.1, "stribeck"), *alone_at(5.1)]).law == "static_friction"


def test_what_was_worse_while_the_line_was_held_is_kept_for_where_it_moves(asked, monkeypatch):
    """Searched for in full the same law comes nearer on the line, and ends farther off."""
    pair = ("area_variation", "static_friction")
    near, full = Slip(pair, 4.0), Slip(pair, 3.0)
    ended = {near: 1.0, full: 2.0}
    monkeypatch.setattr(looks, "slips_again", lambda *_: [near])
    monkeypatch.setattr(
        looks, "slips_of", lambda work, line: [full if work.effects == pair else Slip(work.effects, 9.0)]
    )
    monkeypatch.setattr(looks, "let_loose", lambda slip: Slip(slip.effects, ended.get(slip, slip.found.error)))
    found = errors_of(
        looks.look_beside(bent("area_variation"), ["static_friction"], EMPTY, alone_at(5.0, is_straight=True))
    )
    assert found == {pair: 1.0}
