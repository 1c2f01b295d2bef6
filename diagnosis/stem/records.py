"""Records of one stem, filtered alike and laid end to end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from identification.inverse_dynamics import Preprocessing, StemSignals, prepare_signals
from identification.inverse_dynamics.diagnose import GUARD_ROWS
from valvemodel.errors import InputError
from valvemodel.records import Record

SAME_INTERVAL = 1e-3
"""Share by which the sampling intervals of records that are laid end to end may differ."""


@dataclass(frozen=True, eq=False)
class Joined:
    """Signals of one or several records end to end, and to which record each decimated sample belongs."""

    names: tuple[str, ...]
    signals: StemSignals
    owner: np.ndarray

    @property
    def is_scored(self) -> np.ndarray:
        """The samples that are scored: the last record's, or of one record all, block by block in turn."""
        return self.owner == len(self.names) - 1

    @property
    def is_fitted(self) -> np.ndarray:
        """The samples of the other records but for those next to the last, which a filter mixes."""
        return self.owner[np.minimum(np.arange(len(self.owner)) + GUARD_ROWS, len(self.owner) - 1)] < (
            len(self.names) - 1
        )


def check_kind(records: Sequence[Record]) -> None:
    """Refuse records that are not of the stem alone."""
    if not records:
        raise InputError("a diagnosis takes at least one record", "got none", "name a file")
    for record in records:
        if record.kind != "stem":
            raise InputError(
                "records of the stem alone have force and position and no current",
                f"{record.name} has a current",
                "diagnose it apart from the records of force, or take the current out",
            )


def prepared(records: Sequence[Record]) -> list[StemSignals]:
    """Return the signals of each record, all filtered and decimated as the first."""
    first = prepare_signals(records[0])
    same = Preprocessing(cutoff_frequency=first.cutoff_frequency, factor=first.factor)
    found = [first]
    for record in records[1:]:
        if record.time is not None and abs(record.interval / first.interval - 1.0) > SAME_INTERVAL:
            raise InputError(
                "records of force that are diagnosed together have one sampling interval",
                f"{record.name} has {record.interval:g} s, {records[0].name} {first.interval:g} s",
                "resample one of them",
            )
        found.append(prepare_signals(record, same))
    return found


def join(names: Sequence[str], each: Sequence[StemSignals]) -> Joined:
    """Lay signals end to end on one clock.

    Filter and decimation are linear and treat force and regressors alike, so the balance holds across a
    joint too.
    """
    factor, interval = each[0].factor, each[0].interval
    if len(each) == 1:
        return Joined(tuple(names), each[0], np.zeros(each[0].rows, int))
    cut = [slice(0, factor * (len(one.time) // factor)) for one in each]
    sizes = [part.stop for part in cut]

    def laid(columns: list[np.ndarray]) -> np.ndarray:
        return np.concatenate([column[part] for column, part in zip(columns, cut, strict=True)])

    signals = replace(
        each[0],
        time=each[0].time[0] + interval * np.arange(sum(sizes)),
        force=laid([one.force for one in each]),
        position=laid([one.position for one in each]),
        velocity=laid([one.velocity for one in each]),
        acceleration=laid([one.acceleration for one in each]),
        direction=laid([one.direction for one in each]),
        rest_speed=max(one.rest_speed for one in each),
        position_noise=max(one.position_noise for one in each),
    )
    ends = signals.time[0] + interval * np.cumsum(sizes)
    owner = np.searchsorted(ends, signals.row_time + 0.5 * interval)
    return Joined(tuple(names), signals, owner)
