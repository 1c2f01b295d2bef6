"""Runs of the chain over whole inputs, compiled: samples, one row of numbers after the other."""

from __future__ import annotations

import math

import numpy as np

from valvemodel.chain import advance_period, anchor_stem, mode_of, start_chain
from valvemodel.compiled import compiled
from valvemodel.stages.sensor import read_sensor

NONE = np.zeros((0, 0))
FREE = np.zeros(0)


@compiled
def run_chain(rows, states, memories, time, drive, anchors, driven_by, substep, tolerance, readings, pressures, modes):
    """Run each row of numbers over the same drive; row k of the outputs is the state just before the drive of period k.

    Parameters
    ----------
    rows : array, shape (n,), dtype PARAMETERS
    states : array, shape (n,), dtype STATE
        Overwritten.
    memories : array, shape (1,), dtype MEMORY
        Overwritten; one row after the other uses it.
    time : array, shape (m,) [s]
    drive : array, shape (m,) [A] or [Pa]
        Held from each sample to the next.
    anchors : array, shape (0,) or (m,) [m]
        Readings at which the stem is put anew; NaN where it runs free.
    driven_by : int
        CURRENT or PRESSURE.
    substep : float [s]
        Longest part of a period while the pressure moves.
    tolerance : float [N]
        Force left over by one linearised slip step.
    readings, pressures, modes : arrays, shape (n, m) [m], [Pa], -1 falling 0 stuck 1 rising
        Overwritten; pressures and modes may have shape (0, 0) and are then left out.
    """
    memory = memories[0]
    for row in range(rows.shape[0]):
        p, state = rows[row], states[row]
        start_chain(p, state, memory, drive[0], driven_by, time[0], substep)
        for sample in range(time.shape[0]):
            if anchors.shape[0] > 0 and not math.isnan(anchors[sample]):
                anchor_stem(p, state, anchors[sample], time[sample])
            readings[row, sample] = read_sensor(p, state, time[sample])
            if pressures.shape[0] > 0:
                pressures[row, sample] = state.pressure
                modes[row, sample] = mode_of(state)
            if sample + 1 < time.shape[0]:
                advance_period(
                    p, state, memory, drive[sample], time[sample], time[sample + 1] - time[sample], tolerance
                )
