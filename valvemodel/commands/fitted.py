"""What `valvemodel fit` prints: the parameters, what is determined and how, and the check of the residuals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from rich.table import Table as RichTable

    from identification.results.loop_shape import FittedShape
    from identification.results.outcome import Outcome
    from valvemodel.display import Table

_PIPED_WIDTH = 120


def print_outcome(outcome: Outcome) -> None:
    """Print a fit: one table of parameters, one of residual checks, and what the records cannot say."""
    from rich.console import Console

    from identification.results.display import (
        check_table,
        determined_lines,
        error_words,
        parameter_table,
        smoothing_table,
    )
    from valvemodel.quantities import format_quantity

    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=_PIPED_WIDTH)
    console.print(_laid_out(parameter_table(outcome)))
    for line in determined_lines(outcome.determined):
        console.print(line, soft_wrap=True, markup=False)
    if outcome.checks:
        console.print(_laid_out(check_table(outcome)))
    if outcome.smoothing:
        console.print(_laid_out(smoothing_table(outcome)))
    click.echo(f"error (rms)  {error_words(outcome)}")
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


def _laid_out(table: Table) -> RichTable:
    """Lay a table out for the terminal: words in the first and last column, numbers between."""
    from rich import box
    from rich.markup import escape
    from rich.table import Table as RichTable

    laid = RichTable(box=box.SIMPLE_HEAD, pad_edge=False)
    first, *between, last = table.headings
    laid.add_column(first, no_wrap=True)
    for heading in between:
        laid.add_column(heading, justify="right", no_wrap=True)
    laid.add_column(last)
    for row in table.rows:
        laid.add_row(*map(escape, row))
    return laid
