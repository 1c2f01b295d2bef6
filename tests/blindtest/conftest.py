"""Inputs that the plant tests share."""

import numpy as np
import pytest

from diagnosis.blindtest.valve import NOMINAL


@pytest.fixture
def base() -> dict[str, float]:
    return dict(NOMINAL)


@pytest.fixture
def ramps() -> tuple[np.ndarray, np.ndarray]:
    """A ramp up and down between 6 and 16 mA in 12 s, then steps, at 50 Hz."""
    time = np.arange(901) / 50.0
    triangle = 6.0 + 10.0 * (1.0 - np.abs(time / 6.0 - 1.0))
    steps = np.select([time < 14, time < 16], [9.0, 14.0], 7.0)
    return time, np.where(time < 12, triangle, steps) * 1e-3
