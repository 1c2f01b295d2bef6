"""Where the gap lies: in which stages of the chain, and in which regimes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from diagnosis.report.amounts import amount, is_number, percent, probability_text
from diagnosis.report.finding import SURE, found_cause, own_stages
from diagnosis.report.naming import DECLARED, STAGE_PARTS, capitalised, listed
from valvemodel.declarations import STAGES

CONCENTRATED = 0.1
"""A regime is worth a sentence where its share of the gap exceeds its share of the time by this."""


@dataclass(frozen=True)
class StageWords:
    """One stage of the chain with the probability that the cause lies there."""

    name: str
    parts: str
    probability: float
    probability_text: str
    is_found: bool


def where_of(diagnosis: Mapping[str, Any]) -> tuple[str, ...]:
    where = diagnosis.get("where") or {}
    sentences = []
    likely = [each for each in stages_of(diagnosis) if each.probability >= 0.1]
    likely.sort(key=lambda each: -each.probability)
    if diagnosis["verdict"] == "none":
        sentences.append("In none of the stages.")
    elif len(own_stages(diagnosis)) > 1:
        parts = [f"the {stage} ({STAGE_PARTS[stage]})" for stage in own_stages(diagnosis)]
        sentences.append(f"The effects lie in {listed(parts)}.")
    elif likely and likely[0].probability >= SURE:
        sentences.append(f"In the {likely[0].name} ({likely[0].parts}), probability {likely[0].probability_text}.")
    elif likely:
        names = [f"the {each.name} ({each.probability_text})" for each in likely]
        sentences.append(f"Most likely in {listed(names, 'or')}.")
        if diagnosis["verdict"] == "unknown":
            also = " and by what the signals of each stage explain" if where.get("own_signals") else ""
            sentences.append(f"That is judged by which effects come nearest to it{also}.")
    elif where.get("stage"):
        stage = where["stage"]
        sentences.append(f"In the {stage} ({STAGE_PARTS.get(stage, stage)}).")
    else:
        sentences.append("The record does not say in which stage.")
    found = found_cause(diagnosis)
    if diagnosis["verdict"] == "effect":
        own = set(own_stages(diagnosis))
        rivals = {
            DECLARED[key].stage for each in found.get("indistinguishable_from") or () for key in each if key in DECLARED
        }
        if rivals - own and (len(likely) < 2 or len(own) > 1):
            elsewhere = listed([f"the {stage}" for stage in STAGES if stage in rivals - own], "or")
            sentences.append(f"An effect that looks the same here would lie in {elsewhere}.")
    untried = [
        f"{DECLARED[key].title} (in the {DECLARED[key].stage})" for key in diagnosis.get("untried_aliases") or ()
    ]
    if untried:
        sentences.append(f"Not among the candidates, but alike in such a record: {listed(untried, 'or')}.")
    worst = max(where.get("regimes") or (), key=_beyond_its_time, default=None)
    if worst and diagnosis["verdict"] != "none" and _beyond_its_time(worst) > CONCENTRATED:
        words = worst.get("where") or worst.get("name")
        time = worst.get("time_share")
        spent = f", which is {percent(time)} of the record" if is_number(time) else ""
        sentences.append(f"{capitalised(percent(worst['share']))} of the gap arises {words}{spent}.")
    return tuple(sentences)


def _beyond_its_time(regime: Mapping[str, Any]) -> float:
    """Return by how much a regime's share of the gap exceeds its share of the time."""
    return float(regime.get("share") or 0.0) - float(regime.get("time_share") or 0.0)


def stages_of(diagnosis: Mapping[str, Any]) -> tuple[StageWords, ...]:
    where = diagnosis.get("where") or {}
    own = own_stages(diagnosis)
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


def regimes_of(diagnosis: Mapping[str, Any]) -> tuple[tuple[str, str, str, str], ...]:
    regimes = (diagnosis.get("where") or {}).get("regimes") or ()
    unit = (diagnosis.get("gap") or {}).get("unit", "m")
    all_rms = [each.get("rms") for each in regimes]
    return tuple(
        (
            str(each.get("name") or "").replace("_", " "),
            str(each.get("where") or ""),
            amount(each.get("rms"), unit, like=all_rms),
            percent(each.get("share")),
        )
        for each in regimes
    )
