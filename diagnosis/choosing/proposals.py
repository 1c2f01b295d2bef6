"""Proposals: which effects are tried on top of, beside and in place of those of the best causes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from diagnosis.judging.judgement import is_felt
from diagnosis.trying.candidates import Candidate, Work, promises
from diagnosis.trying.explaining import (
    AT_NOISE,
    any_explains,
    explains,
    leaves_nothing_to_tell,
    misfit,
    nearly_explains,
    stops_seen,
)
from diagnosis.trying.standing import (
    EXPLAINS_SOME,
    NEAR_THE_BEST,
    alone_of,
    best_of,
    has_read_off,
    is_blunt,
    is_dear,
    is_laid_on_top,
    is_quick,
    is_read_off,
    is_settled,
    is_worth_its_time,
    of_many_numbers,
    orders_of,
    unlike,
    values_alone,
)
from diagnosis.trying.workshop import Workshop
from identification.fit import Fit
from identification.starting.hints import begins_at_periods, other_forms
from valvemodel.effects import are_aliases, effect_of_key, jumps_in_closed_form
from valvemodel.stages import EFFECTS

LEADERS = 2
"""Best causes that are tried with one more effect."""

FOLLOWS_NEAREST = 0.5
"""Error of what makes the stem jump, over that of what leads, in what they were fitted to, from which it leads as well:
that is so in one of 561 blind plants of our own, of play beside static friction."""

SHORTLIST, SHORTLIST_BACK = 6, 4
"""Effects that are tried on top of the leader, and when looking backwards, by what they promise on its residual."""

SHORTLIST_FURTHER = 2
"""The same on top of the second leader: of 159 tried there in 31 blind plants of our own none gained a tenth."""

SHORTLIST_SLOW = 2
"""The same on top of a cause whose runs take long."""

SHORTLIST_ON_SERIES, BEST_ON_SERIES = 3, 2
"""Effects that are tried beside a whole series of waves, by what they promise and because they are the best alone."""

BEST_ALONE = 4
"""Effects that are tried on top of each leader because they are the best alone: a leader's faults may hide them."""

REVERSED = 4
"""Best causes of two effects that are tried in the other order too: the first of them is fitted for itself alone."""

NEARLY = 3
"""Best causes of two effects that are searched for from every start, in either order, where they nearly explain a
record."""

LITTLE_BESIDE = 1.5
"""Mean weighted square up to which that is worth it: of three in blind plants of our own that left more none gained by
it, of ten that left less two came to the noise."""

NO_GAIN, FAR_BEHIND = 0.9, 3.0
"""Error over that of the best cause with fewer effects, and over that of the best of all, above which a fit is not
followed to its end."""

PROMISE_IF_SLOW = 0.25
"""Share of the error of an effect whose runs take long that another must promise to explain on top of it: seven in a
blind plant of our own took 15 s and gained nothing."""

NEAR_MISS, NEAR_MISSES = 5.0, 4
"""Factor within which two effects lie behind the best two to be tried in another order, and the most that are."""

APART = 0.2
"""Share of a number of an effect from which it is another one in two fits, and not the same but for a search's end."""

BEHIND, BEHIND_NEAR, SLIGHTLY = 1.5, 2.0, 1.02
"""Factors by which an alias of one of the best two effects lies behind it where its fit may have gone astray, and is
tried once more: as fitted alone with the other effect on top, in all and beyond the noise, and on top of that."""


def extensions(
    leaders: Sequence[Candidate],
    tried: Sequence[Candidate],
    single: dict[str, dict[str, float]],
    count: int,
    workshop: Workshop,
) -> list[Work]:
    """Return what is to be tried on top of some causes: the most promising effects, no cause twice.

    A whole series of waves is laid on top of the other effect, and bears no third. What is read off the record and has
    no numbers to fit is laid on top of all others: a fit beside it follows none but the readings at its steps' edges.
    """
    orders = orders_of(tried)
    # A pair with one wave says nothing of one with many.
    known: dict[tuple[frozenset[str], bool], float] = {}
    for each in tried:
        tried_as = (frozenset(each.effects), each.has_series)
        known[tried_as] = min(known.get(tried_as, math.inf), misfit(each))
    better = [each for each in best_of(tried, 1) if misfit(each) < misfit(tried[0])]
    worth = [each for each in better if is_worth_its_time(each, tried[0], EXPLAINS_SOME)]
    alone = [each.effects[0] for each in unlike(worth)[:BEST_ALONE]]
    fits = {key: each.fit for key, each in alone_of(tried).items()}
    # What has no numbers to fit costs one run, and a promise by slopes says little of it.
    plain = [key for key in single if effect_of_key(key).is_read_off]
    # What an effect came to where it explained nothing leads astray beside what explains much.
    led = {*plain, *(each.effects[0] for each in better if misfit(each) < NO_GAIN * misfit(tried[0]))}
    # What comes close to no effect promises little by slopes, and shows where little is left.
    hiding = [key for key in single if may_hide(key)]
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
        for key in shortlist(leader.fit, single, certain, min(count, most), workshop):
            effects = (*leader.effects, key)
            cause = (frozenset(effects), leader.has_series)
            # What is read off the residual of another fit may have begun amiss, and with one wave followed together.
            is_open = begins_at_periods(effect_of_key(key)) and (
                effects not in orders or known.get(cause, math.inf) > NO_GAIN * misfit(leader)
            )
            if cause in known and not is_open:
                continue
            known[cause] = 0.0
            is_global = key in stopping and effect_of_key(key).is_jagged and not effect_of_key(key).is_chaotic
            if is_laid_on_top(leader):
                # On top of the few unknowns of the other, not of the many of a series, or of none.
                (own,) = leader.effects
                work.append(Work(fits[key], (key, own), is_global=False, known=single[own], is_known=True))
            else:
                work.append(Work(leader.fit, effects, is_global=is_global, known=single[key] if key in led else None))
    return worthwhile(work, tried)


def leaders_of(order: Sequence[Candidate]) -> list[Candidate]:
    """Return the causes, of some in their order, that are tried with one more effect.

    A whole series of waves that comes nearest may stand in for much else: it leads beside others, not in their place.
    So does what makes the stem jump where it comes by far the nearest to what it was fitted to: of what it did not see,
    one slip that falls elsewhere is worth more than all the rest.
    """
    plain = [each for each in order if not each.has_series]
    leaders = [each for each in unlike(plain)[:LEADERS] if misfit(each) < NEAR_THE_BEST * misfit(plain[0])]
    jumping = [each for each in plain if jumps_in_closed_form(each.effects) and follows_nearest(each, leaders)]
    return [*(order[:1] if order[0].has_series else []), *jumping[:1], *leaders]


def follows_nearest(cause: Candidate, leaders: Sequence[Candidate]) -> bool:
    """Return whether a cause comes by far nearer to what it was fitted to than some that lead, by a like run."""
    alike = [each for each in leaders if each.fit.problem.is_anchored == cause.fit.problem.is_anchored]
    return cause.fit.found.error < FOLLOWS_NEAREST * min((each.fit.found.error for each in alike), default=0.0)


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


def shortlist(
    fit: Fit, single: dict[str, dict[str, float]], certain: Sequence[str], count: int, workshop: Workshop
) -> list[str]:
    """Return the effects that promise most on what a fit leaves over, after those that are called for in any case.

    One whose runs take long beside another must be called for.
    """
    keys = [key for key in single if key not in fit.model.effects and not effect_of_key(key).takes_long]
    keys = [key for key in keys if key not in certain]
    gains = promises(fit, {key: single[key] for key in keys}, workshop)
    order = sorted(keys, key=lambda key: -gains[key])
    return [*dict.fromkeys(certain), *order[:count]]


def stopping_on(fit: Fit, single: dict[str, dict[str, float]]) -> list[str]:
    """Return the effects that make a stem stop again and again, where a record shows that and a fit does not."""
    if any(effect_of_key(key).stops_again for key in fit.model.effects) or not stops_seen(fit):
        return []
    return [key for key in single if effect_of_key(key).stops_again]


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
                work.setdefault(key, Work(tried[0].fit, (key,), is_global=False, known=known, kin=pair.fit))
    return list(work.values())


def reversed_pairs(tried: Sequence[Candidate], single: dict[str, dict[str, float]]) -> list[Work]:
    """Return the best causes of two effects as work in the other order, where that begins with a fit at hand.

    Where the best explain the record those that lie far behind it are left as they are.
    """
    alone, best = alone_of(tried), best_of(tried, 2)[:REVERSED]
    far = NEAR_MISS * misfit(best[0]) if explains(best[0], tried[0]) else math.inf
    pairs = [each.effects for each in best if misfit(each) < far]
    known = orders_of(tried)
    work = [
        Work(alone[second].fit, (second, first), is_global=False, known=single[first])
        for first, second in pairs
        if (second, first) not in known and not effect_of_key(first).is_jagged and not is_read_off(alone[second])
    ]
    return worthwhile(work, tried)


def on_what_explains(tried: Sequence[Candidate]) -> list[Work]:
    """Return what comes close to none on top of the best single cause, where that explains the record but leaves some.

    The base valve's numbers make up for most of it: it promises little by slopes, beside whatever else.
    """
    best = best_of(tried, 1)[0]
    (own,) = best.effects
    if misfit(best) < AT_NOISE or not explains(best, tried[0]) or not is_quick(own) or is_laid_on_top(best):
        return []
    known = {frozenset(each.effects) for each in tried}
    values = values_alone(tried)
    keys = [key for key in values if may_hide(key) and is_quick(key) and frozenset((own, key)) not in known]
    return [Work(best.fit, (own, key), is_global=False, known=values[key]) for key in keys]


def on_what_stays(tried: Sequence[Candidate]) -> list[Work]:
    """Return the best cause of two effects with each exchanged for what it may stand in for, on top of what stays.

    An alias as fitted alone may have gone astray without the effect that stays, and where two effects explain the
    record nothing else was tried on top of that. It must explain some alone. What hides in the base valve's numbers
    promises little by slopes, and is tried as well unless the noise is reached: nothing can come nearer than that, but
    an alias may come as near. Where nothing explains the record the best effects have been tried with all that promises
    most.
    """
    best = best_of(tried, 2)[0]
    if not explains(best, tried[0]):
        return []
    alone, values = alone_of(tried), values_alone(tried)
    known = {frozenset(each.effects): each for each in tried}
    some = EXPLAINS_SOME * misfit(tried[0])
    work: list[Work] = []
    for kept, left, other in exchanges(best, alone.values()):
        (key,) = other.effects
        stays = not effect_of_key(kept).is_jagged and not alone[kept].has_series and misfit(alone[kept]) <= some
        before = known.get(frozenset((kept, key)))
        is_behind = before is None or (before.effects[0] != kept and misfit(before) > SLIGHTLY * misfit(best))
        is_called = are_aliases(left, key) or (may_hide(key) and misfit(best) >= AT_NOISE)
        if stays and is_behind and is_called:
            work.append(Work(alone[kept].fit, (kept, key), is_global=False, known=values[key]))
    return worthwhile(unless_slow_in_vain(work, best, tried), tried)


def from_the_best(tried: Sequence[Candidate]) -> list[Work]:
    """Return the best two effects, where they explain the record, with each exchanged for an alias, from there.

    The alias as fitted alone may have been bent to what the other effect does, and beside what stays as fitted alone
    lead nowhere. The valve that was fitted with the best two is right but for the alias. On what makes fits long all
    that promises something was tried.
    """
    best = best_of(tried, 2)[0]
    if not explains(best, tried[0]) or has_read_off(best):
        return []
    alone, values = alone_of(tried), values_alone(tried)
    behind = behind_the_best(tried)
    work: list[Work] = []
    for kept, left, other in exchanges(best, alone.values()):
        (key,) = other.effects
        is_led_on = not (effect_of_key(kept).is_chaotic or alone[kept].has_series)
        if are_aliases(left, key) and behind(kept, key) and is_led_on:
            work.append(Work(alone[kept].fit, (kept, key), is_global=False, known=values[key], kin=best.fit))
    return [each for each in work if not is_slow(each)]


def law_in_closed_form(tried: Sequence[Candidate]) -> list[Work]:
    """Return the best two effects, if they explain the record by a law whose runs take long, with its kindred for that.

    A law of more numbers comes nearer from afar. The one in closed form may be right, and is tried from there.
    """
    pairs = best_of(tried, 2)[:1]
    if not pairs or not explains(pairs[0], tried[0]):
        return []
    behind = behind_the_best(tried)
    work = laws_in_place(pairs[0], alone_of(tried))
    return [each for each in work if jumps_in_closed_form(each.effects) and behind(*each.effects)]


def behind_the_best(tried: Sequence[Candidate]) -> Callable[[str, str], bool]:
    """Return what tells whether two effects, in whatever order, lie behind the best two or were not tried."""
    known = {frozenset(each.effects): misfit(each) for each in tried}
    near = SLIGHTLY * misfit(best_of(tried, 2)[0])
    return lambda one, other: known.get(frozenset((one, other)), math.inf) > near


def near_misses(tried: Sequence[Candidate]) -> list[Work]:
    """Return what lies not far behind the best two effects, where they explain the record, as work in another order.

    A right pair with one of the two in common may have been followed from amiss, with its numbers from another pair or
    together with the other effect, or lack but another form: it may come nearer than what is at the noise already, as
    that is estimated. What is dear to run takes longest on top of what makes fits long: it leads there.
    """
    best = best_of(tried, 2)[0]
    if not explains(best, tried[0]):
        return []
    alone, values = alone_of(tried), values_alone(tried)
    near = [each for each in with_one_of_the_best(tried) if misfit(each) > SLIGHTLY * misfit(best)]
    known = orders_of(tried)
    orders = [order for each in near for order in (each.effects[::-1], each.effects) if order not in known]
    work = [
        Work(alone[first].fit, (first, second), is_global=False, known=values[second])
        for first, second in orders
        if is_quick(second) and not effect_of_key(first).breakaway and not is_laid_on_top(alone[first])
    ]
    work = [each for each in work if not (is_slow(each) and is_dear(each.effects[1]))]
    return worthwhile(unless_slow_in_vain(work, best, tried)[:NEAR_MISSES], tried)


def from_numbers_of_the_best(tried: Sequence[Candidate]) -> list[Work]:
    """Return what has one effect in common with the best two, and lies not far behind, to begin with its numbers there.

    Where the best two explain the record but leave some, another pair may be right: what they share may have ended in a
    side minimum beside the other, far from the numbers that it has beside a stand-in. The other that explains
    most alone comes first.
    """
    best = best_of(tried, 2)[0]
    if misfit(best) < AT_NOISE or not explains(best, tried[0]):
        return []
    alone = alone_of(tried)
    work: list[Work] = []
    for each in with_one_of_the_best(tried):
        shared = set(each.effects) & set(best.effects)
        if len(shared) != 1:
            continue
        (key,), (other,) = shared, set(each.effects) - shared
        numbers, own = (dict(cause.fit.model.effects[key]) for cause in (best, each))
        are_alike = all(math.isclose(value, own[name], rel_tol=APART) for name, value in numbers.items())
        if not are_alike and is_quick(key) and other in alone and not is_laid_on_top(alone[other]):
            work.append(Work(alone[other].fit, (other, key), is_global=False, known=numbers, is_known=True))
    work.sort(key=lambda each: misfit(alone[each.effects[0]]))
    return worthwhile([each for each in work if not is_slow(each)][:NEAR_MISSES], tried)


def with_one_of_the_best(tried: Sequence[Candidate]) -> list[Candidate]:
    """Return the causes of two effects that lie not far behind the best two and have one of these, the best first."""
    best, *others = best_of(tried, 2)
    near = [each for each in others if misfit(each) < NEAR_MISS * misfit(best) and not each.has_series]
    return [each for each in near if not set(each.effects).isdisjoint(best.effects)]


def unless_slow_in_vain(work: Sequence[Work], best: Candidate, tried: Sequence[Candidate]) -> list[Work]:
    """Return work, of which what begins on an effect that makes fits long is called for only where it may come nearer.

    Where the best leaves nothing to tell it could come as near at most, and elsewhere it must promise something: what
    hides in the base valve's numbers does not.
    """
    is_enough = leaves_nothing_to_tell(best, tried)
    called = [each for each in work if not (is_enough and is_slow(each))]
    # What leaves some of what it was fitted to may stand in for what promises nothing from there.
    return promising_if_slow(called, runs_long if nearly_explains(best, tried[0]) else is_slow)


def promising_if_slow(work: Sequence[Work], is_dear_to_fit: Callable[[Work], bool]) -> list[Work]:
    """Return work, of which what begins on an effect that makes fits long must promise something by slopes."""
    return [replace(each, promise=PROMISE_IF_SLOW) if is_dear_to_fit(each) else each for each in work]


def called_on_slow(work: Sequence[Work], tried: Sequence[Candidate]) -> list[Work]:
    """Return work, of which what begins on a fit that is long is called for as what was tried tells, the base first.

    Where as many effects explain the record it may be in vain, and a third one takes longest of all.
    """
    size = max((len(each.effects) for each in work), default=0)
    ends = [each for each in best_of(tried, size)[:1] if explains(each, tried[0])]
    if ends:
        return unless_slow_in_vain(work, ends[0], tried)
    return promising_if_slow(work, is_slow) if size > 2 else list(work)


def is_slow(work: Work) -> bool:
    """Return whether fits on top of what a fit has are long: runs of its first effect are, or one has many numbers."""
    return runs_long(work) or bool(of_many_numbers(work.fit.model))


def runs_long(work: Work) -> bool:
    """Return whether runs of the first effect take long."""
    return effect_of_key(work.effects[0]).takes_long


def nearly_together(tried: Sequence[Candidate]) -> list[Work]:
    """Return the best two effects that nearly explain the record and leave little, from every start in either order.

    What is dear to run is searched for from its best starts alone: from every one that takes as long as all the rest.
    """
    pairs = best_of(tried, 2)
    if not nearly_explains(pairs[0], tried[0]) or misfit(pairs[0]) > LITTLE_BESIDE:
        return []
    alone, values = alone_of(tried), values_alone(tried)
    near = [each.effects for each in pairs[:NEARLY] if misfit(each) < FAR_BEHIND * misfit(pairs[0])]
    orders = [order for first, second in near for order in ((first, second), (second, first))]
    return [
        Work(alone[first].fit, (first, second), is_global=False, known=values[second], follows_all=not is_dear(second))
        for first, second in orders
        if all(key in alone and is_quick(key) and not is_laid_on_top(alone[key]) for key in (first, second))
    ]


def jumps_anew(tried: Sequence[Candidate]) -> list[Work]:
    """Return the best two effects of which one makes the stem jump, as work that searches for that one thoroughly.

    It was searched for in haste, or only followed down where no stops are seen, and has gained by that what a wider
    search may gain more of.
    """
    if any_explains(tried):
        return []
    alone, pairs = alone_of(tried), [each for each in best_of(tried, 2) if is_blunt(each)][:LEADERS]
    return [
        Work(alone[other].fit, (other, jumping), is_global=True, is_thorough=True)
        for pair in pairs
        for other, jumping in jumps_that_gained(pair, alone)
    ]


def other_laws(tried: Sequence[Candidate]) -> list[Work]:
    """Return the best two effects of which one makes the stem jump, with that one exchanged for another law.

    A search for a law beside another effect is long: the one that was found leads it to the valve. What it made of one
    wave says nothing of a whole series.
    """
    if any_explains(tried):
        return []
    alone = alone_of(tried)
    return [each for pair in best_of(tried, 2)[:LEADERS] for each in laws_in_place(pair, alone)]


def laws_in_place(pair: Candidate, alone: Mapping[str, Candidate]) -> list[Work]:
    """Return two effects that gain, with the law by which the stem jumps exchanged for the others, from there."""
    return [
        Work(alone[other].fit, (other, law), is_global=True, kin=pair.fit)
        for other, _ in jumps_that_gained(pair, alone)
        if alone[other].has_series == pair.has_series
        for law in alone
        if effect_of_key(law).breakaway and law not in pair.effects
    ]


def jumps_that_gained(pair: Candidate, alone: Mapping[str, Candidate]) -> Iterator[tuple[str, str]]:
    """Yield the other of two effects and the one that makes the stem jump, if they gain over either alone."""
    for other, jumping in (pair.effects, pair.effects[::-1]):
        first = effect_of_key(other)
        is_beside = effect_of_key(jumping).breakaway and not first.breakaway and not first.takes_long
        if is_beside and other in alone and gains_by_both(pair, alone):
            yield other, jumping


def gains_by_both(pair: Candidate, alone: Mapping[str, Candidate]) -> bool:
    """Return whether two effects leave less, by a tenth, than either alone: what gains nothing by one is the other."""
    return all(misfit(pair) < NO_GAIN * misfit(alone[key]) for key in pair.effects if key in alone)


def in_other_forms(tried: Sequence[Candidate]) -> list[Work]:
    """Return the smooth one of the best two effects, of which the other makes the stem jump, alone in its other forms.

    Where the jumps are left out a wrong form may come as near as the right one.
    """
    best = next(iter(best_of(tried, 2)), None)
    if best is None or explains(best, tried[0]) or not is_blunt(best) or not gains_by_both(best, alone_of(tried)):
        return []
    values = {key: best.fit.model.effects[key] for key in best.effects if is_quick(key)}
    forms = [(key, form) for key in values for form in other_forms(effect_of_key(key), values[key])]
    return [Work(tried[0].fit, (key,), is_global=False, known=form, is_known=True) for key, form in forms]


def with_jumps(alone: Sequence[Candidate], tried: Sequence[Candidate]) -> list[Work]:
    """Return what makes the stem jump of the best two effects, on top of others alone."""
    if not alone:
        return []
    jumping = [key for key in best_of(tried, 2)[0].effects if effect_of_key(key).breakaway]
    return [Work(each.fit, (*each.effects, key), is_global=True, is_thorough=True) for each in alone for key in jumping]


def may_hide(key: str) -> bool:
    """Return whether an effect is declared to come close to none at all."""
    return "none" in effect_of_key(key).aliases


def exchanged(tried: Sequence[Candidate]) -> list[Work]:
    """Return the best causes of two effects with each exchanged for its aliases.

    One that promises most on the leader's residual may only stand in for another that needs the leader's values moved:
    the alias is taken as fitted alone, and what stays with its numbers in the pair comes on top. A cause that was tried
    and lies far behind is tried once more in that way. A whole series of waves takes in whatever goes with time: it
    makes room for the aliases of those of its aliases that act in time as well.
    """
    known = {frozenset(each.effects): misfit(each) for each in tried}
    work: dict[frozenset[str], Work] = {}
    pairs = best_of(tried, 2)
    for best in pairs[: 1 if is_settled(pairs[0], tried[0]) else LEADERS]:
        for kept, left, other in exchanges(best, best_of(tried, 1)):
            (key,) = other.effects
            cause, values = frozenset((key, kept)), dict(best.fit.model.effects[kept])
            is_series = best.has_series and begins_at_periods(effect_of_key(left))
            is_alike = are_aliases(left, key) or (is_series and goes_with_time(key, left))
            if is_alike and lies_behind(known.get(cause, math.inf), misfit(best)):
                work.setdefault(cause, Work(other.fit, (key, kept), is_global=False, known=values, is_known=True))
    return worthwhile(list(work.values()), tried)


def goes_with_time(key: str, series: str) -> bool:
    """Return whether an effect has an alias in common with a series of waves that acts in time: it takes in both."""
    return any(each.acts_in_time and are_aliases(series, each.key) and are_aliases(each.key, key) for each in EFFECTS)


def lies_behind(left: float, least: float) -> bool:
    """Return whether what a cause leaves is so much more than the least that its search may have gone astray."""
    return left > min(BEHIND * least, 1.0 + BEHIND_NEAR * (max(least, AT_NOISE) - 1.0))


def exchanges(pair: Candidate, alone: Iterable[Candidate]) -> Iterator[tuple[str, str, Candidate]]:
    """Yield which of two effects stays, which makes room, and each single one that may take its place.

    A search for that one beside another must be quick; a whole series of waves takes no effect's place.
    """
    others = [each for each in alone if is_quick(each.effects[0]) and not each.has_series]
    for kept, left in (pair.effects, pair.effects[::-1]):
        yield from ((kept, left, each) for each in others if each.effects[0] not in pair.effects)
