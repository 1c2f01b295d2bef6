"""The limit cycle that the exact simulator runs into, stepped period by period."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from valvemodel.linear.limit_cycle import LimitCycle
from valvemodel.linear.loop import Loop
from valvemodel.linear.rates import INTEGRAL, OUTPUT, POSITION
from valvemodel.stepping import SteppedValve

TURNS = 6
"""Turns at the end of a run that are measured."""

STEADINESS = 0.01
"""Spread of the periods of those turns over their mean, beyond which there is no cycle yet."""


def run_loop(loop: Loop, *, duration: float, start: np.ndarray | None = None) -> np.ndarray:
    """Return the controlled variable at each controller period, from a start or from half a jump off the set point.

    Parameters
    ----------
    loop : Loop
        The dead time is rounded to whole periods.
    duration : float [s]
    start : array, shape (n,)
        States in the order of `rates`.

    Returns
    -------
    array, shape (m,) [m]
    """
    static, kinetic = loop.stickiness()
    position = loop.setpoint - 0.5 * (static - kinetic)
    output, integral = position, 0.0
    if start is not None:
        position, output, integral = (float(start[place]) for place in (POSITION, OUTPUT, INTEGRAL))
        output = output if loop.lag > 0.0 else position
    drive = loop.current + loop.proportional * (loop.setpoint - output) + integral
    valve = SteppedValve(loop.model, current=drive, start_position=position)
    line = deque([position] * round(loop.dead_time / loop.period))
    decay = math.exp(-loop.period / loop.lag) if loop.lag > 0.0 else 0.0
    setpoint, before = loop.setpoint, valve.reading
    outputs = np.empty(max(round(duration / loop.period), 2))
    for sample in range(len(outputs)):
        outputs[sample] = output
        error = setpoint - output
        integral += loop.integral * loop.period * error
        reading = valve.step(max(loop.current + loop.proportional * error + integral, 0.0), loop.period)
        if loop.has_process:
            line.append(0.5 * (before + reading))
            arriving = line.popleft()
            output = arriving + (output - arriving) * decay
        else:
            output = reading
        before = reading
    return outputs


def simulated_cycle(loop: Loop, *, duration: float, start: np.ndarray | None = None) -> LimitCycle | None:
    """Return the limit cycle at the end of a run of the exact simulator; None where the stem wanders or rests.

    Parameters
    ----------
    loop : Loop
    duration : float
        Of the run; at least `TURNS` turns longer than the loop takes to settle. [s]
    start : array, shape (n,)
        As in `run_loop`.
    """
    outputs = run_loop(loop, duration=duration, start=start)
    crossings = upward_crossings(outputs - loop.setpoint) * loop.period
    if len(crossings) <= TURNS:
        return None
    periods = np.diff(crossings)[-TURNS:]
    if np.ptp(periods) > STEADINESS * periods.mean() + 2.0 * loop.period:
        return None
    last = outputs[-round(TURNS * periods.mean() / loop.period) :]
    return LimitCycle("simulation", float(periods.mean()), 0.5 * float(np.ptp(last)))


def upward_crossings(values: np.ndarray) -> np.ndarray:
    """Return where values cross 0 upwards, in samples, interpolated."""
    before = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
    return before + values[before] / (values[before] - values[before + 1])
