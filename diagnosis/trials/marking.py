"""Marks: how an answer compares with the truth, by the rule of the plant's kind."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from diagnosis.judging.stages import stages_of
from valvemodel.effects import are_aliases

MOST_DECLARED = 3
"""Causes, the first choice among them, up to which a set declared indistinguishable counts as an answer."""

MOST_STAGES = 2
"""Stages up to which a declared set of stages counts."""

CONFIDENT = 0.6
"""Probability from which the report names a cause as more than its best guess."""

OUTCOMES = {
    "right": "named right",
    "alias": "right in the set that it declares indistinguishable, or a stated alias of what was left out",
    "unknown": "says unknown",
    "none": "says none",
    "partly": "one of several effects right",
    "unsure": "another effect, as its best guess only",
    "wrong": "another effect",
    "false alarm": "an effect where there is none",
    "failed": "broke off",
}
"""What can come out, the best first, and what it means."""

Effects = tuple[str, ...]


@dataclass(frozen=True)
class Mark:
    """How one answer compares with the truth.

    Attributes
    ----------
    outcome : str
        Of `OUTCOMES`.
    is_right : bool
        By the rule of the kind: the truth is the answer or in the declared set; `unknown` or a stated alias where the
        truth was left out of the candidates.
    is_stage_right : bool or None
        None where the plant has no effect.
    said : float
        Probability of the answer, all that it cannot tell from it included.
    is_true : bool
        Whether what was given that probability is the case.
    named : tuple of str
        The first choice; empty for none and unknown.
    """

    outcome: str
    is_right: bool
    is_stage_right: bool | None
    said: float
    is_true: bool
    named: Effects


def mark(kind: str, truth: Effects, diagnosis: Mapping[str, Any]) -> Mark:
    """Mark the content of a diagnosis.json."""
    verdict = diagnosis["verdict"]
    family = family_of(diagnosis)
    declared = family if len(family) <= MOST_DECLARED else family[:1]
    named = family[0] if family else ()
    hidden = beside(diagnosis)
    with_hidden = [*family, *hidden]
    said = diagnosis["unknown_probability"] if verdict == "unknown" else probability_of(with_hidden, diagnosis)
    if kind == "left-out":
        outcome = outcome_left_out(truth[0], verdict, named, said)
        is_true = outcome in ("unknown", "alias")
    else:
        outcome = outcome_of(truth, verdict, named, [*declared, *hidden][:MOST_DECLARED])
        is_true = any(set(truth) == set(each) for each in with_hidden)
    where = diagnosis["where"]
    left_open = stages_of(declared) | set(where.get("open_stages", ()))
    return Mark(
        outcome=outcome,
        is_right=outcome in ("right", "alias") or (kind == "left-out" and outcome == "unknown"),
        is_stage_right=is_stage_right(truth, where["stage"], left_open) if truth else None,
        said=said,
        is_true=is_true,
        named=named if verdict == "effect" else (),
    )


def family_of(diagnosis: Mapping[str, Any]) -> list[Effects]:
    """Return the first choice and the causes that it declares indistinguishable; nothing where it says unknown."""
    if diagnosis["verdict"] == "unknown" or not diagnosis["causes"]:
        return []
    wants_effects = diagnosis["verdict"] != "none"
    found = next(cause for cause in diagnosis["causes"] if bool(cause["effects"]) == wants_effects)
    return [tuple(each) for each in (found["effects"], *found["indistinguishable_from"])]


def beside(diagnosis: Mapping[str, Any]) -> list[Effects]:
    """Return the first choice with each effect added that is said to hide beside it."""
    if diagnosis["verdict"] != "effect":
        return []
    found = diagnosis["causes"][0]
    return [(*found["effects"], key) for key in found.get("may_hide_beside", ())]


def probability_of(family: Sequence[Effects], diagnosis: Mapping[str, Any]) -> float:
    """Return the probability of several causes together, in whatever order of their effects."""
    sets = [set(each) for each in family]
    return sum(cause["probability"] for cause in diagnosis["causes"] if set(cause["effects"]) in sets)


def outcome_of(truth: Effects, verdict: str, named: Effects, declared: Sequence[Effects]) -> str:
    """Return what came out where the truth is among the candidates."""
    if verdict == "unknown":
        return "unknown"
    if set(named) == set(truth):
        return "right"
    if not truth:
        return "false alarm"
    if any(set(each) == set(truth) for each in declared):
        return "alias"
    if verdict == "none":
        return "none"
    return "partly" if set(named) & set(truth) else "wrong"


def outcome_left_out(truth: str, verdict: str, named: Effects, said: float) -> str:
    """Return what came out where the truth was taken out of the candidates."""
    if verdict == "unknown":
        return "unknown"
    if all(are_aliases(truth, key) for key in named or ("none",)):
        return "alias"
    if verdict == "none":
        return "none"
    return "wrong" if said >= CONFIDENT else "unsure"


def is_stage_right(truth: Effects, first: str | None, left_open: Collection[str]) -> bool:
    """Return whether the stage said first, or one of at most two that are left open, is a stage of the truth."""
    true = stages_of([truth])
    return first in true or (len(left_open) <= MOST_STAGES and bool(true & set(left_open)))
