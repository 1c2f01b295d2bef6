"""Between two rows: a logger that is slower than what drives the valve does not see where the current went on to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from identification.determined.uncertainty import rms_of
from identification.driving.timing import END_OF_PERIOD, SAME_PACE
from identification.experiment import Experiment
from identification.fit import Fit, fit_base, fitted_to_all, measured, simulate_model
from identification.noise import noise_level
from valvemodel.effects import takes_long
from valvemodel.periods import jumps, passing_otherwise, straight

PART, MOST_PARTS = 0.02, 8
"""Parts of a period are about so long, but for those of slow rows, which have so many. [s]"""

CALM, CLEAR = 0.2, 20.0
"""The stem has answered a jump of the current, in the row of the jump and the next, by so many times what it moved
before, and by so many times the noise."""

FEWEST_ANSWERS = 3
"""Answers from which their spread says something."""

SPREAD, WHOLE = 0.6, 0.93
"""Spread of the shares of the answers that stand in the row of the jump, from which it jumped at any instant before the
row: of the middle eight tenths, or of all where half of the answers are nearly whole in that row, so that none of a
held current would come later. Of 64 blind valves at four rates whose rows are read as they are driven no spread of
eight tenths was more than 0.12, read at the end of each period 9 of 256 were; of the same valves sampled five times
slower than they were driven 49 of 64."""

SLOWER, MOVING = 0.03, 0.2
"""Interval between rows [s], and share of the rows with another current than before, from which the current may have
moved on between them though no jump shows it."""

SLOW, MOST_ROWS = 0.2, 0.5
"""Sampling interval from which nobody knows that a current was held between the rows [s], if in such a share of them it
is another than before, as in a closed loop."""

HELD = 0.25
"""Share, of what a reading would differ by if a held current ramped, that the base may miss for it to be held. Readings
at the end of a period come half of one early for a current that ramps, for which damping would make up."""

COUNTS = 0.3
"""What a record does not have of its current, or has in it as noise, does to the stem, root mean square, from which it
counts. [noise]"""

USUAL = 0.9
"""Share of the errors, the smallest ones, by which two ways of the current are compared."""

NEARER, NEARER_IF_SEEN = 0.88, 1.1
"""Error with a current that moves on over that with a held one, on the same readings and each with the base fitted to
them, below which that shows it moves on, and where jumps show it. Of 336 records of 48 blind valves with held currents
7 were taken to have moved on so, all but one of valves slow to answer; of 144 records in which it did 125 were."""

SURE = 0.5
"""Readings that depend by more than this on what the current did between the rows are left out. [noise]"""

MOST_ROUNDS = 5
"""How often at most the valve is fitted to what does not hang on how the current moved on."""

SAME_LATE, SAME_LEFT_OUT = 0.04, 0.03
"""Differences, of a period and of the readings, up to which two fits tell the same of a current between the rows."""

LATE = (0.0, 0.05, 0.1, 0.15, 0.2, 0.25)
"""Shares of a period by which the current may come late: one that is held for shorter periods comes late by half of
those, and was seen to go on between the rows where they are half as long as ours or less."""

LATE_IF_SLOW = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5)
"""The same of rows so slow that it may have been held from one to the next."""

AS_NEAR = 1.02
"""Factor in error within which a current may come late by one or the other share, or may be held or move on."""

LEAST_SURE = 0.4
"""Share of the readings that are kept, those that depend least on it, however many depend more."""

UNSEEN = "the current went on between the rows, unseen"
FAR_APART = "how the current went on between rows so far apart is not recorded"
"""What is said of a current that is taken to have moved on, of quick and of slow rows."""


def moving_between_rows(experiments: Sequence[Experiment], base: Fit) -> list[Experiment]:
    """Return experiments whose current moves on between the rows, as far as they tell.

    A current is held from row to row where the records do not speak against it. Two things do: the stem answers jumps
    of the current before the row of the jump, now more, now less; or the base comes much nearer with a current that
    moves on through the rows. Readings that hang on where it was meanwhile are left out. Where slow rows show neither
    that it moved nor that it was held, it moves on if less of what is kept hangs on it so. What one record of a valve
    shows is true of others at its pace.

    Parameters
    ----------
    experiments : sequence of Experiment
    base : Fit
        Of the base to them or some of them, their currents held.
    """
    moved = [_moved(each, base) if may_have_moved(each) else (None, False) for each in experiments]
    paces = [each.period for each, is_shown in moved if each is not None and is_shown]

    def is_alike(each: Experiment) -> bool:
        return not each.is_loop and any(1.0 / SAME_PACE < each.period / pace < SAME_PACE for pace in paces)

    return [
        found or (_followed(each, base)[0] if is_alike(each) else each)
        for (found, _), each in zip(moved, experiments, strict=True)
    ]


def may_have_moved(experiment: Experiment) -> bool:
    """Return whether a current may have moved on between the rows: jumps of it show that, or the rows are slow."""
    if experiment.is_loop:
        return False
    is_slow = experiment.period >= SLOWER and share_moving(experiment) >= MOVING
    return is_slow or jumps_between(moving_on(experiment))


def share_left_out(moved: Experiment, held: Experiment) -> float:
    """Return the share of the readings that were left out as they hang on how a current moved on between the rows."""
    return float(1.0 - np.isfinite(moved.position).sum() / np.isfinite(held.position).sum()) if moved.parts > 1 else 0.0


def share_moving(experiment: Experiment) -> float:
    """Return the share of the rows in which the current is another than before."""
    return float(np.mean(np.diff(experiment.current) != 0.0))


def said_of_motion(notes: Sequence[str], experiments: Sequence[Experiment], held: Sequence[Experiment]) -> list[str]:
    """Return what is said of records, with which currents moved on between the rows, and what does not show then.

    Parameters
    ----------
    notes : sequence of str
        What was said before.
    experiments, held : sequences of Experiment
        As they are taken, and with their currents held.
    """
    said = [note for note in notes if note != END_OF_PERIOD or any(each.reads_at_end for each in experiments)]
    for moved, before in zip(experiments, held, strict=True):
        if moved.parts > 1:
            left_out = share_left_out(moved, before)
            period, latest = 1e3 * moved.period, lates_of(moved)[-1]
            how = FAR_APART if moved.period >= SLOW else UNSEEN
            said.append(
                f"{moved.name}: {how}; it is taken to have moved through them,"
                f" {moved.late * period:.3g} ms late, and {left_out:.0%} of the readings, which hang on how, are left"
                f" out. Lags below {latest * period:.3g} ms do not show: log at every change of the current"
            )
    return said


def followed_anew(experiments: Sequence[Experiment], held: Sequence[Experiment], near: Fit) -> list[Experiment]:
    """Return experiments whose currents move on as a fit tells that came nearer than the base.

    What hangs on how a current moved on, and how late it came, is known as well as the valve is. Those of which the fit
    tells much the same stay as they are, and those of whose readings more would hang on it than before, beyond noise.

    Parameters
    ----------
    experiments : sequence of Experiment
    held : sequence of Experiment
        The same, their currents held.
    near : Fit
        Of some cause to them or some of them.
    """
    return [
        _told_anew(experiment, before, near) if experiment.parts > 1 else experiment
        for experiment, before in zip(experiments, held, strict=True)
    ]


def _told_anew(experiment: Experiment, held: Experiment, near: Fit) -> Experiment:
    # Fits of what takes long to run are not made for every lateness.
    lates = (experiment.late,) if takes_long(near.model.effects) else ()
    found, _ = followed(moving_on(held), fitted_to_all(near, [experiment], starts_anew=True), lates)
    is_known, was_known = np.isfinite(found.position), np.isfinite(experiment.position)
    is_same = abs(found.late - experiment.late) < SAME_LATE and np.mean(is_known != was_known) < SAME_LEFT_OUT
    tells_less = found.sampling_error > max(experiment.sampling_error, experiment.noise)
    return experiment if is_same or tells_less else found


def _moved(held: Experiment, base: Fit) -> tuple[Experiment | None, bool]:
    """Return an experiment with a current that moves on, without what hangs on how, and whether the record shows that.

    None where it shows that the current is held, or nothing and holding it leaves less unknown.
    """
    moved, fitted = _followed(held, base)
    first = len(held.time) - len(moved.time)
    sure = replace(held, position=np.append(np.full(first, np.nan), moved.position))
    near, far = usual_error(moved, fitted), usual_error(sure, fitted_to_all(base, [sure], starts_anew=True))
    is_shown = near < (NEARER_IF_SEEN if jumps_between(moving_on(held)) else NEARER) * far
    unknown = unknown_if_held(held, base)
    kept = np.isfinite(moved.position).sum() / np.isfinite(held.position).sum()
    # What is left out has to be worth it, as fewer readings tell less.
    is_surer = unknown > COUNTS * held.noise and moved.sampling_error < np.sqrt(kept) * unknown
    return (moved if is_shown or (is_surer and near < AS_NEAR * far) else None), is_shown


def unknown_if_held(experiment: Experiment, base: Fit) -> float:
    """Return by how much the readings differ, root mean square, where a held current ramps from row to row. [m]

    It is 0 where nothing speaks for that: of quick rows, of a current that rests in most of them, and of a loop; and
    where the base, its current held, misses so much less than that that it was held.
    """
    if experiment.is_loop or experiment.period < SLOW or share_moving(experiment) < MOST_ROWS:
        return 0.0
    held = base.simulated_on(experiment).position[0]
    ramping = replace(experiment, parts=MOST_PARTS).stepping(straight(experiment.current, MOST_PARTS))
    ramped = simulate_model(base.model, ramping, start_position=held[0]).position[0]
    unknown = float(np.sqrt(np.mean((ramped[::MOST_PARTS] - held) ** 2)))
    is_held = not experiment.reads_at_end and rms_of_most(experiment.position - held) < HELD * unknown
    return 0.0 if is_held else unknown


def _followed(held: Experiment, base: Fit) -> tuple[Experiment, Fit]:
    """Return an experiment whose current moves on as the base tells, which is fitted anew, and that fit."""
    whole = moving_on(held)
    return followed(whole, fit_base(base.problem.model, [whole]))


def followed(whole: Experiment, near: Fit, lates: Sequence[float] = ()) -> tuple[Experiment, Fit]:
    """Return an experiment whose current comes as late as fits best, without what hangs on how, and the fit to it.

    Damping makes up for much of being late, until the valve has so little left that it overshoots, and all readings
    hang on that: of what comes about as near the lateness is taken that leaves out least.
    """
    found = []
    for late in lates or lates_of(whole):
        kept, near = settled(replace(whole, late=late), near)
        found.append((kept, near, rms_of(near, [kept], measured([kept]))))
    limit = AS_NEAR * min(missed for *_, missed in found)
    kept, near, _ = max(
        (each for each in found if each[-1] <= limit), key=lambda each: np.isfinite(each[0].position).sum()
    )
    doubts, _ = doubts_of(kept, near)
    return replace(kept, sampling_error=rms_of_most(doubts[np.isfinite(kept.position)])), near


def lates_of(experiment: Experiment) -> tuple[float, ...]:
    """Return the shares of a period by which the current of an experiment may come late."""
    return LATE_IF_SLOW if experiment.period >= SLOW else LATE


def settled(whole: Experiment, near: Fit) -> tuple[Experiment, Fit]:
    """Return an experiment without the readings that hang on how its current moves on, and a fit to the rest.

    Which do is known as well as the valve is, which is fitted to those that do not: both are found in turn.
    """
    kept = whole
    for _ in range(MOST_ROUNDS):
        before, kept = kept, without_unsure(whole, near)
        if np.array_equal(np.isfinite(kept.position), np.isfinite(before.position)):
            break
        near = fitted_to_all(near, [kept])
    return kept, near


def moving_on(experiment: Experiment) -> Experiment:
    """Return an experiment whose rows are instants and whose current moves on from row to row."""
    parts = int(np.clip(round(experiment.period / PART), 2, MOST_PARTS))
    if not experiment.reads_at_end:
        return replace(experiment, parts=parts)
    pressure = None if experiment.pressure is None else experiment.pressure[1:]
    return replace(
        experiment,
        time=experiment.time[:-1],
        current=experiment.current[:-1],
        position=experiment.position[1:],
        pressure=pressure,
        block=experiment.block[:-1],
        start=experiment.start + experiment.period,
        reads_at_end=False,
        parts=parts,
    )


def jumps_between(experiment: Experiment) -> bool:
    """Return whether the stem answers jumps of the current now more, now less in the row of the jump itself.

    Where a current is held from row to row, that row holds the same share of each answer: none of it, where it was
    read before its current acted.
    """
    answers = answers_in_row(experiment)
    if len(answers) < FEWEST_ANSWERS:
        return False
    lowest, low, middle, high, highest = np.quantile(answers, [0.0, 0.1, 0.5, 0.9, 1.0])
    return bool(high - low > SPREAD or (middle > WHOLE and highest - lowest > SPREAD))


def answers_in_row(experiment: Experiment) -> np.ndarray:
    """Return the share of each clear answer to a jump of the current, over two rows, that stands in its first row."""
    position, noise = experiment.position, noise_level(experiment.position)
    rows = np.flatnonzero(jumps(experiment.current)) + 1
    rows = rows[(rows >= 2) & (rows < len(position) - 1)]
    side = np.sign(experiment.current[rows] - experiment.current[rows - 1])
    earlier = position[rows - 1] - position[rows - 2]
    first, both = position[rows] - position[rows - 1], position[rows + 1] - position[rows - 1]
    is_clear = (side * both > CLEAR * noise) & (np.abs(earlier) < CALM * np.abs(both))
    return np.asarray(first[is_clear] / both[is_clear])


def without_unsure(experiment: Experiment, near: Fit) -> Experiment:
    """Return an experiment whose current moves on without the readings that hang on how it does."""
    return without_doubtful(experiment, doubts_of(experiment, near), SURE)


def without_doubtful(experiment: Experiment, doubts: tuple[np.ndarray, np.ndarray], sure: float) -> Experiment:
    """Return an experiment without the readings that are in doubt.

    Parameters
    ----------
    experiment : Experiment
    doubts : arrays, shape (n,) [m], [Pa]
        Of position and pressure.
    sure : float [noise]
        What is no doubt yet, unless too few readings would be left.
    """
    position, of_pressure = doubts
    doubt = position / experiment.noise
    if experiment.pressure is not None:
        doubt = np.maximum(doubt, of_pressure / experiment.pressure_noise)
    limit = max(sure, float(np.quantile(doubt[np.isfinite(experiment.position)], LEAST_SURE)))
    is_unsure = doubt > limit
    pressure = None if experiment.pressure is None else np.where(is_unsure, np.nan, experiment.pressure)
    return replace(experiment, position=np.where(is_unsure, np.nan, experiment.position), pressure=pressure)


def doubts_of(experiment: Experiment, near: Fit) -> tuple[np.ndarray, np.ndarray]:
    """Return by how much position and pressure hang on how the current moved between rows, shape (n,). [m], [Pa]"""
    through = near.simulated_on(experiment)
    otherwise = [
        simulate_model(near.model, experiment.stepping(current), start_position=through.smooth[0][0])
        for current in passing_otherwise(experiment.current, experiment.parts, experiment.late)
    ]
    rows = slice(None, None, experiment.parts)

    def apart(name: str) -> np.ndarray:
        taken = getattr(through, name)[0]
        return np.max([np.abs(getattr(run, name)[0][rows] - taken) for run in otherwise], axis=0)

    return apart("smooth"), apart("pressure")


def usual_error(experiment: Experiment, fit: Fit) -> float:
    """Return what a fit misses, root mean square, but for the largest: a few rows may show an effect very much. [m]"""
    return rms_of_most(experiment.position - fit.simulated_on(experiment).position[0])


def rms_of_most(errors: np.ndarray) -> float:
    """Return the root mean square of errors, NaN where there is none, but for the largest tenth."""
    known = np.sort(np.abs(errors[np.isfinite(errors)]))
    return float(np.sqrt(np.mean(known[: round(USUAL * len(known))] ** 2)))
