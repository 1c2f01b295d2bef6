"""Stairs: where the stem rests again and again on its way, a slip that comes early or late is a small error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from identification.experiment import Experiment
from identification.extension import extend, slips_by
from identification.fit import Fit
from identification.staircase import stops_on_the_way
from identification.stick_slip import REACH
from valvemodel.stages import EFFECTS

FEW_STOPS = 3
"""Rests of the stem on its way from which a record may have stairs."""

STEPPED = 0.5
"""Share of the base's error below which an effect that makes stairs must come, or there are none: a lag rests too."""


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
