"""How far the gap shrinks, step by step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from diagnosis.report.amounts import amount, closed_text, is_number, percent_interval
from diagnosis.report.finding import found_cause
from diagnosis.report.naming import cause_title


def gap_rows_of(diagnosis: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    """Return what the gap is of, and how large it is, from the valve as given down to the noise."""
    gap = diagnosis.get("gap") or {}
    names = {"as_given": "as given", "refitted": "base parameters refitted"}
    if diagnosis["verdict"] == "effect":
        names["with_cause"] = f"with {cause_title(found_cause(diagnosis)['effects'])}"
    elif diagnosis["verdict"] == "unknown" and found_cause(diagnosis)["effects"]:
        names["with_cause"] = f"nearest candidate, {cause_title(found_cause(diagnosis)['effects'])}"
    names["noise_floor"] = "noise floor of the record"
    values = [gap.get(key) for key in names]
    return tuple(
        (name, amount(value, gap.get("unit", "m"), like=values[:1]))
        for name, value in zip(names.values(), values, strict=True)
        if is_number(value)
    )


def closes_of(diagnosis: Mapping[str, Any]) -> str:
    """Say which part of the gap that could be closed the cause closes."""
    found = found_cause(diagnosis)
    closed = found.get("gap_closed")
    if diagnosis["verdict"] == "none" or closed is None or not is_number(closed):
        return ""
    interval = percent_interval(found.get("gap_closed_interval"))
    interval = f" (95 % interval: {interval})" if interval else ""
    subject = "The cause closes" if diagnosis["verdict"] == "effect" else "The nearest candidate closes"
    return f"{subject} {closed_text(closed)} of the gap that could be closed{interval}."


def measure_of(diagnosis: Mapping[str, Any]) -> str:
    """Say what the sizes of the gap are, on which data they were taken, and how, unless by free runs."""
    scored_on, anchored = (diagnosis.get("gap") or {}).get("scored_on"), re_anchored(diagnosis)
    how = f", each model {anchored}" if anchored else ""
    data = {
        "held-out blocks": "parts of the record that no fit saw",
        "other records": "a record that no fit saw",
    }.get(scored_on or "", scored_on or "data not used for fitting")
    return f"Typical error (root mean square) on {data}{how}."


def re_anchored(diagnosis: Mapping[str, Any]) -> str:
    """Return how the models were put back on the reading; empty where they ran freely, or nothing says."""
    yardstick = (diagnosis.get("gap") or {}).get("yardstick") or "free run"
    return "" if yardstick == "free run" else yardstick


def black_box_of(diagnosis: Mapping[str, Any]) -> str:
    """Say how much a correction without physics would close, as a yardstick for the cause."""
    closed = (diagnosis.get("ceiling") or {}).get("gap_closed")
    if diagnosis["verdict"] == "none" or not is_number(closed):
        return ""
    return (
        "As a yardstick, a black box that knows no physics, taught on the same data, closes "
        f"{closed_text(closed)} of what could be closed."
    )
