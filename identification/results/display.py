"""How a fit shows itself: its tables, the same in a notebook and on the terminal, and its card."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from valvemodel.display import Card, Table, warning_lines
from valvemodel.effects import HIGHER
from valvemodel.quantities import format_quantity

if TYPE_CHECKING:
    from identification.determined.account import Account
    from identification.determined.profile import Ends
    from identification.results.outcome import Outcome


def fit_card(outcome: Outcome) -> Card:
    """Show a fit: its error, its parameters and whether they are determined, its failed checks."""
    tables = [parameter_table(outcome)]
    if outcome.smoothing:
        tables.append(smoothing_table(outcome))
    failed = [check.name for check in outcome.checks if not check.is_passed]
    notes = [f"Residual checks failed: {', '.join(failed)}."] if failed else []
    if outcome.checks and not failed:
        notes.append(f"All {len(outcome.checks)} residual checks passed.")
    title = f"Fit to {', '.join(outcome.records)}: error (rms) {error_words(outcome)}"
    return Card(title, (*tables, *determined_lines(outcome.determined), *notes, *warning_lines(outcome.warnings)))


def error_words(outcome: Outcome) -> str:
    """Say the root mean square errors on fitted and on unseen data."""
    fitted = format_quantity(outcome.rms_fitted, outcome.unit, digits=3)
    if outcome.rms_unseen is None:
        return f"fitted {fitted}, unseen too short to keep anything back"
    unseen = format_quantity(outcome.rms_unseen, outcome.unit, digits=3)
    return f"fitted {fitted}, unseen {unseen} on {outcome.unseen}"


def parameter_table(outcome: Outcome) -> Table:
    """List the parameters with uncertainty, and whether the records determine them."""
    account = outcome.determined
    means = ["95 % interval" if account.profile is None else f"95 % ({account.interval_from})"]
    means += ["95 % (bootstrap)"] if account.bootstrap is not None else []
    rows = []
    for each in outcome.parameters:
        if each.name in HIGHER:
            continue
        cells = [
            each.name,
            format_quantity(each.value, each.unit, digits=5),
            "" if each.std is None else format_quantity(each.std, each.unit, digits=2),
            _interval(account.intervals[each.name], each.unit),
        ]
        if account.bootstrap is not None:
            _, low, high = account.bootstrap[each.name]
            cells.append(_interval((low, high), each.unit))
        reason = outcome.open.get(each.name)
        rows.append((*cells, "yes" if reason is None else f"no: {reason}"))
    series = [each.name for each in outcome.parameters if each.name in HIGHER]
    if series:
        rows.append((f"{series[0]} .. {series[-1]}", f"{len(series)} sizes", *[""] * (len(means) + 1), "see fit.json"))
    return Table("Parameters", ("parameter", "value", "std", *means, "determined"), tuple(rows))


def parameter_columns(outcome: Outcome) -> dict[str, list[Any]]:
    """Return the same as numbers in SI units, by column."""
    ends = [outcome.determined.intervals[each.name] for each in outcome.parameters]
    return {
        "value": [each.value for each in outcome.parameters],
        "unit": [each.unit for each in outcome.parameters],
        "std": [each.std for each in outcome.parameters],
        "low": [low for low, _ in ends],
        "high": [high for _, high in ends],
        "is_determined": [each.name not in outcome.open for each in outcome.parameters],
    }


def check_table(outcome: Outcome) -> Table:
    """List the residual checks."""
    rows = tuple(
        (
            check.name,
            f"{check.statistic:.3g}",
            f"{check.threshold:.3g}",
            "passed" if check.is_passed else f"failed: {check.looks_for}",
        )
        for check in outcome.checks
    )
    return Table("Residual checks", ("residual", "statistic", "threshold", "verdict"), rows)


def smoothing_table(outcome: Outcome) -> Table:
    """List what smoothing did to the fit, by width."""
    exact = {each.name: each.value for each in outcome.parameters if each.name not in outcome.open}
    rows = []
    for each in outcome.smoothing:
        shares = {name: each.shifts[name] / value for name, value in exact.items() if value != 0.0}
        farthest = max(shares, key=lambda name: abs(shares[name]), default="")
        rows.append(
            (
                format_quantity(each.width, "N", digits=3),
                f"{each.error:.5g}",
                f"{format_quantity(each.rms, 'm', digits=2)}, {format_quantity(each.largest, 'm', digits=2)}",
                f"at most {100.0 * shares[farthest]:+.2g} %, {farthest}" if farthest else "",
            )
        )
    headings = ("smoothing", "objective", "off the exact run (rms, max)", "parameters off the exact refit")
    return Table("Smoothing", headings, tuple(rows))


def determined_lines(account: Account) -> tuple[str, ...]:
    """Say in proportion to what the parameters are known, and what the records show least."""
    by_measure: dict[str, list[str]] = {}
    for name in account.intervals:
        measure = account.structure.measured_by.get(name)
        if measure:
            by_measure.setdefault(measure, []).append(name)
    directions = [each for each in account.directions if HIGHER.isdisjoint(each.names)]
    shown = [each for each in directions if not each.is_determined] or directions[:1]
    return (
        *(f"in proportion to {measure} as given: {', '.join(names)}" for measure, names in by_measure.items()),
        *(f"least seen: {direction.words}" for direction in shown),
    )


def _interval(ends: Ends, unit: str) -> str:
    low, high = ends
    if low is None and high is None:
        return ""
    texts = ["open" if end is None else format_quantity(end, unit, digits=5) for end in (low, high)]
    first, *unit_of_first = texts[0].split(" ", 1)
    return f"{first if texts[1].endswith(' '.join(unit_of_first)) else texts[0]} .. {texts[1]}"
