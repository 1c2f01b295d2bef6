"""The answer on the terminal: the same words as on the page, in 80 columns, readable when piped."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from diagnosis.report.naming import NO_BREAK_SPACE, capitalised, printable, tied
from diagnosis.report.words import Answer, ParameterWords, make_answer

if TYPE_CHECKING:
    from rich.console import Console

_LABEL_WIDTH = 13
_WIDEST = 100
_SHOWN_CAUSES = 5
_COLOURS = {"effect": "bold", "none": "bold green"}


def print_answer(diagnosis: Mapping[str, Any], console: Console, places: Mapping[str, str | Path]) -> None:
    """Print a diagnosis.

    Parameters
    ----------
    diagnosis : mapping
        The content of `diagnosis.json`.
    console : rich.console.Console
        Where to print.
    places : mapping of str to path
        What was written, and where.
    """
    answer = make_answer(diagnosis)
    _print(console, answer.headline, style=_COLOURS.get(answer.verdict, "bold yellow"))
    _print(console, " ".join(part for part in (answer.explanation, answer.confidence) if part))
    _print(console, "")
    _print_labelled(console, "Where", [" ".join(answer.where)])
    _print_labelled(console, "How far", _how_far(answer))
    _print_labelled(console, "Causes", _causes(answer))
    _print_labelled(console, "Cannot tell", _cannot_tell(answer))
    _print_labelled(console, "Next step", [answer.next_step])
    _print_labelled(console, "Warnings", answer.warnings)
    for name, place in places.items():
        _print(console, str(place), label=capitalised(name), wraps=False)


def _print_labelled(console: Console, label: str, lines: Iterable[str]) -> None:
    lines = list(lines)
    for number, line in enumerate(lines):
        _print(console, line, label="" if number else label, indent=_LABEL_WIDTH)
    if lines:
        _print(console, "")


def _print(
    console: Console, line: str, *, label: str = "", indent: int = 0, style: str = "", wraps: bool = True
) -> None:
    """Print one line of text, never read as markup, wrapped with its continuation under its first word."""
    from rich.text import Text

    hanging = len(line) - len(line.lstrip(" -"))
    width = max(40, min(console.width, _WIDEST) - indent)
    line = printable(line)
    parts = [line]
    if wraps:
        parts = textwrap.wrap(tied(line), width, subsequent_indent=" " * hanging, break_on_hyphens=False) or [""]
    for number, part in enumerate(parts):
        text = Text()
        if label or indent:
            text.append("" if number else label, style="bold").pad_right(max(1, _LABEL_WIDTH - len(text)))
        console.print(text.append(part.replace(NO_BREAK_SPACE, " "), style=style or None), soft_wrap=True)


def _how_far(answer: Answer) -> list[str]:
    width = max((len(value) for _, value in answer.gap_rows), default=0)
    rows = [f"{value:>{width}}  {name}" for name, value in answer.gap_rows]
    return [*rows, answer.gap_measure, *filter(None, [answer.closes, answer.refit])] if rows else []


def _causes(answer: Answer) -> list[str]:
    lines = []
    has_parameters = False
    for cause in answer.causes[:_SHOWN_CAUSES]:
        closes = f" (closes {cause.closed})" if cause.closed != "–" else ""
        lines.append(f"{cause.probability_text:>9}  {cause.title}{closes}")
        if cause.effects and not has_parameters:
            has_parameters = True
            lines += [_parameter(each) for effect in cause.effects for each in effect.parameters]
    return lines


def _parameter(found: ParameterWords) -> str:
    """Return the line of a parameter, with what it means, less the letter that it has in the equation."""
    meaning = re.sub(r"^\S{1,4}: ", "", found.meaning)
    return f"{'':11}{found.name} = {found.value}" + (f" ({meaning})" if meaning else "")


def _cannot_tell(answer: Answer) -> list[str]:
    lines = [each for each in (answer.alternatives_sentence, answer.hiding) if each]
    telling = [
        f"- {each.title}: {'; or '.join(each.told_apart_by)}" for each in answer.alternatives if each.told_apart_by
    ]
    if telling:
        lines += ["What would:", *telling]
    return [*lines, answer.others] if answer.others else lines
