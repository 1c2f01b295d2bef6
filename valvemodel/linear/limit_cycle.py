"""Limit cycle: what any of the three ways says of it, and what the describing function predicts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import control as ct
import numpy as np

from valvemodel.linear.describing import stiction_nonlinearity
from valvemodel.linear.loop import Loop

AMPLITUDES = 1.0 + np.geomspace(1e-10, 60.0, 200)
"""Of the input, over the smallest one that moves the stem."""

FREQUENCIES = np.geomspace(3e-3, 30.0, 240)
"""Over the frequency at which the linear part has gain 1."""


@dataclass(frozen=True)
class LimitCycle:
    """A limit cycle.

    Attributes
    ----------
    source : str
        describing function, return map or simulation.
    period : float [s]
    amplitude : float
        Half of the controlled variable's range. [m]
    multiplier : float
        By how much a departure grows from turn to turn; NaN where unknown.
    states : array or None
        The loop at the first stop of a rise, as `return_map` orders it.
    """

    source: str
    period: float
    amplitude: float
    multiplier: float = math.nan
    states: np.ndarray | None = None

    @property
    def is_stable(self) -> bool:
        """Whether departures die out."""
        return self.multiplier < 1.0


def linear_part(loop: Loop) -> ct.StateSpace:
    """Return the loop without its friction, from the stem's position to what the friction sees as input.

    The input is the position that the pressure asks for. The sampling is a dead time of half a period.
    """
    valve = loop.point
    stem = ct.ss(valve.pressure_to_position)
    whole = ct.series(stem, loop.process(delays=0.5 * loop.period), ct.ss(loop.controller()), valve.current_to_pressure)
    return ct.ss(whole.A, whole.B, whole.C, whole.D)


def describing_response(loop: Loop) -> ct.DescribingFunctionResponse:
    """Return python-control's harmonic balance of a loop; amplitudes are over the smallest one that moves the stem."""
    static, kinetic = loop.stickiness()
    half_band = 0.5 * (static + kinetic)
    friction = stiction_nonlinearity(static / half_band, kinetic / half_band)
    part = linear_part(loop)
    crossover = loop.integral * float(abs(loop.point.current_to_position.dcgain()))
    return ct.describing_function_response(part, friction, AMPLITUDES, crossover * FREQUENCIES, warn_nyquist=False)


def describing_cycle(loop: Loop) -> LimitCycle | None:
    """Return the limit cycle that the describing function predicts, the largest one; None where it predicts none."""
    static, kinetic = loop.stickiness()
    half_band = 0.5 * (static + kinetic)
    found = [(a, w) for a, w in describing_response(loop) if a >= 1.0 and w > 0.0]
    if not found:
        return None
    amplitude, frequency = max(found)
    friction = stiction_nonlinearity(static, kinetic)
    position = abs(friction.describing_function(amplitude * half_band)) * amplitude * half_band
    controlled = position * abs(loop.process()(1j * frequency))
    return LimitCycle("describing function", 2.0 * math.pi / frequency, controlled)
