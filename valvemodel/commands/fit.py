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
    from identification.loop_shape import FittedShape
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
    "--loop",
    type=click.Choice(["stepped", "ramped"]),
    default="stepped",
    show_default=True,
    help="How the current of a settled loop went from value to value.",
)
@click.option(
    "--out",
    required=True,
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Folder for fit.json and model.json.",
)
def fit(paths: tuple[Path, ...], valve: str | None, effects: tuple[str, ...], loop: str, out: Path) -> None:
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
        outcome = fit_records(records, model, effects=effects, is_ramped=loop == "ramped", progress=progress)
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
