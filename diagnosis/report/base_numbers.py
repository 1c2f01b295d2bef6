"""What the fit made of the base valve's own numbers, in the words of a valve engineer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from diagnosis.report.amounts import NOT_DETERMINED, amount, amount_with_std, is_number
from valvemodel.base_valve import BASE_PARAMETERS

_MEANINGS = {parameter.name: parameter.meaning for parameter in BASE_PARAMETERS}

_WORTH_SAYING = 1.5
"""Gap as given over the gap refitted, from which the first screen says which number made most of it."""


@dataclass(frozen=True)
class NumberRow:
    """One row of the table of the base valve's numbers, as text."""

    name: str
    meaning: str
    given: str
    refitted: str
    found: str
    gap_as_given: str


def number_rows(diagnosis: Mapping[str, Any]) -> tuple[NumberRow, ...]:
    """Return the table of the base valve's numbers; empty where `diagnosis.json` has none."""
    numbers = _numbers(diagnosis)
    gaps = [each["gap_as_given"] for each in numbers]
    rows = []
    for each in numbers:
        values, unit = [each["given"], each["refitted"], each["found"]], each["unit"]
        known = is_number(each["std"])
        rows.append(
            NumberRow(
                each["name"],
                _MEANINGS.get(each["name"], ""),
                amount(each["given"], unit, like=values),
                amount(each["refitted"], unit, like=values),
                amount_with_std(each["found"], each["std"], unit) if known else NOT_DETERMINED,
                amount(each["gap_as_given"], "m", like=gaps),
            )
        )
    return tuple(rows)


def refit_sentence(diagnosis: Mapping[str, Any]) -> str:
    """Say which of the base valve's numbers matters most, where the refit closes much of the gap as given."""
    gap, numbers = diagnosis.get("gap") or {}, _numbers(diagnosis)
    if not numbers or not gap["as_given"] > _WORTH_SAYING * gap["refitted"]:
        return ""
    most = numbers[0]
    values = [most["given"], most["found"]]
    given, found = (amount(value, most["unit"], like=values) for value in values)
    # Without the letter that it has in the paper.
    meaning = _MEANINGS.get(most["name"], most["name"]).rpartition(", ")[2].removeprefix("the ")
    return (
        f"Of the valve's own numbers the {meaning} matters most: {given} as given,"
        f" {found} found. That one alone put back, model and valve differ by {amount(most['gap_as_given'], 'm')}."
    )


def _numbers(diagnosis: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return list((diagnosis.get("base") or {}).get("numbers") or ())
