"""Landing: each move is one long slip whose end is the set point, taken from the branches of a model."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled
from valvemodel.control.laws.feedforward import branch_current

HOLDING, SLIPPING, WITHDRAWING = 0.0, 1.0, 2.0

WITHDRAWAL = 1.25
"""Way back over the shortest slip, where the stem is too near the set point to land on it."""

UNMOVED, STRETCH, MOST_STRETCH = 0.1, 0.5, 1.0
"""A move that went less than this share of its way failed to free the stem; the shortest slip is then taken to be
longer, by this share of what the model says, up to the most."""


@compiled
def land(s, m, setpoint, reading):
    """Return the held current: changed at a new set point, and after a dwell where the mean reading is off. [A]

    A stem slipping under a held pressure stops where the sliding friction ends the motion, whatever it took to break
    away; so the current of that point on the branch is set and held. The readings of the later half of the dwell say
    where the stem came to rest; beyond the dead band their error is added to the branch that was used, and the move is
    made again. A stem nearer than the shortest slip first withdraws; a move that frees nothing makes that slip longer.

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
    shortest = s.slip_jump * (1.0 + m.stretch)
    if abs(error) < shortest:
        side = -math.copysign(1.0, error)
        begin(s, m, WITHDRAWING, side, position, position + side * WITHDRAWAL * shortest)
    else:
        begin(s, m, SLIPPING, math.copysign(1.0, error), position, setpoint)


@compiled
def begin(s, m, phase, direction, position, target):
    """Hold the current whose slip ends at the target, and wait anew."""
    m.phase, m.direction, m.began_at, m.aimed_at = phase, direction, position, target
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
    has_failed = m.phase != HOLDING and abs(position - m.began_at) < UNMOVED * abs(m.aimed_at - m.began_at)
    if has_failed:
        m.stretch = min(m.stretch + STRETCH, MOST_STRETCH)
    if m.phase == WITHDRAWING:
        begin(s, m, SLIPPING, -m.direction, position, setpoint)
        return
    if abs(error) <= s.dead_band:
        m.phase = HOLDING
        wait(m)
        return
    if m.phase == SLIPPING and m.direction > 0.0:
        m.rising_offset += error
    elif m.phase == SLIPPING:
        m.falling_offset += error
    approach(s, m, setpoint, position)
