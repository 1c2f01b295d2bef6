"""Hägglund's knocker: short pulses on top of a PID's output."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled


@compiled
def knock(s, m, output, error):
    """Return the pulse that the knocker adds: in the direction in which the output moved since the last pulse. [A]

    Inside the dead band of the error no pulse begins.

    References
    ----------
    Hägglund, A friction compensator for pneumatic control valves, J. Process Control 12 (2002) 897-904.
    """
    if m.is_started == 0.0:
        m.knocked_from = output
    m.clock += s.period
    is_due = m.clock >= s.knock_interval - 0.5 * s.period
    if is_due and abs(error) > s.dead_band and output != m.knocked_from:
        m.knock_direction = math.copysign(1.0, output - m.knocked_from)
        m.knocked_from = output
        m.clock = 0.0
    if m.clock < s.knock_width - 0.5 * s.period:
        return m.knock_direction * s.knock_amplitude
    return 0.0
