"""Alone: every effect by itself, and what makes the stem jump beside what lags or bends the line of its breakaways."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

from diagnosis.choosing.beside_slips import WHAT, beside_coarse_steps, beside_slips, speaks_for_slips
from diagnosis.choosing.ending import do_explain, goes_in_jumps
from diagnosis.choosing.jointly import try_jointly
from diagnosis.choosing.lags_beside_jumps import lags_beside_jumps
from diagnosis.choosing.proposals import FAR_BEHIND, NO_GAIN, SHORTLIST, extensions, law_in_closed_form, left_alone
from diagnosis.choosing.rivals import short_of_noise
from diagnosis.trying.candidates import Candidate, Work, glances, sharpen_all, try_all, try_in_turn
from diagnosis.trying.explaining import (
    AT_NOISE,
    allowed,
    any_explains,
    explains,
    in_stairs,
    leaves_nothing_to_tell,
    misfit,
    nearly_explains,
    stops_seen,
)
from diagnosis.trying.standing import (
    best_of,
    blunt,
    has_read_off,
    is_dear,
    is_laid_on_top,
    is_near_noise,
    is_quick,
    is_read_off,
    loses_phase,
    values_alone,
    with_better,
)
from diagnosis.trying.workshop import Workshop
from identification.experiment import are_loops
from identification.extending.glance import Glance
from identification.fit import Fit
from identification.holdout import Holdout
from identification.starting.hints import begins_at_periods
from identification.starting.screening import LITTLE_LEFT
from identification.stick_slip.bent_lines import straight_line
from valvemodel.declarations import Effect
from valvemodel.effects import differ_by_aliases, effect_of_key, jumps
from valvemodel.errors import InputError
from valvemodel.stages import EFFECTS

LEAST_SHARE, PROMISE_AT_NOISE = 0.25, 0.005
"""Share of the base's error that an effect must show at a glance to be followed alone where another comes to the
noise, and promise by slopes where the base leaves little. Of 160 blind single effects of our own none that promised
less by slopes had another settle the record that was not alike, but for some that leave next to nothing."""

LEAST_SHARE_DEAR = 0.05
"""The same of an effect whose runs are dear, whatever else comes near: of 67 in blind pairs of our own none took in
less than 0.066."""

OUT_OF_PHASE = 100.0
"""Squared error beyond which no pair is out of phase alone. [noise^2]"""

NEAR_ENOUGH = 4.0
"""Squared error, over what may be left, up to which what makes the stem jump alone is searched about: of nine in blind
plants of our own that left more none came nearer than five times."""

READ_OFF_ON = 2
"""Best causes of one effect on top of which a coarse reading may explain a record."""

MOST_NEARLY, NEAR_IF_DEAR = 4, 1.5
"""Best causes of one effect that are searched for from every start where they nearly explain the record; squared error
up to which one is whose runs are dear: from the 48 of asymmetric filling that takes 11 s."""


def try_first(
    base: Candidate, workshop: Workshop, library: Sequence[Effect], known: Sequence[Candidate] = ()
) -> tuple[list[Candidate], list[Candidate] | None]:
    """Try every effect alone, and what makes the stem jump beside what lags or bends the line through its breakaways.

    What a law of more numbers explains is tried with the one in closed form, and rivals that end short of the noise are
    searched about. Where one of two effects leaves no trace beside the other, that alone had ended beside the least
    error. Where the stops are of a coarse reading, or two that are tried jointly explain the record, nothing speaks for
    jumps. Beside causes that are known to explain the record, besides the law in closed form, only what a local search
    finds is tried.

    Returns
    -------
    tried : list of Candidate
    together : list of Candidate or None
        Pairs that were tried jointly on the way; None where that was not called for yet.
    """
    local, *searched = rounds(library)
    alone = [*try_by_promise(base, local, workshop), *known]
    has_stops = stops_seen(base.fit)
    are_of_reading = has_stops and is_explained_with_reading(alone, workshop)
    alone = try_widely(alone, searched, workshop, has_stops=has_stops and not are_of_reading)
    jumping = [each for each in blunt(best_of(alone, 1), base) if misfit(each) < NEAR_ENOUGH * allowed(base)]
    alone = with_better(alone, sharpen_all(jumping, workshop))
    alone = with_better(alone, try_all(nearly(alone), workshop, "effects one by one, from every start"))
    tried, together = alone, None
    if not are_of_reading:
        tried = [*alone, *lags_beside_jumps(alone, workshop)]
        if not any_explains(tried) and speaks_softly_for_slips(alone):
            together = try_jointly(alone, workshop)
        # What makes the stem jump leaves far more than that to two smooth ones: of eight blind plants of our own seven
        # times the noise at least, squared.
        if not do_explain(together or (), alone):
            for beside in (beside_coarse_steps, beside_slips):
                if not any_explains(tried):
                    tried += beside(alone, workshop)
    tried = with_better(tried, try_all(law_in_closed_form(tried), workshop, WHAT))
    tried = with_better(tried, sharpen_all(short_of_noise(tried), workshop))
    return with_better(tried, try_all(left_alone(tried), workshop, "effects one by one")), together


def speaks_softly_for_slips(alone: Sequence[Candidate]) -> bool:
    """Return whether a record may show stick-slip, but not in stairs nor by what comes nearest: two may be smooth."""
    return not in_stairs(alone[0].fit) and speaks_for_slips(alone) and not goes_in_jumps(best_of(alone, 1)[0])


def in_phase(tried: Sequence[Candidate], workshop: Workshop) -> list[Candidate]:
    """Return what was tried, with the best pairs that lose the phase of their slips searched about, the base first.

    The error of a free run that lost it says little: from the re-anchored one it gets it back.
    """
    lost = [each for each in blunt(best_of(tried, 2), tried[0]) if loses_phase(each) and misfit(each) < OUT_OF_PHASE]
    return with_better(tried, sharpen_all(lost, workshop))


def is_explained_with_reading(tried: Sequence[Candidate], workshop: Workshop) -> bool:
    """Return whether one of the nearest causes explains the record with what is read off it on top: a coarse reading.

    A reading that comes nearest itself has all others tried beside it.
    """
    base, best = tried[0], best_of(tried, 1)[:READ_OFF_ON]
    if any(is_read_off(each) for each in best) or any(explains(each, base) for each in best):
        return False
    read = {key: values for key, values in values_alone(tried).items() if effect_of_key(key).is_read_off}
    work = [
        Work(each.fit, (*each.effects, key), is_global=False, known=values)
        for each in best
        for key, values in read.items()
    ]
    ends = partial(explains, base=base)
    return any(map(ends, try_all(work, workshop, "effects one by one", ends)))


def try_widely(
    tried: Sequence[Candidate], searched: Sequence[Sequence[str]], workshop: Workshop, *, has_stops: bool
) -> list[Candidate]:
    """Try the effects that need a global search alone, where no other explains the gap; return all that was tried.

    A stem's stick-slip that one law explains may be another's: aliases of that are tried all the same.

    One in which a slip's way hangs by a hair comes after its kindred, and starts from what that found: where the stem
    stops on its way, or jumps by what comes nearest. Where a coarse reading comes nearest, all that was tried is tried
    beside it first, which costs little.
    """
    base, tried = tried[0], list(tried)
    for round_of in searched:
        tried += beside_reading(tried, workshop)
        is_called = has_stops or any(jumps(each.effects) for each in best_of(tried, 1)[:1])
        keys = [key for key in round_of if is_called or not effect_of_key(key).is_chaotic]
        ends = [each for each in tried if explains(each, base)]
        if ends:
            best = min(ends, key=misfit)
            keys = [key for key in keys if effect_of_key(key).is_chaotic and differ_by_aliases((key,), best.effects)]
        work = [work_on(base.fit, effect_of_key(key), tried, has_stops=has_stops) for key in keys]
        tried += try_all(work, workshop, "effects one by one")
    return tried


def nearly(tried: Sequence[Candidate]) -> list[Work]:
    """Return the best causes of one effect that nearly explain the record, as work from every start.

    There are none where the base itself leaves nothing to tell.
    """
    base, best = tried[0], best_of(tried, 1)[:MOST_NEARLY]
    if not best or not nearly_explains(best[0], base) or leaves_nothing_to_tell(base, tried):
        return []
    far = FAR_BEHIND * misfit(best[0])
    near = [each for each in best if explains(each, base, generous=True) or misfit(each) < far]
    worth = [each for each in near if misfit(each) < NEAR_IF_DEAR or not is_dear(each.effects[0])]
    keys = [each.effects[0] for each in worth if not is_laid_on_top(each)]
    return [Work(base.fit, (key,), is_global=False, follows_all=True) for key in keys if is_quick(key)]


def try_by_promise(base: Candidate, keys: Sequence[str], workshop: Workshop) -> list[Candidate]:
    """Try effects that a local search finds alone, the most promising ones first; return the base and those.

    Slopes promise little of what is not small, such as a lag: a glance at each shows more. What shows little is
    followed all the same, unless what was tried before leaves nothing to explain.
    """
    # Waves promise something of whatever is left: they come last, for themselves.
    plain = [key for key in keys if not begins_at_periods(effect_of_key(key))]
    workshop.progress("effects one by one", 0.0)
    seen = glances(base.fit, plain, workshop)
    nearest = sorted(plain, key=lambda key: (seen[key].fit.found.error, -seen[key].share))
    order = [*nearest, *(key for key in keys if key not in seen)]
    work = [Work(base.fit, (key,), is_global=False) for key in order]
    followed = partial(called_for, base, seen)
    return [base, *try_in_turn(work, followed, workshop, "effects one by one")]


def called_for(base: Candidate, seen: Mapping[str, Glance], work: Work, tried: Sequence[Candidate]) -> Work:
    """Return work on a single effect that is followed as far as what was tried before it calls for.

    What comes to the noise at a glance is followed from there alone, but where another form may come nearer. Beside one
    that comes to the noise an effect must show something at a glance, unless they are alike, and come near to be
    followed to its end; one whose runs are dear must show a little in any case. Beside a base that leaves little it
    must promise what can be told at all.
    """
    noise = base.fit.problem.noise_error
    if base.fit.found.error < LITTLE_LEFT * noise:
        return replace(work, promise=PROMISE_AT_NOISE)
    (key,) = work.effects
    look = seen.get(key)
    if look is not None and look.fit.found.error < AT_NOISE * noise and effect_of_key(key).has_one_form:
        return replace(work, begun=look.fit)
    ends = [each for each in tried if is_near_noise(each, base)]
    is_alike = any(differ_by_aliases(work.effects, each.effects) for each in ends)
    least = LEAST_SHARE if ends else LEAST_SHARE_DEAR if is_dear(key) else 0.0
    if look is not None and look.share < least and not is_alike:
        return replace(work, begun=look.fit, worth=0.0)
    return replace(work, worth=FAR_BEHIND * min((each.fit.found.error for each in ends), default=math.inf))


def beside_reading(tried: Sequence[Candidate], workshop: Workshop) -> list[Candidate]:
    """Try all effects beside one that is read off the record, where that comes nearest and leaves something.

    The nearest of those that make the stem jump are searched about, if what lies beside the reading gains over it.
    """
    nearest = [each for each in best_of(tried, 1)[:1] if is_read_off(each) and not explains(each, tried[0])]
    work = extensions(nearest, tried, values_alone(tried), SHORTLIST, workshop)
    pairs = try_all(work, workshop, "2 effects together")
    near = [each for each in blunt(best_of(pairs, 2), tried[0]) if misfit(each) < NO_GAIN * misfit(nearest[0])]
    return with_better(pairs, sharpen_all(near, workshop))


def rounds(library: Sequence[Effect]) -> list[list[str]]:
    """Return the keys in the order of trying: what a local search finds, what takes a global one, what takes long."""
    kinds = ((False, False), (True, False), (True, True))
    local, *searched = ([each.key for each in library if (each.is_jagged, each.is_chaotic) == kind] for kind in kinds)
    return [local, *(each for each in searched if each)]


def work_on(base: Fit, effect: Effect, tried: Sequence[Candidate], *, has_stops: bool) -> Work:
    """Return how an effect is tried alone: globally, but for one that leaves the stops of a record unexplained.

    Nor is one whose runs take long where a coarse reading comes nearest, or something else bends the line of the
    breakaways of stops: it is searched for on top of that.
    """
    leaves_stops = has_stops and effect.is_jagged and not effect.stops_again
    is_bent = has_stops and effect.is_chaotic and is_off_the_line(base)
    comes_on_top = effect.is_chaotic and has_read_off(min(tried, key=misfit))
    return Work(base, (effect.key,), is_global=not (leaves_stops or comes_on_top or is_bent), kin=kin_of(effect, tried))


def is_off_the_line(base: Fit) -> bool:
    """Return whether the breakaways of a record lie so far off a line that no search along it brings them there."""
    line = straight_line(base)
    return line is not None and not line.is_in_reach


def kin_of(effect: Effect, tried: Sequence[Candidate]) -> Fit | None:
    """Return the best fit in which the stem jumps off, for an effect whose runs take long; else None."""
    kin = [each.fit for each in tried if jumps(each.effects)]
    return min(kin, key=lambda fit: fit.found.error) if kin and effect.is_chaotic else None


def library_for(holdout: Holdout, keys: Sequence[str] | None = None) -> list[Effect]:
    """Return the effects, of those named or of all, that the records can show: settled loops none that acts in time.

    Raises
    ------
    InputError
        If an effect is unknown, or the records can show none of those named.
    """
    is_loop = are_loops(holdout.experiments)
    named = EFFECTS if keys is None else [effect_of_key(key) for key in dict.fromkeys(keys)]
    shown = [effect for effect in named if not (is_loop and effect.acts_in_time)]
    if not shown:
        titles = ", ".join(effect.title for effect in named)
        raise InputError(
            "at least one of the candidates can show in the records",
            f"{titles}: settled loops hold no time to show it" if named else "none was named",
            "name others, or leave the candidates out: all that the records can show are tried then",
        )
    return shown
