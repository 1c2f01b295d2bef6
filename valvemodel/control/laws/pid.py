"""Discrete PID of eq. (34), around a feedforward."""

from __future__ import annotations

from valvemodel.compiled import inlined
from valvemodel.control.laws.feedforward import gain_schedule
from valvemodel.control.laws.settings import HIGHEST_CURRENT, LOWEST_CURRENT


@inlined
def pid(s, m, setpoint, reading, base):
    """Return the base current plus K_P e(k) + K_I sum e(j) + K_D (e(k) - e(k-1)). [A]

    References
    ----------
    Paper eqs. (34), (41); the options as in Åström and Hägglund, Advanced PID Control (2006), ch. 3.
    """
    error = setpoint - reading
    change = error - m.last_error
    if s.differentiates_reading == 1.0:
        change = m.last_reading - reading
    if m.is_started == 0.0:
        change = 0.0
    factor = 1.0
    if s.is_scheduled == 1.0:
        factor = gain_schedule(s, setpoint)
    added = 0.0
    if abs(error) > s.dead_band:
        added = factor * s.integral_gain * s.period * error
    output = base + factor * (s.proportional_gain * error + s.derivative_gain / s.period * change) + m.integral
    if s.has_anti_windup == 1.0 and (
        (output + added > HIGHEST_CURRENT and added > 0.0) or (output + added < LOWEST_CURRENT and added < 0.0)
    ):
        added = 0.0
    m.integral += added
    m.last_error = error
    return output + added
