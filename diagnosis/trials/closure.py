"""Closure: how much of the reducible gap the found model closes on an unseen record of the same valve."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from diagnosis.blindtest.plants import Plant, measure
from diagnosis.score import closed_share
from identification.experiment import Experiment, experiment_of
from identification.fit import simulate_model
from valvemodel.model import Model, read_model
from valvemodel.records import Record

WORTH_CLOSING = 1.5
"""Gap of the refitted base over the noise from which a share of it means something."""

IMITATED = 1.02
"""Gap of the refitted base over the noise, on an unseen record, up to which it imitates the effects of a valve."""


def closure_on_unseen(answer: Path, plant: Plant, seed: int, *, is_anchored: bool) -> dict[str, float | None]:
    """Compare the refitted base and the found model with a record of the valve that no one has seen.

    The noise floor is the one that was built into the plant: how far its readings are from those without noise, which a
    coarse converter shows as whole steps.

    Parameters
    ----------
    answer : Path
        Folder with base.json and model.json.
    plant : Plant
    seed : int
        Of the record.
    is_anchored : bool
        Whether the runs are put anew on the readings every so often, as the diagnosis was judged, or run free.

    Returns
    -------
    dict
        `base`, `found`, `floor` [m], and `closed`, the share, None where the base reaches the noise; `closed_free`, the
        same where both run free.
    """
    taken = measure(plant, seed)
    unseen = experiment_of(
        Record.from_arrays(name="unseen", time=taken["time"], current=taken["current"], position=taken["position"])
    )
    quiet = measure(replace(plant, noise=0.0, resolution=0.0), seed)
    floor = float(np.sqrt(np.mean((taken["position"] - quiet["position"]) ** 2)))
    models = [read_model(answer / name) for name in ("base.json", "model.json")]
    free = shrinking(models, unseen, floor, is_anchored=False)
    judged = shrinking(models, unseen, floor, is_anchored=True) if is_anchored else free
    return {**judged, "closed_free": free["closed"]}


def shrinking(
    models: Sequence[Model], unseen: Experiment, floor: float, *, is_anchored: bool
) -> dict[str, float | None]:
    """Return what the refitted base and the found model leave, and the share of the gap that is closed."""
    base, found = (gap(each, unseen, is_anchored) for each in models)
    closed = closed_share(base, found, floor) if base > WORTH_CLOSING * floor else None
    return {"base": base, "found": found, "floor": floor, "closed": closed}


def gap(model: Model, unseen: Experiment, is_anchored: bool) -> float:
    """Return the root mean squared error of the position, started at the first readings. [m]"""
    run = simulate_model(model, unseen, start_position=unseen.first_reading, is_anchored=is_anchored)
    return float(np.sqrt(np.nanmean((unseen.position - run.position[0]) ** 2)))
