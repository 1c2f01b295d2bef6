"""The limit cycle that the exact simulator runs into, period by period, compiled."""

from __future__ import annotations

import math

import numpy as np

from valvemodel.chain import CURRENT, advance_period, start_chain
from valvemodel.compiled import compiled
from valvemodel.linear.limit_cycle import LimitCycle
from valvemodel.linear.loop import Loop
from valvemodel.linear.rates import INTEGRAL, OUTPUT, POSITION
from valvemodel.parameters import MEMORY, STATE
from valvemodel.simulation import SUBSTEP, TOLERANCE
from valvemodel.stages.sensor import read_sensor

TURNS = 6
"""Turns at the end of a run that are measured."""

STEADINESS = 0.01
"""Spread of the periods of those turns over their mean, beyond which there is no cycle yet."""


@compiled
def _run(rows, states, memories, settings, drive, output, delayed, decay, period, substep, tolerance, outputs):
    """Run the sampled loop; `outputs` is overwritten with the controlled variable at each sample, `delayed` as well."""
    p, state, memory, s = rows[0], states[0], memories[0], settings[0]
    start_chain(p, state, memory, drive, CURRENT, 0.0, substep)
    integral = drive - s.reference - s.proportional * (s.setpoint - output)
    now, before, place = 0.0, read_sensor(p, state, 0.0), 0
    for sample in range(outputs.shape[0]):
        outputs[sample] = output
        error = s.setpoint - output
        integral += s.integral * period * error
        current = max(s.reference + s.proportional * error + integral, 0.0)
        following = now + period
        advance_period(p, state, memory, current, now, following - now, tolerance)
        reading = read_sensor(p, state, following)
        entering, before, now = 0.5 * (before + reading), reading, following
        if delayed.shape[0] > 0:
            leaving, delayed[place] = delayed[place], entering
            entering = leaving
            place = (place + 1) % delayed.shape[0]
        output = reading if decay == 0.0 and delayed.shape[0] == 0 else entering + (output - entering) * decay


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
    delayed = np.full(round(loop.dead_time / loop.period), position)
    decay = math.exp(-loop.period / loop.lag) if loop.lag > 0.0 else 0.0
    outputs = np.empty(max(round(duration / loop.period), 2))
    _run(
        loop.model.rows(start_position=position), np.zeros(1, STATE), np.zeros(1, MEMORY), loop.settings, drive, output,
        delayed, decay, loop.period, SUBSTEP, TOLERANCE, outputs,
    )  # fmt: skip
    return outputs


def simulated_cycle(loop: Loop, *, duration: float, start: np.ndarray | None = None) -> LimitCycle | None:
    """Return the limit cycle at the end of a run of the exact simulator; None where there is none.

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
