"""`valvemodel blindtest`: how often the diagnosis is right, on valves whose effects it is not told."""

from __future__ import annotations

from pathlib import Path

import click

from valvemodel.commands.command import Count, command, json_option, print_json
from valvemodel.commands.given import complete_effects
from valvemodel.commands.places import check_folder
from valvemodel.commands.trouble import Interrupted
from valvemodel.commands.waiting import progress_shown


@command(
    short_help="How often such a diagnosis is right.",
    epilog="""\b
Examples:
  valvemodel blindtest --out blind
  valvemodel blindtest --plants 600 --baseline --out blind
  valvemodel blindtest --plants 27 --kinds single --out singles
  valvemodel blindtest --plants 10 --kinds single,left-out --only coil_lag --out lag
  valvemodel blindtest --every 5 --out slow
  valvemodel blindtest --current-noise "0.008 mA" --out measured""",
)
@click.option("--plants", type=Count(min=1), default=200, show_default=True, help="How many valves.")
@click.option("--seed", type=Count(min=0), default=0, show_default=True, help="Another number draws other valves.")
@click.option("--jobs", type=Count(min=1), default=2, show_default=True, help="Valves at the same time, one core each.")
@click.option(
    "--kinds",
    default="single,pair,none,left-out",
    show_default=True,
    metavar="KIND,...",
    help="In turn: one effect; two; none; one that is taken out of the candidates.",
)
@click.option(
    "--only",
    multiple=True,
    metavar="KEY",
    shell_complete=complete_effects,
    help="Valves with this effect only; may be given several times.",
)
@click.option("--pressure", is_flag=True, help="Measure the pressure too.")
@click.option(
    "--every",
    type=Count(min=1),
    default=1,
    show_default=True,
    help="Keep every Nth row only, as a logger does that is slower than what drives the valve.",
)
@click.option(
    "--current-noise",
    default="0 mA",
    show_default=True,
    metavar="NOISE",
    help="Measure the current with such noise, root mean square, instead of recording it as it is set.",
)
@click.option("--baseline", is_flag=True, help="Run a trivial baseline beside the diagnosis.")
@click.option(
    "--out",
    required=True,
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Folder for blindtest.json, blindtest.html, and the records, sealed truths and answers.",
)
@json_option
def blindtest(
    plants: int,
    seed: int,
    jobs: int,
    kinds: str,
    only: tuple[str, ...],
    pressure: bool,
    every: int,
    current_noise: str,
    baseline: bool,
    out: Path,
    as_json: bool,
) -> None:
    """Diagnose made-up valves without their truth, and say how often the answer is right.

    The valves are made by a route that shares no simulation code with the toolkit. What is in each is written to
    DIR/sealed, and its hash to DIR/seal.json, before the first diagnosis starts; the diagnosis sees DIR/records only.
    What was interrupted goes on where it stopped when the same command is given again; more plants come on top.
    """
    check_folder(out)
    from diagnosis.trials.blindtest import run_blindtest
    from diagnosis.trials.plan import Settings
    from diagnosis.trials.words import lines_of
    from valvemodel.quantities import parse_quantity

    wanted = tuple(dict.fromkeys(each.strip() for each in kinds.split(",")))
    settings = Settings(seed, wanted, only, pressure, every, parse_quantity(current_noise, unit="A"))
    try:
        with progress_shown() as progress:
            test = run_blindtest(settings, plants, out, has_baseline=baseline, jobs=jobs, progress=progress)
            progress("writing the report", 1.0)
            places = test.write(out)
    except KeyboardInterrupt:
        raise Interrupted(f"interrupted; what is done is kept in {out}, and the same command goes on") from None
    if as_json:
        print_json(test.as_json())
        return
    for line in lines_of(test.as_json()):
        click.echo(line)
    click.echo(f"Report       {places['blindtest.html']}")
