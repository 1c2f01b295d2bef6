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
    crossover = loop.integral * abs(loop.slip_gain)
    return ct.describing_function_response(
        linear_part(loop), _scaled_friction(loop), AMPLITUDES, crossover * FREQUENCIES, refine=False, warn_nyquist=False
    )


def _scaled_friction(loop: Loop) -> stiction_nonlinearity:
    static, kinetic = loop.stickiness()
    half_band = 0.5 * (static + kinetic)
    return stiction_nonlinearity(static / half_band, kinetic / half_band)


def describing_cycle(loop: Loop) -> LimitCycle | None:
    """Return the limit cycle that the describing function predicts, the largest one; None where it predicts none."""
    balances = [_refined(loop, amplitude, frequency) for amplitude, frequency in describing_response(loop)]
    if not balances:
        return None
    amplitude, frequency = max(balances)
    input_size = 0.5 * sum(loop.stickiness()) * amplitude
    output_size = abs(_scaled_friction(loop).describing_function(amplitude)) * input_size
    return LimitCycle(
        "describing function", 2.0 * math.pi / frequency, float(output_size * abs(loop.process()(1j * frequency)))
    )


def _refined(loop: Loop, amplitude: float, frequency: float) -> tuple[float, float]:
    """Return amplitude and frequency at which 1 + N(A) H(jw) = 0, from python-control's estimate on its grid."""
    from scipy.optimize import root

    friction, part = _scaled_friction(loop), linear_part(loop)

    def balance(logarithms: np.ndarray) -> list[float]:
        size, pace = 1.0 + math.exp(logarithms[0]), math.exp(logarithms[1])
        value = 1.0 + friction.describing_function(size) * complex(part(1j * pace))
        return [value.real, value.imag]

    start = np.log([amplitude - 1.0, frequency])
    solution = root(balance, start)
    size, pace = np.exp(solution.x if solution.success else start)
    return 1.0 + float(size), float(pace)
