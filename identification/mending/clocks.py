"""Clocks: a position that leaves before the current which moves it was logged by another clock than that."""

from __future__ import annotations

import numpy as np

from identification.noise import noise_level
from valvemodel.errors import InputError
from valvemodel.records import Record

REACHES = (0.5, 1.0)
"""How long before a step of the current a stem may be seen to leave; it rests as long before that. [s]"""

FEWEST_ROWS = 6
"""Rows that such a time has at least."""

STEP, CALM = 0.01, 0.02
"""A step changes the current by this share of its range in one row, and before it the current changed by no more than
the other share of that."""

RESTS = 8.0
"""A stem rests as long as its readings stay within so much, and has left when they are off by more. [noise]"""

FEWEST_STEPS = 3
"""Steps from which it is told. Of 512 records, blind ones and the field's, the middle one of these leaves before its
step in none, though 6 have one that does."""

MOST_APART = 0.3
"""How far the middle half of them may lie apart, over the middle one, beside two rows: what leaves before its step by
chance does so at any time."""


def check_clocks(record: Record) -> None:
    """Raise if the stem leaves before the steps of the current that move it.

    Raises
    ------
    InputError
        Says by how much the position is early.
    """
    if record.time is None or record.current is None or record.position is None or len(record.time) < FEWEST_ROWS:
        return
    for reach in REACHES:
        leaves = rows_after_steps(record, max(round(reach / record.interval), FEWEST_ROWS))
        if len(leaves) < FEWEST_STEPS:
            continue
        low, middle, high = np.quantile(leaves, [0.25, 0.5, 0.75])
        if middle >= 0.0 or high - low > MOST_APART * abs(middle) + 2.0:
            continue
        early = -float(middle) * record.interval
        raise InputError(
            "a stem moves after the current that moves it",
            f"{record.name}: at {np.sum(leaves < 0)} of {len(leaves)} steps of the current the position leaves before"
            f" the step, in the median by {early:.3g} s",
            f"current and position were logged by two clocks: make the times of the position {early:.3g} s later, or a"
            " little more",
        )


def rows_after_steps(record: Record, reach: int) -> np.ndarray:
    """Return how many rows after clear steps of the current a resting stem leaves that way, negative before them."""
    assert record.current is not None
    assert record.position is not None
    current, position = record.current, record.position
    change, noise = np.diff(current), noise_level(position)
    found = []
    for step in np.flatnonzero(np.abs(change) > STEP * np.ptp(current)) + 1:
        if step < 2 * reach or step + reach >= len(current):
            continue
        size = change[step - 1]
        seen = np.sign(size) * position[step - 2 * reach : step + reach]
        rest = seen[:reach][np.isfinite(seen[:reach])]
        is_calm = np.ptp(current[step - 2 * reach : step]) <= CALM * abs(size)
        if not is_calm or not len(rest) or np.ptp(rest) > RESTS * noise:
            continue
        has_left = seen > np.median(rest) + RESTS * noise
        if has_left.any():
            found.append(int(np.argmax(has_left)) - 2 * reach)
    return np.array(found)
