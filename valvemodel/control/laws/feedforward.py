"""Feedforward: the current at which the valve is thought to stand at a set point."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined
from valvemodel.control.laws.settings import BRANCH_LINE, HELD, MEAN_LINE, TABLE_LENGTH


@inlined
def threshold(s):
    """Return I_threshold of (40), the full width of the loop. [A]"""
    return (s.falling_intercept - s.rising_intercept) / s.line_slope


@compiled
def turn(s, m, setpoint, reading):
    """Write down the direction of the demanded motion, and move the branch line by the full width at a reversal.

    The direction is that in which the set point moved last; where asked for, that of the error beyond the dead band.
    The calibration ends on the falling branch, so the line starts there.
    """
    before = m.direction
    if m.is_started == 0.0:
        before = -1.0
        m.direction = math.copysign(1.0, setpoint - reading)
    elif setpoint != m.last_setpoint:
        m.direction = math.copysign(1.0, setpoint - m.last_setpoint)
    elif s.follows_error == 1.0 and abs(setpoint - reading) > s.dead_band:
        m.direction = math.copysign(1.0, setpoint - reading)
    if m.direction != before:
        m.line_offset += m.direction * threshold(s)


@compiled
def current_from(table, s, position):
    """Return the current at a position of a table; beyond its ends that of the end. [A]"""
    place = (position - s.table_low) / s.table_step
    place = min(max(place, 0.0), TABLE_LENGTH - 1.0)
    index = min(int(place), TABLE_LENGTH - 2)
    return table[index] + (place - index) * (table[index + 1] - table[index])


@compiled
def branch_current(s, direction, position):
    """Return the current whose long slip in a direction ends at a position, from the tables of a model. [A]"""
    if direction > 0.0:
        return current_from(s.rising_currents, s, position)
    return current_from(s.falling_currents, s, position)


@compiled
def slope_at(s, position):
    """Return the slope of the current over the position, the mean of both branches. [A/m]"""
    half = 2.0 * s.table_step
    above = branch_current(s, 1.0, position + half) + branch_current(s, -1.0, position + half)
    below = branch_current(s, 1.0, position - half) + branch_current(s, -1.0, position - half)
    return (above - below) / (4.0 * half)


@compiled
def gain_schedule(s, setpoint):
    """Return that slope at the set point, relative to the middle of the travel."""
    middle = s.table_low + 0.5 * (TABLE_LENGTH - 1.0) * s.table_step
    return slope_at(s, setpoint) / slope_at(s, middle)


@inlined
def feedforward(s, m, setpoint):
    """Return the current that the PID output is added to. [A]

    References
    ----------
    Paper, section 3: i_SC = i +- I_threshold. (40) is the full width of the loop: added at each reversal it is right
    on a branch line, from the mean line half of it is.
    """
    if s.feedforward == HELD:
        return s.start_current
    if s.feedforward == BRANCH_LINE:
        return (setpoint - s.falling_intercept) / s.line_slope + m.line_offset
    if s.feedforward == MEAN_LINE:
        mean = 0.5 * (s.rising_intercept + s.falling_intercept)
        return (setpoint - mean) / s.line_slope + m.direction * s.threshold_share * threshold(s)
    return branch_current(s, m.direction, setpoint)
