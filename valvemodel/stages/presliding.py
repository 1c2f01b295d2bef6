"""Friction that is elastic before it slides: Dahl's bristles, with F_s > F_c those of LuGre."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled
from valvemodel.stages.nodes import fit_powers, left_out
from valvemodel.stages.part import pressure_at
from valvemodel.stages.stem import FALLING, RISING, limiting_friction, thrust

FORGOTTEN = 1e-4
"""Share of the limit of bristles that a swing which is left out may hold, however stiff they are."""

SETTLED = 0.01
"""Share of the tolerance below which the next elastic swing is left out: the stem is at its balance."""


@compiled
def bristle_stiffness(p, bristle, limit):
    """Return by how much the force of the bristles grows with the way, at least 0. [N/m]"""
    return max(1.0 - bristle / limit, 0.0) / p.presliding_compliance


@compiled
def rests_on_bristles(p, state, memory, time, duration, tolerance):
    """Return whether a stem on bristles stays where it is, else choose its side; a negligible swing is left out."""
    position, net = state.position, net_on_bristles(p, state, memory, time)
    if is_negligible(p, state, memory, time, net, tolerance):
        if memory.part_count == 0.0 and state.plan_varies == 0.0:
            return True
        net = net_on_bristles(p, state, memory, time + duration)
        if is_negligible(p, state, memory, time + duration, net, tolerance):
            return True
    side = RISING if net > 0.0 else FALLING
    room = state.plan_highest - position if side > 0.0 else position - state.plan_lowest
    if net == 0.0 or room <= 0.0:
        return True
    state.mode, state.velocity = side, 0.0
    return False


@compiled
def net_on_bristles(p, state, memory, time):
    """Return the force on a stem that rests on bristles. [N]"""
    return thrust(p, state.position, pressure_at(memory, time), time) - state.bristle


@compiled
def is_negligible(p, state, memory, time, net, tolerance):
    """Return whether a force swings a stem that rests on bristles by much less than the tolerance."""
    limit = limiting_friction(p, 0.0, state.position, pressure_at(memory, time), time, 0.0)
    # Near the limit a small force bends them far, and what they forget by swinging back tells then.
    stiffness = bristle_stiffness(p, abs(state.bristle), limit)
    return abs(net) <= min(SETTLED * tolerance * max(stiffness, 1e-9 / p.presliding_compliance), FORGOTTEN * limit)


@compiled
def lay_bristles(p, state, memory, count):
    """Write the force of the bristles at the nodes of a step, counted against the motion.

    Under a limit that is held it is a function of the way alone, exact (Dahl). Else its departure from the limit dies
    out with the way over the limit's own reach, while the limit's changes feed it: both are integrals through nodes.
    """
    side, start, compliance = memory.step_side, memory.bristles[0], p.presliding_compliance
    for node in range(count + 1):
        position = memory.step_position + side * memory.ways[node]
        time = memory.step_time + node * memory.step_spacing
        speed = max(memory.speeds[node], 0.0)
        memory.limits[node] = limiting_friction(p, side, position, memory.step_pressures[node], time, speed)
    departure, memory.bristles_off = start - memory.limits[0], 0.0
    if state.plan_limit_held == 1.0:
        for node in range(1, count + 1):
            reach = memory.limits[node] * compliance
            memory.bristles[node] = memory.limits[node] + departure * math.exp(-memory.ways[node] / reach)
        return
    for node in range(count + 1):
        memory.values[node] = memory.speeds[node] / (memory.limits[node] * compliance)
    fit_powers(count, memory.values, memory.powers)
    length = count * memory.step_spacing
    memory.bristles_off = abs(departure) * length * left_out(count, memory.powers)
    for node in range(count + 1):
        # The feed of the last pass.
        memory.forces[node] = memory.values[node] * memory.feeds[node]
        memory.values[node] = memory.step_spacing * area_to(count, memory.powers, node)
    fit_powers(count, memory.forces, memory.powers)
    memory.bristles_off += length * left_out(count, memory.powers)
    for node in range(1, count + 1):
        change = memory.limits[node] - memory.limits[0]
        memory.feeds[node] = change - memory.step_spacing * area_to(count, memory.powers, node)
        decayed = departure * math.exp(-memory.values[node])
        memory.bristles[node] = memory.limits[node] + decayed - memory.feeds[node]


@compiled
def area_to(count, powers, node):
    """Return the area under a polynomial from the first node to another, in spacings."""
    area = 0.0
    for power in range(count, -1, -1):
        area = (area + powers[power] / (power + 1.0)) * node
    return area
