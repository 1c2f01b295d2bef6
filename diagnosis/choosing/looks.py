"""Looks at the slips: what laws of stick-slip make of them, each slip by itself, beside effects that bend the line."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from diagnosis.trying.candidates import Work
from diagnosis.trying.workshop import Workshop
from identification.fit import Fit
from identification.stick_slip.bent_lines import BentLine
from identification.stick_slip.breakaway import Line
from identification.stick_slip.slip_laws import slips_beside, slips_by
from identification.stick_slip.slip_search import SlipSearch, form_of, let_loose, noise_at_rests, worth_loosening
from valvemodel.declarations import Form
from valvemodel.effects import effect_of_key

LOOSENED = 2.5
"""Error at the slips, over the best one's, both on lines that are held, up to which a line is let loose."""

NEARER_AT_SLIPS = 0.8
"""Error at the slips, over that of a law alone, below which an effect and a law must come to be searched for whole: an
effect's own numbers take in a part of any error."""

NEAR_IN_CLOSED_FORM = 1.25
"""Error at the slips, over the least, up to which a law whose slips have a closed form leads beside other effects: it
costs a tenth, and an effect that gains much beside one law gains beside the other."""


@dataclass(frozen=True)
class Look:
    """What a law on top of an effect, or alone, makes of the slips on a line; the best search for it first."""

    work: Work
    line: Line
    slips: list[SlipSearch]

    @property
    def bend(self) -> str:
        """The effect that bends the line."""
        return self.work.effects[0]

    @property
    def law(self) -> str:
        """The law of the slips."""
        return self.work.effects[-1]

    @property
    def error(self) -> float:
        """Error at the slips, each judged by itself."""
        return self.slips[0].found.error if self.slips else math.inf

    @property
    def explains(self) -> bool:
        """Whether the law explains the slips so well that none comes much nearer beside an effect."""
        return bool(self.slips) and NEARER_AT_SLIPS * self.error < noise_at_rests(self.slips[0])


def look_alone(fit: Fit, line: Line, laws: Mapping[str, list[SlipSearch] | None], workshop: Workshop) -> list[Look]:
    """Return what laws make of the slips by themselves, on the line of a fit, the best first.

    Parameters
    ----------
    fit : Fit
    line : Line
        Through its breakaways.
    laws : mapping
        By key what the forms of each make of the slips, None where that is to be searched for.
    workshop : Workshop
    """
    looks = Looks([], workshop)
    begun = [Look(Work(fit, (law,), is_global=True), line, slips or []) for law, slips in laws.items()]
    looks.add([each for each in begun if each.slips])
    looks.search([each for each in begun if not each.slips])
    looks.loosen()
    return sorted(looks.found, key=lambda each: each.error)


def look_beside(
    bent: Sequence[BentLine], laws: Sequence[str], workshop: Workshop, alone: Sequence[Look] = ()
) -> list[Look]:
    """Return what laws make of the slips beside effects that bend the line.

    Beside the first effect the laws are compared, each in all its forms; beside the others the better one is searched
    near its numbers. Where that comes nearest the laws are compared again: what is better beside a wrong effect need
    not be. Where the line needs no effect to bend it, what a law makes of the slips alone leads beside all of them, and
    the laws are compared where that gains.

    Parameters
    ----------
    bent : sequence of BentLine
        The one whose line is best first.
    laws : sequence of str
        Keys.
    workshop : Workshop
    alone : sequence of Look
        What laws make of the slips alone, the best first.
    """
    looks = Looks(bent, workshop)
    straight = [each for each in alone if each.slips and each.line.is_explained]
    if straight:
        leader = leading(straight)
        compared, far = None, NEARER_AT_SLIPS * leader.error
    else:
        looks.compare(bent[0], laws)
        if looks.nearest.error < min((each.error for each in alone), default=math.inf):
            looks.loosen()
        leader = leading(looks.found)
        compared, far = bent[0].effect.key, math.inf
    looks.follow(leader)
    looks.loosen()
    nearest = looks.nearest
    if nearest.bend != compared and nearest.error < far:
        looks.compare(next(each for each in bent if each.effect.key == nearest.bend), laws)
        looks.loosen()
        leader = leading(looks.found)
        if leader.error < nearest.error:
            looks.follow(leader)
            looks.loosen()
    return looks.found


def leading(looks: Sequence[Look]) -> Look:
    """Return which of some looks leads beside other effects: the nearest, or in closed form what is about as near."""
    order = sorted(looks, key=lambda each: each.error)
    near = [each for each in order if each.error <= NEAR_IN_CLOSED_FORM * order[0].error]
    return next((each for each in near if not effect_of_key(each.law).is_chaotic), order[0])


class Looks:
    """What is known of laws beside effects that bend the line: on lines that are held, and let loose where it pays."""

    def __init__(self, bent: Sequence[BentLine], workshop: Workshop) -> None:
        self.bent, self.map = bent, workshop.map
        self.held: dict[tuple[str, ...], Look] = {}
        self.searched: set[tuple[str, ...]] = set()
        self.loose: dict[SlipSearch, SlipSearch] = {}

    @property
    def found(self) -> list[Look]:
        """All looks, on lines that move where they were let loose."""
        return [with_best(each, [self.loose.get(slip, slip) for slip in each.slips]) for each in self.held.values()]

    @property
    def nearest(self) -> Look:
        """What came nearest."""
        return min(self.found, key=lambda each: each.error)

    def compare(self, beside: BentLine, laws: Sequence[str]) -> None:
        """Search for laws in all their forms beside an effect."""
        self.search([begun_look(beside, law) for law in laws])

    def follow(self, nearest: Look) -> None:
        """Search for the law that came nearest beside the other effects, near its numbers.

        A search that did not come near them leaves an effect behind that is as good. What has other numbers, or where
        there are none to begin near, is searched for by itself.
        """
        others = [begun_look(each, nearest.law) for each in self.bent if each.effect.key != nearest.bend]
        if nearest.slips:
            again = self.map(partial(slips_again, nearest.slips[0]), others)
            self.add([replace(look, slips=slips) for look, slips in zip(others, again, strict=True) if slips])
        self.search([each for each in others if each.work.effects not in self.held])

    def search(self, begun: Sequence[Look]) -> None:
        """Search for the law of each look in all its forms, unless that was done."""
        new = [each for each in begun if each.work.effects not in self.searched]
        self.searched |= {each.work.effects for each in new}
        slips = self.map(slips_of, [each.work for each in new], [each.line for each in new])
        self.add([replace(look, slips=found) for look, found in zip(new, slips, strict=True)])

    def add(self, looks: Sequence[Look]) -> None:
        """Add what was looked at to what is known of the same effect and law: what is worse may get better loose."""
        for look in looks:
            known = self.held.get(look.work.effects, replace(look, slips=[]))
            slips = sorted([*look.slips, *known.slips], key=lambda each: each.found.error)
            self.held[look.work.effects] = replace(look, slips=slips)

    def loosen(self) -> None:
        """Let the line move within its slack beside what comes near while it is held.

        That is done under the best search for a law, and under others that are as good where it stays near.
        """
        near = [each for each in self.held.values() if each.slips]
        within = LOOSENED * min((each.error for each in near), default=math.inf)
        near = [each for each in near if each.error <= within]
        if not near:
            return
        self.let_loose([each.slips[0] for each in near])
        within = LOOSENED * self.nearest.error
        near = [each for each in near if self.loose[each.slips[0]].found.error <= within]
        self.let_loose([slip for each in near for slip in worth_loosening(each.slips)])

    def let_loose(self, slips: Sequence[SlipSearch]) -> None:
        """Let the line move under some slips, where that was not done."""
        held = [each for each in slips if each not in self.loose]
        self.loose.update(zip(held, self.map(let_loose, held), strict=True))


def begun_look(beside: BentLine, law: str) -> Look:
    """Return a look at the slips that a law makes beside an effect, with nothing known yet."""
    return Look(Work(beside.fit, (beside.effect.key, law), is_global=True), beside.line, [])


def with_best(look: Look, slips: Sequence[SlipSearch]) -> Look:
    """Return a look with the best of some slips in each form of its law, the best form first."""
    best: dict[Form, SlipSearch] = {}
    for each in sorted(slips, key=lambda each: each.found.error):
        best.setdefault(form_of(effect_of_key(look.law), each.slips.problem), each)
    return replace(look, slips=list(best.values()))


def slips_of(work: Work, line: Line) -> list[SlipSearch]:
    """Return what the last effect of a cause makes of the slips beside the others, on a line through breakaways."""
    return slips_by(work.fit, effect_of_key(work.effects[-1]), line=line)


def slips_again(nearest: SlipSearch, look: Look) -> list[SlipSearch]:
    """Return what the last effect of a cause makes of the slips beside the others, near what it made beside another."""
    return slips_beside(nearest, look.work.fit, effect_of_key(look.law), look.line)
