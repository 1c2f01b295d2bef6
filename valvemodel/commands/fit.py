"""`valvemodel fit`: the numbers of a valve from its records, and which of them the records determine."""

from __future__ import annotations

from pathlib import Path

import click

from valvemodel.commands.command import Count, command, json_option, print_json
from valvemodel.commands.fitted import print_outcome
from valvemodel.commands.given import (
    base_given,
    columns_called,
    columns_option,
    complete_effects,
    measured_records,
    model_option,
    records_argument,
    valve_option,
)
from valvemodel.commands.places import check_folder, write_together
from valvemodel.commands.trouble import warn
from valvemodel.commands.waiting import progress_shown


@command(
    short_help="Which numbers fit, and how well they are determined.",
    epilog="""\b
Examples:
  valvemodel fit record.csv --out fitted
  valvemodel fit record.csv --profile --bootstrap 200 --out fitted
  valvemodel fit monday.csv tuesday.csv --valve my_valve.toml --effect static_friction --out fitted""",
)
@records_argument
@columns_option
@valve_option
@model_option
@click.option(
    "--effect",
    "effects",
    multiple=True,
    metavar="KEY",
    shell_complete=complete_effects,
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
@click.option(
    "--profile",
    "has_profile",
    is_flag=True,
    help="Take the 95 % intervals from the profile likelihood: each parameter is moved and the others refitted. With "
    "an effect whose error has many minima, as static friction, from samples of what is likely.",
)
@click.option(
    "--bootstrap",
    "repetitions",
    default=0,
    type=Count(min=0),
    help="Refit N times to the fitted trajectory with blocks of its residuals drawn anew; 200 is a good number.",
)
@json_option
def fit(
    paths: tuple[Path, ...],
    columns: tuple[str, ...],
    valve: str | None,
    model_file: Path | None,
    effects: tuple[str, ...],
    route: str,
    loop: str,
    out: Path,
    has_profile: bool,
    repetitions: int,
    as_json: bool,
) -> None:
    """Fit the free parameters of a valve to records of it.

    Free are spring rate, friction, mass, the two numbers of the gap and where each record starts; of a record
    with force instead of current, the numbers of the stem. The error on unseen data is that of a fit to a
    part of the data on the rest: every third block in time of one record, the last one of several records.

    A parameter is determined where the record narrows it; the table says which are, with 95 % intervals, and
    in proportion to what. The residuals are checked: a test that fails says where the model is not the valve.
    """
    check_folder(out)
    from identification.fitting import fit_records
    from valvemodel.effects import effect_of_key

    model, rated_travel = base_given(valve, model_file)
    for key in effects:
        effect_of_key(key)
    with progress_shown() as progress:
        records = measured_records(paths, model, rated_travel, columns_called(columns))
        outcome = fit_records(
            records,
            model,
            effects=effects,
            route=route,
            is_ramped=loop == "ramped",
            has_profile=has_profile,
            repetitions=repetitions,
            progress=progress,
        )
    places = write_together(out, outcome.write)
    warn(outcome.warnings)
    if as_json:
        print_json(outcome.as_json())
        return
    print_outcome(outcome)
    for name, place in places.items():
        click.echo(f"{name:11s} {place}")
