"""How far a cause is from unseen data, and whether that leaves something to explain."""

from __future__ import annotations

from collections.abc import Sequence

from diagnosis.trying.candidates import Candidate
from identification.fit import Fit
from identification.stick_slip.staircase import stops_on_the_way

GOOD_ENOUGH = 1.3
"""Mean weighted square up to which what is left is below notice."""

FORM_SHARE = 0.05
"""Share of the base's error, in root mean square, that the right effect may leave for another form than ours."""

AT_NOISE = 1.05
"""Mean weighted square up to which nothing else can come nearer."""

FITTED = 1.03
"""Error of what was fitted, over that of noise, up to which no search from elsewhere can come nearer."""

WORTH_ONE, WORTH_MORE = 1.1, 1.06
"""Mean weighted square, over the noise or the least that anything left, up to which no effect is told from none, and
none more from what leaves it: it gains less likelihood than that effect and its number cost."""

GENEROUS = 4.0
"""Factor by which a cause may leave more, in square, for what is left to be little: a third effect is not looked for
beside two, and beside one what comes close to none is."""

LEAST_STOPS = 10
"""Rests of the stem on its way from which effects that can show so are looked for first."""


def misfit(candidate: Candidate) -> float:
    """Return how far a cause is from unseen data: 1 where the noise is reached."""
    return candidate.score.misfit


def explains(candidate: Candidate, base: Candidate, *, generous: bool = False) -> bool:
    """Return whether a cause leaves so little that no further effect is looked for.

    What is left is below notice, beside a small part of what the base left: as much as the right effect leaves when it
    has another form than ours; several effects, judged generously, leave more. A series of waves has no other form.
    """
    if candidate.has_series:
        return misfit(candidate) < AT_NOISE
    return leaves_little(candidate, base, generous=generous)


def leaves_little(candidate: Candidate, base: Candidate, *, generous: bool = False) -> bool:
    """Return whether a cause leaves as little as the right one in another form, whatever it is."""
    return misfit(candidate) < allowed(base, GENEROUS if generous else 1.0)


def allowed(base: Candidate, factor: float = 1.0) -> float:
    """Return the misfit below which a cause explains what a base leaves; a factor on what is allowed beyond noise."""
    return 1.0 + factor * (GOOD_ENOUGH - 1.0 + FORM_SHARE**2 * max(misfit(base) - 1.0, 0.0))


def nearly_explains(candidate: Candidate, base: Candidate) -> bool:
    """Return whether a cause leaves little, but some: it may be the right one in a side minimum.

    There it leaves some of what it was fitted to as well.
    """
    return misfit(candidate) >= AT_NOISE and not is_fitted(candidate) and explains(candidate, base, generous=True)


def is_fitted(candidate: Candidate) -> bool:
    """Return whether a cause leaves but noise of what it was fitted to: no search from elsewhere comes nearer."""
    return left_of_fitted(candidate) < FITTED


def left_of_fitted(candidate: Candidate) -> float:
    """Return how far a cause is from what it was fitted to: 1 where the noise is reached."""
    return candidate.fit.found.error / candidate.fit.problem.noise_error


def leaves_nothing_to_tell(candidate: Candidate, tried: Sequence[Candidate]) -> bool:
    """Return whether a cause leaves so little that nothing with one more effect could be told from it."""
    return misfit(candidate) < (WORTH_MORE if candidate.effects else WORTH_ONE) * min(1.0, *map(misfit, tried))


def any_explains(tried: Sequence[Candidate], *, generous: bool = False) -> bool:
    """Return whether one of the causes that were tried, the base first, explains a record."""
    return any(explains(each, tried[0], generous=generous) for each in tried)


def in_stairs(fit: Fit) -> bool:
    """Return whether a fit is to a record that is taken for one in which the stem goes in stairs."""
    return any(each.has_stairs for each in fit.problem.experiments)


def stops_seen(fit: Fit) -> bool:
    """Return whether the measured stem rests again and again where a fit's keeps moving, or goes in stairs."""
    if in_stairs(fit):
        return True
    stops = [stops_on_the_way(each, fit.simulated_on(each).position[0]) for each in fit.problem.experiments]
    return max(stops) >= LEAST_STOPS
