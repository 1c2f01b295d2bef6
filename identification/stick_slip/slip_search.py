"""Stick-slip: a search for what makes the stem jump, from the breakaways to the slips and on to the whole run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from threadpoolctl import threadpool_limits

from identification.problem import Problem
from identification.search import Found, descend, descend_to_end, error_by_all, errors, roam_through
from identification.starting.pressures import told_by_pressure
from identification.stick_slip.breakaway import Line, breakaways_of, line_through, roamed
from identification.stick_slip.rests import put_on_rests
from identification.wide import AT_NOISE, is_at_noise
from valvemodel.declarations import Effect, Form
from valvemodel.effects import effect_of_key

REACH = 4.0
"""Error beyond which a sample of stairs counts by the logarithm: a slip is many times as high. [noise]"""

HIDES_THE_LINE = frozenset({"static_friction", "stribeck", "presliding", "end_stop", "sensor_lag"})
"""Effects beside which a rest's reading, or its end, does not tell what force holds the stem."""

SHAPES_SLIPS = frozenset({"asymmetric_viscous_friction", "sensor_lag"})
"""Effects that leave force and reading of a rest as they are, but not the course of a slip."""

ADDED_FRICTION = ("friction_area",)
"""Unknowns of friction that comes on top of the Coulomb friction, and is overcome at breakaway by the same ratio."""

LEAST_STEPS = 8
"""Breakaways on the way from which a record has stairs."""

BEYOND = 0.5
"""How far the search goes beyond the outermost starts of a logarithmic number, in powers of e."""

DAMPING = 1.2
"""Viscous friction is searched for within so many powers of e."""

SIZE, GENERATIONS, GENERATIONS_IN_CLOSED_FORM = 6, 10, 30
"""Points of the search for the slips for each number, and generations; more where a slip has a closed form."""

NEARBY = 0.5
"""Share of the slips' box, either way, within which what was found is searched near."""

NEARBY_SIZE, NEARBY_GENERATIONS = 5, 12
"""Points of that search for each number, and generations."""

NEAR_AT_SLIPS = 2.0
"""Error at the slips, over the best form's, up to which a form of an effect is searched near."""


@dataclass(frozen=True)
class Stage:
    """One stage of the search of all numbers: share of the slips' box either way, points for each number, generations.

    Along the line through the breakaways it reaches a standard deviation either way.
    """

    share: float
    size: int
    generations: int


LOOSE, ANCHORED, FREE = Stage(0.5, 3, 25), Stage(0.1, 4, 30), Stage(0.04, 3, 15)

follow = partial(descend, evaluations=12, precision=1e-3, renewed=2)
"""How a search is followed down in between."""

CLOSE_AT_SLIPS = 1.25
"""Factor within which the error of another form must come at the slips for that form to be followed."""

LAWFUL = 2.0
"""Error of the re-anchored run from which another law acts, and the phase of a free run says little. [noise]"""


@dataclass(frozen=True)
class Slips:
    """The numbers that set how far a slip goes, while the line through the breakaways stays or moves within its slack.

    Attributes
    ----------
    problem : Problem
        With the effect's unknowns.
    ratio : int
        Unknown that is the breakaway force over Coulomb friction, of the effect.
    friction : int
        Unknown that is the Coulomb friction.
    others : list of int
        Unknowns of the effect beside the ratio, of one that shapes slips, and the viscous friction.
    line : Line
    """

    problem: Problem
    ratio: int
    friction: int
    others: list[int]
    line: Line

    def hold(self, centre: np.ndarray, ratio: float) -> None:
        """Set the scaled ratio at a point whose Coulomb friction is the breakaway force, which stays."""
        centre[self.ratio] = ratio
        self.ease(centre, self.problem.unknowns[self.ratio].value(ratio))

    def ease(self, points: np.ndarray, factor: np.ndarray) -> None:
        """Make the friction in motion less by a factor at scaled points, shape (..., unknowns), all that adds to it."""
        points[..., self.friction] -= np.log(factor)
        for number, unknown in enumerate(self.problem.unknowns):
            if unknown.name in ADDED_FRICTION:
                points[..., number] /= factor

    def points_of(self, centre: np.ndarray, moves: np.ndarray) -> np.ndarray:
        """Return scaled points beside a centre, shape (p, unknowns).

        Parameters
        ----------
        centre : array, shape (unknowns,)
        moves : array, shape (p, m)
            Change of the excess of the ratio over 1 in powers of e; of the others; along the slack of the line, if any.
        """
        points = np.repeat(centre[None, :], len(moves), axis=0)
        count = 1 + len(self.others)
        if moves.shape[1] > count:
            points[:, self.line.columns] += moves[:, count:] @ self.line.slack.T
        points[:, self.others] += moves[:, 1:count]
        unknown = self.problem.unknowns[self.ratio]
        ratio = unknown.value(centre[self.ratio])
        changed = np.minimum(1.0 + (ratio - 1.0) * np.exp(moves[:, 0]), unknown.high)
        points[:, self.ratio] = (changed - unknown.centre) / unknown.spread
        # The breakaway force stays.
        self.ease(points, changed / ratio)
        return np.clip(points, *self.problem.bounds)


def line_of_stairs(problem: Problem, point: np.ndarray) -> Line | None:
    """Return the line through the breakaways of a fit; None where too few are steps of stairs, or it has no time."""
    if problem.has_loop or not HIDES_THE_LINE.isdisjoint(problem.model.effects):
        return None
    breakaways = breakaways_of(problem)
    if len(breakaways.position) == 0 or breakaways.on_the_way(point) < LEAST_STEPS:
        return None
    return roamed(line_through(breakaways, point))


@dataclass(frozen=True, eq=False)
class SlipSearch:
    """A search for an effect that makes the stem jump, after each slip was judged by itself.

    Attributes
    ----------
    slips : Slips
    box : list of (low, high)
        Of the numbers of the slips.
    found : Found
    """

    slips: Slips
    box: list[tuple[float, float]]
    found: Found


def search_slips(effect: Effect, line: Line, forms: Sequence[tuple[Problem, np.ndarray]]) -> list[SlipSearch]:
    """Search for the numbers of an effect that makes the stem jump, each slip judged by itself; the best form first.

    The line through the breakaways stays: few numbers are left. Their error has side minima, and each form its own.

    Parameters
    ----------
    effect : Effect
    line : Line
    forms : sequence of (Problem, array)
        Problems with the effect, one for each form of it, and the scaled starts, shape (starts, unknowns).
    """
    begun = [search_form(effect, line, problem, starts) for problem, starts in forms]
    within = NEAR_AT_SLIPS * min(each.found.error for each in begun)
    found = [
        searched_near(each, each.slips, each.found.point) if each.found.error <= within else each for each in begun
    ]
    return sorted(found, key=lambda each: each.found.error)


def error_at_rests(problem: Problem, point: np.ndarray) -> float:
    """Return the error of a problem whose slips are judged by themselves."""
    return float(errors(on_rests(problem), point[None, :])[0])


def on_rests(problem: Problem) -> Problem:
    """Return the problem whose runs are put anew on each rest: each slip is judged by itself."""
    rested = [put_on_rests(experiment, REACH) for experiment in problem.experiments]
    return of_positions(replace(problem, experiments=rested, is_anchored=True))


def of_positions(problem: Problem) -> Problem:
    """Return the problem without measured pressures, on which the numbers that are searched do not act."""
    return replace(problem, experiments=[replace(each, pressure=None) for each in problem.experiments])


def search_form(effect: Effect, line: Line, problem: Problem, starts: np.ndarray) -> SlipSearch:
    """Search for the numbers of one form of an effect."""
    slips, centre = laid_on(effect, line, problem, starts[0])
    names, ratio, others = [unknown.name for unknown in problem.unknowns], slips.ratio, slips.others
    excesses = np.log(problem.unknowns[ratio].value(starts[:, ratio]) - 1.0)
    widths = [(excesses.min() - BEYOND, excesses.max() + BEYOND)]
    declared = {each.name: each for key in problem.model.effects for each in effect_of_key(key).fitted}
    for number in others[:-1]:
        unknown, parameter = problem.unknowns[number], declared[names[number]]
        values = [unknown.scaled(float(each)) for each in parameter.starts]
        low, high, neutral = min(values), max(values), unknown.scaled(parameter.neutral)
        more = BEYOND if unknown.is_logarithmic else 0.0
        widths.append((low, high + more) if more else (min(low, neutral), max(high, neutral)))
    widths.append((-DAMPING, DAMPING))
    centre[others] = [0.5 * (low + high) for low, high in widths[1:]]
    slips.hold(centre, problem.unknowns[ratio].scaled(1.0 + np.exp(0.5 * sum(widths[0]))))
    box = [(-0.5 * (high - low), 0.5 * (high - low)) for low, high in widths]
    return searched(slips, box, centre, box, SIZE, GENERATIONS if effect.is_chaotic else GENERATIONS_IN_CLOSED_FORM)


def laid_on(effect: Effect, line: Line, problem: Problem, start: np.ndarray) -> tuple[Slips, np.ndarray]:
    """Return the slips of an effect on a line, and a scaled point on it; what no line tells is as it was given.

    A fit without the effect would mislead.
    """
    names = [unknown.name for unknown in problem.unknowns]
    added = [names.index(each.name) for each in effect.free_at(problem.model.effects[effect.key])]
    ratio, friction = names.index(effect.breakaway), names.index("coulomb_friction")
    of_law = (number for number in added if number != ratio)
    others = [*of_law, *shaping_of(problem), names.index("viscous_friction")]
    centre = start.copy()
    centre[[number for number, name in enumerate(names) if name in problem.model.values]] = 0.0
    known = [*line.columns, *told_by_pressure(problem)]
    centre[known] = line.point[known]
    return Slips(problem, ratio, friction, others, line), centre


def shaping_of(problem: Problem) -> list[int]:
    """Return the unknowns of a problem that belong to effects which shape slips."""
    shaping = {
        each.name for key in SHAPES_SLIPS.intersection(problem.model.effects) for each in effect_of_key(key).fitted
    }
    return [number for number, unknown in enumerate(problem.unknowns) if unknown.name in shaping]


def searched(
    slips: Slips,
    box: list[tuple[float, float]],
    centre: np.ndarray,
    within: list[tuple[float, float]],
    size: int,
    generations: int,
    *,
    start: np.ndarray | None = None,
) -> SlipSearch:
    """Search for the numbers of slips about a centre within a box, each slip judged by itself."""
    rested = on_rests(slips.problem)
    found = roam_through(
        rested,
        partial(slips.points_of, centre),
        within,
        size=size,
        generations=generations,
        enough=rested.noise_error,
        start=start,
    )
    return SlipSearch(slips, box, found)


def search_beside_other(begun: SlipSearch, effect: Effect, line: Line, forms: Sequence[Problem]) -> list[SlipSearch]:
    """Search for the numbers of the law that was found, beside another effect: near by, on the line with that effect.

    What sets how far a slip goes hardly depends on what bends the line.

    Parameters
    ----------
    begun : SlipSearch
        Beside one effect.
    effect : Effect
        The law.
    line : Line
        With the other effect.
    forms : sequence of Problem
        With the other effect and each form of the law; that of `begun` counts, and no other that shapes slips.
    """
    known = begun.slips.problem
    values = dict(zip((unknown.name for unknown in known.unknowns), begun.found.point, strict=True))
    alike = [each for each in forms if form_of(effect, each) == form_of(effect, known)]
    found = []
    for problem in alike:
        start = np.array([values.get(unknown.name, 0.0) for unknown in problem.unknowns])
        slips, centre = laid_on(effect, line, problem, start)
        if len(slips.others) != len(begun.slips.others):
            continue
        centre[slips.others] = start[slips.others]
        slips.hold(centre, start[slips.ratio])
        found.append(searched_near(begun, slips, centre))
    return found


def form_of(effect: Effect, problem: Problem) -> Form:
    """Return the values of an effect that no fit moves, in a problem with it."""
    return effect.form_at(problem.model.effects[effect.key])


def searched_near(begun: SlipSearch, slips: Slips, centre: np.ndarray) -> SlipSearch:
    """Search for the numbers of slips near a centre, within a part of the box of a search before."""
    within = [(NEARBY * low, NEARBY * high) for low, high in begun.box]
    start = np.zeros(len(within))
    return searched(slips, begun.box, centre, within, NEARBY_SIZE, NEARBY_GENERATIONS, start=start)


def search_near(begun: Sequence[SlipSearch]) -> tuple[Problem, Found]:
    """Search all numbers near by, and follow them to the end; what does best by re-anchored and free run wins.

    Judged by each slip itself, and then on the re-anchored run, the forms of an effect are followed down one after the
    other until one comes to the noise. Where none does they are searched for globally as well.
    """
    descended: list[Near] = []
    for each in worth_loosening(begun):
        at_rests = min(each.found, follow(on_rests(each.slips.problem), each.found.point), key=lambda one: one.error)
        descended.append(on_the_run(each, at_rests, each.found.point))
        if descended[-1].is_at_noise:
            break
    near = min(descended, key=lambda each: each.error)
    if not near.is_at_noise:
        near = min(near, roamed_about(descended), key=lambda each: each.error)
    problem, points = near.slip.slips.problem, [near.point]
    anchored, free = (tempered(of_positions(problem), is_anchored=is_anchored) for is_anchored in (True, False))
    if near.error < LAWFUL * problem.noise_error:
        found = search_beside(near.slip, near.point, free, FREE)
        points += [found.point, follow(free, found.point).point]

    misfit = partial(error_by_all, (anchored, free))
    best = min(points, key=misfit)
    best = min([best, descend_to_end(problem, best).point], key=misfit)
    return problem, Found(best, float(errors(problem, best[None, :])[0]))


def worth_loosening(begun: Sequence[SlipSearch]) -> list[SlipSearch]:
    """Return the searches for an effect, the best first, that are followed or have their line moved: none far off."""
    return [each for each in begun if each.found.error <= CLOSE_AT_SLIPS * begun[0].found.error]


@threadpool_limits.wrap(limits=1)
def let_loose(slip: SlipSearch) -> SlipSearch:
    """Let the line move within its slack under the slips, each judged by itself, unless they are explained.

    Where the line leaves much open, the right effect looks worse than a wrong one while it is held.
    """
    rested = on_rests(slip.slips.problem)
    if is_at_noise(rested, slip.found):
        return slip
    found = follow(rested, search_beside(slip, slip.found.point, rested, LOOSE).point)
    return replace(slip, found=min(slip.found, found, key=lambda each: each.error))


def noise_at_rests(slip: SlipSearch) -> float:
    """Return the error that noise alone leaves where each slip is judged by itself."""
    return on_rests(slip.slips.problem).noise_error


@dataclass(frozen=True)
class Near:
    """A form of an effect near whose numbers the re-anchored run was followed down: the best point and its error."""

    slip: SlipSearch
    at_rests: Found
    point: np.ndarray
    error: float

    @property
    def is_at_noise(self) -> bool:
        """Whether it explains the re-anchored run."""
        return self.error <= AT_NOISE**2 * self.slip.slips.problem.noise_error


def tempered(problem: Problem, *, is_anchored: bool) -> Problem:
    """Return the problem whose runs count large errors by their logarithm."""
    reached = [replace(each, reach=REACH) for each in problem.experiments]
    return replace(problem, experiments=reached, is_anchored=is_anchored)


def on_the_run(slip: SlipSearch, at_rests: Found, start: np.ndarray) -> Near:
    """Return what is best on the re-anchored run: a start, what is best by each slip, or what lies below the latter."""
    anchored = tempered(of_positions(slip.slips.problem), is_anchored=True)
    points = np.array([start, at_rests.point, follow(anchored, at_rests.point).point])
    left = errors(anchored, points)
    best = int(np.argmin(left))
    return Near(slip, at_rests, points[best], float(left[best]))


def roamed_about(descended: Sequence[Near]) -> Near:
    """Search globally about forms of an effect: each slip by itself, until one comes to the noise; then on the run."""
    searched: list[SlipSearch] = []
    for each in descended:
        searched.append(let_loose(replace(each.slip, found=each.at_rests)))
        if is_at_noise(on_rests(each.slip.slips.problem), searched[-1].found):
            break
    slip = min(searched, key=lambda each: each.found.error)
    anchored = tempered(of_positions(slip.slips.problem), is_anchored=True)
    run = search_beside(slip, slip.found.point, anchored, ANCHORED)
    return on_the_run(slip, run, slip.found.point)


def search_beside(begun: SlipSearch, centre: np.ndarray, problem: Problem, stage: Stage) -> Found:
    """Search all numbers beside a scaled point."""
    along = [(-1.0, 1.0)] * len(begun.slips.line.columns)
    box = [(stage.share * low, stage.share * high) for low, high in begun.box] + along
    return roam_through(
        problem,
        partial(begun.slips.points_of, centre),
        box,
        size=stage.size,
        generations=stage.generations,
        enough=problem.noise_error,
        start=np.zeros(len(box)),
    )
