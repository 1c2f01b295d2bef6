"""`valvemodel effects`: the library of effects, from their declarations."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import click

from valvemodel.commands.command import command, json_option, print_json
from valvemodel.commands.given import complete_effects

if TYPE_CHECKING:
    from rich.console import Console

    from valvemodel.declarations import Effect, Parameter

_PIPED_WIDTH = 120


@command(
    short_help="Which effects are known, with which parameters.",
    epilog="""\b
Examples:
  valvemodel effects
  valvemodel effects static_friction
  valvemodel effects --json""",
)
@click.argument("key", required=False, metavar="[KEY]", shell_complete=complete_effects)
@json_option
def effects(key: str | None, as_json: bool) -> None:
    """List the effects that the base model lacks, by stage; with KEY all about one of them."""
    from valvemodel.effects import effect_of_key
    from valvemodel.stages import EFFECTS

    found = EFFECTS if key is None else (effect_of_key(key),)
    if as_json:
        _print_json(found)
        return
    from rich.console import Console

    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=_PIPED_WIDTH)
    if key is None:
        _list(console, found)
    else:
        _show(console, found[0])


def _print_json(found: tuple[Effect, ...]) -> None:
    content = {"schema": "valvemodel.effects/1", "effects": [_as_json(effect) for effect in found]}
    print_json(content)


def _as_json(effect: Effect) -> dict[str, Any]:
    return {
        "key": effect.key,
        "stage": effect.stage,
        "title": effect.title,
        "meaning": effect.meaning,
        "equation": effect.equation,
        "source": effect.source,
        "parameters": {
            each.name: {
                "unit": each.unit,
                "meaning": each.meaning,
                "low": each.low,
                "high": each.high,
                "neutral": each.neutral,
                "typical": each.typical,
                "is_fitted": each.is_fitted,
            }
            for each in effect.parameters
        },
        "aliases": list(effect.aliases),
        "told_apart_by": effect.told_apart_by,
    }


def _list(console: Console, found: tuple[Effect, ...]) -> None:
    from rich import box
    from rich.table import Table

    for stage in dict.fromkeys(effect.stage for effect in found):
        table = Table(title=stage, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False, expand=True)
        table.add_column("effect", no_wrap=True)
        table.add_column("what it is", ratio=1)
        table.add_column("parameter \\[unit], bounds, neutral")
        for effect in found:
            if effect.stage == stage:
                parameters = "\n".join(
                    f"{each.name} {_bracketed(each)}, {_bounds(each)}, {_amount(each.neutral)}" for each in effect.shown
                )
                table.add_row(effect.key, _plain(effect.meaning), parameters)
        console.print(table)
    click.echo(f"{len(found)} effects. Bounds, equation and source: valvemodel effects {found[0].key}")


def _show(console: Console, effect: Effect) -> None:
    from rich import box
    from rich.table import Table

    console.print(f"[bold]{effect.key}[/bold]  {_plain(effect.title)} ({effect.stage})")
    lines = {
        "meaning": effect.meaning,
        "equation": _on_a_line(effect.equation),
        "source": effect.source,
        "comes close to": ", ".join(effect.aliases),
        "told apart by": effect.told_apart_by,
    }
    facts = Table(box=None, show_header=False, pad_edge=False)
    facts.add_column(no_wrap=True, style="bold")
    facts.add_column()
    for name, text in lines.items():
        if text:
            facts.add_row(name, _plain(text))
    console.print(facts)
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("parameter", "unit", "bounds", "neutral", "typical", "meaning"):
        table.add_column(heading, no_wrap=heading in ("parameter", "bounds"))
    for each in effect.shown:
        table.add_row(
            each.name,
            each.unit,
            _bounds(each),
            _amount(each.neutral),
            _amount(float(each.typical or 0.0)),
            _plain(each.meaning + ("" if each.is_fitted else " (not fitted)")),
        )
    console.print(table)
    first = next((each for each in effect.parameters if each.typical not in (None, each.neutral)), None)
    if first is not None:
        click.echo(f"Try it: valvemodel simulate --effect {effect.key}:{first.name}={first.typical:g} ...")


def _on_a_line(equation: str) -> str:
    """Return an equation in LaTeX as plain text; an exponent of several parts keeps its brackets."""
    from pylatexenc.latex2text import LatexNodes2Text

    grouped = re.sub(r"\^\{([^{}]*[^{}\w][^{}]*)\}", r"^{(\1)}", equation)
    text: str = LatexNodes2Text(math_mode="text").latex_to_text(grouped)
    return " ".join(text.split())


def _bracketed(parameter: Parameter) -> str:
    return f"\\[{parameter.unit}]"


def _bounds(parameter: Parameter) -> str:
    return f"{_amount(parameter.low)}..{_amount(parameter.high)}"


def _amount(value: float) -> str:
    return f"{value:g}"


def _plain(text: str) -> str:
    from rich.markup import escape

    return escape(text)
