"""Rivals: which causes of two effects may come as near as the best two."""

from __future__ import annotations

from collections.abc import Sequence

from diagnosis.choosing.proposals import gains_by_both
from diagnosis.judging.judgement import is_felt
from diagnosis.trying.candidates import Candidate
from diagnosis.trying.explaining import any_explains, explains, is_fitted, misfit
from diagnosis.trying.standing import alone_of, best_of, is_blunt, is_quick
from valvemodel.effects import differ_by_aliases

ALIASES_BEHIND = 4.0
"""Squared error over that of the best two effects from which others are not searched about: of fourteen in blind plants
of our own that began 1.1 to 5.5 times as far none came as near, one by a factor of 3.3, the others of two at most."""

RIVALS_BEHIND = 1.5
"""The same where the best two explain the record: what is to be a rival must come as near."""

SHORT_OF_NOISE = 3
"""Rivals of the best two effects that are searched about though they explain the record, at most."""


def two_that_gain(tried: Sequence[Candidate]) -> list[Candidate]:
    """Return the causes of two effects that leave less, by a tenth, than either of these alone, the best first."""
    alone = alone_of(tried)
    return [each for each in best_of(tried, 2) if gains_by_both(each, alone)]


def rivals_of_best(tried: Sequence[Candidate]) -> list[Candidate]:
    """Return the causes of two effects that gain by both and may come as near as the best one, that included."""
    best = best_of(tried, 2)[0]
    behind = RIVALS_BEHIND if explains(best, tried[0]) else ALIASES_BEHIND
    return [each for each in two_that_gain(tried) if misfit(each) < behind * misfit(best)]


def short_of_noise(tried: Sequence[Candidate]) -> list[Candidate]:
    """Return the rivals of the best two effects, that included, of which one makes the stem jump, that end too early.

    They explain the record, but leave some of what they were fitted to: another may come nearer there only because the
    error is jagged.
    """
    if not best_of(tried, 2):
        return []
    near = [each for each in rivals_of_best(tried) if is_blunt(each) and explains(each, tried[0])]
    return [each for each in near if not (is_fitted(each) or each.is_sharpened)][:SHORT_OF_NOISE]


def ended_at_nothing(tried: Sequence[Candidate]) -> list[Candidate]:
    """Return what makes the stem jump beside the best alone, if the search for it ended where it changes nothing.

    Where a record shows but few slips a look from afar promises none: a search about that end finds them.
    """
    if any_explains(tried):
        return []
    best = [each for each in best_of(tried, 1) if is_quick(each.effects[0]) and not each.has_series][:1]
    return [
        pair
        for each in best
        for pair in best_of(tried, 2)
        if is_blunt(pair) and not (pair.is_sharpened or is_felt(pair)) and set(each.effects) < set(pair.effects)
    ]


def aliases_of_best(tried: Sequence[Candidate]) -> list[Candidate]:
    """Return those of the best two effects' rivals that differ from it by an alias."""
    best = best_of(tried, 2)[0]
    return [each for each in rivals_of_best(tried) if differ_by_aliases(each.effects, best.effects)]
