"""Friction that is elastic before it slides: Dahl's bristles, with damping those of LuGre, and Iwan's sliders."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined
from valvemodel.stages.nodes import NODES, first_fall, fit_powers, left_out
from valvemodel.stages.part import pressure_at
from valvemodel.stages.rest import are_forces_held, break_away, is_blocked
from valvemodel.stages.sliders import (
    force_of_sliders,
    has_sliders,
    lay_sliders,
    pull_sliders,
    sliders_after,
    stiffness_of_sliders,
)
from valvemodel.stages.stem import FALLING, RISING, limiting_friction, thrust

FORGOTTEN = 1e-4
"""Share of the limit of bristles that a swing which is left out may hold, however stiff they are."""

SETTLED = 0.01
"""Share of the tolerance below which the next elastic swing is left out: the stem is at its balance."""


STRAIGHT = 1e-8
"""An exponent that is above 1 by less is 1."""


@inlined
def is_curved(p):
    """Return whether bristles fade as a power of the way, not as an exponential."""
    return p.bristle_exponent > 1.0 + STRAIGHT


@compiled
def bristle_stiffness(p, bristle, limit):
    """Return by how much the force of the bristles grows with the way, at least 0. [N/m]"""
    room = max(1.0 - bristle / limit, 0.0)
    if is_curved(p):
        room **= p.bristle_exponent
    return room / p.presliding_compliance


@inlined
def bristle_viscosity(p, stiffness):
    """Return the viscous friction of bristles of a stiffness: both fade as they slide. [N s/m]"""
    return (1.0 - p.slider_share) * p.bristle_damping * p.presliding_compliance * stiffness


@compiled
def fade_after(p, room, way):
    """Return what is left, as a share, of the room of bristles over their limit after a way over their reach."""
    if not is_curved(p):
        return math.exp(-way)
    bend = p.bristle_exponent - 1.0
    return math.exp(-math.log1p(bend * abs(room) ** bend * way) / bend)


@inlined
def with_sliders(p, bristle, slider):
    """Return force or stiffness of bristles and sliders, each by its share."""
    return bristle + p.slider_share * (slider - bristle)


@compiled
def limit_behind(p, state, side, position, pressure, time, speed):
    """Return what holds the sliders against the motion; infinity where that is held, and they are within it. [N]"""
    if not has_sliders(p) or state.plan_limit_held == 1.0:
        return math.inf
    return limiting_friction(p, -side, position, pressure, time, speed)


@compiled
def elastic_friction(p, state):
    """Return the force of bristles and sliders on a stem, down positive. [N]"""
    if not has_sliders(p):
        return state.bristle
    return with_sliders(p, state.bristle, force_of_sliders(p, state))


@compiled
def elastic_friction_at(p, state, pressure, time):
    """Return that force at an instant, on a stem that stays where it is until then: sliders may have slid. [N]"""
    if not has_sliders(p):
        return state.bristle
    rising, falling = limits_either_way(p, state, pressure, time)
    return with_sliders(p, state.bristle, sliders_after(p, state, RISING, 0.0, rising, falling))


@compiled
def let_slide(p, state, pressure, time):
    """Let sliders slide that friction, where it fell, does not hold any more."""
    rising, falling = limits_either_way(p, state, pressure, time)
    if rising < math.inf:
        pull_sliders(p, state, RISING, 0.0, rising, falling)


@compiled
def limits_either_way(p, state, pressure, time):
    """Return what holds the sliders of a stem where it is, bent up and down; infinity as for `limit_behind`. [N]"""
    position, speed = state.position, abs(state.velocity)
    rising = limit_behind(p, state, FALLING, position, pressure, time, speed)
    return rising, limit_behind(p, state, RISING, position, pressure, time, speed)


@compiled
def elastic_stiffness(p, state, side, limit, stiffness):
    """Return by how much that force grows with the way to one side, from the stiffness of the bristles. [N/m]"""
    if not has_sliders(p):
        return stiffness
    return with_sliders(p, stiffness, stiffness_of_sliders(p, state, side, limit))


@compiled
def bristle_after(p, state, side, way, limit):
    """Return the force of the bristles after a way to one side, counted against it and exact along it (Dahl). [N]"""
    departure = side * state.bristle - limit
    return limit + departure * fade_after(p, departure / limit, way / (limit * p.presliding_compliance))


@compiled
def friction_after(p, state, side, way, limit, behind, bristle):
    """Return the force of bristles, given, and sliders after a way to one side, counted against it. [N]"""
    if not has_sliders(p):
        return bristle
    return with_sliders(p, bristle, sliders_after(p, state, side, way, limit, behind))


@compiled
def pull_bristles(p, state, side, way, limit, behind):
    """Take bristles and sliders along a way to one side."""
    state.bristle = side * bristle_after(p, state, side, way, limit)
    if has_sliders(p):
        pull_sliders(p, state, side, way, limit, behind)


@compiled
def time_on_bristles(p, state, memory, time, duration, tolerance):
    """Return how long a stem on bristles stays where it is, at most a duration; its side is chosen where it goes. [s]

    A negligible swing is left out; what presses it on an end of the travel holds it until it has turned.
    """
    let_slide(p, state, pressure_at(memory, time), time)
    net = net_on_bristles(p, state, memory, time)
    is_held = are_forces_held(state, memory)
    if is_negligible(p, state, memory, time, net, tolerance):
        if is_held:
            return duration
        net = net_on_bristles(p, state, memory, time + duration)
        if is_negligible(p, state, memory, time + duration, net, tolerance):
            return duration
    side = RISING if net > 0.0 else FALLING
    if net == 0.0 or is_blocked(state, state.position, side):
        return duration if is_held or net == 0.0 else time_pressed(p, state, memory, time, duration, side)
    break_away(p, state, side)
    return 0.0


@compiled
def time_pressed(p, state, memory, time, duration, side):
    """Return how long a moving force goes on pressing a stem on bristles to a side, at most a duration. [s]"""
    length = min(duration, state.plan_longest)
    spacing, nets = length / NODES, memory.values
    for node in range(NODES + 1):
        nets[node] = side * net_on_bristles(p, state, memory, time + node * spacing)
    return min(first_fall(NODES, nets, memory.powers) * spacing, length)


@compiled
def net_on_bristles(p, state, memory, time):
    """Return the force on a stem that rests on bristles. [N]"""
    pressure = pressure_at(memory, time)
    return thrust(p, state.position, pressure, time) - elastic_friction_at(p, state, pressure, time)


@compiled
def is_negligible(p, state, memory, time, net, tolerance):
    """Return whether a force swings a stem that rests on bristles by much less than the tolerance."""
    limit = limiting_friction(p, 0.0, state.position, pressure_at(memory, time), time, 0.0)
    # Near the limit a small force bends them far, and what they forget by swinging back tells then.
    stiffness = bristle_stiffness(p, abs(state.bristle), limit)
    if has_sliders(p):
        rising = stiffness_of_sliders(p, state, RISING, limit)
        stiffness = with_sliders(p, stiffness, min(rising, stiffness_of_sliders(p, state, FALLING, limit)))
    return abs(net) <= min(SETTLED * tolerance * max(stiffness, 1e-9 / p.presliding_compliance), FORGOTTEN * limit)


@compiled
def lay_bristles(p, state, memory, count):
    """Write the force of bristles and of sliders at the nodes of a step, counted against the motion.

    Under a limit that is held that of bristles is a function of the way alone, exact (Dahl). Else its departure from
    the limit dies out with the way over the limit's own reach, while the limit's changes feed it: both are integrals
    through nodes. Bristles of another exponent have no such form: their force is the integral of what the last pass
    says that it grows.
    """
    side, start, compliance = memory.step_side, memory.bristles[0], p.presliding_compliance
    for node in range(count + 1):
        position = memory.step_position + side * memory.ways[node]
        time = memory.step_time + node * memory.step_spacing
        speed = max(memory.speeds[node], 0.0)
        pressure = memory.step_pressures[node]
        memory.limits[node] = limiting_friction(p, side, position, pressure, time, speed)
        memory.limits_behind[node] = limit_behind(p, state, side, position, pressure, time, speed)
    departure, memory.bristles_off = start - memory.limits[0], 0.0
    if has_sliders(p):
        lay_sliders(p, state, memory, count, False)
    if state.plan_limit_held == 1.0:
        for node in range(1, count + 1):
            reach = memory.limits[node] * compliance
            fade = fade_after(p, departure / memory.limits[0], memory.ways[node] / reach)
            memory.bristles[node] = memory.limits[node] + departure * fade
        return
    if is_curved(p):
        lay_curved_bristles(p, memory, count)
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
def lay_curved_bristles(p, memory, count):
    """Write the force of the bristles at the nodes under a limit that changes, one pass further."""
    start, spacing = memory.bristles[0], memory.step_spacing
    for node in range(count + 1):
        room = 1.0 - (start + memory.feeds[node]) / memory.limits[node]
        growth = math.copysign(abs(room) ** p.bristle_exponent, room) / p.presliding_compliance
        memory.values[node] = growth * memory.speeds[node]
    fit_powers(count, memory.values, memory.powers)
    memory.bristles_off = count * spacing * left_out(count, memory.powers)
    for node in range(1, count + 1):
        memory.feeds[node] = spacing * area_to(count, memory.powers, node)
        memory.bristles[node] = start + memory.feeds[node]


@compiled
def area_to(count, powers, node):
    """Return the area under a polynomial from the first node to another, in spacings."""
    area = 0.0
    for power in range(count, -1, -1):
        area = (area + powers[power] / (power + 1.0)) * node
    return area
