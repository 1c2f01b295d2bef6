"""What `valvemodel fit` prints: the parameters, what is determined and how, and the check of the residuals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from identification.determined.account import Account
    from identification.determined.profile import Ends
    from identification.loop_shape import FittedShape
    from identification.outcome import Outcome

_PIPED_WIDTH = 120


def print_outcome(outcome: Outcome) -> None:
    """Print a fit: one table of parameters, one of residual checks, and what the records cannot say."""
    from rich.console import Console

    from valvemodel.quantities import format_quantity

    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=_PIPED_WIDTH)
    console.print(_parameters(outcome))
    _print_determined(console, outcome.determined)
    if outcome.checks:
        console.print(_checks(outcome))
    if outcome.smoothing:
        console.print(_smoothing(outcome))
    fitted = format_quantity(outcome.rms_fitted, outcome.unit, digits=3)
    if outcome.rms_unseen is None:
        unseen = "too short to keep anything back"
    else:
        unseen = f"{format_quantity(outcome.rms_unseen, outcome.unit, digits=3)} on {outcome.unseen}"
    click.echo(f"error (rms)  fitted {fitted}, unseen {unseen}")
    if outcome.loop is not None:
        _print_loop(outcome.loop)
    if outcome.noise is not None:
        noise = format_quantity(outcome.noise, outcome.unit, digits=3)
        click.echo(f"noise (rms)  {noise}, from the readings themselves")


def _print_loop(loop: FittedShape) -> None:
    """Print width, slope and height of a loop: in mA, mm/mA and mm."""
    shape, std = loop.shape, loop.std
    click.echo(
        f"loop         {'ramped' if loop.is_ramped else 'stepped'}; at {1e3 * shape.position:.4g} mm: "
        f"width {1e3 * shape.width:.4g} mA (std {1e3 * std['width']:.2g}), "
        f"slope {shape.slope:.4g} mm/mA (std {std['slope']:.2g}), "
        f"height {1e3 * shape.height:.4g} mm (std {1e3 * std['height']:.2g})"
    )


def _table(left: tuple[str, ...], right: tuple[str, ...], last: str) -> Table:
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in (*left, *right):
        table.add_column(heading, justify="right" if heading in right else "left", no_wrap=True)
    table.add_column(last)
    return table


def _parameters(outcome: Outcome) -> Table:
    from valvemodel.quantities import format_quantity

    account = outcome.determined
    means = ["95 % interval" if account.profile is None else f"95 % ({account.interval_from})"]
    means += ["95 % (bootstrap)"] if account.bootstrap is not None else []
    table = _table(("parameter",), ("value", "std", *means), "determined")
    for each in outcome.parameters:
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
        table.add_row(*cells, "yes" if reason is None else f"no: {reason}")
    return table


def _interval(ends: Ends, unit: str) -> str:
    from valvemodel.quantities import format_quantity

    low, high = ends
    if low is None and high is None:
        return ""
    texts = ["open" if end is None else format_quantity(end, unit, digits=5) for end in (low, high)]
    first, *unit_of_first = texts[0].split(" ", 1)
    return f"{first if texts[1].endswith(' '.join(unit_of_first)) else texts[0]} .. {texts[1]}"


def _print_determined(console: Console, account: Account) -> None:
    by_measure: dict[str, list[str]] = {}
    for name in account.intervals:
        measure = account.structure.measured_by.get(name)
        if measure:
            by_measure.setdefault(measure, []).append(name)
    for measure, names in by_measure.items():
        click.echo(f"in proportion to {measure} as given: {', '.join(names)}")
    shown = [each for each in account.directions if not each.is_determined] or list(account.directions[:1])
    for direction in shown:
        console.print(f"least seen: {direction.words}", soft_wrap=True)


def _checks(outcome: Outcome) -> Table:
    table = _table(("residual",), ("statistic", "threshold"), "verdict")
    for check in outcome.checks:
        verdict = "passed" if check.is_passed else f"failed: {check.looks_for}"
        table.add_row(check.name, f"{check.statistic:.3g}", f"{check.threshold:.3g}", verdict)
    return table


def _smoothing(outcome: Outcome) -> Table:
    from valvemodel.quantities import format_quantity

    exact = {each.name: each.value for each in outcome.parameters}
    table = _table(("smoothing",), ("objective", "off the exact run (rms, max)"), "parameters off the exact refit")
    for each in outcome.smoothing:
        shares = {name: shift / exact[name] for name, shift in each.shifts.items() if exact[name] != 0.0}
        farthest = max(shares, key=lambda name: abs(shares[name]))
        table.add_row(
            format_quantity(each.width, "N", digits=3),
            f"{each.error:.5g}",
            f"{format_quantity(each.rms, 'm', digits=2)}, {format_quantity(each.largest, 'm', digits=2)}",
            f"at most {100.0 * shares[farthest]:+.2g} %, {farthest}",
        )
    return table
