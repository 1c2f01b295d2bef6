"""Spikes: readings that leave and come back within a few rows, as no stem does, are faults of the signal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from identification.noise import noise_level
from valvemodel.records import Record

LONGEST = 3
"""Rows that a spike lasts at most."""

FAR, MOVED = 30.0, 2.0
"""A spike is beyond all readings about it by more than so many times the noise, and than so many times their range."""

ABOUT = 3
"""Readings on either side that are about a spike."""

JUMP = 0.02
"""Change of the current from row to row, over its range, that may move a stem out, and another one back."""

RARE = 0.02
"""Share of the readings up to which they may be spikes: what comes more often is no fault."""


def without_spikes(record: Record) -> tuple[Record, list[str]]:
    """Return a record without readings of the position that are spikes, and say so."""
    if record.time is None or record.current is None or record.position is None:
        return record, []
    is_spike = spikes(record.position, record.current)
    if not 0.0 < is_spike.mean() <= RARE:
        return record, []
    first = record.time[int(np.argmax(is_spike))]
    return replace(record, position=np.where(is_spike, np.nan, record.position)), [
        f"{record.name}: {is_spike.sum()} reading(s) of the position jump off and back though the current does not, the"
        f" first at {first:g} s; they do not count: look for a loose contact"
    ]


def spikes(signal: np.ndarray, current: np.ndarray) -> np.ndarray:
    """Return which readings of a signal are spikes, shape (n,)."""
    found, noise = np.zeros(len(signal), bool), noise_level(signal)
    change, jump = np.diff(current, prepend=current[0]), JUMP * float(np.ptp(current))
    for length in range(1, LONGEST + 1):
        width = length + 2 * ABOUT
        if len(signal) < width:
            break
        seen = np.lib.stride_tricks.sliding_window_view(signal, width)
        before, inside, behind = seen[:, :ABOUT], seen[:, ABOUT : ABOUT + length], seen[:, ABOUT + length :]
        about = np.concatenate([before, behind], axis=1)
        above, below = (inside.min(axis=1) - about.max(axis=1), about.min(axis=1) - inside.max(axis=1))
        is_off = np.maximum(above, below) > np.maximum(FAR * noise, MOVED * np.ptp(about, axis=1))
        meanwhile = np.lib.stride_tricks.sliding_window_view(change, width)
        may_be_back = (meanwhile.max(axis=1) > jump) & (meanwhile.min(axis=1) < -jump)
        for start in np.flatnonzero(is_off & ~may_be_back) + ABOUT:
            found[start : start + length] = True
    return found
