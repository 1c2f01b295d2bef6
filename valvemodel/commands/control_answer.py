"""What `valvemodel control` prints."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from valvemodel.control.contest import Contest
    from valvemodel.control.grid import Grid

_PIPED_WIDTH = 160


def print_contest(contest: Contest) -> None:
    """Print the calibration and a table of what was measured."""
    from rich import box
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    click.echo(_calibration_line(contest))
    headings = (
        "controller", "settled", "after [s]", "over [mm]", "off [mm]", "∫|e| [mm s]",
        "turns", "way [mm]", "cycle [mm]", "cycle [s]",
    )  # fmt: skip
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in headings:
        table.add_column(escape(heading), justify="left" if heading == "controller" else "right", no_wrap=True)
    for entry in contest.entries:
        measured = entry.overall
        lengths = [1e3 * measured[name] for name in _LENGTHS]
        table.add_row(
            entry.kind.title,
            f"{100 * measured['settled_share']:.0f} %",
            _number(measured["settling_time"]),
            *(_number(value) for value in lengths[:3]),
            f"{measured['reversals']:.0f}",
            *(_number(value) for value in lengths[3:]),
            _number(measured["limit_cycle_period"]),
        )
    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=_PIPED_WIDTH)
    console.print(table)
    click.echo(_LEGEND)
    if contest.has_one_friction:
        click.echo(
            "static equals sliding friction here, so nothing sticks and slips: "
            "see --effect static_friction:static_friction_ratio=1.3"
        )


_LENGTHS = ("overshoot", "steady_error", "integral_absolute_error", "travelled_distance", "limit_cycle_amplitude")


_LEGEND = (
    "settled: share of set points kept within 1 % of the travel, after the mean time; over: largest overshoot; off: "
    "largest steady error;\nturns: reversals of the stem; way: travelled distance; cycle: amplitude and period of "
    "lasting oscillation"
)


def _number(value: float) -> str:
    return f"{value:.3g}" if math.isfinite(value) else "none"


def _calibration_line(contest: Contest) -> str:
    """Say what self-calibration found and how far the loop's true width is from it along the travel."""
    from valvemodel.control.contest_json import calibration_json

    found = calibration_json(contest.bench)
    widths = ", ".join(
        f"{1e3 * each['value']:.2f} mA {each['where']} ({100 * each['error_of_threshold']:+.1f} %)"
        for each in found["true_width"]
    )
    return f"self-calibration: I_threshold {1e3 * found['threshold']['value']:.3f} mA; true width of the loop {widths}"


def print_findings(grid: Grid) -> None:
    """Print what a grid says, a line each."""
    from valvemodel.control.claims import findings_of

    for text in findings_of(grid):
        click.echo(f"- {text}")
