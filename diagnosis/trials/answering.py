"""The answer to one record: what the diagnosis says of it, and what a trivial baseline would say."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from diagnosis.diagnosing import diagnose
from diagnosis.trials.baseline import name_by_least_squares
from valvemodel.files import make_folder, write_json
from valvemodel.model import Model
from valvemodel.records import Record, read_record
from valvemodel.stages import EFFECTS
from valvemodel.valves import read_valve

GIVEN = "calibrated"
"""The valve set that every diagnosis begins with; the plants' parameters are spread about it."""

ANSWER = "answer.json"


def answer(record: Path, folder: Path, left_out: tuple[str, ...], *, has_baseline: bool) -> None:
    """Diagnose a record on one core, with nothing known but the file, unless that was done before.

    Writes diagnosis.json, base.json, model.json and, when all is done, answer.json with yardstick, seconds and the
    baseline's answer; or with the error that a diagnosis broke off with.

    Parameters
    ----------
    record : Path
    folder : Path
        Where the answer goes.
    left_out : tuple of str
        Effects that are no candidates.
    has_baseline : bool
        Whether the trivial baseline answers too.
    """
    before = read_answer(folder)
    if before is not None and (before["baseline"] is not None or not has_baseline):
        return
    valve = read_valve(GIVEN)
    model = Model(valve.name, valve.values)
    candidates = [effect.key for effect in EFFECTS if effect.key not in left_out]
    measured = read_record(record)
    content = before or diagnosed(measured, model, candidates, make_folder(folder))
    content["baseline"] = name_by_least_squares(measured, model, candidates) if has_baseline else None
    write_json(folder / ANSWER, content)


def diagnosed(record: Record, model: Model, candidates: Sequence[str], folder: Path) -> dict[str, Any]:
    """Diagnose a record, write the files, and return yardstick and seconds, or the error."""
    began, computed = time.perf_counter(), time.process_time()
    try:
        found = diagnose([record], model, candidates=candidates, jobs=1)
    except Exception as error:  # one plant that breaks must not cost the others: it counts as a miss
        return {"error": f"{type(error).__name__}: {error}"}
    seconds, computing = time.perf_counter() - began, time.process_time() - computed
    write_json(folder / "diagnosis.json", found.as_json())
    found.base.model.write(folder / "base.json")
    found.found_model.write(folder / "model.json")
    return {"yardstick": found.yardstick, "seconds": seconds, "computing_seconds": computing}


def read_answer(folder: Path) -> dict[str, Any] | None:
    """Return the content of answer.json, or None where there is no answer yet."""
    path = folder / ANSWER
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None
