"""Landing: each move is one long slip whose end is the set point, taken from the branches of a model."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled
from valvemodel.control.laws.feedforward import branch_current

HOLDING, SLIPPING, WITHDRAWING = 0.0, 1.0, 2.0

WITHDRAWAL = 1.25
"""Way back over the shortest slip, where the stem is too near the set point to land on it."""


@compiled
def land(s, m, setpoint, reading):
    """Return the held current: changed at a new set point, and after a dwell where the mean reading is off. [A]

    A stem slipping under a held pressure stops where the sliding friction ends the motion, whatever it took to break
    away; so the current of that point on the branch is set and held. The readings of the later half of the dwell say
    where the stem came to rest; beyond the dead band their error is added to the branch that was used, and the move is
    made again. A stem nearer than the shortest slip first withdraws.

    References
    ----------
    Of this project. Inverse of a known backlash: Tao and Kokotovic, Automatica 29 (1993) 323-335.
    """
    if m.is_started == 0.0 or setpoint != m.last_setpoint:
        approach(s, m, setpoint, reading)
        return m.held_current
    m.clock += s.period
    if m.clock > 0.5 * s.dwell:
        m.readings_sum += reading
        m.readings_count += 1.0
    if m.clock >= s.dwell - 0.5 * s.period and m.readings_count > 0.0:
        judge(s, m, setpoint, m.readings_sum / m.readings_count)
    return m.held_current


@compiled
def approach(s, m, setpoint, position):
    """Begin to move: to the set point, or first away from it."""
    error = setpoint - position
    if abs(error) < s.slip_jump:
        side = -math.copysign(1.0, error)
        begin(s, m, WITHDRAWING, side, position + side * WITHDRAWAL * s.slip_jump)
    else:
        begin(s, m, SLIPPING, math.copysign(1.0, error), setpoint)


@compiled
def begin(s, m, phase, direction, target):
    """Hold the current whose slip ends at the target, and wait anew."""
    m.phase, m.direction = phase, direction
    offset = m.rising_offset if direction > 0.0 else m.falling_offset
    m.held_current = branch_current(s, direction, target + offset)
    wait(m)


@compiled
def wait(m):
    """Begin a dwell."""
    m.clock = m.readings_sum = m.readings_count = 0.0


@compiled
def judge(s, m, setpoint, position):
    """Say after a dwell whether the stem is where it should be, learn from a landing beside it, and go on."""
    error = setpoint - position
    if m.phase == WITHDRAWING:
        begin(s, m, SLIPPING, -m.direction, setpoint)
    elif abs(error) > s.dead_band:
        if m.phase == SLIPPING and m.direction > 0.0:
            m.rising_offset += error
        elif m.phase == SLIPPING:
            m.falling_offset += error
        approach(s, m, setpoint, position)
    else:
        m.phase = HOLDING
        wait(m)
