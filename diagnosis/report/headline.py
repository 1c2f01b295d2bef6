"""What is missing and how sure that is: the headline, its tag and the sentences under it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from diagnosis.report.amounts import amount, is_number, probability_text
from diagnosis.report.finding import (
    LIKELY,
    SURE,
    family_probability,
    found_cause,
    is_too_vague,
    is_undecided,
    lacks_readings,
)
from diagnosis.report.naming import DECLARED, capitalised, cause_title, likelihood, listed

_EXPLAINED = 3
"""Effects that are explained under the headline; more would hide the answer."""


def headline_of(diagnosis: Mapping[str, Any]) -> str:
    """Return the answer in one sentence."""
    verdict = diagnosis["verdict"]
    if verdict == "unknown":
        return "Something is missing from the model that none of the known effects explains."
    probability = family_probability(diagnosis)
    if verdict == "none":
        if is_too_vague(diagnosis):
            return "The record says too little of the current to show whether the model lacks anything."
        if is_undecided(diagnosis):
            return "The record does not decide whether the model lacks anything."
        if probability is not None and probability < SURE:
            return "The model most likely lacks nothing: refitted, it explains this record."
        return "The model lacks nothing: refitted, it explains this record."
    found = found_cause(diagnosis)
    rivals = [each for each in found.get("indistinguishable_from") or () if each]
    name = _family_title(found["effects"], rivals)
    if [] in [list(each) for each in found.get("indistinguishable_from") or ()]:
        return f"The model may lack {name}, but other base parameters explain this record as well."
    if probability is None or probability < LIKELY:
        return f"The model lacks something; the best guess is {name}."
    sure = "" if probability >= SURE else "most likely "
    return f"The model {sure}lacks {name}."


def _family_title(own: Sequence[str], rivals: Sequence[Sequence[str]]) -> str:
    """Name a cause with those that look the same, their common effects once."""
    if not rivals:
        return cause_title(own)
    common = [key for key in own if all(key in rival for rival in rivals)]
    rests = [[key for key in each if key not in common] for each in (own, *rivals)]
    if len(rests) > 4 or not all(rests):
        return f"{cause_title(own)}, or an effect that looks the same in this record"
    either = listed([cause_title(rest) for rest in rests], "or")
    return f"{cause_title(common)} and either {either}" if common else either


def tag_of(diagnosis: Mapping[str, Any]) -> str:
    """Return the kind of answer in two or three words."""
    if is_too_vague(diagnosis) or is_undecided(diagnosis):
        return "Cannot tell"
    if diagnosis["verdict"] != "effect":
        return {"none": "No effect missing", "unknown": "Cause unknown"}.get(diagnosis["verdict"], "")
    probability = family_probability(diagnosis) or 0.0
    if probability >= SURE:
        return "Cause found"
    return "Likely cause" if probability >= LIKELY else "Possible cause"


def explanation_of(diagnosis: Mapping[str, Any]) -> str:
    """Say what the effects that the headline names are."""
    if diagnosis["verdict"] == "none":
        if lacks_readings(diagnosis):
            return (
                f"{100.0 * diagnosis['gap']['left_out']:.0f} % of the readings are left out, as they hang on how the "
                "current went on between the rows: any effect that shows itself only there, right after the current "
                "moves, goes unseen."
            )
        if is_too_vague(diagnosis):
            return (
                "What the record does not say of the current moves the stem by about "
                f"{amount(diagnosis['gap']['sampling_error'], 'm')}: any effect smaller than that goes unseen."
            )
        if is_undecided(diagnosis):
            return (
                "With its own parameters fitted anew, the base model comes near the noise of the record. Some effect "
                f"may be missing nevertheless; the nearest is {_nearest(diagnosis)}."
            )
        return (
            "With its own parameters fitted anew, the base model comes down to the noise of the record. "
            "No listed effect improves it enough to be believed."
        )
    found = found_cause(diagnosis)
    declared = [DECLARED[key] for key in found["effects"] if key in DECLARED]
    if diagnosis["verdict"] == "unknown":
        text = "A gap remains above the noise of the record, and no admissible set of listed effects closes it."
        if declared:
            nearest = cause_title(found["effects"])
            text += f" The nearest candidate is {nearest}, which is not good enough to be called the cause."
        return text
    named = dict.fromkeys(key for rival in found.get("indistinguishable_from") or () for key in rival)
    others = [DECLARED[key] for key in named if key in DECLARED and key not in found["effects"]]
    if len(declared) + len(others) <= _EXPLAINED:
        declared += others
    return " ".join(f"{capitalised(each.title)} – {each.meaning}." for each in declared)


def _nearest(diagnosis: Mapping[str, Any]) -> str:
    """Name the most probable cause that is not none."""
    causes = [cause for cause in diagnosis.get("causes") or () if cause["effects"] and is_number(cause["probability"])]
    best = max(causes, key=lambda cause: float(cause["probability"]), default=None)
    return cause_title(best["effects"]) if best else "none of the listed ones"


def confidence_of(diagnosis: Mapping[str, Any]) -> str:
    """Say how sure the answer is."""
    found = found_cause(diagnosis)
    if diagnosis["verdict"] == "unknown":
        probability = diagnosis.get("unknown_probability")
        subject = "That the cause is not among the listed effects"
    else:
        probability = found.get("probability")
        subject = "This" if diagnosis["verdict"] == "effect" else "That nothing is missing"
        if is_too_vague(diagnosis):
            subject += ", beside what goes unseen,"
    if probability is None or not is_number(probability):
        return ""
    family = family_probability(diagnosis) if diagnosis["verdict"] == "effect" else None
    whole = family or probability
    if whole - probability >= 0.005:
        subject = "That it is one of these"
    text = f"{subject} is {likelihood(whole)}: probability {probability_text(whole)}"
    if whole - probability >= 0.005:
        text += f" together, {probability_text(probability)} for {cause_title(found['effects'])} alone"
    return text + "."
