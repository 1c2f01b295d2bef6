"""Parts that are kept: the pressures of one row of numbers serve the rows that differ from it behind them alone."""

from __future__ import annotations

import numpy as np

from valvemodel.compiled import inlined
from valvemodel.stages.nodes import COARSE_NODES, fit_powers
from valvemodel.stages.part import is_coarse, lay_part

MOST_KEPT = 65536
"""Parts of one run that can be kept; of longer runs each lays its own."""

KEPT = np.dtype([("length", "f8"), ("pressures", "f8", (COARSE_NODES + 1,)), ("pressure", "f8"), ("rest_drive", "f8")])
"""Type of a part of a coarse run: its length, the pressures at its nodes and at its end, its drive if that rests."""


@inlined
def begin_parts(memory, keeps, takes, plan, tolerance):
    """Begin a run that keeps its parts, or takes those of the row before.

    The plan, a positive number, says how the run goes along its pressures: a row of another plan lays its own. It is 0
    where none are kept.
    """
    memory.parts_taken = 0.0
    memory.takes_parts = takes and memory.kept_plan == plan
    if memory.takes_parts == 0.0:
        memory.kept_plan = plan if keeps and is_coarse(tolerance) else 0.0
        memory.parts_kept = 0.0


@inlined
def next_part(p, state, memory, drive, time, left, tolerance):
    """Lay the pressure over a part, or take the part that was kept; return its length. [s]"""
    if memory.takes_parts == 1.0:
        return take_part(state, memory, time)
    length = lay_part(p, state, memory, drive, time, left, tolerance)
    if memory.kept_plan > 0.0:
        keep_part(state, memory, length)
    return length


@inlined
def take_part(state, memory, time):
    """Take the part that was kept next, with the pressure at its end; return its length. [s]"""
    kept = memory.kept[int(memory.parts_taken)]
    memory.parts_taken += 1.0
    for node in range(COARSE_NODES + 1):
        memory.pressures[node] = kept.pressures[node]
    fit_powers(COARSE_NODES, memory.pressures, memory.part_powers)
    memory.part_count, memory.part_time, memory.part_spacing = COARSE_NODES, time, kept.length / COARSE_NODES
    state.pressure, state.rest_drive = kept.pressure, kept.rest_drive
    return kept.length


@inlined
def keep_part(state, memory, length):
    """Keep the part that was laid; where there are too many, none is."""
    index = int(memory.parts_kept)
    if index == MOST_KEPT:
        memory.kept_plan = 0.0
        return
    kept = memory.kept[index]
    for node in range(COARSE_NODES + 1):
        kept.pressures[node] = memory.pressures[node]
    kept.length, kept.pressure, kept.rest_drive = length, state.pressure, state.rest_drive
    memory.parts_kept += 1.0
