"""What the record cannot tell, what would, and what to do next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from diagnosis.report.amounts import is_number, percent, probability_text
from diagnosis.report.finding import WORTH_SAYING, found_cause, is_too_vague, is_undecided, own_stages
from diagnosis.report.naming import DECLARED, STAGE_PARTS, capitalised, cause_title, effect_title, listed
from diagnosis.report.place import CONCENTRATED
from diagnosis.report.where import leads_of
from diagnosis.whereabouts.curve import AT_REST, BREAKAWAY, PLAIN

_TELLING = 0.5
"""Difference of two rivals over the noise, root mean square, from which an experiment tells them apart."""
_HARDLY_VISIBLE = 1.0
"""Trace of an effect of typical size over the noise below which it is said to hardly show."""


@dataclass(frozen=True)
class Alternative:
    """What the record cannot tell from the cause, and what would."""

    title: str
    told_apart_by: tuple[str, ...]


def alternatives_of(diagnosis: Mapping[str, Any]) -> tuple[Alternative, ...]:
    """Return what the record cannot tell from the cause, those that the same would tell as one."""
    if diagnosis["verdict"] == "unknown":
        return ()
    own, rivals = _apart(diagnosis)
    titles: dict[tuple[str, ...], list[str]] = {}
    for rival in rivals:
        titles.setdefault(_ways(own, rival), []).append(_rival_title(rival))
    return tuple(Alternative(listed(names, "or"), ways) for ways, names in titles.items())


def _apart(diagnosis: Mapping[str, Any]) -> tuple[list[str], list[list[str]]]:
    """Return the effects of the cause and of each that looks the same, without those that all of them have."""
    found = found_cause(diagnosis)
    sets = [list(found["effects"]), *map(list, found.get("indistinguishable_from") or ())]
    common = set.intersection(*map(set, sets))
    own, *rivals = [[key for key in each if key not in common] or each for each in sets]
    return own, rivals


def _rival_title(rival: Sequence[str]) -> str:
    return cause_title(rival) if rival else "the base model with other parameters"


def _ways(own: Sequence[str], rival: Sequence[str]) -> tuple[str, ...]:
    """Return what tells two sets apart by the declarations: the rival's that name the cause, else the cause's."""
    for one, other in ((rival, own), (own, rival)):
        declared = [DECLARED[key] for key in one if key not in other and key in DECLARED]
        naming = [each for each in declared if set(each.aliases) & set(other or ["none"])]
        ways = [_bracketed(each.told_apart_by) for each in naming or declared if each.told_apart_by]
        if ways:
            return tuple(dict.fromkeys(ways))
    return ()


def _bracketed(text: str) -> str:
    """Put the reason after a colon in brackets, so that the text can stand inside a sentence."""
    head, colon, tail = text.partition(": ")
    return f"{head} ({tail})" if colon else head


def alternatives_sentence(diagnosis: Mapping[str, Any]) -> str:
    """Name what the record cannot tell from the cause, or say that there is nothing."""
    if diagnosis["verdict"] == "unknown":
        return "Which effect it is: none of the listed ones fits well enough to be named."
    if is_too_vague(diagnosis):
        return "Whether an effect hides in what the record does not say of the current."
    own, others = _apart(diagnosis)
    subject, rivals = cause_title(own), [_rival_title(other) for other in others]
    if not rivals:
        if diagnosis["verdict"] == "none":
            return "No listed effect could hide behind the base model's own parameters in this record."
        return f"No other listed effect would leave the same trace in this record as {subject}."
    names = listed(rivals, "or")
    if diagnosis["verdict"] == "none":
        return f"This record cannot exclude {names}: it would look like other base parameters."
    return f"This record cannot tell {subject} from {names}."


def hiding_sentence(diagnosis: Mapping[str, Any]) -> str:
    """Name what may be in the valve beside the cause without a trace in the record; empty where nothing may."""
    hiding = found_cause(diagnosis).get("may_hide_beside") or ()
    if diagnosis["verdict"] != "effect" or not hiding:
        return ""
    names = capitalised(listed([effect_title(key) for key in hiding], "or"))
    return f"{names} may be there as well: the record would look the same."


def others_of(diagnosis: Mapping[str, Any]) -> str:
    """Name the other causes that are worth saying."""
    found = found_cause(diagnosis)
    told = [frozenset(each) for each in found.get("indistinguishable_from") or ()]
    others = [
        f"{cause_title(cause['effects'])} ({probability_text(cause['probability'])})"
        for cause in diagnosis.get("causes") or ()
        if cause is not found
        and frozenset(cause["effects"]) not in told
        and (cause.get("probability") or 0.0) >= WORTH_SAYING
    ]
    unknown = diagnosis.get("unknown_probability")
    if diagnosis["verdict"] != "unknown" and is_number(unknown) and unknown >= WORTH_SAYING:
        others.append(f"none of the listed effects ({probability_text(unknown)})")
    return f"Less likely, but not excluded: {listed(others)}." if others else ""


def input_shows_of(diagnosis: Mapping[str, Any]) -> tuple[str, ...]:
    """Say what the input of the records can show, whatever is in the valve."""
    content = diagnosis.get("confusability")
    if not content:
        return ()
    keys, alike = content["effects"], content["alike_from"]
    hidden = [
        effect_title(key) for key, visible in zip(keys, content["visibility"], strict=True) if visible < _HARDLY_VISIBLE
    ]
    pairs = [
        f"{effect_title(other)} for {effect_title(key)}"
        for key, row in zip(keys, content["similarity"], strict=True)
        for other, cosine in zip(keys, row, strict=True)
        if key != other and is_number(cosine) and cosine >= alike
    ]
    sentences = []
    if hidden:
        sentences.append(f"Under this input, {listed(hidden)} of typical size would hardly rise above the noise.")
    if pairs:
        sentences.append(f"One would pass for another, whatever is in the valve: {listed(pairs)}.")
    return tuple(sentences) or ("Under this input every listed effect of typical size leaves a trace of its own.",)


def designed_of(diagnosis: Mapping[str, Any]) -> str:
    """Say what the designed experiment would tell apart and how far, or that only another signal would."""
    designed = diagnosis.get("next_experiment")
    if not designed:
        return ""
    names = [cause_title(each) for each in designed["rivals"]]
    rivals = listed(names)
    purpose = f"To tell {rivals} apart" if designed["is_open"] else f"To confirm {names[0]} against {names[1]}"
    separation = {name: value for name, value in designed["separation"].items() if is_number(value)}
    profile, gauge = separation["profile"], separation.get("pressure_now", 0.0)
    both = separation.get("profile_and_pressure", 0.0)
    now = separation["now"]
    if now >= max(profile, _TELLING):
        return (
            f"{purpose}, no current profile within the limits tells more than the record that is there: refitted, they "
            f"differ by {now:.2g} times the noise in it, by {profile:.2g} times under the best profile "
            f"({designed['file']}). Allow a longer or a faster one (--next-duration, --next-rate)."
        )
    if profile >= _TELLING:
        return (
            f"{purpose}, record the current profile in {designed['file']}: refitted, they would differ by "
            f"{profile:.2g} times the noise (in the record that is there by {now:.2g})."
        )
    if gauge >= _TELLING:
        return (
            f"{purpose}, measure the pressure: under the same input they would then differ by {gauge:.2g} times the "
            f"noise. Without it no current profile within the limits tells them apart ({designed['file']} is the best)."
        )
    if both >= _TELLING:
        return (
            f"{purpose}, record the current profile in {designed['file']} and measure the pressure: refitted, they "
            f"would differ by {both:.2g} times the noise."
        )
    nor = ", nor does a measured pressure" if "pressure_now" in separation else ""
    return (
        f"No current profile within the limits tells {rivals} apart{nor}: refitted, they would differ by "
        f"{max(profile, gauge, both):.1g} times the noise at most ({designed['file']} is the best)."
    )


def depends_of(diagnosis: Mapping[str, Any]) -> tuple[str, ...]:
    """Say for each signal what its residual depends on most; the curves of a signal stand best first."""
    curves = [curve for curve in diagnosis.get("residual_curves") or () if not curve.get("is_lead")]
    best = {curve["signal"]: curve for curve in reversed(curves)}
    return tuple(
        f"What is left of the {signal} depends most on {best[signal]['against']}: a curve over it explains "
        f"{percent(best[signal]['share'])} of it."
        for signal in reversed(best)
        if best[signal]["share"] >= CONCENTRATED
    )


def breaking_away(diagnosis: Mapping[str, Any]) -> str:
    """Say what the force of breaking away depends on, if that is plain and the gap has a cause or is the stem's."""
    curves = [curve for curve in diagnosis.get("residual_curves") or () if curve["signal"] == BREAKAWAY]
    is_elsewhere = diagnosis["verdict"] == "unknown" and (diagnosis.get("where") or {}).get("stage") != "stem"
    if not curves or curves[0]["share"] < PLAIN or is_elsewhere:
        return ""
    against, share = curves[0]["against"], percent(curves[0]["share"])
    meant = ", as of friction that grows while the stem rests" if against == AT_REST else ""
    return f"The force at which the stem breaks away depends on the {against}, which explains {share} of it{meant}."


def next_step_of(diagnosis: Mapping[str, Any], alternatives: tuple[Alternative, ...]) -> str:
    """Say what to do with the answer, and then how to settle what it leaves open."""
    verdict, designed = diagnosis["verdict"], designed_of(diagnosis)
    if is_too_vague(diagnosis):
        return "Log the current as it is set and faster, or settled positions at held currents, and diagnose that."
    if is_undecided(diagnosis):
        return f"A second record of the valve, with slower and faster strokes, decides it. {designed}".rstrip()
    if verdict == "none":
        later = designed or "Look for effects again only where a new record shows a gap."
        return f"Use the refitted model (base.json). {later}"
    if verdict == "unknown":
        return f"{_look(diagnosis)} {designed}".rstrip()
    ways = dict.fromkeys(each.told_apart_by[0] for each in alternatives if each.told_apart_by)
    if alternatives and (designed or ways):
        settle = designed or f"To settle which: {'; for the others '.join(list(ways)[:2])}."
        return f"{settle} Until then use the found model (model.json) with care."
    stages = [f"the {stage}" for stage in own_stages(diagnosis)] or [_stage_in_words(diagnosis)]
    cause = found_cause(diagnosis)
    look = f"Inspect {listed(stages)} for {cause_title(cause['effects'])}"
    if _is_of_this_record(cause):
        later = "The load that was found is that of this record alone: the model (model.json) foretells no other's."
        return f"{look}. {later} {designed}".rstrip()
    confirmed = f"{breaking_away(diagnosis)} {designed or 'A second record of the same valve confirms it.'}".lstrip()
    return f"{look}, and use the found model (model.json) in place of the base. {confirmed}"


def _is_of_this_record(cause: Mapping[str, Any]) -> bool:
    """Return whether a cause is a load that varies at will, which no other record repeats."""
    load = (cause.get("parameters") or {}).get("load_force") or {}
    return bool((load.get("load_waves") or {}).get("value", 1.0) > 1.0)


def _look(diagnosis: Mapping[str, Any]) -> str:
    """Say where to look for a cause that has no name."""
    measured = "" if "pressure" in (diagnosis.get("signals") or ()) else "the actuator pressure measured and with "
    look = f"Look at {_stage_in_words(diagnosis)}{_lead(diagnosis)}, and in the report at what the models leave"
    lead = breaking_away(diagnosis) or "When and where it is large is the lead."
    return f"{look}. {lead} A second record, with {measured}slower and faster strokes, narrows it down."


def _lead(diagnosis: Mapping[str, Any]) -> str:
    """Say what of the named stage's own signals explains much by itself."""
    where = diagnosis.get("where") or {}
    what, share = leads_of(where).get(where.get("stage", ""), ("", 0.0))
    return f" for {what}, which alone would close {percent(share)} of the squared gap" if what else ""


def _stage_in_words(diagnosis: Mapping[str, Any]) -> str:
    stage = (diagnosis.get("where") or {}).get("stage")
    return f"the {stage} ({STAGE_PARTS[stage]})" if stage in STAGE_PARTS else "the stage named above"
