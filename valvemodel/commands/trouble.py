"""How a command ends where it cannot go on: one message on standard error and an exit status."""

from __future__ import annotations

from typing import IO, Any

import click

from valvemodel.errors import InputError


class BadInput(click.ClickException):
    """A mistake in what the user gave, exit status 2."""

    exit_code = 2

    def __init__(self, error: InputError) -> None:
        super().__init__(str(error))
        self.error = error

    def show(self, file: IO[Any] | None = None) -> None:
        """Print the rule, what arrived and what to do, a line each."""
        lines = (self.error.rule, f"  found:  {self.error.arrived}", f"  remedy: {self.error.remedy}")
        text = "\n".join(printable(line) for line in lines)
        click.echo(f"valvemodel: error: {text}", file=file, err=True)


class Interrupted(click.ClickException):
    """Ctrl-C, exit status 130."""

    exit_code = 130

    def __init__(self, message: str = "interrupted; nothing was written") -> None:
        super().__init__(message)

    def show(self, file: IO[Any] | None = None) -> None:
        """Print that the command was interrupted."""
        click.echo(f"valvemodel: {self.message}", file=file, err=True)


def printable(text: str) -> str:
    """Return text that cannot carry control characters of a file to the terminal."""
    return "".join(character if character.isprintable() else "�" for character in text)


def warn(texts: tuple[str, ...] | list[str]) -> None:
    """Print warnings on standard error, a line each."""
    for text in texts:
        click.echo(f"valvemodel: warning: {printable(text)}", err=True)
