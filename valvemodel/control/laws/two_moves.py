"""Two-move compensation: one move frees the stem, the second lets it stop at the set point."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled
from valvemodel.control.laws.feedforward import threshold
from valvemodel.control.laws.pid import pid
from valvemodel.control.laws.settings import HIGHEST_CURRENT, LOWEST_CURRENT

FOLLOWING, FREEING, STOPPING = 0.0, 1.0, 2.0


@compiled
def two_moves(s, m, setpoint, reading):
    """Return a PI's current, or that of the move under way. [A]

    Where the error has been beyond the dead band for `still_duration`, or the set point has changed, the current goes
    beyond the calibrated branch by `first_move`, then to the mean line, where a stem is stuck whichever way it came;
    the integral goes on from there.

    References
    ----------
    Srinivasan and Rengaswamy, Approaches for efficient stiction compensation in process control valves, Comput. Chem.
    Eng. 32 (2008) 218-229; begun by the error as in Cuadros, Munaro and Munareto, Improved stiction compensation in
    pneumatic control valves, Comput. Chem. Eng. 38 (2012) 106-114.
    """
    error = setpoint - reading
    mean = (setpoint - 0.5 * (s.rising_intercept + s.falling_intercept)) / s.line_slope
    m.clock += s.period
    if m.phase == FOLLOWING and abs(error) <= s.dead_band:
        m.clock = 0.0
    is_still = m.phase == FOLLOWING and m.clock > s.still_duration
    if is_still or m.is_started == 0.0 or (setpoint != m.last_setpoint and abs(error) > s.dead_band):
        m.phase, m.clock = FREEING, 0.0
        excess = 0.5 * threshold(s) + s.first_move
        m.held_current = min(max(mean + math.copysign(excess, error), LOWEST_CURRENT), HIGHEST_CURRENT)
    elif m.phase != FOLLOWING and m.clock >= s.move_duration - 0.5 * s.period:
        m.phase = STOPPING if m.phase == FREEING else FOLLOWING
        m.clock = 0.0
        m.held_current = mean
        m.integral = mean - s.start_current
    if m.phase == FOLLOWING:
        return pid(s, m, setpoint, reading, s.start_current)
    m.last_error = error
    return m.held_current
