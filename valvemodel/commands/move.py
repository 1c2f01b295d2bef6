"""`valvemodel move`: the current that brings a valve to a new position soonest, or with the least travel."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from valvemodel.commands.command import command, json_option, print_json
from valvemodel.commands.given import model_given, model_option, valve_option
from valvemodel.commands.places import check_file, check_not_input
from valvemodel.commands.trouble import warn
from valvemodel.commands.waiting import progress_shown

if TYPE_CHECKING:
    from valvemodel.control.optimal_move import Move


@command(
    short_help="The fastest move without overshoot.",
    epilog="""\b
Examples:
  valvemodel move --to "150 mm" --from "12 mA" --rate "2 mA/s" --out move.csv
  valvemodel move --to "80 mm" --least travel --within "2 s" --out move.csv
  valvemodel move --model fitted/model.json --to "150 mm" --out move.csv --json""",
)
@valve_option
@model_option
@click.option("--to", "target", required=True, metavar="QUANTITY", help='Reading that is wanted, as "150 mm".')
@click.option(
    "--from",
    "start_current",
    default="12 mA",
    show_default=True,
    metavar="QUANTITY",
    help="Current under which the valve is at rest at the start.",
)
@click.option(
    "--start-position",
    metavar="QUANTITY",
    help='Reading at the start, as "28.15 mm".  [default: at rest in the middle of the stuck band]',
)
@click.option("--rate", metavar="QUANTITY", help='Greatest rate of the current, as "2 mA/s".  [default: none]')
@click.option("--least", type=click.Choice(["time", "travel"]), default="time", show_default=True)
@click.option(
    "--within", metavar="QUANTITY", help="Time that a move of least travel may take.  [default: twice the least time]"
)
@click.option("--period", default="10 ms", show_default=True, metavar="QUANTITY", help="Period of the controller.")
@click.option(
    "--band",
    default="0.5 mm",
    show_default=True,
    metavar="QUANTITY",
    help="The move has arrived where the reading stays short of the target by at most this.",
)
@click.option(
    "--out",
    required=True,
    metavar="MOVE.csv",
    type=click.Path(path_type=Path),
    help="Where the table goes; a name ending in .parquet makes it Parquet.",
)
@json_option
def move(
    valve: str | None,
    model_file: Path | None,
    target: str,
    start_current: str,
    start_position: str | None,
    rate: str | None,
    least: str,
    within: str | None,
    period: str,
    band: str,
    out: Path,
    as_json: bool,
) -> None:
    """Find the current that moves a valve to a new position without overshoot, within 4..20 mA and a rate.

    The current is held for each period. It is found on smooth functions with exact derivatives (CasADi, IPOPT) and
    run on the exact valve: MOVE.csv has time, current, pressure, position and mode of that run, until the valve has
    been watched at rest for five seconds.
    """
    if within is not None and least == "time":
        raise click.UsageError("--within belongs to --least travel.")
    check_file(out)
    check_not_input(out, {"--model": model_file, "--valve": valve})
    from valvemodel.control.optimal_move import least_time, least_travel
    from valvemodel.quantities import parse_quantity
    from valvemodel.records import write_table

    model = model_given(valve, model_file)[0]
    asked: dict[str, Any] = {
        "start_current": parse_quantity(start_current, unit="A"),
        "target": parse_quantity(target, unit="m"),
        "start_position": math.nan if start_position is None else parse_quantity(start_position, unit="m"),
        "rate": math.inf if rate is None else parse_quantity(rate, unit="A/s"),
        "period": parse_quantity(period, unit="s"),
        "band": parse_quantity(band, unit="m"),
    }
    with progress_shown() as progress:
        if least == "time":
            found = least_time(model, **asked, progress=progress)
        else:
            longest = math.nan if within is None else parse_quantity(within, unit="s")
            found = least_travel(model, within=longest, **asked, progress=progress)
    run = found.trajectory
    write_table(
        out,
        {
            "time [s]": run.time,
            "current [mA]": 1e3 * run.current,
            "pressure [kPa]": 1e-3 * run.pressure,
            "position [mm]": 1e3 * run.position,
            "mode": run.mode_names,
        },
    )
    if not found.is_reached:
        warn(["the exact valve does not stay in the band under this current: widen it with --band"])
    if as_json:
        print_json(found.as_json())
    else:
        click.echo(_summary(found))
    click.echo(f"wrote {out}: {len(run.time)} rows", err=True)


def _summary(found: Move) -> str:
    from valvemodel.quantities import format_quantity

    start, end = (format_quantity(found.trajectory.position[row], "m", digits=5) for row in (0, -1))
    arrives = f"arrives after {format_quantity(found.duration, 's', digits=3)}" if found.is_reached else "not reached"
    return (
        f"{start} -> {end}: {arrives}, overshoot {format_quantity(found.overshoot, 'm', digits=2)}, "
        f"travel of the current {format_quantity(found.travel, 'A', digits=3)} (exact valve)"
    )
