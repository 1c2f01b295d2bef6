"""`valvemodel fit`: the numbers of a valve from its records, and which of them the records determine."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from valvemodel.commands.given import measured_records, records_argument, valve_model, valve_option
from valvemodel.commands.places import check_folder, write_together
from valvemodel.commands.trouble import warn
from valvemodel.commands.waiting import progress_shown

if TYPE_CHECKING:
    from rich.console import Console

    from identification.outcome import Outcome

_PIPED_WIDTH = 100


@click.command(
    epilog="""\b
Examples:
  valvemodel fit record.csv --out fitted
  valvemodel fit monday.csv tuesday.csv --valve my_valve.toml --effect static_friction --out fitted"""
)
@records_argument
@valve_option
@click.option(
    "--effect",
    "effects",
    multiple=True,
    metavar="KEY",
    help="Fit the parameters of this effect too; may be given several times.",
)
@click.option(
    "--route",
    type=click.Choice(["exact", "smooth"]),
    default="exact",
    show_default=True,
    help="Search on the exact simulator; or on smooth functions with exact derivatives and then on the exact one, "
    "which shows what smoothing did.",
)
@click.option(
    "--out",
    required=True,
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Folder for fit.json and model.json.",
)
def fit(paths: tuple[Path, ...], valve: str | None, effects: tuple[str, ...], route: str, out: Path) -> None:
    """Fit the free parameters of a valve to records of it.

    Free are spring rate, friction, mass, the two numbers of the gap and where each record starts; of a record
    with force instead of current, the numbers of the stem. The error on unseen data is that of a fit to a
    part of the data on the rest: every third block in time of one record, the last one of several records.
    """
    check_folder(out)
    from identification.outcome import fit_records
    from valvemodel.effects import effect_of_key

    model, rated_travel = valve_model(valve)
    for key in effects:
        effect_of_key(key)
    with progress_shown() as progress:
        records = measured_records(paths, model, rated_travel)
        outcome = fit_records(records, model, effects=effects, route=route, progress=progress)
    places = write_together(out, outcome.write)
    warn(outcome.warnings)
    _print(outcome)
    for name, place in places.items():
        click.echo(f"{name:11s} {place}")


def _print(outcome: Outcome) -> None:
    from rich import box
    from rich.console import Console
    from rich.table import Table

    from valvemodel.quantities import format_quantity

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("parameter", "value", "std", "determined?"):
        table.add_column(heading, justify="right" if heading in ("value", "std") else "left", no_wrap=True)
    for each in outcome.parameters:
        reason = outcome.open.get(each.name)
        table.add_row(
            each.name,
            format_quantity(each.value, each.unit, digits=5),
            "" if each.std is None else format_quantity(each.std, each.unit, digits=2),
            "yes" if reason is None else f"no: {reason}",
        )
    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=_PIPED_WIDTH)
    console.print(table)
    if outcome.smoothing:
        _print_smoothing(console, outcome)
    fitted = format_quantity(outcome.rms_fitted, outcome.unit, digits=3)
    if outcome.rms_unseen is None:
        unseen = "too short to keep anything back"
    else:
        unseen = f"{format_quantity(outcome.rms_unseen, outcome.unit, digits=3)} on {outcome.unseen}"
    click.echo(f"error (rms)  fitted {fitted}, unseen {unseen}")
    if outcome.noise is not None:
        noise = format_quantity(outcome.noise, outcome.unit, digits=3)
        click.echo(f"noise (rms)  {noise}, from the readings themselves")


def _print_smoothing(console: Console, outcome: Outcome) -> None:
    from rich import box
    from rich.table import Table

    from valvemodel.quantities import format_quantity

    exact = {each.name: each.value for each in outcome.parameters if each.name not in outcome.open}
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("smoothing", "objective", "off the exact run (rms, max)", "off the exact refit, at most"):
        table.add_column(heading, justify="right", no_wrap=True)
    for each in outcome.smoothing:
        shares = {name: each.shifts[name] / value for name, value in exact.items() if value != 0.0}
        farthest = max(shares, key=lambda name: abs(shares[name]), default="")
        table.add_row(
            format_quantity(each.width, "N", digits=3),
            f"{each.error:.5g}",
            f"{format_quantity(each.rms, 'm', digits=2)}, {format_quantity(each.largest, 'm', digits=2)}",
            f"{farthest} {100.0 * shares[farthest]:+.2g} %" if farthest else "",
        )
    console.print(table)
