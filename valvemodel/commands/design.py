"""`valvemodel design`: the current to send next, so that a fit tells the parameters one wants to know."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from valvemodel.commands.command import Count, command, json_option, print_json
from valvemodel.commands.places import check_file, check_not_input
from valvemodel.commands.waiting import progress_shown
from valvemodel.errors import InputError

if TYPE_CHECKING:
    from identification.design.inputs import Limits
    from identification.design.search import Design


@command(
    short_help="Which current to measure next.",
    epilog="""\b
Examples:
  valvemodel design --model fitted/model.json --for k,F_c,f_v --out next.csv
  valvemodel design --model fitted/model.json --for f_v --range "8 mA" "16 mA" --rate "2 mA/s" --out n.csv
  valvemodel simulate --model fitted/model.json --input next.csv --out expected.csv""",
)
@click.option(
    "--model",
    "model_file",
    required=True,
    metavar="MODEL.json",
    type=click.Path(path_type=Path),
    help="What is known of the valve: a model that fit or diagnose wrote.",
)
@click.option(
    "--for",
    "wanted",
    required=True,
    metavar="NAMES",
    help="Parameters to tell, with commas: k, F_c, F_s, f_v, m, c0, E, or full names, those of effects too.",
)
@click.option("--duration", default="120 s", show_default=True, metavar="TIME", help="Of the test.")
@click.option("--period", default="20 ms", show_default=True, metavar="TIME", help="Of the samples.")
@click.option(
    "--range", "ends", nargs=2, default=("4 mA", "20 mA"), show_default=True, metavar="LOW HIGH", help="Of the current."
)
@click.option(
    "--rate", metavar="RATE", help='Fastest change of the current, as "2 mA/s".  [default: steps are allowed]'
)
@click.option("--dwell", default="0.5 s", show_default=True, metavar="TIME", help="Shortest stay at a level.")
@click.option("--noise", default="0.1 mm", show_default=True, metavar="LENGTH", help="White noise of the reading.")
@click.option("--criterion", default="D", show_default=True, type=click.Choice(["D", "A"]),
              help="D: smallest volume of the errors' ellipsoid; A: smallest sum of relative variances.")  # fmt: skip
@click.option("--repetitions", default=20, show_default=True, type=Count(min=0),
              help="Simulated repetitions that verify the deviations; 0 leaves them out.")  # fmt: skip
@click.option(
    "--out",
    required=True,
    metavar="INPUT.csv",
    type=click.Path(path_type=Path),
    help="Where the current goes; what it promises goes beside it, INPUT.json.",
)
@json_option
def design(
    model_file: Path,
    wanted: str,
    duration: str,
    period: str,
    ends: tuple[str, str],
    rate: str | None,
    dwell: str,
    noise: str,
    criterion: str,
    repetitions: int,
    out: Path,
    as_json: bool,
) -> None:
    """Find an admissible current that tells the most about chosen parameters of a valve.

    Ramps, steps and dwells between levels are varied until the errors that a fit to the record would have are
    smallest. INPUT.csv has `time [s]` and `current [mA]`, as simulate takes it; INPUT.json has the standard
    deviations expected of it, those of plain ramps of the same duration, and those seen in repetitions.
    """
    beside = out.with_suffix(".json")
    for place in (out, beside):
        check_file(place)
        check_not_input(place, {"--model": model_file})
    if beside == out:
        raise InputError("INPUT.csv and INPUT.json are two files", f"--out is {out}", "name a table, as next.csv")
    from identification.design.choice import chosen_parameters
    from identification.design.search import design as find_input
    from valvemodel.files import write_json
    from valvemodel.model import read_model
    from valvemodel.quantities import parse_quantity
    from valvemodel.records import write_table

    model = read_model(model_file)
    names = chosen_parameters(wanted, model)
    limits = _limits(ends, rate, dwell, duration, period)
    level = parse_quantity(noise, unit="m")
    if not level > 0.0:
        raise InputError("the noise is positive", f"got {noise}", "give the noise of the reading, as --noise '0.1 mm'")
    with progress_shown() as progress:
        found = find_input(
            model, names, limits, noise=level, criterion=criterion, repetitions=repetitions, progress=progress
        )
    write_table(out, {"time [s]": found.time, "current [mA]": 1e3 * found.current})
    write_json(beside, found.as_json())
    if as_json:
        print_json(found.as_json())
        return
    _print(found)
    click.echo(f"current   {out}\npromises  {beside}")


def _limits(ends: tuple[str, str], rate: str | None, dwell: str, duration: str, period: str) -> Limits:
    import math

    from identification.design.inputs import Limits
    from valvemodel.quantities import parse_quantity

    return Limits(
        low=parse_quantity(ends[0], unit="A"),
        high=parse_quantity(ends[1], unit="A"),
        rate=math.inf if rate is None else parse_quantity(rate, unit="A/s"),
        dwell=parse_quantity(dwell, unit="s"),
        duration=_seconds(duration),
        period=parse_quantity(period, unit="s"),
    )


def _seconds(text: str) -> float:
    """Read a duration; a number alone is in seconds."""
    from valvemodel.quantities import parse_quantity

    try:
        return float(text)
    except ValueError:
        return parse_quantity(text, unit="s")


def _print(found: Design) -> None:
    from rich import box
    from rich.console import Console
    from rich.table import Table

    from valvemodel.quantities import format_quantity

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("parameter", no_wrap=True)
    for heading in ("value", "std by plain ramps", "std by this input", f"seen in {found.repetitions} repetitions"):
        table.add_column(heading, justify="right", no_wrap=True)
    for each in found.expectations:
        amounts = (each.ramp, each.design, each.observed)
        shown = ["" if amount is None else format_quantity(amount, each.unit, digits=2) for amount in amounts]
        table.add_row(each.name, format_quantity(each.value, each.unit), *shown)
    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=100)
    console.print(table)
