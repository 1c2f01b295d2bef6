"""A part of a period over which the actuator pressure is a polynomial in time, through its values at the nodes."""

from __future__ import annotations

import math

import numpy as np

from valvemodel.compiled import compiled, inlined
from valvemodel.stages.amplifier import INSTANT, lay_amplifier
from valvemodel.stages.chamber import lay_chamber
from valvemodel.stages.electromagnet import (
    accept_currents,
    advance_flux,
    flux_departs,
    followed_by_lags,
    gap_of_current,
    has_coil_lag,
    lay_currents,
)
from valvemodel.stages.nodes import COARSE_NODES, NODES, fit_powers, left_out, value_at
from valvemodel.stages.nozzle import (
    behind_leak,
    drawn_to_settle,
    has_leak,
    is_amplified,
    rest_nozzle,
    resting_pressure_of_chain,
    time_to_fill,
    time_to_vent,
)
from valvemodel.stages.supply import lay_supply

COARSE = 1e-7
"""Tolerance from which a run is coarse: fewer nodes. [m]"""

OF_A_SEARCH = 5e-6
"""Tolerance from which a run serves a search among many. [m]"""

PRESSURE_SHARE = 0.1
"""Share of the tolerance that the polynomial of the pressure may use."""

PRESSURE_SHARE_OF_A_SEARCH = 0.3
"""The same of a run that serves a search: what it is off by at the end of a part mostly dies out in the next."""

REST_SHARE = 0.02
"""Share of the tolerance within which the pressure has come to rest."""

SHORTEST_PART = 1e-6
"""Parts are not made shorter: what a kink of the pressure does within is far below a nanometre. [s]"""

CUTS, LONGER = 1, 4.0
"""Cuts of a part at a kink before it is halved at one instead, and how much longer the next part is tried."""

NEARLY = 2.0 ** np.arange(1, NODES + 3)
"""By how much the error of a polynomial through nodes falls when its length is halved, by their count."""

CURRENT_SPAN = 4e-3
"""A departure of the current by this moves the pressure by less than the supply. [A]"""


@inlined
def is_coarse(tolerance):
    """Return whether a run is a coarse one."""
    return tolerance >= COARSE


@inlined
def is_of_a_search(tolerance):
    """Return whether a run serves a search among many."""
    return tolerance >= OF_A_SEARCH


@inlined
def pressure_at(memory, time):
    """Return the actuator pressure at an instant of the part. [Pa]"""
    count = int(memory.part_count)
    if count == 0:
        return memory.part_powers[0]
    return value_at(count, memory.part_powers, (time - memory.part_time) / memory.part_spacing)


@inlined
def hold_pressure(memory, pressure):
    """Take the pressure as held."""
    memory.part_count = 0.0
    memory.part_powers[0] = pressure


@inlined
def resistance_within(p, duration):
    """Return how large a force moves the stem by a metre at most within a duration. [N/m]"""
    rate = 1.0 / duration
    return p.spring_rate + rate * (p.viscous_friction + 2.0 * p.stem_mass * rate)


@inlined
def allowed_force(p, state, tolerance, duration):
    """Return by how much the force on the stem may be off for a duration. [N]"""
    share = PRESSURE_SHARE_OF_A_SEARCH if is_of_a_search(tolerance) else PRESSURE_SHARE
    return share * state.plan_share * tolerance * resistance_within(p, duration)


@inlined
def near_pressure(p, state, tolerance):
    """Return by how much a pressure may be off without being seen at the stem. [Pa]"""
    return REST_SHARE * state.plan_share * tolerance * p.spring_rate / p.diaphragm_area + 1e-13 * p.supply_pressure


@inlined
def rest_parts(state, drive):
    """Take no part as too long yet."""
    state.part_aim = state.aim_after_rise = state.aim_after_fall = math.inf
    state.held_drive = drive


@compiled
def lay_part(p, state, memory, drive, time, left, tolerance):
    """Lay the pressure over the longest part that a polynomial carries, at most what is left; return its length. [s]"""
    count = COARSE_NODES if is_coarse(tolerance) else NODES
    slack = near_pressure(p, state, tolerance)
    if drive != state.held_drive:
        # What carried after the last switch to the same side is tried first.
        state.part_aim = state.aim_after_rise if drive > state.held_drive else state.aim_after_fall
    length = left
    if state.part_aim < left:
        length = left / math.ceil(left / state.part_aim - 1e-6)
    cuts = 0
    while True:
        kept = allowed_force(p, state, tolerance, max(length, time_to_fill(p) + time_to_vent(p))) / p.diaphragm_area
        end = lay_nodes(p, state, memory, drive, time, length / count, count, slack, kept)
        fit_powers(count, memory.pressures, memory.part_powers)
        off = left_out(count, memory.part_powers) * p.diaphragm_area
        allowed = allowed_force(p, state, tolerance, length)
        if off > allowed and length > SHORTEST_PART:
            # What is left out shrinks with a high power of the length.
            finer = 0.5 if off < allowed * NEARLY[count] else 0.25
            length = max(finer * length, SHORTEST_PART)
            continue
        # A pressure at a limited rate would be far beyond its aim a moment later.
        shortest = SHORTEST_PART if p.filling_slowness == 0.0 else INSTANT
        if not (end < count and length > shortest):
            break
        # What a polynomial that is too long takes for a kink goes with its length and is never met.
        length = max(length * (end / count if cuts < CUTS else 0.5), shortest)
        cuts += 1
    if off < allowed / NEARLY[count + 1]:
        state.part_aim = max(2.0 * length, state.part_aim)
    elif length < left:
        state.part_aim = length
    if cuts > CUTS:
        state.part_aim = min(state.part_aim, LONGER * length)
    if drive > state.held_drive:
        state.aim_after_rise = state.part_aim
    elif drive < state.held_drive:
        state.aim_after_fall = state.part_aim
    state.held_drive = drive
    memory.part_count, memory.part_time, memory.part_spacing = count, time, length / count
    end_part(p, state, memory, drive, length, tolerance)
    return length


@compiled
def lay_nodes(p, state, memory, drive, time, spacing, count, slack, kept):
    """Lay the pressure at the nodes, stage by stage; return where a stage changes its law, in spacings.

    The pressures that the amplifier follows may be off their polynomial by what may be kept from then on. [Pa]
    """
    end = lay_currents(p, state, memory, drive, spacing, count)
    is_still = not has_coil_lag(p) and p.gap_drift_rate == 0.0
    resting = 0.0
    for node in range(count + 1):
        if is_still and node > 0:
            memory.gaps[node], memory.pressures[node] = memory.gaps[0], resting
        else:
            gap = gap_of_current(p, memory.currents[node], time + node * spacing)
            memory.gaps[node] = gap
            resting = resting_pressure_of_chain(p, gap, memory.currents[node])
            memory.pressures[node] = resting
    if p.droop_gain > 0.0 or p.droop_consumption > 0.0:
        end = min(end, lay_supply(p, state, memory, spacing, count, slack))
        memory.end_share, memory.end_supply = memory.shares[count], memory.values[count]
    memory.end_supplied = memory.pressures[count]
    if p.chamber_filling_time > 0.0:
        lay_chamber(p, state, memory, spacing, count, slack)
    memory.end_chamber = memory.pressures[count]
    if is_amplified(p):
        end = min(end, lay_amplifier(p, state, memory, spacing, count, slack, kept))
    memory.end_filled = memory.pressures[count]
    if has_leak(p):
        for node in range(count + 1):
            memory.pressures[node] = behind_leak(p, memory.pressures[node])
    return end


@compiled
def end_part(p, state, memory, drive, length, tolerance):
    """Take the stages to the end of the part that was laid; put them at rest where they have come near it."""
    count = int(memory.part_count)
    near = near_pressure(p, state, tolerance)
    accept_currents(p, state, memory)
    is_near = flux_departs(p, state, drive) * p.supply_pressure <= near * CURRENT_SPAN and p.gap_drift_rate == 0.0
    if p.droop_gain > 0.0 or p.droop_consumption > 0.0:
        state.share, state.droop = memory.end_share, p.supply_pressure - memory.end_supply
        is_near = is_near and abs(state.droop - drawn_to_settle(p, state.share)) <= near
    state.chamber_pressure, state.filled_pressure = memory.end_chamber, memory.end_filled
    is_near = is_near and abs(memory.end_chamber - memory.end_supplied) <= near
    is_near = is_near and abs(memory.end_filled - memory.end_chamber) <= near
    state.pressure = memory.pressures[count]
    state.rest_drive = math.nan
    if is_near:
        state.flux_current = state.less_lagged_flux = followed_by_lags(p, state, drive)
        effective = advance_flux(p, state, drive)
        rest_nozzle(p, state, gap_of_current(p, effective, 0.0), effective)
        state.rest_drive = drive
