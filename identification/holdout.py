"""What is fitted and what is kept back to score on: blocks in time, or other records."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from identification.experiment import Experiment, block_time_at
from identification.stick_slip.rests import put_on_rests
from valvemodel.errors import InputError

EVERY = 3
"""Every so many blocks in time one is kept back."""


@dataclass(frozen=True)
class Holdout:
    """Experiments to fit and experiments to score on, each with the samples that count.

    With one record the scored samples are blocks in time of the same experiment; with several, the last record, of
    which only the start position is taken, from its first readings.
    """

    experiments: tuple[Experiment, ...]
    fitted: tuple[np.ndarray, ...]
    scored_experiments: tuple[Experiment, ...]
    scored: tuple[np.ndarray, ...]
    scored_on: str
    kept: int = EVERY - 1

    @property
    def has_blocks(self) -> bool:
        """Whether blocks in time of one record are kept back."""
        return self.experiments == self.scored_experiments

    @cached_property
    def scored_on_rests(self) -> tuple[Experiment, ...]:
        """The experiments to score on, their runs put anew on each rest."""
        return tuple(put_on_rests(each, each.reach) for each in self.scored_experiments)

    @cached_property
    def whole(self) -> Holdout:
        """The same experiments, those to score on last, with all samples to be scored."""
        others = tuple(each for each in self.experiments if all(each is not one for one in self.scored_experiments))
        everything = (*others, *self.scored_experiments)
        measured = tuple(np.isfinite(each.position) for each in everything)
        return replace(self, scored_experiments=everything, scored=measured)

    @property
    def floor(self) -> float:
        """Error that the right model leaves of the scored readings, root mean square. [m]"""
        counts = np.array([mask.sum() for mask in self.scored])
        squares = np.array([experiment.floor**2 for experiment in self.scored_experiments])
        return float(np.sqrt((squares * counts).sum() / counts.sum()))


def hold_out(experiments: Sequence[Experiment], kept: int = EVERY - 1) -> Holdout:
    """Split experiments into what is fitted and what is scored.

    Parameters
    ----------
    experiments : sequence of Experiment
    kept : int
        Which of every `EVERY` blocks in time of a single record is kept back, from 0.

    Raises
    ------
    InputError
        If a single record is too short to keep a part of it back.
    """
    measured = [np.isfinite(experiment.position) for experiment in experiments]
    if len(experiments) > 1:
        return Holdout(
            tuple(experiments[:-1]),
            tuple(measured[:-1]),
            (experiments[-1],),
            (measured[-1],),
            "other records",
        )
    is_kept = experiments[0].block % EVERY == kept
    whole = (experiments[0],)
    if not (measured[0] & is_kept).any() or not (measured[0] & ~is_kept).any():
        raise InputError(
            "a record must be long enough to keep a part of it back",
            f"{experiments[0].name} has {measured[0].sum()} samples over {np.ptp(experiments[0].time):.3g} s",
            f"record for {EVERY * block_time_at(experiments[0].period):.3g} s or longer, or give a second record",
        )
    return Holdout(whole, (measured[0] & ~is_kept,), whole, (measured[0] & is_kept,), "held-out blocks", kept)
