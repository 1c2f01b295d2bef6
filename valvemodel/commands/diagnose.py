"""`valvemodel diagnose`: why a model does not match its valve, what is missing, how much better it gets."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from valvemodel.commands.command import Count, command, json_option, print_json
from valvemodel.commands.given import (
    base_given,
    columns_called,
    columns_option,
    measured_records,
    model_option,
    records_argument,
    valve_option,
)
from valvemodel.commands.places import check_file, check_folder, check_not_input, write_together
from valvemodel.commands.waiting import progress_shown
from valvemodel.errors import InputError
from valvemodel.progress import Progress

if TYPE_CHECKING:
    from diagnosis.next_experiment import Limits


@command(
    short_help="Why a model does not match its valve, and what is missing.",
    epilog="""\b
Examples:
  valvemodel diagnose record.csv --out report
  valvemodel diagnose monday.csv tuesday.csv --valve my_valve.toml --out report
  valvemodel diagnose record.csv --out report --next-experiment next.csv --next-duration "3 min"
  valvemodel diagnose record.csv --out report --json""",
)
@records_argument
@columns_option
@valve_option
@model_option
@click.option(
    "--out",
    required=True,
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Folder for diagnosis.json, base.json, model.json and report.html.",
)
@click.option(
    "--jobs",
    type=Count(min=1),
    help="Processes that search at the same time.  [default: one a core, at most 8]",
)
@click.option(
    "--next-experiment",
    "next_file",
    metavar="NEXT.csv",
    type=click.Path(path_type=Path),
    help="Design the current profile that tells the cause from its rivals best, and write it here.",
)
@click.option("--next-duration", default="120 s", show_default=True, metavar="QUANTITY", help="Its length.")
@click.option(
    "--next-range", nargs=2, default=("4 mA", "20 mA"), show_default=True, metavar="LOW HIGH", help="Its currents."
)
@click.option("--next-rate", metavar="QUANTITY", help='Its fastest change, as "2 mA/s".  [default: steps are allowed]')
@json_option
def diagnose(
    paths: tuple[Path, ...],
    columns: tuple[str, ...],
    valve: str | None,
    model_file: Path | None,
    out: Path,
    jobs: int | None,
    next_file: Path | None,
    next_duration: str,
    next_range: tuple[str, str],
    next_rate: str | None,
    as_json: bool,
) -> None:
    """Find where a valve and its model disagree, which effect causes it, and how far the gap shrinks with it.

    RECORD is a table of `time [s]`, `current [mA]`, `position [mm]` and perhaps `pressure [kPa]`: CSV,
    Parquet or MAT. Without time it is a settled loop; with `force [N]` instead of current the stem alone. The
    gap is scored on data that were not fitted: blocks in time of one record, the last one of several records.
    """
    check_folder(out)
    limits = None
    if next_file is not None:
        check_next_file(next_file, out, paths)
        limits = limits_of(next_duration, next_range, next_rate)
    from diagnosis.by_kind import diagnose as find_causes

    model, rated_travel = base_given(valve, model_file)
    with progress_shown() as progress:
        records = measured_records(paths, model, rated_travel, columns_called(columns))
        if limits is not None and records[0].kind != "time":
            raise InputError("a next experiment is designed from time records", "these have none", "record over time")
        diagnosis: Any = find_causes(records, model, jobs=jobs, progress=progress)
        if limits is not None and next_file is not None:
            diagnosis = _with_next_experiment(diagnosis, limits, next_file, progress)
        progress("drawing the report", 0.95)
        places = write_together(out, partial(diagnosis.write, jobs=jobs))
        if next_file is not None:
            diagnosis.next_experiment.write(next_file)
    if as_json:
        print_json(diagnosis.as_json())
    else:
        from rich.console import Console

        from diagnosis.report import print_answer

        shown = {"report": places["report.html"], "files": out} if "report.html" in places else {"files": out}
        print_answer(diagnosis.as_json(), Console(highlight=False), shown)


def check_next_file(path: Path, out: Path, records: Sequence[Path]) -> None:
    """Refuse a place for the profile that could not be written or holds a record."""
    if path.parent.resolve() != out.resolve():
        check_file(path, "--next-experiment")
    named = {f"RECORD {number}": record for number, record in enumerate(records, 1)}
    check_not_input(path, named, "--next-experiment")


def limits_of(duration: str, currents: tuple[str, str], rate: str | None) -> Limits:
    """Read what the next experiment may do.

    Raises
    ------
    InputError
        If a quantity cannot be read, or the limits leave nothing to do.
    """
    from diagnosis.next_experiment import Limits
    from valvemodel.quantities import parse_quantity

    lowest, highest = (parse_quantity(text, unit="A") for text in currents)
    seconds = parse_quantity(duration, unit="s")
    fastest = math.inf if rate is None else parse_quantity(rate, unit="A/s")
    if not 0.0 <= lowest < highest:
        raise InputError(
            "--next-range is a lower and a higher current",
            f"got {' and '.join(currents)}",
            'write it like "4 mA" "20 mA"',
        )
    if seconds <= 0.0 or fastest <= 0.0:
        raise InputError("--next-duration and --next-rate are positive", f"got {duration} and {rate}", "correct them")
    return Limits(lowest, highest, fastest, seconds)


def _with_next_experiment(diagnosis: Any, limits: Limits, path: Path, progress: Progress) -> Any:
    from diagnosis.next_experiment import next_experiment

    return replace(diagnosis, next_experiment=next_experiment(diagnosis, limits, name=path.name, progress=progress))
