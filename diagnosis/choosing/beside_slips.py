"""Beside slips: pairs of what makes the stem jump and what bends the line through its breakaways, bend first."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

from diagnosis.choosing.looks import NEARER_AT_SLIPS, Look, look_alone, look_beside
from diagnosis.trying.candidates import Candidate, Work, sharpen_all, try_all
from diagnosis.trying.explaining import any_explains, explains, in_stairs, misfit, stops_seen
from diagnosis.trying.standing import (
    alone_of,
    best_of,
    blunt,
    is_dear,
    is_laid_on_top,
    is_quick,
    is_read_off,
    with_better,
)
from diagnosis.trying.workshop import Workshop
from identification.fit import Fit
from identification.starting.hints import begins_at_periods, coarse_step
from identification.stick_slip.bent_at_will import bent_at_will
from identification.stick_slip.bent_lines import BentLine, bent_afresh, bent_line, on_the_line, straight_line
from identification.stick_slip.breakaway import LIES_ON, Line
from identification.stick_slip.slip_search import LEAST_STEPS, SHAPES_SLIPS, SlipSearch, line_of_stairs
from valvemodel.declarations import Effect
from valvemodel.effects import effect_of_key, jumps_in_closed_form

MAKERS, BENDS = 2, 4
"""Laws of stick-slip, the best alone, and effects that bend the line, the best ones, whose slips are looked at, beside
those that bring the breakaways onto it."""

BESIDE = 6
"""Effects on top of which a law in closed form is tried, those that come nearest alone. Of 21 blind pairs of our own
static friction came in fourteen as near on top of the other effect as the other way about, or nearer, in six by a
factor of four and more; of fifteen of them the other one was among the first six alone in twelve."""

FOLLOWED = 2
"""Of those as many are searched for once more, longer: where the pressure moves that would take half a minute."""

SOME, FAR_OFF = 0.9, 5.0
"""Share of the base's squared error below which such a law must come alone where the record shows no rests on the way,
and over that of the best alone: what only looks like breakaways lies on no line either. Of twenty blind pairs of our
own in which a stem jumps the law alone left up to 3.4 times what the best did, of two without 13 and 20 times."""

WHAT = "two effects together"
"""What is said meanwhile."""

CLOSE_AT_SLIPS, MOST = 1.5, 3
"""Error at the slips, over the best one's, up to which an effect and a law are searched for whole; how many effects."""

AS_WELL = 4.0
"""Error of the line, over the best one's, up to which an effect bends it as well."""


BENT = 0.1
"""Error of the line, over that of the straight one, below which an effect bends it already: others are not laid afresh.
In two blind plants of our own those took 10 s each, and the line of the effect that bent it came to a tenth."""


Bend = Callable[[Fit, Line, Effect], BentLine | None]
"""How a line is bent by an effect."""


def beside_slips(alone: Sequence[Candidate], workshop: Workshop) -> list[Candidate]:
    """Try what makes the stem jump on top of another effect, where a record may show that.

    In stairs the line through the breakaways tells of which; elsewhere it is what comes nearest alone, and the line
    only where none of that explains the record.

    Parameters
    ----------
    alone : sequence of Candidate
        The base, then the effects one by one.
    workshop : Workshop

    Returns
    -------
    list of Candidate
        Causes of two effects, or a law alone where nothing bends the line; empty where nothing speaks for stick-slip, a
        coarse reading comes nearer or one effect explains the gap.
    """
    if not speaks_for_slips(alone):
        return []
    if in_stairs(alone[0].fit):
        return by_the_line(alone, workshop) or on_the_nearest(alone, workshop)
    on_top = on_the_nearest(alone, workshop)
    if any_explains([alone[0], *on_top]):
        return on_top
    return [*on_top, *by_the_line(alone, workshop)]


def by_the_line(alone: Sequence[Candidate], workshop: Workshop) -> list[Candidate]:
    """Try what makes the stem jump on top of an effect that brings its breakaways onto a line.

    The other way about a search goes astray: a second effect moves each breakaway, and what then is a slip's way
    depends on it. The line needs no run of the stem. Parameters are those of `beside_slips`; nothing is tried where no
    line is bent and a law is not the best alone, or no two come nearer at the slips than a law alone.
    """
    base, single, laws, has_stops = alone[0], alone_of(alone), laws_alone(alone), stops_seen(alone[0].fit)
    line = straight_line(base.fit)
    # Where all breakaways lie on the line as it is, only slips tell; a law that gains little alone has none there.
    is_best, gains = is_best_alone(laws[0], alone), misfit(laws[0]) <= SOME * misfit(base)
    if line is None or (line.is_explained and not is_best and not gains):
        return []
    workshop.progress("what sets how far the slips go", 0.0)
    keys = [law.effects[0] for law in laws[:MAKERS]]
    alone_at_slips = look_alone(on_the_line(base.fit.problem, line), line, to_look_at(laws[:MAKERS], line), workshop)
    if any(each.explains for each in alone_at_slips):
        return []
    effects = [effect_of_key(key) for key in single]
    if line.error <= LIES_ON * line.count:
        # What is seen elsewhere would bend it, or shapes the slips.
        effects = list(filter(is_unseen_elsewhere, effects))
    bent = bent_lines(base.fit, line, effects, workshop, is_thorough=gains)
    if not bent:
        # Nothing bends the line: what was left for on top of that is all there is.
        was_left = has_stops and not line.is_in_reach
        left = [law for law in laws if was_left and effect_of_key(law.effects[0]).is_chaotic]
        anew = [
            Work(base.fit, law.effects, is_global=True, kin=laws[0].fit if law is not laws[0] else None) for law in left
        ]
        return try_all(anew, workshop, WHAT)
    worth = [
        each
        for number, each in enumerate(bent)
        if number < BENDS or (each.line.is_explained and (not line.is_explained or is_unseen_elsewhere(each.effect)))
    ]
    workshop.progress("how far the slips go beside what bends the line", 0.0)
    looked = look_beside(worth, keys, workshop, alone_at_slips)
    if not any(each.slips for each in looked):
        known = [replace(each.work, slips=[]) for each in looked[:MAKERS] if is_best or not line.is_explained]
        return try_all(known, workshop, WHAT)
    brought = bent[0].effect.key if bent[0].line.is_explained and not line.is_explained else None
    return try_all(nearest_at_slips(looked, alone_at_slips[0].error, brought), workshop, WHAT)


def speaks_for_slips(alone: Sequence[Candidate]) -> bool:
    """Return whether a record may show stick-slip beside another effect: it stops, or a law alone comes near.

    It need not where one effect explains the gap, or lets the reading rest while the stem moves on.
    """
    base, laws = alone[0], laws_alone(alone)
    if not laws or any_explains(alone):
        return False
    far = min(SOME * misfit(base), FAR_OFF * min(map(misfit, alone[1:])))
    least = min(misfit(laws[0]), SOME * misfit(base))
    is_of_reading = any(stops_by_reading(each) and misfit(each) < least for each in alone[1:])
    return (misfit(laws[0]) <= far or stops_seen(base.fit)) and not is_of_reading


def laws_alone(alone: Sequence[Candidate]) -> list[Candidate]:
    """Return the laws of stick-slip alone, the best first."""
    return [each for each in best_of(alone, 1) if effect_of_key(each.effects[0]).breakaway]


def beside_coarse_steps(alone: Sequence[Candidate], workshop: Workshop) -> list[Candidate]:
    """Try what makes the stem jump on top of a coarse reading in which slips of several steps show; none where none do.

    Parameters are those of `beside_slips`.
    """
    readings = [each.fit for each in alone if is_read_off(each) and any(map(coarse_step, each.fit.problem.experiments))]
    in_stairs = [fit for fit in readings if line_of_stairs(fit.problem, fit.found.point) is not None]
    laws = [key for key in alone_of(alone) if effect_of_key(key).breakaway]
    work = [Work(fit, (*fit.model.effects, law), is_global=True) for fit in in_stairs for law in laws]
    tried = try_all(work, workshop, WHAT)
    return with_better(tried, sharpen_all(blunt(best_of(tried, 2), alone[0]), workshop))


def to_look_at(laws: Sequence[Candidate], line: Line) -> dict[str, list[SlipSearch] | None]:
    """Return the laws that are looked at by themselves, with what is known of their slips.

    Where the breakaways lie far off the line that is but a yardstick, and one in closed form does for it.
    """
    seen = {law.effects[0]: law.slips for law in laws}
    kept = {key: slips for key, slips in seen.items() if line.is_in_reach or not effect_of_key(key).is_chaotic}
    return kept or seen


def is_unseen_elsewhere(effect: Effect) -> bool:
    """Return whether slips may be all that shows an effect: it hides in the base valve, or shapes the slips."""
    return effect.hides_in_base or effect.key in SHAPES_SLIPS


def bends_to_stairs(base: Fit, effects: Sequence[Effect], workshop: Workshop) -> bool:
    """Return whether one of some effects brings the steps of stairs onto a line on which they do not lie without."""
    line = straight_line(base)
    if line is None or line.is_explained or line.breakaways.on_the_way(line.point) < LEAST_STEPS:
        return False
    # The lines that cost least come first: one is enough.
    laid = lines_with(bent_line, base, line, sorted(effects, key=lambda each: each.acts_in_time), workshop)
    return any(each.line.is_explained for each in laid)


def stops_by_reading(cause: Candidate) -> bool:
    """Return whether a cause of one effect lets a reading rest again and again while the stem moves on."""
    effect = effect_of_key(cause.effects[0])
    return effect.stops_again and not effect.breakaway


def nearest_at_slips(looked: Sequence[Look], alone: float, brought: str | None = None) -> list[Work]:
    """Return the work whose law comes nearest at the slips, each judged by itself, the best first.

    Several effects bend the line as well as each other, and the law that is better alone may be the wrong one: a quick
    look at the slips tells. Both laws are kept beside the nearest effect only. What comes hardly nearer there than a
    law `alone` is not searched for whole, unless the effect is the one that `brought` the breakaways onto the line.
    """
    near = [each for each in looked if each.error < NEARER_AT_SLIPS * alone or (each.slips and each.bend == brought)]
    begun = sorted(near, key=lambda each: each.error)
    close = [each for each in begun if each.error <= CLOSE_AT_SLIPS * begun[0].error]
    best: dict[str, Look] = {}
    for each in close:
        best.setdefault(each.bend, each)
    kept = {each.work.effects for each in list(best.values())[:MOST]}
    chosen = [each for each in close if each.work.effects in kept or each.bend == close[0].bend]
    return [replace(each.work, slips=each.slips) for each in chosen]


def bent_lines(
    base: Fit, line: Line, effects: Sequence[Effect], workshop: Workshop, *, is_thorough: bool = False
) -> list[BentLine]:
    """Return the effects with which the breakaways lie on a line as well as with the best of them, that one first.

    A search that `is_thorough` lays lines afresh from the valve as it was given where they lie on none: with those
    effects that bend it already, or else with all. Where no effect of few numbers explains them a load that varies at
    will may.
    """
    laid = list(lines_with(bent_line, base, line, effects, workshop))
    if is_thorough and not are_explained(line, laid):
        worth = [each.effect for each in laid if each.line.error < BENT * line.error] or effects
        laid += lines_with(bent_afresh, base, line, worth, workshop)
    if not are_explained(line, laid):
        at_will = [each for each in effects if begins_at_periods(each)]
        laid += lines_with(bent_at_will, base, line, at_will, workshop)
    best: dict[str, BentLine] = {}
    for each in sorted(laid, key=lambda each: each.line.error):
        best.setdefault(each.effect.key, each)
    bent = list(best.values())
    return [each for each in bent if each.line.is_explained or each.line.error <= AS_WELL * bent[0].line.error]


def lines_with(bend: Bend, base: Fit, line: Line, effects: Sequence[Effect], workshop: Workshop) -> Iterator[BentLine]:
    """Return the lines that some of the effects bend, as they are done; what nobody waits for is not begun."""
    workshop.progress("what bends the line through the breakaways", 0.0)
    return filter(None, workshop.map(partial(bend, base, line), effects))


def are_explained(line: Line, bent: Sequence[BentLine]) -> bool:
    """Return whether the breakaways lie on a line as it is, or as one of some effects bends it."""
    return line.is_explained or any(each.line.is_explained for each in bent)


def on_the_nearest(alone: Sequence[Candidate], workshop: Workshop) -> list[Candidate]:
    """Try a law of stick-slip in closed form on top of the effects that come nearest alone, up to what explains all.

    The other way about the law takes in what it can of both, and no slope leads from there to the other effect. Where
    none explains the record the search takes its time on top of those with which it came nearest, and nearer than
    alone.
    """
    closed = {each.effects[0]: each for each in laws_alone(alone) if jumps_in_closed_form(each.effects)}
    smooth = [each for each in best_of(alone, 1) if is_quick(each.effects[0]) and not is_laid_on_top(each)]
    nearest = sorted(smooth, key=lambda each: each.fit.found.error)[:BESIDE]
    ends = partial(explains, base=alone[0])
    work = [Work(each.fit, (*each.effects, law), is_global=True) for law in closed for each in nearest]
    tried = try_all(work, workshop, WHAT, ends)
    if any(map(ends, tried)):
        return tried
    order = sorted(zip(tried, work, strict=True), key=lambda pair: pair[0].fit.found.error)[:FOLLOWED]
    promising = [each for found, each in order if found.fit.found.error < closed[each.effects[1]].fit.found.error]
    again = [replace(each, is_thorough=True) for each in promising if not is_dear(each.effects[0])]
    return with_better(tried, try_all(again, workshop, WHAT, ends))


def is_best_alone(maker: Candidate, alone: Sequence[Candidate]) -> bool:
    """Return whether no effect alone comes nearer than a law."""
    return maker is best_of(alone, 1)[0]
