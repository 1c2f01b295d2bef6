"""Bent lines: effects that bring the breakaways of stairs onto a line, beside whatever makes the stem jump."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from identification.fit import Fit, finished
from identification.problem import Problem
from identification.search import Found, Start, errors
from identification.starting.hints import SHRUNK, resized
from identification.starting.joining import as_given, joined
from identification.starting.screening import starts_on
from identification.stick_slip.breakaway import LIES_ON, Line, breakaways_of, counted, line_through, roamed, slopes_of
from identification.stick_slip.slip_search import HIDES_THE_LINE, SHAPES_SLIPS
from valvemodel.declarations import Effect

DEAD_TIME, LONGEST, APART = "transport_delay", 1.0, 1.1
"""A number that moves breakaways by whole samples alone, so that slopes tell nothing of it: it is tried at a ladder of
them, up to so many seconds, each rung so many times the one before or a sample further."""

LEAST_BREAKAWAYS = 12
"""Breakaways that a line needs which is bent."""

MUCH_NEARER = 0.3
"""Share of the line's error below which an effect must bring it, unless the line explains the breakaways as it is."""

FOLLOWED, AFRESH, RUNGS, ALL_AFRESH = 2, 1, 6, 6
"""Most promising starts of an effect from which a line is laid, some lead where none follows: beside the line without
it, and beside the valve as it was given unless the pressure moves by it; rungs of a ladder; and starts beside the valve
as it was given where no effect bends the line from those."""

LATE = (1, 2, 4)
"""Samples that a reading that lags is tried to be late by."""

ANSWER = 3.0
"""How far the line's unknowns may answer a start by slopes, scaled."""


@dataclass(frozen=True)
class BentLine:
    """An effect and the line through the breakaways with it.

    Attributes
    ----------
    effect : Effect
    problem : Problem
        With the effect's unknowns.
    line : Line
    """

    effect: Effect
    problem: Problem
    line: Line

    @property
    def fit(self) -> Fit:
        """The base valve and the effect on the line; its Coulomb friction is the breakaway force."""
        return on_the_line(self.problem, self.line)


def on_the_line(problem: Problem, line: Line) -> Fit:
    """Return a problem's fit on a line through its breakaways."""
    return finished(problem, Found(line.point, float(errors(problem, line.point[None, :])[0])))


def straight_line(fit: Fit) -> Line | None:
    """Return the line through the breakaways of a base valve; None where they are few."""
    breakaways = breakaways_of(fit.problem)
    if fit.problem.has_loop or len(breakaways.position) < LEAST_BREAKAWAYS:
        return None
    return roamed(line_through(breakaways, fit.found.point))


@threadpool_limits.wrap(limits=1)
def bent_line(fit: Fit, line: Line, effect: Effect) -> BentLine | None:
    """Bend the line of a fit by an effect, from the starts that promise most; None where the breakaways lie off it.

    Parameters
    ----------
    fit : Fit
    line : Line
        Through its breakaways.
    effect : Effect
    """
    if effect.key in SHAPES_SLIPS:
        as_read = line if line.is_explained or effect.stage != "sensor" else read_late(fit, line)
        return beside_line(fit, as_read, effect) if as_read.is_explained else None
    if effect.key in HIDES_THE_LINE or effect.is_read_off:
        return None
    followed = RUNGS if has_dead_time(effect) else FOLLOWED
    values = list(starts_to_bend(fit, effect))
    starts = promised(fit, line, effect, values, line.point)[:followed]
    if not effect.acts_in_time:
        # Where an effect bends the line much, the one without it leads astray.
        starts += promised(fit, line, effect, values, as_given(fit, fit.found.point))[:AFRESH]
    small = resized(effect, starts[0][0].model.effects[effect.key], SHRUNK)
    begun = [*(each[:2] for each in starts), joined(fit.problem, line.point, effect, small)]
    return laid_from(begun, line, effect)


@threadpool_limits.wrap(limits=1)
def bent_afresh(fit: Fit, line: Line, effect: Effect) -> BentLine | None:
    """Bend the line of a fit by an effect beside the valve as it was given, as `bent_line` does beside the line.

    Where an effect bends the line much neither the line without it nor what slopes promise leads there.
    """
    if effect.key in HIDES_THE_LINE | SHAPES_SLIPS or effect.is_read_off:
        return None
    starts = promised(fit, line, effect, list(starts_to_bend(fit, effect)), as_given(fit, fit.found.point))
    return laid_from([each[:2] for each in starts[:ALL_AFRESH]], line, effect)


def laid_from(starts: Sequence[Start], line: Line, effect: Effect) -> BentLine | None:
    """Lay the line with an effect from one start after the other until it explains the breakaways; the best, if any."""
    laid: list[BentLine] = []
    for problem, point in starts:
        laid.append(BentLine(effect, problem, line_through(replace(line.breakaways, problem=problem), point)))
        if laid[-1].line.error < LIES_ON * line.count:
            break
    bent = min(laid, key=lambda each: each.line.error)
    bent = replace(bent, line=roamed(bent.line))
    return bent if bent.line.is_explained or bent.line.error < MUCH_NEARER * line.error else None


def read_late(fit: Fit, line: Line) -> Line:
    """Return the line of a reading that may show each breakaway some samples late, as few as explain them."""
    for late in LATE:
        line = roamed(line_through(replace(line.breakaways, late=late), fit.found.point))
        if line.is_explained:
            break
    return line


def beside_line(fit: Fit, line: Line, effect: Effect) -> BentLine:
    """Return an effect that acts on slips alone with the line as it is; its numbers are searched with the slips'."""
    problem, point = joined(fit.problem, line.point, effect, effect.typical)
    return BentLine(effect, problem, replace(line, point=point, breakaways=replace(line.breakaways, problem=problem)))


def promised(
    fit: Fit, line: Line, effect: Effect, starts: Sequence[dict[str, float]], origin: np.ndarray
) -> list[tuple[Problem, np.ndarray, float]]:
    """Return the starts of an effect with the line's best answer by slopes, and the squared error left, least first.

    Parameters
    ----------
    fit : Fit
    line : Line
        Through its breakaways.
    effect : Effect
    starts : sequence of dict
        Of its parameters. [SI]
    origin : array, shape (unknowns,)
        Scaled point of the base valve beside which the starts are.
    """
    known, found = len(origin), []
    slopes = slopes_of(line.breakaways.centred, origin, line.columns)
    for start in starts:
        problem, point = joined(fit.problem, origin, effect, start)
        there = replace(line.breakaways, problem=problem)
        off = there.centred(point[None, :])[0]
        answer, *_ = np.linalg.lstsq(slopes, -off, rcond=1e-6)
        point[:known][line.columns] += np.clip(answer, -ANSWER, ANSWER)
        point = np.clip(point, *problem.bounds)
        off = there.centred(point[None, :])[0]
        found.append((problem, point, float(counted(off))))
    return sorted(found, key=lambda each: each[2])


def starts_to_bend(fit: Fit, effect: Effect) -> Iterator[dict[str, float]]:
    """Yield the points at which a line is first bent by an effect."""
    starts = starts_on(fit, effect)
    if not has_dead_time(effect):
        yield from starts
        return
    forms = dict.fromkeys(tuple((start | {DEAD_TIME: 0.0}).items()) for start in starts)
    period = min(each.period for each in fit.problem.experiments)
    samples = 1
    while samples * period <= LONGEST:
        yield from (dict(form) | {DEAD_TIME: samples * period} for form in forms)
        samples = max(samples + 1, round(APART * samples))


def has_dead_time(effect: Effect) -> bool:
    """Return whether an effect has a number that moves breakaways by whole samples alone."""
    return any(each.name == DEAD_TIME for each in effect.parameters)
