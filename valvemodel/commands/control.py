"""`valvemodel control`: PID, self-calibration, SC-PID and their rivals in closed loops on the exact valve."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from valvemodel.commands.command import Count, command, json_option, print_json
from valvemodel.commands.control_answer import print_contest, print_findings
from valvemodel.commands.given import effects_option, model_given, model_option, valve_option, with_effects
from valvemodel.commands.places import check_folder, write_together
from valvemodel.commands.waiting import progress_shown

if TYPE_CHECKING:
    from valvemodel.control.contest import Contest
    from valvemodel.control.grid import Grid
    from valvemodel.model import Model


@command(
    short_help="Which controller is best on a valve.",
    epilog="""\b
Examples:
  valvemodel control --out contest
  valvemodel control --effect static_friction:static_friction_ratio=1.3 --out contest
  valvemodel control --model report/model.json --setpoints "120 mm, 60 %, 130 mm" --period "20 ms" --out contest
  valvemodel control --claims --out claims""",
)
@valve_option
@model_option
@effects_option
@click.option(
    "--setpoints",
    metavar="LIST",
    help='Set points, each held in turn: "120 mm, 60 %, 130 mm" (% of the rated travel).  '
    "[default: long and short steps within the valve's reach]",
)
@click.option("--duration", metavar="TIME", default="20 s", show_default=True, help="For which each set point is held.")
@click.option("--period", metavar="TIME", default="10 ms", show_default=True, help="Controller period.")
@click.option(
    "--noise",
    metavar="LENGTH",
    default="0.1 mm",
    show_default=True,
    help="Standard deviation of the noise on the controller's reading.",
)
@click.option(
    "--resolution",
    metavar="LENGTH",
    default="0 mm",
    show_default=True,
    help="Step of the controller's reading; 0 for none.",
)
@click.option(
    "--load",
    metavar="FORCE",
    default="0 N",
    show_default=True,
    help="Disturbance: a force on the stem in the second half of each set point, positive against a rise.",
)
@click.option("--seed", type=Count(min=0), default=0, show_default=True, help="Of the noise.")
@click.option(
    "--tuning-runs",
    type=Count(min=40),
    default=400,
    show_default=True,
    help="Settings that each controller may try; the same number for all; fewer for a slow valve.",
)
@click.option(
    "--claims",
    "tests_claims",
    is_flag=True,
    help="Instead, test the paper's claims over a grid of friction, gains, periods, noise and ageing (about 40 s).",
)
@click.option("--coarse", is_flag=True, help="With --claims: only two levels of each factor.")
@click.option(
    "--out",
    required=True,
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Folder for control.json, control.csv, control.png and control.svg; with --claims claims.json and claims.png.",
)
@json_option
def control(
    valve: str | None,
    model_file: Path | None,
    effects: tuple[str, ...],
    setpoints: str | None,
    duration: str,
    period: str,
    noise: str,
    resolution: str,
    load: str,
    seed: int,
    tuning_runs: int,
    tests_claims: bool,
    coarse: bool,
    out: Path,
    as_json: bool,
) -> None:
    """Run controllers on the same set points of an exactly simulated valve, and measure them.

    PID (34), self-calibration alone, SC-PID (41) in both readings of its threshold, the usual remedies for stiction,
    and two that use the model. Each is tuned by the same number of runs at the same cost, on other set points, on the
    valve as it is and with its friction grown by a fifth. Controllers see the noisy reading only; measures are of
    the stem's true position.
    """
    if coarse and not tests_claims:
        raise click.UsageError("--coarse goes with --claims.")
    given = click.get_current_context().get_parameter_source
    for name in ("setpoints", "duration", "load"):
        if tests_claims and given(name) is click.core.ParameterSource.COMMANDLINE:
            raise click.UsageError(f"--claims has set points of its own: leave --{name} out.")
    check_folder(out)
    from valvemodel.quantities import parse_quantity

    model = model_given(valve, model_file)[0]
    model, notes = with_effects(model, effects)
    conditions: dict[str, Any] = {
        "period": parse_quantity(period, unit="s"),
        "noise": parse_quantity(noise, unit="m"),
        "resolution": parse_quantity(resolution, unit="m"),
        "seed": seed,
        "budget": tuning_runs,
    }
    levels = None if setpoints is None else _levels(setpoints, model)
    held, force = parse_quantity(duration, unit="s"), parse_quantity(load, unit="N")
    for note in notes:
        click.echo(note, err=True)
    if tests_claims:
        from valvemodel.control.grid import COARSE, FACTORS, run_grid

        with progress_shown() as progress:
            grid = run_grid(
                model,
                **conditions,
                factors=COARSE if coarse else FACTORS,
                progress=progress,
            )
        places = write_together(out, lambda folder: _write_grid(grid, folder))
        if as_json:
            from valvemodel.control.claims import as_json as grid_json

            print_json(grid_json(grid))
            return
        print_findings(grid)
    else:
        from valvemodel.control.contest import hold_contest

        with progress_shown() as progress:
            contest = hold_contest(
                model,
                levels=levels,
                duration=held,
                **conditions,
                load=force,
                progress=progress,
            )
        places = write_together(out, lambda folder: _write_contest(contest, folder))
        if as_json:
            from valvemodel.control.contest_json import contest_json

            print_json(contest_json(contest))
            return
        print_contest(contest)
    for name, place in places.items():
        click.echo(f"{name:13s} {place}")


def _levels(text: str, model: Model) -> list[float]:
    """Read set points in lengths or in percent of the rated travel. [m]"""
    from valvemodel.errors import InputError
    from valvemodel.quantities import parse_quantity

    parts = [part.strip() for part in text.split(",")]
    if not all(parts):
        raise InputError("set points are separated by single commas", f"got {text!r}", 'write "120 mm, 60 %"')
    return [
        model.values["rated_travel"] * parse_quantity(part, unit="1")
        if part.endswith("%")
        else parse_quantity(part, unit="m")
        for part in parts
    ]


def _write_contest(contest: Contest, folder: Path) -> dict[str, Path]:
    from valvemodel.control.contest_figure import draw_contest
    from valvemodel.control.contest_json import contest_json
    from valvemodel.files import write_json
    from valvemodel.records import write_table

    names = ("control.json", "control.csv", "control.png", "control.svg")
    places = {name: folder / name for name in names}
    write_json(places["control.json"], contest_json(contest))
    columns = {"time [s]": contest.scenario.time, "setpoint [mm]": 1e3 * contest.scenario.setpoint}
    for entry in contest.entries:
        columns[f"{entry.kind.key} current [mA]"] = 1e3 * entry.run.current
        columns[f"{entry.kind.key} reading [mm]"] = 1e3 * entry.run.reading
        columns[f"{entry.kind.key} position [mm]"] = 1e3 * entry.run.position
    write_table(places["control.csv"], columns)
    draw_contest(contest, [places["control.png"], places["control.svg"]])
    return places


def _write_grid(grid: Grid, folder: Path) -> dict[str, Path]:
    from valvemodel.control.claims import as_json
    from valvemodel.control.claims_figure import draw_claims
    from valvemodel.files import write_json

    places = {name: folder / name for name in ("claims.json", "claims.png")}
    write_json(places["claims.json"], as_json(grid))
    draw_claims(grid, places["claims.png"])
    return places
