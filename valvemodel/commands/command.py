"""What commands share in how they speak: `--quiet` for all of them, `--json` for those that answer machines."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import redirect_stderr, redirect_stdout
from functools import partial
from typing import Any

import click

_IS_QUIET = "valvemodel.is_quiet"


class Count(click.IntRange):
    """A whole number within bounds, in the help an N."""

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        """Return what stands for it in the help."""
        return "N"


def _keep_quiet(context: click.Context, option: click.Parameter, is_quiet: bool) -> None:
    context.meta[_IS_QUIET] = is_quiet


class Command(click.Command):
    """A command that can keep quiet: with `--quiet` nothing it prints arrives, only the message of an error."""

    def __init__(self, name: str | None, *, params: list[click.Parameter] | None = None, **given: Any) -> None:
        quiet = click.Option(
            ["--quiet"],
            is_flag=True,
            expose_value=False,
            callback=_keep_quiet,
            help="Print nothing but errors; files and exit status say it all.",
        )
        super().__init__(name, params=[*(params or ()), quiet], **given)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command; errors are shown later, when its output is open again."""
        if not ctx.meta.get(_IS_QUIET):
            return super().invoke(ctx)
        if ctx.params.get("as_json"):
            raise click.UsageError("--json and --quiet exclude each other: give one of them.")
        with open(os.devnull, "w", encoding="utf-8") as nowhere, redirect_stdout(nowhere), redirect_stderr(nowhere):
            return super().invoke(ctx)


command = partial(click.command, cls=Command)
"""Make a function a command of `valvemodel`, as `click.command` does."""

json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON for machines instead of words.")


def print_json(content: Mapping[str, Any] | list[Any]) -> None:
    """Print what a machine can read on standard output, infinities and gaps as null."""
    import json

    from valvemodel.files import finite

    click.echo(json.dumps(finite(content), indent=1, ensure_ascii=False, allow_nan=False))
