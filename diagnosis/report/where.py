"""The stages side by side, and the map of the regimes, in the words of a valve engineer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from diagnosis.report.amounts import amount, is_number, percent
from diagnosis.report.naming import STAGE_PARTS, listed

_MOSTLY = 0.8
"""Share of the gap from which it lies in one half of the chain."""

_SLOW = 0.5
"""Share of the gap below which no slow correction closes it."""

_MUCH = 0.5
"""Share of the squared gap from which what a stage's own signals explain by themselves is told as a lead."""

_SEES = {
    "electromagnet": "current",
    "nozzle": "pressure",
    "stem": "position, speed and side of the friction",
    "sensor": "position",
}
"""What goes through a stage, in words."""


@dataclass(frozen=True)
class StageRow:
    """One row of the table of stages."""

    stages: str
    output: str
    gap: str
    noise: str
    as_position: str
    share: str
    numbers: str


@dataclass(frozen=True)
class MapCell:
    """One cell of the map: the gap there, its share, and how dark it is from 0 to 1; no text where nothing was."""

    gap: str
    share: str
    shade: float


@dataclass(frozen=True)
class WhereSection:
    """What the page says of stages and regimes."""

    is_measured: bool
    sentences: tuple[str, ...]
    rows: tuple[StageRow, ...]
    map_columns: tuple[str, ...]
    map_rows: tuple[tuple[str, tuple[MapCell, ...]], ...]


def where_section(diagnosis: Mapping[str, Any]) -> WhereSection:
    """Put the stages' gaps and the regime map of `diagnosis.json` into words; both may be missing."""
    where = diagnosis.get("where") or {}
    stages = where.get("stages") or ()
    regime_map = where.get("regime_map") or {"rows": (), "columns": ()}
    is_measured = _is_measured(stages)
    sentences = _measured_sentences(where) if is_measured else _corrected_sentences(where)
    sentences += _own_sentences(where, is_measured=is_measured)
    return WhereSection(
        is_measured,
        sentences,
        tuple(_row(stage) for stage in stages),
        tuple(regime_map["columns"]),
        tuple((name, _cells(regime_map, number)) for number, name in enumerate(regime_map["rows"])),
    )


def half_of_chain(diagnosis: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the sentence that says in which half of the chain the gap lies, where the pressure was measured."""
    stages = (diagnosis.get("where") or {}).get("stages") or ()
    return (_half(stages),) if _is_measured(stages) else ()


def _is_measured(stages: Sequence[Mapping[str, Any]]) -> bool:
    return bool(stages) and all(stage["method"] == "measured input" for stage in stages)


def _measured_sentences(where: Mapping[str, Any]) -> tuple[str, ...]:
    front, back = where["stages"]
    total, cross = where["stages_sum"]["total"], where["stages_sum"]["cross_term"]
    return (
        f"Driven by the measured current, {listed(front['stages'])} miss the measured pressure by"
        f" {amount(front['gap'], 'Pa')} (its noise: {amount(front['noise'], 'Pa')}), which moves the stem by"
        f" {amount(front['gap_as_position'], 'm')}.",
        f"Driven by the measured pressure, {listed(back['stages'])} miss the measured position by"
        f" {amount(back['gap'], 'm')} (its noise: {amount(back['noise'], 'm')}).",
        _half(where["stages"]),
        f"Each half is fitted on its own measured input and output. Sample by sample their errors of position add up to"
        f" that of the whole chain, {amount(total, 'm')}; their mean squares do but for a cross term of"
        f" {100.0 * cross / (total**2 or 1.0):.0f} % of the whole's.",
    )


def _half(stages: Sequence[Mapping[str, Any]]) -> str:
    """Say in which half of the chain the gap lies."""
    if not all(is_number(stage["share"]) for stage in stages):
        return "By the measured pressure, each half of the chain comes down to its noise with its own parameters."
    most = max(stages, key=lambda stage: stage["share"])
    other = "before" if most is stages[0] else "behind"
    named = " and ".join(f"{stage} ({STAGE_PARTS[stage]})" for stage in most["stages"])
    if most["share"] >= _MOSTLY:
        return f"By the measured pressure, {percent(most['share'])} of the gap arises {other} it: in {named}."
    return (
        f"By the measured pressure, {percent(stages[0]['share'])} of the gap arises before it and"
        f" {percent(stages[1]['share'])} behind it: both halves have their part."
    )


def _corrected_sentences(where: Mapping[str, Any]) -> tuple[str, ...]:
    stages = where.get("stages") or ()
    if not stages:
        return ()
    asked = (
        "Without a measured pressure each stage is asked in turn which smallest and smoothest change of its output"
        f" would explain {where['stages_sum']['record']}."
    )
    known = [stage for stage in stages if is_number(stage["closed"])]
    if not known or all(stage["gap"] == 0.0 for stage in stages):
        return asked, "None is needed, or none helps: nothing slow is left above the noise."
    best = max(stage["closed"] for stage in known)
    if best < _SLOW:
        return (
            asked,
            f"No slow change at any stage closes more than {percent(best)} of the squared gap: what is missing acts"
            " within about a second of a move, as a lag, a delay, filling or sticking does.",
        )
    return (
        asked,
        *(_needed(known, signal) for signal in ("pressure", "reading")),
        "This alone names no stage: a gap, a pressure and a force on the stem are one correction in three units, and"
        " friction lets a regular correction before it look like a small, less regular one of the reading. A measured"
        " pressure would tell the halves of the chain apart.",
    )


def leads_of(where: Mapping[str, Any]) -> dict[str, tuple[str, float]]:
    """Return what explains much by itself in the stages that are left open, with the share of the gap, by stage."""
    leads = {}
    for each in where.get("own_signals") or ():
        what, share = next(iter(each["closed_by"].items()))
        if each["stage"] in (where.get("open_stages") or ()) and is_number(share) and share >= _MUCH:
            leads[each["stage"]] = what, share
    return leads


def _own_sentences(where: Mapping[str, Any], *, is_measured: bool) -> tuple[str, ...]:
    """Say what each stage explains by its own signals, where that was asked and anything is to be explained."""
    own = [each for each in where.get("own_signals") or () if is_number(each["gap_closed"])]
    if not own:
        return ()
    closed = [f"in the {each['stage']} ({_SEES[each['stage']]}) {percent(each['gap_closed'])}" for each in own]
    of_what = " that is left behind the measured pressure" if is_measured else ""
    return (
        "An effect can only depend on what goes through its stage, and on time. Of the squared gap of"
        f" {own[0]['record']}{of_what}, corrections that do so would close {listed(closed)}.",
        *(
            f"In the {stage}, {what} closes {percent(share)} by itself."
            for stage, (what, share) in leads_of(where).items()
        ),
    )


def _needed(stages: Sequence[Mapping[str, Any]], signal: str) -> str:
    """Say what it takes on one side of the friction."""
    stage = next(stage for stage in stages if stage["signal"] == signal)
    place = "Of the reading" if signal == "reading" else "Before the stem's friction"
    return (
        f"{place} it takes {amount(stage['gap_as_position'], 'm')}, in {stage['freedom']:.0f} independent numbers,"
        f" to close {percent(stage['closed'])} of the squared gap."
    )


def _row(stage: Mapping[str, Any]) -> StageRow:
    share = stage["share"] if stage["closed"] is None else stage["closed"]
    return StageRow(
        stages=listed(stage["stages"]),
        output=f"{stage['signal']} ({percent(stage['share_of_range'])} of its range)",
        gap=amount(stage["gap"], stage["unit"]),
        noise=amount(stage["noise"], stage["unit"]) if is_number(stage["noise"]) else "–",
        as_position=amount(stage["gap_as_position"], "m"),
        share=percent(share) if is_number(share) else "–",
        numbers=f"{stage['freedom']:.0f}" if is_number(stage["freedom"]) else "–",
    )


def _cells(regime_map: Mapping[str, Any], row: int) -> tuple[MapCell, ...]:
    known = [value for values in regime_map["rms"] for value in values if is_number(value)]
    largest = max(known, default=0.0) or 1.0
    return tuple(
        MapCell(amount(rms, regime_map["unit"], like=known), percent(share), rms / largest)
        if is_number(rms)
        else MapCell("", "", 0.0)
        for rms, share in zip(regime_map["rms"][row], regime_map["share"][row], strict=True)
    )
