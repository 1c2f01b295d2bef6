"""The answer in the words of a valve engineer, made once; the page and the terminal only lay it out."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from diagnosis.report.amounts import (
    amount,
    amount_with_std,
    is_number,
    percent,
    percent_interval,
    probability_text,
)
from valvemodel.declarations import STAGES, Effect
from valvemodel.stages import EFFECTS

STAGE_PARTS = {
    "electromagnet": "coil, core and flapper",
    "nozzle": "air supply, nozzle and chamber",
    "stem": "diaphragm, spring, packing and stem",
    "sensor": "linkage and transmitter",
}
"""What a stage is made of, so that a reader knows where to go with a spanner."""

_CONCENTRATED = 0.1
"""A regime is worth a sentence where its share of the gap exceeds its share of the time by this."""

_SURE, _LIKELY = 0.9, 0.6
"""Probabilities from which a cause is named without reserve, and as the most likely one."""
_WORTH_SAYING = 0.05
"""Probability from which another cause is mentioned on the first screen."""
_SHOWN_CAUSES = 8
_TELLING = 0.5
"""Difference of two rivals over the noise, root mean square, from which an experiment tells them apart."""
_HARDLY_VISIBLE = 1.0
"""Trace of an effect of typical size over the noise below which it is said to hardly show."""
NO_BREAK_SPACE = "\u00a0"
_UNPRINTABLE = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff]")
_BEFORE_UNIT = re.compile(r"(?<=\d) (?=%|(?:[mµn]?[msNA]|k?Pa|kN)\b)")
_DECLARED = {effect.key: effect for effect in EFFECTS}


@dataclass(frozen=True)
class ParameterWords:
    """One parameter of an effect as found: `value` is text with unit and uncertainty."""

    name: str
    meaning: str
    value: str


@dataclass(frozen=True)
class EffectWords:
    """One effect of a cause: its declaration and the parameters found."""

    key: str
    title: str
    stage: str
    meaning: str
    equation: str
    source: str
    parameters: tuple[ParameterWords, ...]


@dataclass(frozen=True)
class CauseWords:
    """One row of the table of causes."""

    title: str
    stages: str
    probability: float
    probability_text: str
    gap_after: str
    closed: str
    closed_interval: str
    effects: tuple[EffectWords, ...]


@dataclass(frozen=True)
class Alternative:
    """What the record cannot tell from the cause, and what would."""

    title: str
    told_apart_by: tuple[str, ...]


@dataclass(frozen=True)
class StageWords:
    """One stage of the chain with the probability that the cause lies there."""

    name: str
    parts: str
    probability: float
    probability_text: str
    is_found: bool


@dataclass(frozen=True)
class Answer:
    """Everything that is said, in finished sentences."""

    verdict: str
    tag: str
    headline: str
    explanation: str
    confidence: str
    where: tuple[str, ...]
    stages: tuple[StageWords, ...]
    how_far: tuple[str, ...]
    gap_rows: tuple[tuple[str, str], ...]
    gap_measure: str
    closed: str
    closed_interval: str
    alternatives: tuple[Alternative, ...]
    alternatives_sentence: str
    others: str
    input_shows: tuple[str, ...]
    black_box: str
    designed: str
    depends: tuple[str, ...]
    next_step: str
    regimes: tuple[tuple[str, str, str, str], ...]
    causes: tuple[CauseWords, ...]
    causes_left_out: str
    judged: tuple[str, ...]
    warnings: tuple[str, ...]


def make_answer(diagnosis: Mapping[str, Any], more_warnings: Iterable[str] = ()) -> Answer:
    """Put a diagnosis, the content of `diagnosis.json`, into words."""
    verdict = diagnosis["verdict"]
    causes = [_cause_words(cause, diagnosis) for cause in diagnosis.get("causes") or ()]
    unknown = diagnosis.get("unknown_probability")
    if unknown is not None and is_number(unknown):
        causes.append(_unknown_words(unknown))
    causes.sort(key=lambda cause: -cause.probability)
    found = _found(diagnosis)
    alternatives = _alternatives(diagnosis)
    warnings = dict.fromkeys([*map(_plain, diagnosis.get("warnings") or ()), *more_warnings])
    shown = causes[:_SHOWN_CAUSES] + [each for each in causes[_SHOWN_CAUSES:] if each.probability >= 0.01]
    return Answer(
        verdict=verdict,
        tag=_tag(diagnosis),
        headline=_headline(diagnosis),
        explanation=_explanation(diagnosis),
        confidence=_confidence(diagnosis),
        where=_where(diagnosis),
        stages=_stages(diagnosis),
        how_far=_how_far(diagnosis),
        gap_rows=_gap_rows(diagnosis),
        gap_measure=f"Root mean square {_scored_on(diagnosis)}.",
        closed=capitalised(percent(found.get("gap_closed"))) if is_number(found.get("gap_closed")) else "",
        closed_interval=percent_interval(found.get("gap_closed_interval")),
        alternatives=alternatives,
        alternatives_sentence=_alternatives_sentence(diagnosis, alternatives),
        others=_others(diagnosis),
        input_shows=_input_shows(diagnosis),
        black_box=_black_box(diagnosis),
        designed=_designed(diagnosis),
        depends=_depends(diagnosis),
        next_step=diagnosis.get("next_step") or _designed(diagnosis) or _next_step(diagnosis, alternatives),
        regimes=_regimes(diagnosis),
        causes=tuple(shown),
        causes_left_out=_left_out(len(causes) - len(shown)),
        judged=_judged(diagnosis),
        warnings=tuple(warnings),
    )


def effect_title(key: str) -> str:
    """Return the declared title of an effect, or its key in words where it is not declared."""
    return _DECLARED[key].title if key in _DECLARED else key.replace("_", " ")


def cause_title(effects: Sequence[str]) -> str:
    """Name a set of effects; the empty set is the base alone."""
    return listed([effect_title(key) for key in effects]) if effects else "the base model alone"


def likelihood(probability: float) -> str:
    """Return the word for a probability."""
    for bound, word in ((0.99, "almost certain"), (0.9, "very likely"), (0.7, "likely")):
        if probability >= bound:
            return word
    if probability >= 0.5:
        return "more likely than not"
    return "possible" if probability >= 0.2 else "unlikely"


def listed(items: Sequence[str], word: str = "and") -> str:
    """Join items as in a sentence: "a, b and c"."""
    if len(items) < 2:
        return "".join(items)
    return f"{', '.join(items[:-1])} {word} {items[-1]}"


def capitalised(text: str) -> str:
    """Return the text with its first letter in upper case and the others as they are."""
    return text[:1].upper() + text[1:]


def tied(text: str) -> str:
    """Put a no-break space between each number and its unit."""
    return _BEFORE_UNIT.sub(NO_BREAK_SPACE, text)


def printable(text: str) -> str:
    """Replace what a file name may hold but no terminal and no UTF-8 file: controls, lone surrogates."""
    return _UNPRINTABLE.sub("\ufffd", text)


def _plain(warning: Any) -> str:
    if isinstance(warning, Mapping):
        return "; ".join(str(part) for part in warning.values() if part is not None)
    return str(warning)


def _found(diagnosis: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the cause that the verdict speaks of: the best one with effects, the base for `none`."""
    causes = diagnosis.get("causes") or ()
    wants_effects = diagnosis["verdict"] != "none"
    for cause in causes:
        if bool(cause["effects"]) == wants_effects:
            return cause
    return {"effects": [], "probability": None}


def _family_probability(diagnosis: Mapping[str, Any]) -> float | None:
    """Return the probability of the cause together with those that the record cannot tell from it."""
    found = _found(diagnosis)
    if not is_number(found.get("probability")):
        return None
    family = {frozenset(each) for each in found.get("indistinguishable_from") or ()}
    family.discard(frozenset(found["effects"]))
    others = (cause for cause in diagnosis.get("causes") or () if frozenset(cause["effects"]) in family)
    return min(1.0, found["probability"] + sum(each["probability"] or 0.0 for each in others))


def _headline(diagnosis: Mapping[str, Any]) -> str:
    verdict = diagnosis["verdict"]
    if verdict == "unknown":
        return "Something is missing from the model that none of the known effects explains."
    probability = _family_probability(diagnosis)
    if verdict == "none":
        if probability is not None and probability < _SURE:
            return "The model most likely lacks nothing: refitted, it explains this record."
        return "The model lacks nothing: refitted, it explains this record."
    found = _found(diagnosis)
    rivals = [each for each in found.get("indistinguishable_from") or () if each]
    name = _family_title(found["effects"], rivals)
    if [] in [list(each) for each in found.get("indistinguishable_from") or ()]:
        return f"The model may lack {name}, but other base parameters explain this record as well."
    if probability is None or probability < _LIKELY:
        return f"The model lacks something; the best guess is {name}."
    sure = "" if probability >= _SURE else "most likely "
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


def _tag(diagnosis: Mapping[str, Any]) -> str:
    if diagnosis["verdict"] != "effect":
        return {"none": "No effect missing", "unknown": "Cause unknown"}.get(diagnosis["verdict"], "")
    probability = _family_probability(diagnosis) or 0.0
    if probability >= _SURE:
        return "Cause found"
    return "Likely cause" if probability >= _LIKELY else "Possible cause"


def _explanation(diagnosis: Mapping[str, Any]) -> str:
    if diagnosis["verdict"] == "none":
        return (
            "With its own parameters fitted anew, the base model comes down to the noise of the record. "
            "No listed effect improves it enough to be believed."
        )
    declared = [_DECLARED[key] for key in _found(diagnosis)["effects"] if key in _DECLARED]
    if diagnosis["verdict"] == "unknown":
        text = "A gap remains above the noise of the record, and no admissible set of listed effects closes it."
        if declared:
            nearest = cause_title(_found(diagnosis)["effects"])
            text += f" The nearest candidate is {nearest}, which is not good enough to be called the cause."
        return text
    return " ".join(f"{capitalised(each.title)} – {each.meaning}." for each in declared)


def _confidence(diagnosis: Mapping[str, Any]) -> str:
    found = _found(diagnosis)
    if diagnosis["verdict"] == "unknown":
        probability = diagnosis.get("unknown_probability")
        subject = "That the cause is not among the listed effects"
    else:
        probability = found.get("probability")
        subject = "This" if diagnosis["verdict"] == "effect" else "That nothing is missing"
    if probability is None or not is_number(probability):
        return ""
    family = _family_probability(diagnosis) if diagnosis["verdict"] == "effect" else None
    whole = family or probability
    text = f"{subject} is {likelihood(whole)}: probability {probability_text(whole)}"
    if whole - probability >= 0.005:
        text += f", of which {probability_text(probability)} for {cause_title(found['effects'])}"
    return text + "."


def _where(diagnosis: Mapping[str, Any]) -> tuple[str, ...]:
    where = diagnosis.get("where") or {}
    sentences = []
    likely = [each for each in _stages(diagnosis) if each.probability >= 0.1]
    likely.sort(key=lambda each: -each.probability)
    if diagnosis["verdict"] == "none":
        sentences.append("In none of the stages.")
    elif len(_own_stages(diagnosis)) > 1:
        parts = [f"the {stage} ({STAGE_PARTS[stage]})" for stage in _own_stages(diagnosis)]
        sentences.append(f"The effects lie in {listed(parts)}.")
    elif likely and likely[0].probability >= _SURE:
        sentences.append(f"In the {likely[0].name} ({likely[0].parts}), probability {likely[0].probability_text}.")
    elif likely:
        names = [f"the {each.name} ({each.probability_text})" for each in likely]
        sentences.append(f"Most likely in {listed(names, 'or')}.")
    elif where.get("stage"):
        stage = where["stage"]
        sentences.append(f"In the {stage} ({STAGE_PARTS.get(stage, stage)}).")
    else:
        sentences.append("The record does not say in which stage.")
    found = _found(diagnosis)
    if diagnosis["verdict"] == "effect":
        own = set(_own_stages(diagnosis))
        rivals = {
            _DECLARED[key].stage
            for each in found.get("indistinguishable_from") or ()
            for key in each
            if key in _DECLARED
        }
        if rivals - own and (len(likely) < 2 or len(own) > 1):
            elsewhere = listed([f"the {stage}" for stage in STAGES if stage in rivals - own], "or")
            sentences.append(f"An effect that looks the same here would lie in {elsewhere}.")
    worst = max(where.get("regimes") or (), key=_beyond_its_time, default=None)
    if worst and diagnosis["verdict"] != "none" and _beyond_its_time(worst) > _CONCENTRATED:
        words = worst.get("where") or worst.get("name")
        time = worst.get("time_share")
        spent = f", which is {percent(time)} of the record" if is_number(time) else ""
        sentences.append(f"{capitalised(percent(worst['share']))} of the gap arises {words}{spent}.")
    return tuple(sentences)


def _beyond_its_time(regime: Mapping[str, Any]) -> float:
    """Return by how much a regime's share of the gap exceeds its share of the time."""
    return float(regime.get("share") or 0.0) - float(regime.get("time_share") or 0.0)


def _own_stages(diagnosis: Mapping[str, Any]) -> list[str]:
    """Return the stages of the effects found, in the order of the chain; none where no effect was found."""
    if diagnosis["verdict"] != "effect":
        return []
    own = {_DECLARED[key].stage for key in _found(diagnosis)["effects"] if key in _DECLARED}
    return [stage for stage in STAGES if stage in own]


def _stages(diagnosis: Mapping[str, Any]) -> tuple[StageWords, ...]:
    where = diagnosis.get("where") or {}
    own = _own_stages(diagnosis)
    given = where.get("stage_probability") or {}
    stages = []
    for name in STAGES:
        probability = given.get(name)
        share = float(probability) if probability is not None and is_number(probability) else 0.0
        stages.append(
            StageWords(
                name=name,
                parts=STAGE_PARTS[name],
                probability=share,
                probability_text=probability_text(probability) if is_number(probability) else "",
                is_found=name in (where.get("stage"), *own) or share >= 0.25,
            )
        )
    return tuple(stages)


def _gap_rows(diagnosis: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    gap = diagnosis.get("gap") or {}
    names = {"as_given": "as given", "refitted": "base parameters refitted"}
    if diagnosis["verdict"] == "effect":
        names["with_cause"] = f"with {cause_title(_found(diagnosis)['effects'])}"
    elif diagnosis["verdict"] == "unknown" and _found(diagnosis)["effects"]:
        names["with_cause"] = f"nearest candidate, {cause_title(_found(diagnosis)['effects'])}"
    names["noise_floor"] = "noise floor of the record"
    values = [gap.get(key) for key in names]
    return tuple(
        (name, amount(value, gap.get("unit", "m"), like=values[:1]))
        for name, value in zip(names.values(), values, strict=True)
        if is_number(value)
    )


def _how_far(diagnosis: Mapping[str, Any]) -> tuple[str, ...]:
    rows = dict(_gap_rows(diagnosis))
    found = _found(diagnosis)
    sentences = []
    if rows:
        sentences.append(f"Gap (rms, {_scored_on(diagnosis)}): {listed([f'{v} {k}' for k, v in rows.items()])}.")
    closed = found.get("gap_closed")
    if diagnosis["verdict"] == "none" or closed is None or not is_number(closed):
        return tuple(sentences)
    interval = percent_interval(found.get("gap_closed_interval"))
    interval = f" (95 % interval: {interval})" if interval else ""
    subject = "The cause closes" if diagnosis["verdict"] == "effect" else "The nearest candidate closes"
    if closed <= 0:
        sentences.append(f"{subject} nothing of the gap that could be closed{interval}.")
    else:
        sentences.append(f"{subject} {percent(closed)} of the gap that could be closed{interval}.")
    return tuple(sentences)


def _scored_on(diagnosis: Mapping[str, Any]) -> str:
    scored_on = (diagnosis.get("gap") or {}).get("scored_on")
    return f"on {scored_on}" if scored_on else "on data not used for fitting"


def _alternatives(diagnosis: Mapping[str, Any]) -> tuple[Alternative, ...]:
    found = _found(diagnosis)
    own = list(found["effects"])
    alternatives = []
    for rival in found.get("indistinguishable_from") or ():
        ways = [_bracketed(each.told_apart_by) for each in _tellers(own, list(rival)) if each.told_apart_by]
        title = cause_title(rival) if rival else "the base model with other parameters"
        alternatives.append(Alternative(title=title, told_apart_by=tuple(dict.fromkeys(ways))))
    return tuple(alternatives)


def _bracketed(text: str) -> str:
    """Put the reason after a colon in brackets, so that the text can stand inside a sentence."""
    head, colon, tail = text.partition(": ")
    return f"{head} ({tail})" if colon else head


def _tellers(own: list[str], rival: list[str]) -> list[Effect]:
    """Return the effects whose declarations tell the two sets apart; those that name the other, if any."""
    only_own = [_DECLARED[key] for key in own if key not in rival and key in _DECLARED]
    only_rival = [_DECLARED[key] for key in rival if key not in own and key in _DECLARED]
    naming = [each for each in only_own if set(each.aliases) & set(rival or ["none"])]
    naming += [each for each in only_rival if set(each.aliases) & set(own or ["none"])]
    return naming or only_own + only_rival


def _alternatives_sentence(diagnosis: Mapping[str, Any], alternatives: tuple[Alternative, ...]) -> str:
    if diagnosis["verdict"] == "unknown":
        return "Which effect it is: none of the listed ones fits well enough to be named."
    subject = "it" if diagnosis["verdict"] == "none" else cause_title(_found(diagnosis)["effects"])
    if not alternatives:
        if diagnosis["verdict"] == "none":
            return "No listed effect could hide behind the base model's own parameters in this record."
        return f"No other listed effect would leave the same trace in this record as {subject}."
    names = listed([each.title for each in alternatives], "or")
    if diagnosis["verdict"] == "none":
        return f"This record cannot exclude {names}: it would look like other base parameters."
    return f"This record cannot tell {subject} from {names}."


def _others(diagnosis: Mapping[str, Any]) -> str:
    found = _found(diagnosis)
    told = [frozenset(each) for each in found.get("indistinguishable_from") or ()]
    others = [
        f"{cause_title(cause['effects'])} ({probability_text(cause['probability'])})"
        for cause in diagnosis.get("causes") or ()
        if cause is not found
        and frozenset(cause["effects"]) not in told
        and (cause.get("probability") or 0.0) >= _WORTH_SAYING
    ]
    unknown = diagnosis.get("unknown_probability")
    if diagnosis["verdict"] != "unknown" and is_number(unknown) and unknown >= _WORTH_SAYING:
        others.append(f"none of the listed effects ({probability_text(unknown)})")
    return f"Less likely, but not excluded: {listed(others)}." if others else ""


def _input_shows(diagnosis: Mapping[str, Any]) -> tuple[str, ...]:
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


def _black_box(diagnosis: Mapping[str, Any]) -> str:
    """Say how much a correction without physics would close, as a yardstick for the cause."""
    closed = (diagnosis.get("ceiling") or {}).get("gap_closed")
    if diagnosis["verdict"] == "none" or not is_number(closed):
        return ""
    share = f"{percent(closed)} of what could be closed" if closed > 0.0 else "nothing"
    return f"A black box that knows no physics, taught on the same data, closes {share}."


def _designed(diagnosis: Mapping[str, Any]) -> str:
    """Say what the designed experiment would tell apart and how far, or that only another signal would."""
    designed = diagnosis.get("next_experiment")
    if not designed:
        return ""
    names = [cause_title(each) for each in designed["rivals"]]
    purpose = f"To tell {listed(names)} apart" if designed["is_open"] else f"To confirm {names[0]} against {names[1]}"
    separation = {name: value for name, value in designed["separation"].items() if is_number(value)}
    gauge = separation.get("pressure_now", 0.0)
    if separation["profile"] >= _TELLING or separation["profile"] >= gauge:
        hope = "" if separation["profile"] >= _TELLING else " Even that is little."
        return (
            f"{purpose}, record the current profile in {designed['file']}: refitted, they would differ by "
            f"{separation['profile']:.2g} times the noise (now {separation['now']:.2g}).{hope}"
        )
    return (
        f"{purpose}, measure the pressure: under the same input they would differ by {gauge:.2g} times the noise; "
        f"no current profile within the limits brings more than {separation['profile']:.2g} without it "
        f"({designed['file']} is the best)."
    )


def _depends(diagnosis: Mapping[str, Any]) -> tuple[str, ...]:
    """Say for each signal what its residual depends on most; the curves of a signal stand best first."""
    best = {curve["signal"]: curve for curve in reversed(diagnosis.get("residual_curves") or ())}
    return tuple(
        f"What is left of the {signal} depends most on {best[signal]['against']}: a curve over it explains "
        f"{percent(best[signal]['share'])} of it."
        for signal in reversed(best)
        if best[signal]["share"] >= _CONCENTRATED
    )


def _next_step(diagnosis: Mapping[str, Any], alternatives: tuple[Alternative, ...]) -> str:
    verdict, found = diagnosis["verdict"], _found(diagnosis)
    stage = (diagnosis.get("where") or {}).get("stage")
    parts = f"the {stage} ({STAGE_PARTS[stage]})" if stage in STAGE_PARTS else "the stage named above"
    if verdict == "none":
        return "Use the refitted model (base.json). Look for effects again only where a new record shows a gap."
    if verdict == "unknown":
        measured = "" if "pressure" in (diagnosis.get("signals") or ()) else "the actuator pressure measured and with "
        return (
            f"Look at {parts}, and in the report at what the models leave: when and where it is large is the "
            f"lead. A second record, with {measured}slower and faster strokes, narrows it down."
        )
    ways = dict.fromkeys(each.told_apart_by[0] for each in alternatives if each.told_apart_by)
    if ways:
        settle = "; for the others ".join(list(ways)[:2])
        return f"To settle which: {settle}. Until then use the found model (model.json) with care."
    check = listed([f"the {_DECLARED[key].stage}" for key in found["effects"] if key in _DECLARED][:1]) or parts
    return (
        f"Inspect {check} for {cause_title(found['effects'])}, and use the found model (model.json) "
        "in place of the base. A second record of the same valve confirms it."
    )


def _regimes(diagnosis: Mapping[str, Any]) -> tuple[tuple[str, str, str, str], ...]:
    regimes = (diagnosis.get("where") or {}).get("regimes") or ()
    unit = (diagnosis.get("gap") or {}).get("unit", "m")
    all_rms = [each.get("rms") for each in regimes]
    return tuple(
        (
            str(each.get("name") or ""),
            str(each.get("where") or ""),
            amount(each.get("rms"), unit, like=all_rms),
            percent(each.get("share")),
        )
        for each in regimes
    )


def _cause_words(cause: Mapping[str, Any], diagnosis: Mapping[str, Any]) -> CauseWords:
    gap = diagnosis.get("gap") or {}
    effects = tuple(_effect_words(key, (cause.get("parameters") or {}).get(key) or {}) for key in cause["effects"])
    closed = cause.get("gap_closed")
    return CauseWords(
        title=capitalised(cause_title(cause["effects"])) if effects else "No further effect: the base model alone",
        stages=listed(list(dict.fromkeys(effect.stage for effect in effects))) or "–",
        probability=min(1.0, max(0.0, cause.get("probability") or 0.0)),
        probability_text=probability_text(cause.get("probability")),
        gap_after=amount(cause.get("gap_after"), gap.get("unit", "m"), like=[gap.get("as_given")]),
        closed=percent(closed) if effects and is_number(closed) else "–",
        closed_interval=percent_interval(cause.get("gap_closed_interval")) if effects else "",
        effects=effects,
    )


def _unknown_words(probability: float) -> CauseWords:
    return CauseWords(
        title="Unknown: not among the listed effects",
        stages="–",
        probability=min(1.0, max(0.0, probability)),
        probability_text=probability_text(probability),
        gap_after="–",
        closed="–",
        closed_interval="",
        effects=(),
    )


def _effect_words(key: str, found: Mapping[str, Mapping[str, Any]]) -> EffectWords:
    effect = _DECLARED.get(key)
    meanings = {parameter.name: parameter.meaning for parameter in effect.parameters} if effect else {}
    order = [name for name in meanings if name in found] + [name for name in found if name not in meanings]
    return EffectWords(
        key=key,
        title=effect_title(key),
        stage=effect.stage if effect else "–",
        meaning=effect.meaning if effect else "",
        equation=effect.equation if effect else "",
        source=effect.source if effect else "",
        parameters=tuple(
            ParameterWords(
                name=name,
                meaning=meanings.get(name, ""),
                value=amount_with_std(found[name].get("value"), found[name].get("std"), found[name].get("unit", "1")),
            )
            for name in order
        ),
    )


def _left_out(count: int) -> str:
    if count <= 0:
        return ""
    return f"{count} more {'candidate' if count == 1 else 'candidates'}, each below 1 %, in diagnosis.json."


def _judged(diagnosis: Mapping[str, Any]) -> tuple[str, ...]:
    scored_on = (diagnosis.get("gap") or {}).get("scored_on")
    on = {
        "held-out blocks": "on blocks of the record that were kept out of every fit",
        "other records": "on other records of the same valve than those that were fitted",
    }.get(scored_on or "", f"on {scored_on}" if scored_on else "on data that were not used for fitting")
    return (
        f"Every gap is a root mean square {on}, so that a model with more freedom has no advantage.",
        "The gap that could be closed is that of the refitted base less the noise of the record. "
        "Intervals hold with 95 % probability; ± is one standard deviation.",
        "The probabilities compare the listed effects, their combinations, the base model alone (none) and "
        "a cause outside the list (unknown); they sum to 100 %.",
        *_controlled(diagnosis),
    )


def _controlled(diagnosis: Mapping[str, Any]) -> tuple[str, ...]:
    control = diagnosis.get("control")
    if not control:
        return ()
    return (
        f"As a control, {control['shams']} random regressors that cannot be in a valve were judged beside the effects: "
        f"together they would have got {probability_text(control['probability'])}.",
    )
