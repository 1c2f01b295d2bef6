"""`valvemodel linearise`: the valve's answer to small changes, and the limit cycle of a loop around it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from valvemodel.commands.command import Count, command
from valvemodel.commands.given import effects_option, model_given, model_option, valve_option, with_effects
from valvemodel.commands.places import check_file, check_folder, write_together
from valvemodel.commands.waiting import progress_shown

if TYPE_CHECKING:
    from valvemodel.linear import LimitCycle, Linearisation, Loop
    from valvemodel.linear.feedback import Gains


@command(
    short_help="Poles, margins and limit cycles at an operating point.",
    epilog="""\b
Examples:
  valvemodel linearise --at "12 mA"
  valvemodel linearise --at "8 mA" --mode falling --effect coil_lag --out linear
  valvemodel linearise --at "12 mA" --valve linear --effect static_friction --limit-cycle \\
      --kp "0 mA/mm" --ki "0.4 mA/(mm*s)" --out cycle
  valvemodel linearise --model report/base.json --at "12 mA" --limit-cycle --lag "5 s" --dead-time "1 s" """,
)
@valve_option
@model_option
@click.option("--at", "place", required=True, metavar="CURRENT", help='Current of the operating point, as "12 mA".')
@click.option(
    "--mode",
    type=click.Choice(["rising", "falling", "stuck"]),
    help="In slip on that branch, or stuck: small moves before the stem breaks away.  [default: all three]",
)
@click.option("--speed", default="0 m/s", show_default=True, metavar="SPEED", help="Of the stem in slip.")
@effects_option
@click.option("--kp", metavar="GAIN", help='Of the PID, as "0.05 mA/mm".  [default: half of the inverse static gain]')
@click.option("--ki", metavar="GAIN", help='As "0.1 mA/(mm*s)".  [default: the inverse static gain, per second]')
@click.option("--kd", metavar="GAIN", default="0 A*s/m", show_default=True, help='As "0.001 mA*s/mm".')
@click.option("--pade-order", type=Count(1, 10), default=4, show_default=True, help="Of the line's dead time.")
@click.option(
    "--limit-cycle",
    "seeks_cycle",
    is_flag=True,
    help="Also the limit cycle of a PI loop around the valve: by describing function, by return map, simulated.",
)
@click.option("--lag", default="0 s", metavar="TIME", show_default=True, help="Of a process behind the valve.")
@click.option("--dead-time", default="0 s", metavar="TIME", show_default=True, help="Of a process behind the valve.")
@click.option("--period", default="1 ms", metavar="TIME", show_default=True, help="Of the controller in the loop.")
@click.option("--json", "json_file", metavar="FILE", type=click.Path(path_type=Path), help="Write linearise.json here.")
@click.option(
    "--out",
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Folder for linearise.json and figures: bode, root_locus, margins, with --limit-cycle limit_cycle.",
)
def linearise(
    valve: str | None,
    model_file: Path | None,
    place: str,
    mode: str | None,
    speed: str,
    effects: tuple[str, ...],
    kp: str | None,
    ki: str | None,
    kd: str,
    pade_order: int,
    seeks_cycle: bool,
    lag: str,
    dead_time: str,
    period: str,
    json_file: Path | None,
    out: Path | None,
) -> None:
    """Linearise a valve at an operating point: state space, transfer functions, poles, margins with a PID.

    Derivatives are symbolic. Effects without a linearisation are named and left out. With --limit-cycle a PI
    loop is closed around the valve, and around a process behind it where --lag or --dead-time is given.
    """
    if out is not None:
        check_folder(out)
    if json_file is not None:
        check_file(json_file)
    from valvemodel.linear import Loop
    from valvemodel.linear import linearise as run
    from valvemodel.linear.feedback import Gains, usual_gains
    from valvemodel.linear.report import content, loop_content
    from valvemodel.quantities import parse_quantity

    model = model_given(valve, model_file)[0]
    model, notes = with_effects(model, effects)
    for note in notes:
        click.echo(note, err=True)
    current, pace = parse_quantity(place, unit="A"), parse_quantity(speed, unit="m/s")
    modes = ["rising", "falling", "stuck"] if mode is None else [mode]
    found = [run(model, current=current, mode=each, speed=pace, pade_order=pade_order) for each in modes]
    usual = usual_gains(run(model, current=current))
    gains = Gains(
        usual.proportional if kp is None else parse_quantity(kp, unit="A/m"),
        usual.integral if ki is None else parse_quantity(ki, unit="A/(m*s)"),
        parse_quantity(kd, unit="A*s/m"),
    )
    result = content(found, gains)
    loop, cycles = None, None
    if seeks_cycle:
        times = (parse_quantity(each, unit="s") for each in (lag, dead_time, period))
        loop = Loop(model, current, gains.proportional, gains.integral, *times)
        cycles = _seek(loop)
        result["limit_cycle"] = loop_content(loop, cycles)
    _show(found, result)
    if json_file is not None:
        from valvemodel.files import write_json

        write_json(json_file, result)
        click.echo(f"wrote {json_file}", err=True)
    if out is not None:
        places = write_together(out, lambda folder: _write(folder, found, gains, result, loop, cycles))
        click.echo(f"wrote {', '.join(str(each) for each in places.values())}", err=True)


def _seek(loop: Loop) -> dict[str, LimitCycle | None]:
    from valvemodel.linear.comparison import compare

    with progress_shown() as progress:
        progress("seeking the limit cycle", 0.1)
        return compare(loop)


def _write(
    folder: Path,
    found: list[Linearisation],
    gains: Gains,
    result: dict[str, Any],
    loop: Loop | None,
    cycles: dict[str, LimitCycle | None] | None,
) -> dict[str, Path]:
    from valvemodel.drawing import drawn
    from valvemodel.files import write_json
    from valvemodel.linear.figures import draw_bode, draw_limit_cycle, draw_margins, draw_root_locus, moving

    write_json(folder / "linearise.json", result)
    names = ["bode"]
    with drawn(folder, "bode", size=(12.0, 6.5)) as figure:
        draw_bode(figure, found)
    if still_moving := moving(found):
        names += ["root_locus", "margins"]
        with drawn(folder, "root_locus", size=(5.0 * len(still_moving) + 0.5, 5.2)) as figure:
            draw_root_locus(figure, found, gains)
        with drawn(folder, "margins", size=(8.5, 6.5)) as figure:
            draw_margins(figure, found, gains)
    if loop is not None and cycles is not None:
        names.append("limit_cycle")
        with drawn(folder, "limit_cycle", size=(12.0, 5.2)) as figure:
            draw_limit_cycle(figure, loop, cycles)
    files = ["linearise.json", *(f"{name}.{kind}" for name in names for kind in ("png", "svg"))]
    return {file: folder / file for file in files}


def _show(found: list[Linearisation], result: dict[str, Any]) -> None:
    """Print the operating points, gains, poles and margins, and how the effects enter."""
    for each, facts in zip(found, result["linearisations"], strict=True):
        _show_point(each, facts)
    treated = [(key, treatment) for key, treatment in found[0].effects.items()]
    for key, treatment in treated:
        click.echo(f"{key}: {'' if treatment.is_linear else 'not linearised; '}{treatment.how}")
    if "limit_cycle" in result:
        _show_cycles(result["limit_cycle"])


def _show_point(found: Linearisation, facts: dict[str, Any]) -> None:
    from valvemodel.quantities import format_quantity

    point = found.point
    click.echo(
        f"{point.mode} at {format_quantity(point.current, 'A')}: {format_quantity(point.pressure, 'Pa')}, "
        f"stem at {format_quantity(point.position, 'm')}, reading {format_quantity(point.reading, 'm')}"
    )
    gains = {name: facts["transfer_functions"][name]["static_gain"]["value"] for name in facts["transfer_functions"]}
    click.echo(
        f"  static gains: {1e-6 * gains['current_to_pressure']:.5g} kPa/mA, "
        f"{1e6 * gains['pressure_to_position']:.5g} mm/kPa, current to reading {gains['current_to_reading']:.5g} mm/mA"
    )
    for pole in facts["poles"]:
        if pole["pole"][1] >= 0.0:
            click.echo(f"  pole {_pole(pole)}")
    if facts["margins"] is None:
        click.echo("  the stem does not move before it breaks away")
        return
    margins = facts["margins"]
    click.echo(
        f"  with the PID {'stable' if margins['is_stable'] else 'unstable'}: gain margin "
        f"{margins['gain_margin']:.4g}, phase margin {math.degrees(margins['phase_margin']):.4g} deg"
    )


def _pole(pole: dict[str, Any]) -> str:
    real, imaginary = pole["pole"]
    if imaginary == 0.0:
        return f"{real:.5g} 1/s: time constant {pole['time_constant']:.4g} s"
    return (
        f"{real:.5g} +- {imaginary:.5g}j 1/s: {pole['frequency']:.4g} rad/s, damping ratio {pole['damping_ratio']:.4g}"
    )


def _show_cycles(facts: dict[str, Any]) -> None:
    for name, cycle in facts["limit_cycles"].items():
        words = name.replace("_", " ")
        if cycle is None:
            click.echo(f"limit cycle by {words}: none")
            continue
        stability = "" if cycle["multiplier"] is None else f", multiplier {cycle['multiplier']:.4g}"
        error = facts["errors"].get(name)
        off = (
            f", {100 * error['period']:+.2f} % off the simulation"
            if error and error["period"] == error["period"]
            else ""
        )
        click.echo(
            f"limit cycle by {words}: period {cycle['period']['value']:.5g} s, "
            f"amplitude {1e3 * cycle['amplitude']['value']:.4g} mm{stability}{off}"
        )
