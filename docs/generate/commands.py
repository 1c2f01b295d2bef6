"""A page a command: what it is for and how to read its answer (how_to/), then every option from the command itself."""

from __future__ import annotations

from importlib import import_module
from inspect import cleandoc
from pathlib import Path

import click
import mkdocs_gen_files

from valvemodel.commands import COMMANDS

HOW_TO = Path(__file__).resolve().parents[1] / "how_to"


def plain(text: str | None) -> str:
    """Help text without click's marks, safe in a table."""
    return cleandoc(text or "").replace("\b", "").replace("|", "\\|").replace("<", "&lt;").strip()


def option_row(option: click.Parameter, context: click.Context) -> str:
    if isinstance(option, click.Argument):
        return f"| `{option.make_metavar(context)}` | |"
    assert isinstance(option, click.Option)
    written = ", ".join(f"`{name}`" for name in option.opts)
    takes = "" if option.is_flag else f" {option.make_metavar(context)}"
    return f"| {written}{plain(takes)} | {plain(option.help)} |"


def page_of(name: str) -> str:
    command: click.Command = getattr(import_module(f"valvemodel.commands.{name}"), name)
    context = click.Context(command, info_name=f"valvemodel {name}")
    examples = (command.epilog or "").replace("\b", "").replace("Examples:", "").replace("Example:", "").rstrip()
    rows = "\n".join(option_row(option, context) for option in command.params)
    return "\n\n".join(
        [
            (HOW_TO / f"{name}.md").read_text(encoding="utf-8").strip(),
            "## Examples",
            "```text\n" + "\n".join(line.strip() for line in examples.splitlines() if line.strip()) + "\n```",
            "## What it says of itself",
            plain(command.help),
            f"    {command.get_usage(context)}",
            f"| option | meaning |\n|---|---|\n{rows}",
        ]
    )


for name in COMMANDS:
    with mkdocs_gen_files.open(f"commands/{name}.md", "w") as page:
        page.write(page_of(name) + "\n")

with mkdocs_gen_files.open("navigation.md", "w") as navigation:
    commands = "\n".join(f"    * [{name}](commands/{name}.md)" for name in COMMANDS)
    navigation.write(
        f"""* [Start](index.md)
* [Tutorial: from a record to a cause](tutorial.md)
* Commands
    * [The command line](command_line.md)
{commands}
* Explanation
    * [The valve and its physics](explanation/physics.md)
    * [How a cause is found and judged](explanation/diagnosis.md)
    * [Blind tests: how often it is right](blind_tests.md)
    * [The paper's equations](explanation/derivations.md)
* Effect library
    * [Electromagnet](effects/electromagnet.md)
    * [Nozzle](effects/nozzle.md)
    * [Stem](effects/stem.md)
    * [Sensor](effects/sensor.md)
* [Library reference](reference.md)
* [Glossary](glossary.md)
"""
    )
