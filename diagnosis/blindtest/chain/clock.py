"""The fine time grid inside the sample periods of a record."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Signal = NDArray[np.float64]

# Sample times printed with four or five decimals are uniform to within this part of a period.
UNIFORMITY = 0.02


@dataclass(frozen=True)
class Clock:
    """Sample times and the fine step between them.

    Attributes
    ----------
    periods : int
        Number of held sample periods.
    substeps : int
        Fine steps in a period.
    step : float
        Fine step. [s]
    """

    periods: int
    substeps: int
    step: float

    @property
    def period(self) -> float:
        """Length of a sample period. [s]"""
        return float(self.substeps * self.step)

    def starts(self) -> Signal:
        """Start of each period, shape (periods,). [s]"""
        return np.arange(self.periods, dtype=np.float64) * self.period

    def held(self, values: Signal) -> Signal:
        """Values at the period starts as a signal of width 1."""
        return np.ascontiguousarray(values, dtype=float).reshape(self.periods, 1)


def clock_of(time: Signal, step: float) -> Clock:
    """Divide a record's uniform sample period into whole steps no longer than `step`. [s]"""
    if time.ndim != 1 or time.size < 2:
        raise ValueError(f"time must be a list of at least two samples, not shape {time.shape}")
    period = (time[-1] - time[0]) / (time.size - 1)
    spread = np.max(np.abs(np.diff(time) - period))
    if not period > 0 or spread > UNIFORMITY * period:
        raise ValueError(f"time must increase uniformly; steps differ from {period:g} s by {spread:g} s")
    substeps = max(1, int(np.ceil(period / step - 1e-9)))
    return Clock(periods=time.size, substeps=substeps, step=period / substeps)
