"""`valvemodel valves`: the valve sets and files, and whether their numbers can be true."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from valvemodel.commands.command import command, json_option, print_json
from valvemodel.commands.given import complete_valves

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from valvemodel.valves import Valve


@command(
    short_help="Which valves are known, and whether their numbers can be true.",
    epilog="""\b
Examples:
  valvemodel valves
  valvemodel valves table2
  valvemodel valves calibrated --toml > my_valve.toml
  valvemodel valves my_valve.toml --json""",
)
@click.argument("names", nargs=-1, metavar="[SET|FILE]...", shell_complete=complete_valves)
@click.option("--toml", "as_toml", is_flag=True, help="Print the file of one set: a form for a valve of your own.")
@json_option
def valves(names: tuple[str, ...], as_toml: bool, as_json: bool) -> None:
    """List the valve sets with what is doubtful about them, or show every entry of those named.

    A valve of your own is a TOML file with a table for each number:

    \b
      [spring_rate]
      value = 52.5
      unit = "N/mm"
      source = "data sheet"

    With the line `based_on = "calibrated"` on top it may lack numbers, as of friction and nozzle: they are taken
    from that set, and a fit or a diagnosis finds what they are.
    """
    from valvemodel.valves import read_valve, valve_names, valve_text

    if as_toml:
        if as_json or len(names) != 1:
            raise click.UsageError("--toml goes with one valve set, and not with --json.")
        click.echo(valve_text(names[0]), nl=False)
        return
    found = [read_valve(name) for name in names or valve_names()]
    if as_json:
        _print_json(found)
        return
    from rich.console import Console

    console = Console(highlight=False)
    if names:
        for valve in found:
            _show(console, valve)
    else:
        _list(console, found)


def _print_json(found: list[Valve]) -> None:
    content = {"schema": "valvemodel.valves/1", "valves": [_as_json(valve) for valve in found]}
    print_json(content)


def _as_json(valve: Valve) -> dict[str, Any]:
    from valvemodel.base_valve import BASE_PARAMETERS
    from valvemodel.valves import figures, plausibility

    found = figures(valve)
    return {
        "name": valve.name,
        "what": valve.what,
        "source": valve.source,
        "parameters": {
            parameter.name: {"value": valve.values[parameter.name], "unit": parameter.unit}
            for parameter in BASE_PARAMETERS
        },
        "entries": {
            name: {
                "value": entry.value,
                "unit": entry.unit,
                "source": entry.source,
                "is_given": entry.is_given,
            }
            for name, entry in valve.entries.items()
        },
        "figures": {
            "pressure": {"low": found.pressure.min(), "high": found.pressure.max(), "unit": "Pa"},
            "gap": None if found.gap is None else {"low": found.gap.min(), "high": found.gap.max(), "unit": "m"},
            "travel": {"low": found.travel[0], "high": found.travel[1], "unit": "m"},
            "dead_band": {"value": found.dead_band, "unit": "1"},
            "damping_ratio": {"value": found.damping_ratio, "unit": "1"},
            "period": {"value": found.period, "unit": "s"},
            "settling": {"value": found.settling, "unit": "s"},
        },
        "warnings": [{"check": doubt.check, "text": doubt.text} for doubt in plausibility(valve)],
    }


def _list(console: Console, found: list[Valve]) -> None:
    from valvemodel.valves import figures, plausibility

    table = _table("valve", "pressure at 4..20 mA", "travel", "damping ratio", "what it is")
    for valve in found:
        of = figures(valve)
        table.add_row(
            valve.name,
            _range(of.pressure.min(), of.pressure.max(), "Pa"),
            _range(*of.travel, "m"),
            f"{of.damping_ratio:.3g}",
            _plain(valve.what),
        )
    console.print(table)
    for valve in found:
        if count := len(plausibility(valve)):
            name = _plain(valve.name)
            console.print(f"[yellow]{count} warnings[/yellow] about {name}: `valvemodel valves {name}` shows them")


def _show(console: Console, valve: Valve) -> None:
    console.print(f"[bold]{_plain(valve.name)}[/bold]  {_plain(valve.what)}")
    table = _table("entry", "value", "unit", "source")
    for name, entry in valve.entries.items():
        style = None if entry.is_given else "dim"
        table.add_row(name, f"{entry.value:.5g}", _plain(entry.unit), _plain(entry.source), style=style)
    console.print(table)
    if not _warn(console, valve):
        console.print("no warnings: the numbers are plausible")


def _warn(console: Console, valve: Valve) -> bool:
    """Print the warnings about a valve and return whether there were any."""
    from valvemodel.valves import plausibility

    doubts = plausibility(valve)
    for doubt in doubts:
        console.print(
            f"[yellow]warning[/yellow] {_plain(valve.name)}, {doubt.check}: {_plain(doubt.text)}",
            soft_wrap=True,
        )
    return bool(doubts)


def _table(*columns: str) -> Table:
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for column in columns:
        table.add_column(column, overflow="fold")
    return table


def _range(low: float, high: float, unit: str) -> str:
    from valvemodel.quantities import format_quantity

    low_text, high_text = format_quantity(low, unit), format_quantity(high, unit)
    low_number, _, low_unit = low_text.partition(" ")
    return f"{low_number}..{high_text}" if high_text.endswith(f" {low_unit}") else f"{low_text} .. {high_text}"


def _plain(text: str) -> str:
    """Return text from a file so that it cannot carry markup or control characters to the terminal."""
    from rich.markup import escape

    return escape("".join(character for character in text if character.isprintable()))
