"""The command line: `valvemodel COMMAND`, each command loaded when it is called."""

from __future__ import annotations

import os
import sys
from importlib import import_module
from typing import Any, NoReturn

import click

from valvemodel.commands.interruption import listen
from valvemodel.commands.trouble import BadInput, Interrupted
from valvemodel.errors import InputError, unknown_name

COMMANDS = (
    *("diagnose", "fit", "design"),
    *("simulate", "control", "move", "linearise", "figures"),
    *("effects", "valves", "derive", "blindtest"),
)
"""In the order in which they are listed; each is a function of its own name in a module of its own name."""


class LazyGroup(click.Group):
    """Commands that are imported when they are called, and the user's mistakes as messages."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import a command and return it."""
        if cmd_name in COMMANDS:
            return getattr(import_module(f"valvemodel.commands.{cmd_name}"), cmd_name)
        if ctx.resilient_parsing or cmd_name.startswith("-"):
            return None
        raise BadInput(unknown_name("a command", cmd_name, COMMANDS))

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command; what the user can mend ends as one message, without a traceback."""
        try:
            return super().invoke(ctx)
        except InputError as error:
            raise BadInput(error) from None
        except KeyboardInterrupt:
            raise Interrupted from None


@click.command(
    cls=LazyGroup,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Example: valvemodel diagnose record.csv --out report",
)
@click.version_option(package_name="valvemodel", message="valvemodel %(version)s")
def command_line() -> None:
    """Model an electro-pneumatic control valve, and find why model and valve disagree."""


def main() -> NoReturn:
    """Run the command line and end the process with its status: 0 done, 2 bad input, 130 interrupted."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    listen()
    command_line.main(prog_name="valvemodel")
    sys.exit(0)
