"""What a diagnosis found: the cause that its verdict speaks of, with those that look the same."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from diagnosis.report.amounts import is_number
from diagnosis.report.naming import DECLARED
from valvemodel.declarations import STAGES

SURE, LIKELY = 0.9, 0.6
"""Probabilities from which a cause is named without reserve, and as the most likely one."""
MOST_OF_THE_NOISE = 0.7
"""Share of the noise, root mean square, above which something is most of it."""
MUCH_LEFT_OUT = 0.2
"""Share of the readings that are left out above which nothing is said to be missing only of what the others show."""
WORTH_SAYING = 0.05
"""Probability from which another cause is mentioned on the first screen."""


def found_cause(diagnosis: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the cause that the verdict speaks of: the best one with effects, the base for `none`."""
    causes = diagnosis.get("causes") or ()
    wants_effects = diagnosis["verdict"] != "none"
    for cause in causes:
        if bool(cause["effects"]) == wants_effects:
            return cause
    return {"effects": [], "probability": None}


def family_probability(diagnosis: Mapping[str, Any]) -> float | None:
    """Return the probability of the cause together with those that the record cannot tell from it."""
    found = found_cause(diagnosis)
    if not is_number(found.get("probability")):
        return None
    family = {frozenset(each) for each in found.get("indistinguishable_from") or ()}
    family.discard(frozenset(found["effects"]))
    others = (cause for cause in diagnosis.get("causes") or () if frozenset(cause["effects"]) in family)
    return min(1.0, found["probability"] + sum(each["probability"] or 0.0 for each in others))


def is_too_vague(diagnosis: Mapping[str, Any]) -> bool:
    """Return whether nothing is missing as far as a record shows whose current is not known well enough to show more.

    It has its noise mostly from that, or much of what was read hangs on how the current moved between its rows.
    """
    gap = diagnosis.get("gap") or {}
    missed, floor = gap.get("sampling_error"), gap.get("noise_floor")
    is_most = is_number(missed) and is_number(floor) and missed > MOST_OF_THE_NOISE * floor
    return diagnosis["verdict"] == "none" and (is_most or lacks_readings(diagnosis))


def lacks_readings(diagnosis: Mapping[str, Any]) -> bool:
    """Return whether much of what was read was left out, as it hangs on how the current moved between the rows."""
    left_out = (diagnosis.get("gap") or {}).get("left_out")
    return is_number(left_out) and left_out > MUCH_LEFT_OUT


def is_undecided(diagnosis: Mapping[str, Any]) -> bool:
    """Return whether that nothing is missing is the first of several answers of which none is likely."""
    probability = family_probability(diagnosis)
    return diagnosis["verdict"] == "none" and probability is not None and probability < LIKELY


def own_stages(diagnosis: Mapping[str, Any]) -> list[str]:
    """Return the stages of the effects found, in the order of the chain; none where no effect was found."""
    if diagnosis["verdict"] != "effect":
        return []
    own = {DECLARED[key].stage for key in found_cause(diagnosis)["effects"] if key in DECLARED}
    return [stage for stage in STAGES if stage in own]
