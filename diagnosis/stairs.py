"""Stairs: where the stem rests again and again on its way, a slip that comes early or late is a small error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from identification.experiment import Experiment
from identification.extension import extend, slips_by
from identification.fit import Fit, fit_base
from identification.holdout import Holdout, hold_out
from identification.staircase import stops_on_the_way
from identification.stick_slip import REACH
from valvemodel.model import Model
from valvemodel.stages import EFFECTS

FEW_STOPS = 3
"""Rests of the stem on its way from which a record may have stairs."""

STEPPED = 0.5
"""Share of the base's error below which an effect that makes stairs must come, or there are none: a lag rests too."""


def on_stairs(
    experiments: list[Experiment], holdout: Holdout, base: Fit, model: Model
) -> tuple[list[Experiment], Holdout, Fit]:
    """Return experiments, their parts and the base refitted to them, where they have stairs; else all as it was."""
    stepped = with_stairs(experiments, base)
    if stepped == experiments:
        return experiments, holdout, base
    parted = hold_out(stepped)
    tempered = fit_base(model, parted.experiments, parted.fitted)
    return (stepped, parted, tempered) if makes_stairs(tempered) else (experiments, holdout, base)


def with_stairs(experiments: Sequence[Experiment], base: Fit) -> list[Experiment]:
    """Return experiments, in those that may have stairs the samples beside a slip count less.

    The right cause in the right numbers lets a slip come a sample early or late, and is then off by its whole height;
    squared, a few such samples outweigh all the rest of the record.
    """
    return [
        replace(each, reach=REACH) if stops_on_the_way(each, base.simulated_on(each).position[0]) >= FEW_STOPS else each
        for each in experiments
    ]


def makes_stairs(base: Fit) -> bool:
    """Return whether an effect that makes the stem stop again and again explains much of what is left.

    A reading in coarse steps does not count: no slip comes early in it.
    """
    makers = [each for each in EFFECTS if each.stops_again and each.is_jagged and not each.is_chaotic]
    return any(
        bool(slips_by(base, each)) or extend(base, each.key).found.error < STEPPED * base.found.error for each in makers
    )
