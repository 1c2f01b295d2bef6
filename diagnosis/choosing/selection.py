"""Which effects: every effect alone, then more on top of the best, as long as unseen data gain from it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from diagnosis.choosing.ending import gains, goes_in_jumps, is_enough, is_explained, is_told
from diagnosis.choosing.jointly import try_jointly
from diagnosis.choosing.proposals import (
    LEADERS,
    NO_GAIN,
    SHORTLIST,
    SHORTLIST_BACK,
    SHORTLIST_FURTHER,
    called_on_slow,
    exchanged,
    extensions,
    from_numbers_of_the_best,
    from_the_best,
    in_other_forms,
    jumps_anew,
    leaders_of,
    left_alone,
    near_misses,
    nearly_together,
    on_what_explains,
    on_what_stays,
    other_laws,
    reversed_pairs,
    with_jumps,
)
from diagnosis.choosing.rivals import aliases_of_best, ended_at_nothing, rivals_of_best, short_of_noise, two_that_gain
from diagnosis.trying.candidates import (
    Candidate,
    Work,
    begin_again,
    change_all,
    each_in_turn,
    never,
    sharpen_all,
    take_out,
    try_all,
    try_anew,
)
from diagnosis.trying.explaining import AT_NOISE, allowed, any_explains, misfit
from diagnosis.trying.standing import (
    as_tried,
    best_of,
    blunt,
    breaks_away,
    has_read_off,
    is_out_of_reach,
    is_read_off,
    is_settled,
    is_worth_its_time,
    values_alone,
    with_better,
)
from diagnosis.trying.workshop import Workshop
from identification.extending.restart import is_far_off
from valvemodel.effects import effect_of_key

MOST_EFFECTS = 3
"""Effects that a cause may have."""

WORTH_ANOTHER = 0.3
"""Share by which one more effect must lower the error for yet another to be looked for."""

ALIAS_ROUNDS = 2
"""Times that each of the best two effects makes room for those that come near it: both may be stand-ins."""

BEGUN_AGAIN = 4
"""Best causes of two effects that begin again from the given valve's numbers where their mass is far off."""

LACKS_A_FORM = 5.0
"""Squared error, over what may be left, up to which the best two effects may lack but the right form. Of twelve blind
plants of our own that nothing explained, at whatever error, none gained more than 4 % by another."""

LOOKED_BACK = 2
"""Best causes of three effects that are tried without each of them in turn."""


def try_together(
    first: Sequence[Candidate], workshop: Workshop, *, together: Sequence[Candidate] | None = None
) -> list[Candidate]:
    """Try further effects on top of the best, as long as unseen data gain from it.

    After each round the best cause is looked at backwards: from what it is without its first effect, in case that one
    only stood in for another.

    Parameters
    ----------
    first : sequence of Candidate
        The base, then the effects one by one, and the pairs that were tried already.
    together : sequence of Candidate or None
        Pairs that were tried jointly before; None where they are to be where that is called for.
    """
    base, tried = first[0], list(first)
    for size in range(2, MOST_EFFECTS + 1):
        if is_explained(tried, size):
            break
        order = [each for each in best_of(tried, size - 1) if is_worth_its_time(each, base)] or best_of(tried, size - 1)
        if not order or (size > 2 and any(effect_of_key(key).is_chaotic for key in order[0].effects)):
            break
        if size == 2:
            tried = in_right_form(tried, workshop)
        formed = best_of(tried, 2)[:1]
        if size == 2 and not goes_in_jumps(order[0]):
            joined = try_jointly(tried, workshop) if together is None else together
            tried = with_better(tried, joined)
            tried = with_pairs(tried, on_what_explains(tried), workshop)
        if not is_told(tried) and not any(is_enough(each, base) for each in order):
            tried = on_top_of_the_best(tried, order, workshop)
        best, fewer = best_of(tried, size), as_tried(order[0], tried)
        if not best or not gains(best[0], fewer):
            break
        if size == 2:
            tried = with_kindred(tried, workshop, formed)
        led = leading_pair(tried)
        tried = with_better(tried, each_in_turn(take_out, worth_a_look_back(tried, size), workshop))
        tried = exchanged_anew(tried, led, workshop)
        if misfit(best_of(tried, size)[0]) > (1.0 - WORTH_ANOTHER) ** 2 * misfit(fewer):
            break
    return tried


def on_top_of_the_best(tried: Sequence[Candidate], order: Sequence[Candidate], workshop: Workshop) -> list[Candidate]:
    """Try one more effect on top of the best causes, and of what the best of all is without its first effect.

    Where the best two leave much, and little less than one, they are not tried without the first, nor in another order.

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
    for number, leader in enumerate(leaders):
        work = extensions([leader], known, single, SHORTLIST if number == 0 else SHORTLIST_FURTHER, workshop)
        work = called_on_slow(work, known)
        # Readings in coarse steps tell less: what is not alike may come as near.
        until = settles if not is_read_off(leader) else never
        for part in (local(work), wide(work)):
            known += try_all(still_called_for(part, known), workshop, what, until)
        if any(map(settles, known)):
            break
    if size == 2:
        known = with_better(known, try_all(left_alone(known), workshop, what))
        known = with_better(known, sharpen_all(ended_at_nothing(known), workshop))
    best = best_of(known, size)
    if (
        not best
        or not gains(best[0], as_tried(order[0], known))
        or settles(best[0])
        or (size == 2 and is_out_of_reach(known))
    ):
        return known
    without_first = set(best[0].effects[1:])
    rest = [each for each in known if set(each.effects) == without_first]
    rest = [each for each in rest if all(each.fit is not leader.fit for leader in leaders)]
    work = called_on_slow(extensions(rest, known, single, SHORTLIST_BACK, workshop), known)
    work = still_called_for(work, known)
    known += try_all(work, workshop, what)
    if size == 2:
        known = with_better(known, try_all(reversed_pairs(known, single), workshop, what))
    return known


def in_right_form(tried: Sequence[Candidate], workshop: Workshop) -> list[Candidate]:
    """Return what was tried, with what makes the stem jump of the best two effects beside the other in other forms."""
    alone = try_all(in_other_forms(tried), workshop, "effects in other forms")
    return with_pairs(tried, with_jumps(alone, tried), workshop)


def with_kindred(tried: Sequence[Candidate], workshop: Workshop, formed: Sequence[Candidate] = ()) -> list[Candidate]:
    """Return what was tried, with the best two effects exchanged for their aliases, searched for anew and about.

    Where these leave two effects out of reach nothing more is tried. What was tried in other forms already is not once
    more.
    """
    known, done = list(tried), set[frozenset[str]]()
    for _ in range(ALIAS_ROUNDS):
        work = [each for each in exchanged(known) if frozenset(each.effects) not in done]
        done |= {frozenset(each.effects) for each in work}
        known = with_pairs(known, work, workshop)
    if is_out_of_reach(known):
        return known
    led = leading_pair(known)
    for proposed in (on_what_stays, near_misses, from_the_best):
        known = with_pairs(known, proposed(known), workshop)
    again = worth_beginning_again(known)
    known = with_better(known, change_all(begin_again, again, workshop, "beginning again with"))
    known = with_better(known, each_in_turn(try_anew, worth_trying_anew(known), workshop))
    known = with_pairs(known, jumps_anew(known), workshop)
    known = with_pairs(known, other_laws(known), workshop)
    best = best_of(known, 2)[0]
    if all((each.effects, misfit(each)) != (best.effects, misfit(best)) for each in formed):
        known = in_right_form(known, workshop)
    known = exchanged_anew(known, led, workshop)
    for proposed in (nearly_together, from_numbers_of_the_best):
        known = with_pairs(known, proposed(known), workshop)
    for choice_of in (rivals_of_best, aliases_of_best):
        known = with_better(known, sharpen_all(blunt(choice_of(known), known[0]), workshop))
    return with_better(known, sharpen_all(short_of_noise(known), workshop))


def with_pairs(tried: Sequence[Candidate], work: Sequence[Work], workshop: Workshop) -> list[Candidate]:
    """Return what was tried, with pairs of effects that are tried now, each as it comes nearest."""
    return with_better(tried, try_all(work, workshop, "2 effects together"))


def leading_pair(tried: Sequence[Candidate]) -> frozenset[str]:
    """Return the best two effects."""
    return frozenset(best_of(tried, 2)[0].effects)


def exchanged_anew(tried: Sequence[Candidate], led: frozenset[str], workshop: Workshop) -> list[Candidate]:
    """Return what was tried, with the best two effects exchanged for their aliases if two others led until then."""
    work = exchanged(tried) if leading_pair(tried) != led else []
    return with_pairs(tried, work, workshop)


def worth_beginning_again(tried: Sequence[Candidate]) -> list[Candidate]:
    """Return the best causes of two effects whose fit moved the mass far off, unless one of two is at the noise.

    Where something explains the record only those that come about as near are.
    """
    if misfit(best_of(tried, 2)[0]) < AT_NOISE:
        return []
    near = rivals_of_best(tried) if any_explains(tried) else two_that_gain(tried)
    return [each for each in near[:BEGUN_AGAIN] if is_far_off(each.fit)]


def worth_trying_anew(tried: Sequence[Candidate]) -> list[Candidate]:
    """Return the best causes of two effects, if nothing explains the record, of which each is to be searched for again.

    The form that came nearest alone, while the other effect was left out, need not be the right one. What leaves much
    lacks more than a form.
    """
    if any_explains(tried):
        return []
    near = [each for each in two_that_gain(tried)[:LEADERS] if misfit(each) < LACKS_A_FORM * allowed(tried[0])]
    return [each for each in near if not (breaks_away(each) or has_read_off(each))]


def worth_a_look_back(tried: Sequence[Candidate], size: int) -> list[Candidate]:
    """Return the best causes of so many effects that are to be tried without each in turn, from where the others are.

    One of three may be none, and only have led the other two out of a side minimum; of two that is so where slips make
    the error jagged.
    """
    far = NO_GAIN * misfit(best_of(tried, size - 1)[0])
    return [
        each
        for each in best_of(tried, size)[:LOOKED_BACK]
        if misfit(each) < far
        and (size > 2 or (goes_in_jumps(each) and not each.has_series))
        and not any(effect_of_key(key).is_chaotic for key in each.effects)
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
