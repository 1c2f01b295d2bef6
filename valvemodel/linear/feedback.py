"""Feedback: a PID around the linearised valve, and how far it is from instability."""

from __future__ import annotations

from dataclasses import dataclass

import control as ct
import numpy as np

from valvemodel.linear.state_space import Linearisation

FILTER = 10.0
"""The derivative acts up to this many times the frequency at which it equals the proportional part."""


@dataclass(frozen=True)
class Gains:
    """Gains of a PID in continuous time. [A/m], [A/(m s)], [A s/m]"""

    proportional: float
    integral: float
    derivative: float = 0.0


def usual_gains(found: Linearisation) -> Gains:
    """Return half of the inverse static gain as proportional gain, and that whole inverse per second as integral."""
    gain = abs(float(found.current_to_reading.dcgain()))
    return Gains(0.5 / gain, 1.0 / gain)


def controller(gains: Gains) -> ct.TransferFunction:
    """Return the controller's transfer function, from error to current."""
    law = (
        ct.tf([gains.proportional, gains.integral], [1.0, 0.0])
        if gains.integral
        else ct.tf([gains.proportional], [1.0])
    )
    if gains.derivative == 0.0:
        return law
    pace = gains.derivative / (FILTER * gains.proportional) if gains.proportional else 1e-3
    return law + ct.tf([gains.derivative, 0.0], [pace, 1.0])


def open_loop(found: Linearisation, gains: Gains) -> ct.StateSpace:
    """Return controller and valve in series, from error to reading."""
    return ct.series(ct.ss(controller(gains)), found.current_to_reading)


def margins(found: Linearisation, gains: Gains) -> dict[str, float]:
    """Return the margins of a linearised loop, infinite where it has none, and whether it is stable.

    Returns
    -------
    dict
        gain_margin [1], phase_margin [rad], stability_margin [1], delay_margin [s], gain_crossover and
        phase_crossover [rad/s], closed_loop_damping [1], is_stable.
    """
    loop = open_loop(found, gains)
    gain, phase, distance, at_phase, at_gain, _ = (float(value) for value in ct.stability_margins(loop))
    poles = ct.feedback(loop).poles()
    return {
        "gain_margin": gain,
        "phase_margin": np.radians(phase),
        "stability_margin": distance,
        "delay_margin": np.radians(phase) / at_gain if at_gain > 0.0 else np.inf,
        "gain_crossover": at_gain,
        "phase_crossover": at_phase,
        "closed_loop_damping": float(np.min(-poles.real / np.maximum(np.abs(poles), 1e-300))),
        "is_stable": bool(np.all(poles.real < 0.0)),
    }
