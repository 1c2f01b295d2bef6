"""Ending: whether what was tried explains a record, so that no more is looked for."""

from __future__ import annotations

from collections.abc import Sequence

from diagnosis.choosing.proposals import NO_GAIN, gains_by_both
from diagnosis.trying.candidates import Candidate
from diagnosis.trying.explaining import AT_NOISE, any_explains, explains, is_fitted, leaves_nothing_to_tell, misfit
from diagnosis.trying.standing import alone_of, best_of, is_read_off, stands_in
from valvemodel.effects import jumps


def is_explained(tried: Sequence[Candidate], size: int) -> bool:
    """Return whether what was tried leaves nothing for causes of so many effects to be looked for.

    One effect must come near the noise, where two of the right kind do by both, and be none that may stand in for
    anything; a third is looked for where two leave much.
    """
    if size > 2:
        return any_explains(tried, generous=True)
    base, *others = tried
    ends = [each for each in others if explains(each, base) and not stands_in(each)]
    alone = alone_of(tried)
    return explains(base, base) or any(
        gains_by_both(each, alone) if len(each.effects) > 1 else leaves_nothing_to_tell(each, tried) for each in ends
    )


def is_enough(candidate: Candidate, base: Candidate) -> bool:
    """Return whether a cause explains the record, and comes to the noise if it may stand in for others.

    Coarse readings tell little of what was kept back: by them alone it must leave but noise of what it was fitted to.
    """
    if is_read_off(candidate) and not is_fitted(candidate):
        return False
    return explains(candidate, base) and (misfit(candidate) < AT_NOISE or not stands_in(candidate))


def is_told(tried: Sequence[Candidate]) -> bool:
    """Return whether the nearest two effects explain the record by both, and neither may stand in for anything.

    At the noise none of few numbers can come nearer.
    """
    return do_explain(best_of(tried, 2)[:1], tried)


def do_explain(pairs: Sequence[Candidate], tried: Sequence[Candidate]) -> bool:
    """Return whether one of some pairs explains the record by both effects, and neither may stand in for anything."""
    alone = alone_of(tried)
    return any(is_enough(each, tried[0]) and gains_by_both(each, alone) for each in pairs)


def gains(candidate: Candidate, other: Candidate) -> bool:
    """Return whether a cause leaves less beyond the noise than another of fewer effects."""
    return misfit(candidate) - 1.0 <= NO_GAIN * max(misfit(other) - 1.0, 0.0)


def goes_in_jumps(candidate: Candidate) -> bool:
    """Return whether the readings go in slips or in steps by a cause, so that small changes tell little."""
    return is_read_off(candidate) or jumps(candidate.effects)
