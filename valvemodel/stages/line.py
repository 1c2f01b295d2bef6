"""The line behind a transport delay: the drives that are under way in it, in the order in which they entered."""

from __future__ import annotations

from valvemodel.compiled import compiled

CAPACITY = 16384
"""Drives that are under way in the line at once, at most."""

ROUNDING = 1e-12
"""Instants that differ by less are equal but for the rounding of their times. [s]"""


@compiled
def rest_line(memory, drive):
    """Fill the line with one drive."""
    memory.line_entered = memory.line_acting = 0.0
    memory.line_drive[0] = drive


@compiled
def enter_line(memory, instant, drive):
    """Let a drive enter the line at an instant. [s]"""
    memory.line_entered += 1.0
    slot = int(memory.line_entered) % CAPACITY
    memory.line_time[slot] = instant
    memory.line_drive[slot] = drive


@compiled
def leave_line(memory, delay, instant):
    """Return the drive that acts at the end of the line at an instant."""
    while (
        memory.line_acting < memory.line_entered
        and memory.line_time[int(memory.line_acting + 1.0) % CAPACITY] + delay <= instant + ROUNDING
    ):
        memory.line_acting += 1.0
    return memory.line_drive[int(memory.line_acting) % CAPACITY]


@compiled
def next_arrival(memory, delay, end):
    """Return when the next drive arrives at the end of the line; an end where none does before. [s]"""
    if memory.line_acting < memory.line_entered:
        arrival = memory.line_time[int(memory.line_acting + 1.0) % CAPACITY] + delay
        if arrival < end - ROUNDING:
            return arrival
    return end
