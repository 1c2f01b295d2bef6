"""Scores of a whole blind test: plants are opened and marked, and the marks counted."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from diagnosis.judging.stages import stages_of
from diagnosis.trials.answering import read_answer
from diagnosis.trials.closure import IMITATED, closure_on_unseen
from diagnosis.trials.marking import Mark, is_stage_right, mark, outcome_left_out, outcome_of
from diagnosis.trials.plan import Task
from diagnosis.trials.sealing import Places, open_truth


@dataclass(frozen=True)
class Result:
    """One plant after it was opened.

    Attributes
    ----------
    plant, kind : str
    truth, formulations : tuple of str
        Effects, nuisances left out, and the law of each.
    visibility : float or None [noise]
        The least that a refit leaves of an effect, root mean square.
    mark : Mark
    verdict : str
        `effect`, `none`, `unknown` or `failed`.
    baseline : dict or None
        The trivial baseline's `effects`, `outcome`, `is_right`, `seconds`.
    closure : dict
        As `closure_on_unseen` gives it; empty where the diagnosis broke off.
    sham : float or None
        Probability that effects which cannot be in the record would have got together.
    black_box, cause : float or None
        Share of the reducible gap on held-out blocks that a correction without physics closes, and the cause.
    seconds, computing_seconds : float or None
        Of the diagnosis, on one core: waiting for others included, and without. [s]
    """

    plant: str
    kind: str
    truth: tuple[str, ...]
    formulations: tuple[str, ...]
    visibility: float | None
    mark: Mark
    verdict: str
    baseline: dict[str, Any] | None
    closure: dict[str, float | None]
    sham: float | None = None
    black_box: float | None = None
    cause: float | None = None
    seconds: float | None = None
    computing_seconds: float | None = None

    @property
    def is_imitated(self) -> bool:
        """Whether the valve has effects that a refitted base imitates to the noise, so that none can be seen."""
        base, floor = self.closure.get("base"), self.closure.get("floor")
        return bool(self.truth) and base is not None and floor is not None and base < IMITATED * floor

    def as_json(self) -> dict[str, Any]:
        """Return the result as blindtest.json has it."""
        return asdict(self)


FAILED = Mark("failed", False, False, 0.0, False, ())


def open_plant(task: Task, places: Places, sealed: dict[str, str]) -> Result:
    """Open a plant's truth and mark the answer to it."""
    plant = open_truth(task, places, sealed)
    own = [truth for truth in plant.effects if not truth.nuisance]
    answer = read_answer(places.answer(task))
    assert answer is not None, task.name
    shown: dict[str, Any] = {
        "plant": task.name,
        "kind": task.kind,
        "truth": task.effects,
        "formulations": tuple(truth.formulation for truth in own),
        "visibility": min((truth.unabsorbed for truth in own if np.isfinite(truth.unabsorbed)), default=None),
        "baseline": baseline_mark(task, answer["baseline"]),
    }
    if "error" in answer:
        return Result(**shown, mark=FAILED, verdict="failed", closure={})
    diagnosis = json.loads((places.answer(task) / "diagnosis.json").read_text(encoding="utf-8"))
    is_anchored = answer["yardstick"] == "anchored"
    return Result(
        **shown,
        mark=mark(task.kind, task.effects, diagnosis),
        verdict=diagnosis["verdict"],
        closure=closure_on_unseen(places.answer(task), plant, task.seeds["unseen"], is_anchored=is_anchored),
        sham=diagnosis["control"]["probability"],
        black_box=diagnosis["ceiling"]["gap_closed"],
        cause=diagnosis["causes"][0]["gap_closed"],
        seconds=answer["seconds"],
        computing_seconds=answer["computing_seconds"],
    )


def baseline_mark(task: Task, said: dict[str, Any] | None) -> dict[str, Any] | None:
    """Mark what the trivial baseline named."""
    if said is None:
        return None
    named = tuple(said["effects"])
    verdict = "effect" if named else "none"
    if task.kind == "left-out":
        outcome = outcome_left_out(task.effects[0], verdict, named, said=1.0)
    else:
        outcome = outcome_of(task.effects, verdict, named, [named])
    return {
        "effects": named,
        "outcome": outcome,
        "is_right": outcome in ("right", "alias"),
        "is_stage_right": is_stage_right(task.effects, None, stages_of([named])) if task.effects else None,
        "seconds": said["seconds"],
    }
