"""Stairs: where the stem rests again and again on its way, a slip that comes early or late is a small error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from diagnosis.choosing.beside_slips import bends_to_stairs
from diagnosis.trying.candidates import Candidate
from diagnosis.trying.explaining import GOOD_ENOUGH, misfit
from diagnosis.trying.parts import parted
from diagnosis.trying.standing import best_of
from diagnosis.trying.workshop import Workshop
from identification.experiment import Experiment
from identification.extending.extension import Extension, extend
from identification.fit import Fit
from identification.holdout import Holdout
from identification.stick_slip.slip_laws import slips_by
from identification.stick_slip.slip_search import REACH
from identification.stick_slip.staircase import stops_on_the_way
from valvemodel.declarations import Effect
from valvemodel.effects import effect_of_key
from valvemodel.model import Model
from valvemodel.stages import EFFECTS

FEW_STOPS = 3
"""Rests of the stem on its way from which a record may have stairs."""

STEPPED = 0.5
"""Share of the base's error below which an effect that makes stairs must come, or there are none: a lag rests too."""


def on_stairs(
    experiments: list[Experiment], workshop: Workshop, base: Fit, library: Sequence[Effect], model: Model
) -> tuple[list[Experiment], Holdout, Fit]:
    """Return experiments, their parts and the base refitted to them, where they have stairs; else all as it was."""
    read = tempered(experiments, workshop.holdout, base, model)
    if read and makes_stairs(read[2], library, workshop):
        return read
    return experiments, workshop.holdout, base


def stairs_beside(
    tried: Sequence[Candidate], experiments: list[Experiment], holdout: Holdout, model: Model
) -> tuple[list[Experiment], Holdout, Fit] | None:
    """Return experiments, their parts and the base, as `on_stairs` does, where stairs show beside another effect only.

    An effect that explains most of the gap hides the stairs: what makes them explains much of what it leaves.

    Parameters
    ----------
    tried : sequence of Candidate
        All that was tried on the record as it was, the base first.
    experiments : list of Experiment
    holdout : Holdout
        Of them.
    model : Model

    Returns
    -------
    tuple or None
        None where the record was taken for one with stairs before, or no stairs show.
    """
    pairs = best_of(tried, 2)
    if not pairs or any(each.has_stairs for each in experiments):
        return None
    best = pairs[0]
    makers = [each for each in best.effects if effect_of_key(each).breakaway]
    rest = [each for each in tried if set(each.effects) == set(best.effects) - set(makers)]
    if not makers or not rest or misfit(best) > STEPPED * misfit(rest[0]) or misfit(best) < GOOD_ENOUGH:
        return None
    return tempered(experiments, holdout, tried[0].fit, model)


def tempered(
    experiments: list[Experiment], holdout: Holdout, base: Fit, model: Model
) -> tuple[list[Experiment], Holdout, Fit] | None:
    """Return experiments as ones with stairs, their parts and the base refitted; None where they can have none."""
    stepped = with_stairs(experiments, base)
    if stepped == experiments:
        return None
    return stepped, *parted(stepped, model, holdout.kept)


def with_stairs(experiments: Sequence[Experiment], base: Fit) -> list[Experiment]:
    """Return experiments, in those that may have stairs the samples beside a slip count less.

    The right cause in the right numbers lets a slip come a sample early or late, and is then off by its whole height;
    squared, a few such samples outweigh all the rest of the record.
    """
    return [
        replace(each, reach=REACH) if stops_on_the_way(each, base.simulated_on(each).position[0]) >= FEW_STOPS else each
        for each in experiments
    ]


def makes_stairs(base: Fit, library: Sequence[Effect], workshop: Workshop) -> bool:
    """Return whether what makes the stem stop again and again explains much of what is left, alone or beside another.

    A reading in coarse steps does not count: no slip comes early in it. Where the readings show such steps, an effect
    must explain much of what these leave. Beside another effect it does where that brings the steps onto a line.
    """
    makers = [each for each in EFFECTS if each.breakaway and not each.is_chaotic]
    readings = [extend(base, each.key) for each in EFFECTS if each.is_read_off]
    least = min((base, *readings), key=lambda fit: fit.found.error)
    alone = any(
        bool(slips_by(base, each, least))
        or extend(base, each.key, Extension(slips=[])).found.error < STEPPED * least.found.error
        for each in makers
    )
    has_steps = least.found.error < STEPPED * base.found.error
    return alone or (not has_steps and bends_to_stairs(base, library, workshop))
