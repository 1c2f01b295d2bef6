"""The answer in the words of a valve engineer, made once; the page and the terminal only lay it out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from diagnosis.report.advice import (
    Alternative,
    alternatives_of,
    alternatives_sentence,
    depends_of,
    designed_of,
    hiding_sentence,
    input_shows_of,
    next_step_of,
    others_of,
)  # fmt: skip
from diagnosis.report.amounts import (
    amount,
    amount_with_std,
    closed_text,
    is_number,
    percent_interval,
    probability_text,
)
from diagnosis.report.base_numbers import NumberRow, number_rows, refit_sentence
from diagnosis.report.finding import WORTH_SAYING, found_cause
from diagnosis.report.headline import confidence_of, explanation_of, headline_of, tag_of
from diagnosis.report.naming import DECLARED, capitalised, cause_title, effect_title, listed
from diagnosis.report.place import StageWords, regimes_of, stages_of, where_of
from diagnosis.report.shrinking import black_box_of, closes_of, gap_rows_of, measure_of, re_anchored
from diagnosis.report.where import half_of_chain
from valvemodel.declarations import Effect, Parameter
from valvemodel.effects import HIGHER

_SHOWN_CAUSES = 8


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
class Answer:
    """Everything that is said, in finished sentences."""

    verdict: str
    tag: str
    headline: str
    explanation: str
    confidence: str
    where: tuple[str, ...]
    stages: tuple[StageWords, ...]
    closes: str
    gap_rows: tuple[tuple[str, str], ...]
    gap_measure: str
    refit: str
    base_numbers: tuple[NumberRow, ...]
    closed: str
    closed_interval: str
    alternatives: tuple[Alternative, ...]
    alternatives_sentence: str
    hiding: str
    others: str
    input_shows: tuple[str, ...]
    black_box: str
    designed: str
    depends: tuple[str, ...]
    next_step: str
    regimes: tuple[tuple[str, str, str, str], ...]
    causes: tuple[CauseWords, ...]
    causes_left_out: str
    told: tuple[tuple[EffectWords, str], ...]
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
    found = found_cause(diagnosis)
    alternatives = alternatives_of(diagnosis)
    warnings = dict.fromkeys([*map(_plain, diagnosis.get("warnings") or ()), *more_warnings])
    shown = causes[:_SHOWN_CAUSES] + [each for each in causes[_SHOWN_CAUSES:] if each.probability >= 0.01]
    return Answer(
        verdict=verdict,
        tag=tag_of(diagnosis),
        headline=headline_of(diagnosis),
        explanation=explanation_of(diagnosis),
        confidence=confidence_of(diagnosis),
        where=(*where_of(diagnosis), *half_of_chain(diagnosis)),
        stages=stages_of(diagnosis),
        closes=closes_of(diagnosis),
        gap_rows=gap_rows_of(diagnosis),
        gap_measure=measure_of(diagnosis),
        refit=refit_sentence(diagnosis),
        base_numbers=number_rows(diagnosis),
        closed=capitalised(closed_text(found.get("gap_closed"))) if is_number(found.get("gap_closed")) else "",
        closed_interval=percent_interval(found.get("gap_closed_interval")),
        alternatives=alternatives,
        alternatives_sentence=alternatives_sentence(diagnosis),
        hiding=hiding_sentence(diagnosis),
        others=others_of(diagnosis),
        input_shows=input_shows_of(diagnosis),
        black_box=black_box_of(diagnosis),
        designed=designed_of(diagnosis),
        depends=depends_of(diagnosis),
        next_step=next_step_of(diagnosis, alternatives),
        regimes=regimes_of(diagnosis),
        causes=tuple(shown),
        causes_left_out=_left_out(len(causes) - len(shown)),
        told=_told(causes, cause_title(found["effects"])),
        judged=_judged(diagnosis),
        warnings=tuple(warnings),
    )


def _plain(warning: Any) -> str:
    if isinstance(warning, Mapping):
        return "; ".join(str(part) for part in warning.values() if part is not None)
    return str(warning)


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
        closed=closed_text(closed) if effects and is_number(closed) else "–",
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
    effect = DECLARED.get(key)
    declared = {parameter.name: parameter for parameter in effect.shown} if effect else {}
    values = {name: each["value"] for name, each in found.items() if is_number(each.get("value"))}
    held = effect.held_at(values) if effect else frozenset()
    unknown = [name for name in found if name not in declared and name not in HIGHER]
    order = [name for name in declared if name in found and not _is_first_law(declared[name], found[name])] + unknown
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
                meaning=declared[name].meaning if name in declared else "",
                value=_value_words(found[name], _why_held(effect) if name in held else ""),
            )
            for name in order
        ),
    )


def _is_first_law(parameter: Parameter, found: Mapping[str, Any]) -> bool:
    """Return whether a parameter only says that an effect follows the law that it does where nothing is said."""
    return not parameter.is_fitted and found.get("value") == parameter.neutral


def _why_held(effect: Effect | None) -> str:
    """Say where the numbers of an effect that no fit moves come from."""
    return "read off the record" if effect is not None and effect.is_read_off else "chosen"


def _value_words(found: Mapping[str, Any], why_held: str) -> str:
    """Say what was found of a parameter; one that no fit moved has no uncertainty."""
    value, unit = found.get("value"), found.get("unit", "1")
    if why_held and is_number(value):
        return f"{value:g} ({why_held})" if unit == "1" else f"{amount(value, unit)} ({why_held})"
    return amount_with_std(value, found.get("std"), unit)


def _told(causes: Sequence[CauseWords], found: str) -> tuple[tuple[EffectWords, str], ...]:
    """Return the effects that are worth telling about, each once, with the title of the cause that it was found in."""
    told: dict[str, tuple[EffectWords, str]] = {}
    for cause in causes:
        if cause.probability >= WORTH_SAYING or cause.title == capitalised(found):
            for effect in cause.effects:
                told.setdefault(effect.key, (effect, cause.title if len(cause.effects) > 1 else ""))
    return tuple(told.values())


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
        *_measured(diagnosis),
        "The gap that could be closed is that of the refitted base less the noise of the record. "
        "Intervals hold with 95 % probability; ± is one standard deviation.",
        "The probabilities compare the listed effects, their combinations, the base model alone (none) and "
        "a cause outside the list (unknown); they sum to 100 %.",
        *_controlled(diagnosis),
    )


def _measured(diagnosis: Mapping[str, Any]) -> tuple[str, ...]:
    """Say how the models ran, where the diagnosis says it."""
    if not (diagnosis.get("gap") or {}).get("yardstick"):
        return ()
    anchored = re_anchored(diagnosis)
    if not anchored:
        return ("Each model ran freely from the start of the record under its current.",)
    return (f"Each model ran under the current of the record, {anchored}: slips that stick make a free run drift.",)


def _controlled(diagnosis: Mapping[str, Any]) -> tuple[str, ...]:
    control = diagnosis.get("control")
    if not control:
        return ()
    return (
        f"As a control, {control['shams']} random regressors that cannot be in a valve were judged beside the effects: "
        f"together they would have got {probability_text(control['probability'])}.",
    )
