"""Where a stem's base model misses the force: at rest, fast, on the way up or down."""

from __future__ import annotations

import numpy as np

from diagnosis.stem.records import Joined
from diagnosis.whereabouts.regimes import Regime
from identification.experiment import Experiment
from identification.inverse_dynamics.fit import blocks_of, root_mean_square
from identification.results.regimes import masks_of, words_of

LOW_SPEED, HIGH_SPEED = 0.1, 0.75
"""Shares of the record's top speed (its 0.95 quantile) that count as near rest and as fast."""

FEWEST_SAMPLES = 10
"""A regime with fewer samples is not listed."""


def regimes_of_rows(joined: Joined, residual: np.ndarray) -> list[Regime]:
    """Return where the error of the base model is large, the largest first. [N]"""
    signals = joined.signals
    velocity = signals.decimate(signals.velocity)
    speed = np.abs(velocity)
    top = float(np.quantile(speed, 0.95))
    rows = Experiment(
        name="",
        time=signals.row_time,
        current=np.full(signals.rows, np.nan),
        position=signals.decimate(signals.position),
        pressure=None,
        noise=signals.position_noise,
        pressure_noise=0.0,
        block=blocks_of(signals),
    )
    masks = masks_of(rows, np.sign(velocity))
    slow, fast = LOW_SPEED * top, HIGH_SPEED * top
    masks |= {"near_rest": speed < slow, "high_speed": speed > fast}
    words = words_of([rows]) | {
        "near_rest": f"near rest, below {slow * 1e3:.3g} mm/s",
        "high_speed": f"at high speed, above {fast * 1e3:.3g} mm/s",
    }
    whole = float(np.sum(residual**2)) or 1.0
    found = []
    for name, mask in masks.items():
        if mask.sum() >= FEWEST_SAMPLES:
            share = float(np.sum(residual[mask] ** 2)) / whole
            found.append(Regime(name, words[name], root_mean_square(residual[mask]), share, float(mask.mean())))
    return sorted(found, key=lambda regime: -regime.rms)
