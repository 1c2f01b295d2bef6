"""Which effects: every effect alone, then more on top of the best, as long as unseen data gain from it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial

from diagnosis.beside_slips import beside_slips
from diagnosis.explaining import AT_NOISE, any_explains, explains, misfit, stops_seen
from diagnosis.jointly import try_jointly
from diagnosis.judgement import is_felt
from diagnosis.trying import (
    Candidate,
    Progress,
    Work,
    each_in_turn,
    never,
    promises,
    sharpen_all,
    take_out,
    try_all,
    try_anew,
    try_in_turn,
)
from identification.fit import Fit
from identification.hints import is_periodic
from identification.holdout import Holdout
from identification.screening import LITTLE_LEFT
from valvemodel.declarations import Effect
from valvemodel.effects import are_aliases, differ_by_aliases, effect_of_key
from valvemodel.stages import EFFECTS

LEADERS = 2
"""Best causes that are tried with one more effect."""

SHORTLIST, SHORTLIST_BACK = 6, 4
"""Effects that are tried on top of each leader, and when looking backwards, by what they promise on its residual."""

SHORTLIST_SLOW = 2
"""The same on top of a cause whose runs take long."""

SHORTLIST_ON_SERIES, BEST_ON_SERIES = 3, 2
"""Effects that are tried beside a whole series of waves, by what they promise and because they are the best alone."""

MOST_EFFECTS = 3
"""Effects that a cause may have."""

SHARPENED = 2
"""Best causes that are searched about where they make the stem stop and jump, and leave something to explain."""

NEAR_THE_BEST = 2.0
"""Causes whose squared error is within this factor of the best of their size are tried with one more effect, or
searched about."""

WORTH_ANOTHER = 0.3
"""Share by which one more effect must lower the error for yet another to be looked for."""

BEST_ALONE = 4
"""Effects that are tried on top of each leader because they are the best alone: a leader's faults may hide them."""

REVERSED = 4
"""Best causes of two effects that are tried in the other order too: the first of them is fitted for itself alone."""

SETTLED_SHARE = 0.025
"""Share of the base's error, in root mean square, that a cause may leave beside the noise for only those that are alike
to be looked for."""

MANY_NUMBERS = 4
"""Free numbers from which an effect may stand in for one of fewer: a tight spot of any place, width and shape does."""

ALIAS_ROUNDS = 2
"""Times that each of the best two effects makes room for those that come near it: both may be stand-ins."""

EXPLAINS_MUCH, EXPLAINS_SOME = 0.5, 0.75
"""Share of the base's squared error below which a cause must come whose runs take long for others to be tried on top of
it, and for it to be tried on top of others."""

NO_GAIN, FAR_BEHIND = 0.9, 3.0
"""Error over that of the best cause with fewer effects, and over that of the best of all, above which a fit is not
followed to its end."""

LEAST_PROMISE, PROMISE_AT_NOISE = 0.05, 0.005
"""Share of the base's error that an effect must promise by slopes to be followed alone where another settles the
record, and where the base leaves little."""

LOOKED_BACK = 2
"""Best causes of three effects that are tried without each of them in turn."""

MOST_NEARLY = 4
"""Best causes of one effect that are searched for from every start where they nearly explain the record."""

BEHIND = 1.5
"""Factor by which an alias of one of the best two effects lies behind it where its fit may have gone astray."""


def select(
    base: Candidate, holdout: Holdout, library: Sequence[Effect], pool: Executor | None, progress: Progress
) -> list[Candidate]:
    """Try every effect alone, then further effects on top of the best, and return all that was tried, base first."""
    return try_together(try_first(base, holdout, library, pool, progress), holdout, pool, progress)


def try_first(
    base: Candidate, holdout: Holdout, library: Sequence[Effect], pool: Executor | None, progress: Progress
) -> list[Candidate]:
    """Try every effect alone, and what makes the stem jump beside what bends the line through its breakaways."""
    alone = try_alone(base, holdout, library, pool, progress)
    alone = with_better(alone, sharpen_all(blunt(best_of(alone, 1), base), holdout, pool, progress))
    alone = with_better(alone, try_all(nearly(alone), holdout, pool, progress, "effects one by one, from every start"))
    return [*alone, *beside_slips(alone, holdout, pool, progress)]


def try_alone(
    base: Candidate, holdout: Holdout, library: Sequence[Effect], pool: Executor | None, progress: Progress
) -> list[Candidate]:
    """Try every effect alone; those that need a global search come last, and only where no other explains the gap.

    A stem's stick-slip that one law explains may be another's: aliases of that are tried all the same.

    One in which a slip's way hangs by a hair comes after its kindred, and starts from what that found. Where a coarse
    reading comes nearest, all that was tried is tried beside it first, which costs little.
    """
    local, *searched = rounds(library)
    tried = try_by_promise(base, holdout, local, pool, progress)
    has_stops = stops_seen(base.fit)
    for round_of in searched:
        tried += beside_reading(tried, holdout, pool, progress)
        keys = [key for key in round_of if has_stops or not effect_of_key(key).is_chaotic]
        ends = [each for each in tried if explains(each, base)]
        if ends:
            best = min(ends, key=misfit)
            keys = [key for key in keys if effect_of_key(key).is_chaotic and differ_by_aliases((key,), best.effects)]
        work = [work_on(base.fit, effect_of_key(key), tried, has_stops=has_stops) for key in keys]
        tried += try_all(work, holdout, pool, progress, "effects one by one")
    return tried


def nearly(tried: Sequence[Candidate]) -> list[Work]:
    """Return the best causes of one effect that nearly explain the record, as work from every start.

    What leaves so little may be the right one in a side minimum, or stand in for one that ended there.
    """
    base, best = tried[0], best_of(tried, 1)[:MOST_NEARLY]
    if not best or misfit(best[0]) < AT_NOISE or not explains(best[0], base, generous=True):
        return []
    far = FAR_BEHIND * misfit(best[0])
    near = [each for each in best if explains(each, base, generous=True) or misfit(each) < far]
    keys = [each.effects[0] for each in near if not is_laid_on_top(each)]
    return [Work(base.fit, (key,), False, follows_all=True) for key in keys if is_quick(key)]


def try_by_promise(
    base: Candidate, holdout: Holdout, keys: Sequence[str], pool: Executor | None, progress: Progress
) -> list[Candidate]:
    """Try effects that a local search finds alone, the most promising ones first; return the base and those.

    Slopes promise little of what is not small, such as a lag: what promises little is followed all the same, unless
    what was tried before leaves nothing to explain.
    """
    # Waves promise something of whatever is left: they come last, for themselves.
    plain = [key for key in keys if not any(map(is_periodic, effect_of_key(key).parameters))]
    gains = promises(base.fit, {key: {} for key in plain}, pool)
    order = sorted(keys, key=lambda key: -gains.get(key, -math.inf))
    work = [Work(base.fit, (key,), False) for key in order]
    followed = partial(called_for, base)
    return [base, *try_in_turn(work, followed, holdout, pool, progress, "effects one by one")]


def called_for(base: Candidate, work: Work, tried: Sequence[Candidate]) -> Work:
    """Return work on a single effect that is followed as far as what was tried before it calls for.

    Beside one that settles the record an effect must promise something by slopes, unless they are alike, and come near
    to be followed to its end. Beside a base that leaves little it must promise what can be told at all.
    """
    if base.fit.found.error < LITTLE_LEFT * base.fit.problem.noise_error:
        return replace(work, promise=PROMISE_AT_NOISE)
    ends = [each for each in tried if is_settled(each, base)]
    if not ends:
        return work
    worth = FAR_BEHIND * min(each.fit.found.error for each in ends)
    is_alike = any(differ_by_aliases(work.effects, each.effects) for each in ends)
    return replace(work, worth=worth, promise=0.0 if is_alike else LEAST_PROMISE)


def beside_reading(
    tried: Sequence[Candidate], holdout: Holdout, pool: Executor | None, progress: Progress
) -> list[Candidate]:
    """Try all effects beside one that is read off the record, where that comes nearest and leaves something."""
    nearest = [each for each in best_of(tried, 1)[:1] if is_read_off(each) and not explains(each, tried[0])]
    work = extensions(nearest, tried, values_alone(tried), SHORTLIST, pool)
    return try_all(work, holdout, pool, progress, "2 effects together")


def try_together(
    first: Sequence[Candidate], holdout: Holdout, pool: Executor | None, progress: Progress
) -> list[Candidate]:
    """Try further effects on top of the best, as long as unseen data gain from it.

    After each round the best cause is looked at backwards: from what it is without its first effect, in case that one
    only stood in for another.

    Parameters
    ----------
    first : sequence of Candidate
        The base, then the effects one by one, and the pairs that were tried already.
    """
    base, tried = first[0], list(first)
    for size in range(2, MOST_EFFECTS + 1):
        if is_explained(tried, size):
            break
        order = [each for each in best_of(tried, size - 1) if is_worth_its_time(each, base)] or best_of(tried, size - 1)
        if not order or (size > 2 and any(effect_of_key(key).is_chaotic for key in order[0].effects)):
            break
        if size == 2 and not breaks_off(order[0]):
            tried = with_better(tried, try_jointly(tried, holdout, pool, progress))
        if not is_told(tried) and not any(explains(each, base) for each in order):
            tried = on_top_of_the_best(tried, order, holdout, pool, progress)
        best = best_of(tried, size)
        if not best or misfit(best[0]) > NO_GAIN * misfit(order[0]):
            break
        if size == 2:
            tried = with_kindred(tried, holdout, pool, progress)
        else:
            tried = with_better(tried, each_in_turn(take_out, worth_a_look_back(tried), holdout, pool, progress))
        if misfit(best_of(tried, size)[0]) > (1.0 - WORTH_ANOTHER) ** 2 * misfit(order[0]):
            break
    return tried


def is_explained(tried: Sequence[Candidate], size: int) -> bool:
    """Return whether what was tried leaves nothing for causes of so many effects to be looked for.

    What may stand in for anything ends no search for two effects; a third is looked for where two leave much.
    """
    if size > 2:
        return any_explains(tried, generous=True)
    return any(explains(each, tried[0]) and not stands_in(each) for each in tried)


def is_told(tried: Sequence[Candidate]) -> bool:
    """Return whether the nearest two effects explain the record, and neither may stand in for anything."""
    return any(explains(each, tried[0]) and not stands_in(each) for each in best_of(tried, 2)[:1])


def breaks_off(candidate: Candidate) -> bool:
    """Return whether the readings go in slips or in steps by a cause, so that small changes tell little."""
    return is_read_off(candidate) or any(effect_of_key(key).breakaway for key in candidate.effects)


def on_top_of_the_best(
    tried: Sequence[Candidate],
    order: Sequence[Candidate],
    holdout: Holdout,
    pool: Executor | None,
    progress: Progress,
) -> list[Candidate]:
    """Try one more effect on top of the best causes, and of what the best of all is without its first effect.

    Parameters
    ----------
    tried : sequence of Candidate
        The base first.
    order : sequence of Candidate
        Causes of one effect less, the best first.
    """
    base, known = tried[0], list(tried)
    settles, single, size = partial(is_settled, base=base), values_alone(tried), len(order[0].effects) + 1
    leaders, what = leaders_of(order), f"{size} effects together"
    for leader in leaders:
        work = extensions([leader], known, single, SHORTLIST, pool)
        # Readings in coarse steps tell less: what is not alike may come as near.
        until = settles if not is_read_off(leader) else never
        for part in (local(work), wide(work)):
            known += try_all(still_called_for(part, known), holdout, pool, progress, what, until)
        if any(map(settles, known)):
            break
    if size == 2:
        known = with_better(known, try_all(left_alone(known), holdout, pool, progress, what))
    best = best_of(known, size)
    if not best or misfit(best[0]) > NO_GAIN * misfit(order[0]) or settles(best[0]):
        return known
    without_first = set(best[0].effects[1:])
    rest = [each for each in known if set(each.effects) == without_first]
    rest = [each for each in rest if all(each is not leader for leader in leaders)]
    work = still_called_for(extensions(rest, known, single, SHORTLIST_BACK, pool), known)
    known += try_all(work, holdout, pool, progress, what)
    if size == 2:
        known = with_better(known, try_all(reversed_pairs(known, single), holdout, pool, progress, what))
    return known


def with_kindred(
    tried: Sequence[Candidate], holdout: Holdout, pool: Executor | None, progress: Progress
) -> list[Candidate]:
    """Return what was tried, with the best two effects exchanged for their aliases, searched for anew and about."""
    known, done = list(tried), set[frozenset[str]]()
    for _ in range(ALIAS_ROUNDS):
        work = [each for each in exchanged(known) if frozenset(each.effects) not in done]
        done |= {frozenset(each.effects) for each in work}
        known = with_better(known, try_all(work, holdout, pool, progress, "2 effects together"))
    known = with_better(known, each_in_turn(try_anew, worth_trying_anew(known), holdout, pool, progress))
    for choice in (best_of(known, 2), aliases_of_best(known)):
        known = with_better(known, sharpen_all(blunt(choice, known[0]), holdout, pool, progress))
    return known


def worth_trying_anew(tried: Sequence[Candidate]) -> list[Candidate]:
    """Return the best causes of two effects, if nothing explains the record, of which each is to be searched for again.

    The form that came nearest alone, while the other effect was left out, need not be the right one.
    """
    if any_explains(tried):
        return []
    best = best_of(tried, 2)[:LEADERS]
    return [
        each
        for each in best
        if not breaks_away(each) and not any(effect_of_key(key).is_read_off for key in each.effects)
    ]


def worth_a_look_back(tried: Sequence[Candidate]) -> list[Candidate]:
    """Return the best causes of three effects that are to be tried without each in turn, from where the others are.

    The third may be none, and only have led the other two out of a side minimum.
    """
    far = NO_GAIN * misfit(best_of(tried, 2)[0])
    return [
        each
        for each in best_of(tried, 3)[:LOOKED_BACK]
        if misfit(each) < far and not each.has_series and not any(effect_of_key(key).is_chaotic for key in each.effects)
    ]


def local(work: Sequence[Work]) -> list[Work]:
    """Return the work that takes no global search."""
    return [each for each in work if not each.is_global]


def wide(work: Sequence[Work]) -> list[Work]:
    """Return the work that takes a global search, as for what makes the stem stop, which takes long."""
    return [each for each in work if each.is_global]


def still_called_for(work: Sequence[Work], tried: Sequence[Candidate]) -> list[Work]:
    """Return work without global searches where something that was tried explains the record, the base being first."""
    return local(work) if any_explains(tried) else list(work)


def is_settled(candidate: Candidate, base: Candidate) -> bool:
    """Return whether a cause is as near the noise as the right one in another form can be expected to come.

    Only what is alike can come as near. A whole series of waves, or an effect of many numbers, may come there in the
    place of something else.
    """
    within = AT_NOISE + SETTLED_SHARE**2 * (misfit(base) - 1.0)
    numbers = [sum(not each.is_higher for each in effect_of_key(key).fitted) for key in candidate.effects]
    return misfit(candidate) <= within and not candidate.has_series and max(numbers, default=0) < MANY_NUMBERS


def stands_in(candidate: Candidate) -> bool:
    """Return whether an effect of a cause has so many free numbers that it may stand in for another, at little cost."""
    effects = [effect_of_key(key) for key in candidate.effects]
    return any(len(each.fitted) >= MANY_NUMBERS and not each.takes_long for each in effects) or candidate.has_series


def leaders_of(order: Sequence[Candidate]) -> list[Candidate]:
    """Return the causes, of some in their order, that are tried with one more effect.

    A whole series of waves that comes nearest may stand in for much else: it leads beside others, not in their place.
    """
    plain = [each for each in order if not each.has_series]
    leaders = [each for each in unlike(plain)[:LEADERS] if misfit(each) < NEAR_THE_BEST * misfit(plain[0])]
    return [*order[:1], *leaders] if order[0].has_series else leaders


def worthwhile(work: Sequence[Work], tried: Sequence[Candidate]) -> list[Work]:
    """Return work whose fits are only followed to their end where they come near the best so far.

    Errors of runs that are put anew on the readings every so often tell nothing of those of free runs.
    """

    def worth(job: Work) -> float:
        alike = [each for each in tried if each.fit.problem.is_anchored == job.fit.problem.is_anchored]
        least = min(each.fit.found.error for each in alike)
        smaller = min(each.fit.found.error for each in alike if len(each.effects) < len(job.effects))
        return min(NO_GAIN * smaller, FAR_BEHIND * least)

    return [replace(each, worth=worth(each)) for each in work]


def blunt(order: Sequence[Candidate], base: Candidate) -> list[Candidate]:
    """Return those of the first of some causes whose search may have ended beside the least error."""
    near = [each for each in order[:SHARPENED] if misfit(each) < NEAR_THE_BEST * misfit(order[0])]
    return [each for each in near if is_blunt(each) and not explains(each, base)]


def is_blunt(candidate: Candidate) -> bool:
    """Return whether a cause makes the stem stop and jump, and a search about its fit ends in good time."""
    effects = [effect_of_key(key) for key in candidate.effects]
    ends_soon = not any(each.is_chaotic for each in effects) and not candidate.has_series
    return any(each.breakaway for each in effects) and ends_soon


def aliases_of_best(tried: Sequence[Candidate]) -> list[Candidate]:
    """Return the causes of two effects that differ from the best one by a declared alias, the best first."""
    best, *others = best_of(tried, 2)
    return [each for each in others if differ_by_aliases(each.effects, best.effects)]


def best_of(tried: Sequence[Candidate], size: int) -> list[Candidate]:
    """Return the causes of so many effects, the best first."""
    return sorted((each for each in tried if len(each.effects) == size), key=misfit)


def extensions(
    leaders: Sequence[Candidate],
    tried: Sequence[Candidate],
    single: dict[str, dict[str, float]],
    count: int,
    pool: Executor | None,
) -> list[Work]:
    """Return what is to be tried on top of some causes: the most promising effects, no cause twice.

    A whole series of waves is laid on top of the other effect, and bears no third. What is read off the record and has
    no numbers to fit is laid on top of all others: a fit beside it follows none but the readings at its steps' edges.
    """
    known = {frozenset(each.effects) for each in tried}
    better = [each for each in best_of(tried, 1) if misfit(each) < misfit(tried[0])]
    worth = [each for each in better if is_worth_its_time(each, tried[0], EXPLAINS_SOME)]
    alone = [each.effects[0] for each in unlike(worth)[:BEST_ALONE]]
    fits = {key: each.fit for key, each in alone_of(tried).items()}
    # What has no numbers to fit costs one run, and a promise by slopes says little of it.
    plain = [key for key in single if effect_of_key(key).is_read_off]
    # What comes close to no effect promises little by slopes, and shows where little is left.
    hiding = [key for key in single if "none" in effect_of_key(key).aliases]
    has_cause = bool(alone) and effect_of_key(alone[0]).stops_again
    work: list[Work] = []
    for leader in leaders:
        if leader.has_series and len(leader.effects) > 1:
            continue
        takes_long = any(effect_of_key(key).is_chaotic or effect_of_key(key).takes_long for key in leader.effects)
        stopping = [] if has_cause else stopping_on(leader.fit, single)
        best = alone[:BEST_ON_SERIES] if leader.has_series else alone
        if is_read_off(leader):
            best = [*alone, *(key for key in single if not effect_of_key(key).takes_long)]
        called = (*best, *plain, *(hiding if explains(leader, tried[0], generous=True) else ()))
        certain = list(dict.fromkeys([*stopping, *(key for key in called if key not in leader.effects)]))
        most = SHORTLIST_SLOW if takes_long else SHORTLIST_ON_SERIES if leader.has_series else count
        for key in shortlist(leader.fit, single, certain, min(count, most), pool):
            effects = (*leader.effects, key)
            if frozenset(effects) in known:
                continue
            known.add(frozenset(effects))
            is_global = key in stopping and effect_of_key(key).is_jagged and not effect_of_key(key).is_chaotic
            if is_laid_on_top(leader):
                # On top of the few unknowns of the other, not of the many of a series, or of none.
                (own,) = leader.effects
                work.append(Work(fits[key], (key, own), False, single[own], is_known=True))
            else:
                work.append(Work(leader.fit, effects, is_global, single[key]))
    return worthwhile(work, tried)


def breaks_away(candidate: Candidate) -> bool:
    """Return whether one of a cause's effects makes the stem stop and jump, or takes long to run."""
    effects = [effect_of_key(key) for key in candidate.effects]
    return any(each.breakaway or each.takes_long for each in effects)


def left_alone(tried: Sequence[Candidate]) -> list[Work]:
    """Return the causes of one effect that came nearer beside another which leaves no trace, as work from there.

    The search for it alone had ended beside the least error.
    """
    alone = alone_of(tried)
    work: dict[str, Work] = {}
    pairs = best_of(tried, 2)
    idle = [each for each in pairs if not is_felt(each) and misfit(each) < NEAR_THE_BEST * misfit(pairs[0])]
    for pair in idle:
        for key in pair.effects:
            if misfit(pair) < NO_GAIN * misfit(alone[key]):
                known = dict(pair.fit.model.effects[key])
                work.setdefault(key, Work(tried[0].fit, (key,), False, known, kin=pair.fit))
    return list(work.values())


def values_alone(tried: Sequence[Candidate]) -> dict[str, dict[str, float]]:
    """Return the values of each effect as fitted alone. [SI]"""
    return {key: dict(each.fit.model.effects[key]) for key, each in alone_of(tried).items()}


def alone_of(tried: Sequence[Candidate]) -> dict[str, Candidate]:
    """Return the causes of one effect by its key, in the order in which they were tried."""
    return {each.effects[0]: each for each in tried if len(each.effects) == 1}


def is_read_off(candidate: Candidate) -> bool:
    """Return whether all numbers of a cause are read off the record."""
    return bool(candidate.effects) and all(effect_of_key(key).is_read_off for key in candidate.effects)


def is_laid_on_top(candidate: Candidate) -> bool:
    """Return whether a cause of one effect is laid on top of another's fit, not under it."""
    return candidate.has_series or is_read_off(candidate)


def unlike(causes: Sequence[Candidate]) -> list[Candidate]:
    """Return causes without those that differ from one before them by a declared alias.

    These are exchanged later, but for what takes long.
    """
    kept: list[Candidate] = []
    for cause in causes:
        is_exchanged = all(is_quick(key) for key in cause.effects)
        if not is_exchanged or not any(differ_by_aliases(cause.effects, each.effects) for each in kept):
            kept.append(cause)
    return kept


def reversed_pairs(tried: Sequence[Candidate], single: dict[str, dict[str, float]]) -> list[Work]:
    """Return the best causes of two effects as work in the other order, where that begins with a fit at hand."""
    alone = alone_of(tried)
    pairs = [each.effects for each in best_of(tried, 2)[:REVERSED]]
    known = {each.effects for each in tried}
    return [
        Work(alone[second].fit, (second, first), False, single[first])
        for first, second in pairs
        if (second, first) not in known and not effect_of_key(first).is_jagged and not is_read_off(alone[second])
    ]


def exchanged(tried: Sequence[Candidate]) -> list[Work]:
    """Return the best causes of two effects with each exchanged for its aliases.

    One that promises most on the leader's residual may only stand in for another that needs the leader's values moved:
    the alias is taken as fitted alone, and what stays with its numbers in the pair comes on top. A cause that was tried
    and lies far behind is tried once more in that way.
    """
    known = {frozenset(each.effects): misfit(each) for each in tried}
    work: dict[frozenset[str], Work] = {}
    pairs = best_of(tried, 2)
    for best in pairs[: 1 if is_settled(pairs[0], tried[0]) else LEADERS]:
        for kept, left in (best.effects, best.effects[::-1]):
            values = dict(best.fit.model.effects[kept])
            for other in best_of(tried, 1):
                key = other.effects[0]
                cause = frozenset((key, kept))
                is_behind = known.get(cause, math.inf) > BEHIND * misfit(best)
                if other.has_series:
                    continue
                if are_aliases(left, key) and key != kept and is_behind and is_quick(key):
                    work.setdefault(cause, Work(other.fit, (key, kept), False, values, is_known=True))
    return list(work.values())


def is_worth_its_time(candidate: Candidate, base: Candidate, share: float = EXPLAINS_MUCH) -> bool:
    """Return whether a cause is tried together with more: where its runs take long, only if it explains so much."""
    takes_long = any(effect_of_key(key).takes_long for key in candidate.effects)
    return not takes_long or misfit(candidate) < share * misfit(base)


def is_quick(key: str) -> bool:
    """Return whether a search for an effect beside another takes no global search and no long runs."""
    effect = effect_of_key(key)
    return not effect.is_jagged and not effect.takes_long


def with_better(tried: Sequence[Candidate], others: Sequence[Candidate]) -> list[Candidate]:
    """Return the causes, each as the one of the same effects that comes nearest, in whatever order of adding."""
    best: dict[frozenset[str], Candidate] = {}
    for each in (*tried, *others):
        effects = frozenset(each.effects)
        best[effects] = min(best.get(effects, each), each, key=misfit)
    return list(best.values())


def stopping_on(fit: Fit, single: dict[str, dict[str, float]]) -> list[str]:
    """Return the effects that make a stem stop again and again, where a record shows that and a fit does not."""
    if any(effect_of_key(key).stops_again for key in fit.model.effects) or not stops_seen(fit):
        return []
    return [key for key in single if effect_of_key(key).stops_again]


def rounds(library: Sequence[Effect]) -> list[list[str]]:
    """Return the keys in the order of trying: what a local search finds, what takes a global one, what takes long."""
    kinds = ((False, False), (True, False), (True, True))
    local, *searched = ([each.key for each in library if (each.is_jagged, each.is_chaotic) == kind] for kind in kinds)
    return [local, *(each for each in searched if each)]


def work_on(base: Fit, effect: Effect, tried: Sequence[Candidate], *, has_stops: bool) -> Work:
    """Return how an effect is tried alone: globally, but for one that leaves the stops of a record unexplained."""
    is_global = not (has_stops and effect.is_jagged and not effect.stops_again)
    return Work(base, (effect.key,), is_global, kin=kin_of(effect, tried))


def kin_of(effect: Effect, tried: Sequence[Candidate]) -> Fit | None:
    """Return the best fit in which the stem jumps off, for an effect whose runs take long; else None."""
    kin = [each.fit for each in tried if any(effect_of_key(key).breakaway for key in each.effects)]
    return min(kin, key=lambda fit: fit.found.error) if kin and effect.is_chaotic else None


def library_for(holdout: Holdout, keys: Sequence[str] | None = None) -> list[Effect]:
    """Return the effects, of those named or of all, that the records can show: settled loops none that acts in time."""
    is_loop = all(experiment.is_loop for experiment in holdout.experiments)
    named = EFFECTS if keys is None else [effect_of_key(key) for key in dict.fromkeys(keys)]
    return [effect for effect in named if not (is_loop and effect.acts_in_time)]


def shortlist(
    fit: Fit, single: dict[str, dict[str, float]], certain: Sequence[str], count: int, pool: Executor | None
) -> list[str]:
    """Return the effects that promise most on what a fit leaves over, after those that are called for in any case.

    One whose runs take long beside another must be called for.
    """
    keys = [key for key in single if key not in fit.model.effects and not effect_of_key(key).takes_long]
    keys = [key for key in keys if key not in certain]
    gains = promises(fit, {key: single[key] for key in keys}, pool)
    order = sorted(keys, key=lambda key: -gains[key])
    return [*dict.fromkeys(certain), *order[:count]]
