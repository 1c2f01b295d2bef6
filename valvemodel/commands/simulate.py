"""`valvemodel simulate`: a valve or a model run over measured or made-up currents."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from valvemodel.commands.command import command
from valvemodel.commands.given import (
    columns_called,
    columns_option,
    effects_option,
    model_given,
    model_option,
    valve_option,
    with_effects,
)
from valvemodel.commands.places import check_file, check_not_input
from valvemodel.commands.trouble import warn

if TYPE_CHECKING:
    from valvemodel.records import Record
    from valvemodel.simulation import Trajectory


@command(
    short_help="What a valve would do under a current.",
    epilog="""\b
Examples:
  valvemodel simulate --input ramps.csv --out out.csv
  valvemodel simulate --valve table2 --input ramps.csv --out out.csv
  valvemodel simulate --input ramps.csv --effect static_friction:static_friction_ratio=1.3 --out out.csv
  valvemodel simulate --model report/model.json --input ramps.csv --start-position "28.15 mm" --out out.csv
  valvemodel simulate --model report/model.json --input record.csv --reanchor "2 s" --out out.csv""",
)
@valve_option
@model_option
@click.option(
    "--input",
    "input_file",
    required=True,
    metavar="IN.csv",
    type=click.Path(path_type=Path),
    help="Columns `time [s]` and `current [mA]`; also Parquet and MAT.",
)
@columns_option
@effects_option
@click.option(
    "--start-position",
    metavar="QUANTITY",
    help='Reading at the start, as "28.15 mm".  [default: at rest in the middle of the stuck band]',
)
@click.option(
    "--reanchor",
    metavar="QUANTITY",
    help='Put the stem on the input\'s `position` every so often, as "2 s", or at `rest`: whenever it comes to rest. '
    "Speed and friction stay as they are.  [default: the run is free]",
)
@click.option(
    "--events",
    "events_file",
    metavar="EVENTS.csv",
    type=click.Path(path_type=Path),
    help="Also write every breakaway, stop, reversal, impact and release at its own instant.",
)
@click.option(
    "--out",
    required=True,
    metavar="OUT.csv",
    type=click.Path(path_type=Path),
    help="Where the table goes; a name ending in .parquet makes it Parquet.",
)
def simulate(
    valve: str | None,
    model_file: Path | None,
    input_file: Path,
    columns: tuple[str, ...],
    effects: tuple[str, ...],
    start_position: str | None,
    reanchor: str | None,
    events_file: Path | None,
    out: Path,
) -> None:
    """Simulate a valve under currents that are held from each row to the next.

    The base model is exact: sticking and slipping by mode, stops and breakaways in closed form, no step size.
    OUT.csv has time, current, pressure, position (the sensor's reading) and mode (stuck, rising, falling) at
    the input's times; a row shows the state just before its current acts. A position in the input is used by
    --reanchor, and to say how far the run is off; it does not set the start.
    """
    check_file(out)
    check_not_input(out, {"--input": input_file, "--model": model_file, "--valve": valve})
    if events_file is not None:
        check_file(events_file)
        check_not_input(events_file, {"--input": input_file, "--model": model_file, "--valve": valve})
        if events_file.resolve() == out.resolve():
            raise click.UsageError("--events and --out name the same file: give two.")
    import math

    from valvemodel.quantities import format_quantity, parse_quantity
    from valvemodel.records import read_record, write_table
    from valvemodel.simulation import AT_REST
    from valvemodel.simulation import simulate as run

    model = model_given(valve, model_file)[0]
    model, notes = with_effects(model, effects)
    start = math.nan if start_position is None else parse_quantity(start_position, unit="m")
    needs = ("time", "current") if reanchor is None else ("time", "current", "position")
    record = read_record(input_file, needs=needs, allow_loop=False, columns=columns_called(columns))
    assert record.time is not None
    assert record.current is not None
    for note in notes:
        click.echo(note, err=True)
    warn(record.warnings)
    travel = model.values["rated_travel"]
    if abs(start) > travel:
        warn([f"the start at {format_quantity(start, 'm')} is beyond the rated travel, {format_quantity(travel, 'm')}"])
    trajectory = run(
        model,
        time=record.time,
        current=record.current,
        start_position=start,
        measured=record.position,
        reanchor=reanchor if reanchor in (None, AT_REST) else parse_quantity(reanchor, unit="s"),
    )
    write_table(out, trajectory.columns())
    click.echo(f"wrote {out}: {len(record)} rows{_off(record, trajectory)}", err=True)
    if events_file is not None:
        events = trajectory.events
        write_table(
            events_file,
            {
                "time [s]": events.time,
                "event": events.kind.tolist(),
                "stem position [mm]": 1e3 * events.position,
                "speed [mm/s]": 1e3 * events.speed,
            },
        )
        click.echo(f"wrote {events_file}: {len(events)} events", err=True)


def _off(record: Record, trajectory: Trajectory) -> str:
    """Say how far a run is off the measured position, where there is one."""
    import numpy as np

    from valvemodel.quantities import format_quantity

    if record.position is None or record.position_unit != "m":
        return ""
    off = record.position - trajectory.position
    known = off[np.isfinite(off)]
    if not known.size:
        return ""
    rms = format_quantity(float(np.sqrt(np.mean(known**2))), "m", digits=3)
    return f", {rms} (root mean square) off the measured position"
