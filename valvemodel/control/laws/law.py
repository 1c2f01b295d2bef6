"""One period of a controller: set point and reading in, current out."""

from __future__ import annotations

from valvemodel.compiled import compiled, inlined
from valvemodel.control.laws.feedforward import feedforward, turn
from valvemodel.control.laws.knocker import knock
from valvemodel.control.laws.landing import land
from valvemodel.control.laws.pid import pid
from valvemodel.control.laws.reinforcement import reinforce
from valvemodel.control.laws.settings import (
    HELD,
    HIGHEST_CURRENT,
    KNOCKER,
    LANDING,
    LOWEST_CURRENT,
    REINFORCEMENT,
    TWO_MOVES,
)
from valvemodel.control.laws.two_moves import two_moves


@inlined
def within_limits(current):
    """Return a current as the current loop can carry it, 4..20 mA. [A]"""
    return min(max(current, LOWEST_CURRENT), HIGHEST_CURRENT)


@compiled
def step(s, m, setpoint, reading):
    """Return the current that a controller sets for the coming period. [A]

    Parameters
    ----------
    s : record, dtype SETTINGS
    m : record, dtype RECOLLECTION
        What the law remembers; overwritten.
    setpoint, reading : float [m]
        All that it learns of the world.
    """
    if s.law == LANDING:
        current = land(s, m, setpoint, reading)
    elif s.law == TWO_MOVES:
        current = two_moves(s, m, setpoint, reading)
    else:
        if s.feedforward != HELD:
            turn(s, m, setpoint, reading)
        current = pid(s, m, setpoint, reading, feedforward(s, m, setpoint))
        if s.law == KNOCKER:
            current += knock(s, m, current, setpoint - reading)
        elif s.law == REINFORCEMENT:
            current += reinforce(s, m, current, setpoint - reading)
    current = within_limits(current)
    if m.is_started == 1.0:
        most = s.rate_limit * s.period
        current = min(max(current, m.last_current - most), m.last_current + most)
    m.is_started = 1.0
    m.last_setpoint, m.last_reading, m.last_current = setpoint, reading, current
    return current
