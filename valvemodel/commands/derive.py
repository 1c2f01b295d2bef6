"""`valvemodel derive`: the paper's equations derived again, and the code that is generated from them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from valvemodel.commands.command import command, json_option, print_json
from valvemodel.errors import InputError, unknown_name
from valvemodel.files import write_text

if TYPE_CHECKING:
    from derivations import Verdict

_PIPED_WIDTH = 100
_FIELDS = ("equation", "verdict", "printed", "derived", "steps", "right")


@command(short_help="Which of the paper's equations hold, and why.", epilog="Example: valvemodel derive --equation 27")
@click.option("--equation", metavar="ID", help="Show the steps for one id only: 27, table-2, state-2, text-n, ...")
@json_option
@click.option("--latex", "as_latex", is_flag=True, help="Print a LaTeX document part, for an article with amsmath.")
@click.option("--write", is_flag=True, help="Write valvemodel/equations/*.py anew from the derivations.")
def derive(equation: str | None, as_json: bool, as_latex: bool, write: bool) -> None:
    """Derive the paper's equations again and say which hold.

    Each equation is derived from its premises and compared with the printed one; the table tells what
    was found. With --write the functions that the simulator runs are generated from the derived forms.
    """
    if sum((as_json, as_latex, write)) > 1 or (write and equation):
        raise InputError(
            "derive takes one of --json, --latex, --write",
            "got several, or --equation with --write",
            "leave out all but one",
        )
    if write:
        _write_modules()
        return
    findings = _findings(equation)
    if as_json:
        print_json([_plain(one) for one in findings])
    elif as_latex:
        from derivations import latex

        click.echo(latex(findings))
    elif equation:
        _show_steps(findings)
    else:
        _show_table(findings)


def _findings(equation: str | None) -> list[Verdict]:
    """Compute the findings, of one id or of all, with a sign of life on a terminal."""
    from rich.console import Console

    with Console(stderr=True).status("deriving (1)-(41) again ..."):
        from derivations import verdicts

        findings = verdicts()
    if equation is None:
        return findings
    wanted = equation.strip().strip("()").lower()
    chosen = [one for one in findings if one.equation == wanted]
    if not chosen:
        raise unknown_name("equation", equation, {one.equation for one in findings})
    return chosen


def _plain(finding: Verdict) -> dict[str, object]:
    values = {name: getattr(finding, name) for name in _FIELDS}
    return values | {"steps": list(finding.steps)}


def _show_table(findings: Sequence[Verdict]) -> None:
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    table.add_column("equation", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    table.add_column("what is right")
    for one in findings:
        colour = "green" if one.verdict == "holds" else "yellow"
        table.add_row(Text(one.equation), Text(one.verdict, style=colour), Text(one.right))
    console = Console()
    if not console.is_terminal:
        console = Console(width=_PIPED_WIDTH)
    console.print(table)
    errors = sum(one.verdict != "holds" for one in findings)
    click.echo(f"{len(findings)} findings, {errors} of them not 'holds'. Steps: valvemodel derive --equation 27")


def _show_steps(findings: Sequence[Verdict]) -> None:
    blocks = []
    for one in findings:
        steps = "\n".join(f"  {number}. {step}" for number, step in enumerate(one.steps, 1))
        blocks.append(
            f"{one.equation}: {one.verdict}\n  printed  {one.printed}\n  derived  {one.derived}\n{steps}\n"
            f"  right    {one.right}"
        )
    click.echo("\n\n".join(blocks))


def _write_modules() -> None:
    from derivations import render

    root = Path(__file__).resolve().parents[2]
    for path, text in render().items():
        file = root / path
        is_fresh = file.exists() and file.read_text(encoding="utf-8") == text
        write_text(file, text)
        click.echo(f"wrote {path} ({'as it was' if is_fresh else 'changed'})")
