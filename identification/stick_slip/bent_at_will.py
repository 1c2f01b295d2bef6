"""Bent at will: a load that varies at will brings breakaways of stairs onto a line, its waves solved for together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from identification.fit import Fit
from identification.starting.joining import joined
from identification.starting.load_series import series_over, sizes_of
from identification.starting.ridge import FOLDS
from identification.starting.screening import beside_own
from identification.stick_slip.bent_lines import ANSWER, BentLine
from identification.stick_slip.breakaway import FAR, TO_THE_MIDDLE, Breakaways, Line, counted, slopes_of
from valvemodel.declarations import Effect

SOLVED, NONE = 3, 0.03
"""Times that the waves of a series are solved for, each time with what lies far off counting less; and the share of
breakaways that may be none, as where a stem but slows down on a step."""

FORETOLD = 0.3
"""Share of the error of unseen breakaways without waves that these may leave: of three loads at will in blind plants of
our own 0.06 to 0.16 was left, of a law that waves imitated 0.55."""


@threadpool_limits.wrap(limits=1)
def bent_at_will(fit: Fit, line: Line, effect: Effect) -> BentLine | None:
    """Bend the line of a fit by a load that varies at will; None where the breakaways lie off it, or are too few.

    At breakaway the load is what the line misses: all waves of a series over the record are solved for together, as
    large as unseen breakaways bear out, which they must foretell. They stay while slips are searched for.
    """
    load, waves = series_over(fit.problem.experiments, effect)
    if line.count < len(waves) + len(line.columns):
        return None
    problem, point = joined(fit.problem, line.point, effect, load | dict.fromkeys(waves, 1.0))
    columns = np.array([number for number, unknown in enumerate(problem.unknowns) if unknown.name in waves])
    point[columns] = 0.0
    breakaways = replace(line.breakaways, problem=problem)
    for _ in range(SOLVED):
        told = told_at_will(breakaways, point, line.columns, columns)
        own, sizes = solved_for(*told)
        point[line.columns] += np.clip(own, -ANSWER, ANSWER)
        point[columns] = sizes
    if left_unseen(*told) > FORETOLD:
        return None
    values = problem.values(point)
    problem, begun = joined(
        fit.problem, point[: len(line.point)], effect, load | {name: values[name] for name in waves}
    )
    breakaways = replace(breakaways, problem=problem)
    off = np.sort(np.abs(breakaways.enclosed(begun[None, :])[0]))
    error = float(counted(off[: line.count - round(NONE * line.count)]))
    bent = Line(begun, line.columns, breakaways.slack(begun, line.columns), error, breakaways)
    return BentLine(effect, problem, bent) if bent.is_explained else None


def told_at_will(
    breakaways: Breakaways, point: np.ndarray, own: np.ndarray, waves: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return what a line's own unknowns and waves do to breakaways, and what is wanted of them, far ones counting less.

    Parameters
    ----------
    breakaways : Breakaways
    point : array, shape (unknowns,)
        Scaled.
    own, waves : arrays of int
        Their numbers among the unknowns.

    Returns
    -------
    (array, array, array)
        Slopes by the line's own unknowns and by the waves, shape (breakaways, m) each, and what moves of the former and
        the sizes of the latter are to make up, shape (breakaways,).
    """
    off = breakaways.centred(point[None, :])[0]
    far = max(FAR, 2.0 * float(np.median(np.abs(off))))
    weights = np.where(breakaways.is_ramped(point), 1.0, TO_THE_MIDDLE) / np.sqrt(1.0 + (off / far) ** 2)
    slopes = weights[:, None] * slopes_of(breakaways.centred, point, np.concatenate([own, waves]))
    by_own, by_waves = slopes[:, : len(own)], slopes[:, len(own) :]
    return by_own, by_waves, by_waves @ point[waves] - weights * off


def solved_for(by_own: np.ndarray, by_waves: np.ndarray, wanted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the moves of a line's own unknowns and the sizes of waves that make up what is wanted of breakaways.

    Parameters
    ----------
    by_own, by_waves : arrays, shape (breakaways, unknowns), (breakaways, waves)
        Slopes.
    wanted : array, shape (breakaways,)
    """
    basis, triangle = np.linalg.qr(by_own)
    sizes = sizes_of(beside_own(by_waves, basis), beside_own(wanted, basis), np.arange(len(wanted)))
    return np.linalg.lstsq(triangle, basis.T @ (wanted - by_waves @ sizes), rcond=1e-6)[0], sizes


def left_unseen(by_own: np.ndarray, by_waves: np.ndarray, wanted: np.ndarray) -> float:
    """Return what waves leave of breakaways that they were not solved for, over what a line without them leaves there.

    Parameters are those of `solved_for`.
    """
    fold, left = np.arange(len(wanted)) % FOLDS, np.zeros((2, len(wanted)))
    for part in range(FOLDS):
        seen, unseen = fold != part, fold == part
        moves, sizes = solved_for(by_own[seen], by_waves[seen], wanted[seen])
        straight = np.linalg.lstsq(by_own[seen], wanted[seen], rcond=1e-6)[0]
        left[0, unseen] = (wanted - by_own @ moves - by_waves @ sizes)[unseen]
        left[1, unseen] = (wanted - by_own @ straight)[unseen]
    with_waves, without = counted(left)
    return float(with_waves / without)
