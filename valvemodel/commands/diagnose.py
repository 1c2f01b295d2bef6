"""`valvemodel diagnose`: why a model does not match its valve, what is missing, how much better it gets."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from valvemodel.commands.given import measured_records, records_argument, valve_model, valve_option
from valvemodel.commands.places import check_folder, write_together
from valvemodel.commands.waiting import Report, progress_shown

if TYPE_CHECKING:
    from valvemodel.model import Model
    from valvemodel.records import Record


@click.command(
    epilog="""\b
Examples:
  valvemodel diagnose record.csv --out report
  valvemodel diagnose monday.csv tuesday.csv --valve my_valve.toml --out report
  valvemodel diagnose record.csv --out report --json"""
)
@records_argument
@valve_option
@click.option(
    "--out",
    required=True,
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Folder for diagnosis.json, base.json, model.json and report.html.",
)
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    metavar="N",
    help="Processes that search at the same time.  [default: one a core, at most 8]",
)
@click.option("--json", "as_json", is_flag=True, help="Print diagnosis.json instead of the answer in words.")
@click.option("--quiet", is_flag=True, help="Print nothing but errors; the files say it all.")
def diagnose(
    paths: tuple[Path, ...], valve: str | None, out: Path, jobs: int | None, as_json: bool, quiet: bool
) -> None:
    """Find where a valve and its model disagree, which effect causes it, and how far the gap shrinks with it.

    RECORD is a table of `time [s]`, `current [mA]`, `position [mm]` and perhaps `pressure [kPa]`: CSV,
    Parquet or MAT. Without time it is a settled loop; with `force [N]` instead of current the stem alone. The
    gap is scored on data that were not fitted: blocks in time of one record, the last one of several records.
    """
    check_folder(out)
    model, rated_travel = valve_model(valve)
    with progress_shown(is_quiet=quiet) as progress:
        records = measured_records(paths, model, rated_travel)
        diagnosis = _diagnosed(records, model, jobs, progress)
        progress("drawing the report", 0.95)
        places = write_together(out, diagnosis.write)
    if as_json:
        import json

        from valvemodel.files import finite

        click.echo(json.dumps(finite(diagnosis.as_json()), indent=1, ensure_ascii=False, allow_nan=False))
    elif not quiet:
        from rich.console import Console

        from diagnosis.report import print_answer

        shown = {"report": places["report.html"], "files": out} if "report.html" in places else {"files": out}
        print_answer(diagnosis.as_json(), Console(highlight=False), shown)


def _diagnosed(records: Sequence[Record], model: Model, jobs: int | None, progress: Report) -> Any:
    if all(record.kind == "stem" for record in records):
        from diagnosis.stem_only import diagnose_stem_records

        progress("force balance of the stem", 0.0)
        return diagnose_stem_records(records, model)
    from diagnosis.diagnose import diagnose as find_causes

    return find_causes(records, model, jobs=jobs, progress=progress)
