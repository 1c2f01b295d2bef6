"""One step of a slip under forces that change along it: the linear part exact, the rest a polynomial through nodes."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined
from valvemodel.stages.nodes import fit_powers, left_out
from valvemodel.stages.part import pressure_at
from valvemodel.stages.presliding import (
    bristle_stiffness,
    bristle_viscosity,
    elastic_stiffness,
    is_curved,
    lay_bristles,
    let_slide,
    with_sliders,
)
from valvemodel.stages.response import nearby_response, response_of_step
from valvemodel.stages.sliders import force_of_sliders, has_sliders
from valvemodel.stages.stem import (
    limiting_friction,
    sliding_friction,
    stribeck_excess,
    stribeck_slope,
    tangent_stiffness,
    thrust,
)

SWEEPS = 10
"""Most passes over the nodes until the motion stands still; a step that needs more is too long."""

STANDING = 0.2
"""Share of the allowed error by which the motion may still move when the passes end."""

STEP_SHARE = 0.1
"""Share of the tolerance that one step may use."""

SWING_SHARE = 0.02
"""The same on bristles, whose swings are many steps."""

ROUGH = 0.1
"""Share of its own motion by which a slip may be off while its speed feeds on itself: it would stop for nothing."""


@compiled
def begin_step(p, state, memory, time):
    """Write down where a slip is, and how its forces change with position and speed there."""
    side, position, mass = state.mode, state.position, p.stem_mass
    speed, pressure = max(side * state.velocity, 0.0), pressure_at(memory, time)
    memory.step_time, memory.step_side, memory.step_position, memory.step_speed = time, side, position, speed
    memory.step_pressures[0] = pressure
    memory.ways[0], memory.speeds[0], memory.pulls[0], memory.feeds[0] = 0.0, speed, 0.0, 0.0
    damping = p.viscous_friction * (1.0 + p.viscous_asymmetry * side)
    stiffness = tangent_stiffness(p, side, position, pressure, time)
    if state.plan_elastic == 1.0:
        let_slide(p, state, pressure, time)
        memory.bristles[0] = side * state.bristle
        limit = limiting_friction(p, side, position, pressure, time, speed)
        bending = bristle_stiffness(p, memory.bristles[0], limit)
        stiffness += elastic_stiffness(p, state, side, limit, bending)
        memory.limits[0] = limit
        if has_sliders(p):
            memory.slid[0] = side * force_of_sliders(p, state)
        if p.bristle_damping > 0.0:
            damping += bristle_viscosity(p, bending)
    elif p.stribeck_ratio > 1.0:
        damping -= stribeck_slope(p, sliding_friction(p, side, position, pressure, time), speed)
    memory.step_damping, memory.step_stiffness = damping / mass, stiffness / mass
    memory.step_start = slip_force(p, state, memory, 0, position, speed) / mass


@inlined
def slip_force(p, state, memory, node, position, speed):
    """Return the net force along its side on a stem that slips, at a node of the step. [N]"""
    side, pressure = memory.step_side, memory.step_pressures[node]
    time = memory.step_time + node * memory.step_spacing
    viscous = p.viscous_friction * (1.0 + p.viscous_asymmetry * side)
    if state.plan_elastic == 1.0:
        friction = memory.bristles[node]
        if p.bristle_damping > 0.0:
            viscous += bristle_viscosity(p, bristle_stiffness(p, friction, memory.limits[node]))
        if has_sliders(p):
            friction = with_sliders(p, friction, memory.slid[node])
    else:
        friction = sliding_friction(p, side, position, pressure, time)
        if p.stribeck_ratio > 1.0:
            friction += stribeck_excess(p, friction, speed)
    return side * thrust(p, position, pressure, time) - friction - viscous * speed


@compiled
def sweep_step(p, state, memory, length, count, tolerance):
    """Lay the motion over a step of a length; return its error over what is allowed, infinite where passes diverge."""
    memory.step_spacing, memory.step_count = length / count, count
    nearby_response(memory, memory.step_damping, memory.step_stiffness, memory.step_spacing, count)
    response, is_held = response_of_step(memory), memory.part_count == 0.0
    for node in range(1, count + 1):
        memory.step_pressures[node] = memory.step_pressures[0]
        if not is_held:
            memory.step_pressures[node] = pressure_at(memory, memory.step_time + node * memory.step_spacing)
        memory.feeds[node] = 0.0
    for power in range(count + 1):
        memory.pull_powers[power] = 0.0
    is_linear = state.plan_linear == 1.0 and (is_held or p.area_slope == 0.0)
    is_linear = is_linear and response.damping == memory.step_damping and response.stiffness == memory.step_stiffness
    if is_linear:
        for node in range(1, count + 1):
            memory.ways[node], memory.speeds[node] = 0.0, memory.step_speed
    else:
        lay_motion(memory, count)
    share = SWING_SHARE if state.plan_elastic == 1.0 else STEP_SHARE
    usable = share * state.plan_share * tolerance
    moved, left, allowed = math.inf, math.inf, usable
    # What curved bristles lack at the end of a step stays: it moves the stem as far as the spring lets it.
    follows = state.plan_elastic == 1.0 and state.plan_limit_held == 0.0 and is_curved(p)
    lasting = p.presliding_compliance + (1.0 / p.spring_rate if p.spring_rate > 0.0 else 0.0)
    bristle = math.inf
    for _ in range(SWEEPS):
        lay_pulls(p, state, memory, count)
        way, speed = memory.ways[count], memory.speeds[count]
        lay_motion(memory, count)
        before = moved
        moved = abs(memory.ways[count] - way) + state.plan_response * abs(memory.speeds[count] - speed)
        if follows:
            moved += lasting * abs(memory.bristles[count] - bristle)
            bristle = memory.bristles[count]
        # Each pass gains by as much as the last one did.
        left = 0.0 if is_linear else moved * min(moved / before, 1.0) if before < math.inf else moved
        if memory.step_damping < 0.0:
            extent = abs(memory.ways[count]) + state.plan_response * abs(memory.speeds[count])
            allowed = min(usable, ROUGH * extent)
        if left <= STANDING * allowed:
            break
    else:
        return math.inf
    reach = response.way[count, 0] + state.plan_response * response.impulse[count]
    off = left_out(count, memory.pull_powers)
    if state.plan_elastic == 1.0:
        off += memory.bristles_off / p.stem_mass
    error = off * abs(reach)
    if follows:
        error += lasting * memory.bristles_off
    # What the passes leave is bounded: it says nothing about the length.
    return error / allowed


@compiled
def lay_pulls(p, state, memory, count):
    """Write by how much the stem is pulled more than the linear part says, over its mass, and the powers of that."""
    response, side = response_of_step(memory), memory.step_side
    if state.plan_elastic == 1.0:
        lay_bristles(p, state, memory, count)
    for node in range(1, count + 1):
        way, speed = memory.ways[node], memory.speeds[node]
        force = slip_force(p, state, memory, node, memory.step_position + side * way, speed)
        foreseen = memory.step_start - response.damping * (speed - memory.step_speed) - response.stiffness * way
        memory.pulls[node] = force / p.stem_mass - foreseen
    fit_powers(count, memory.pulls, memory.pull_powers)


@compiled
def lay_motion(memory, count):
    """Write ways and speeds at the nodes under the pulls, exact for their polynomial."""
    response, powers = response_of_step(memory), memory.pull_powers
    speed, start, per_spacing = memory.step_speed, memory.step_start, 1.0 / memory.step_spacing
    for node in range(1, count + 1):
        impulse, way = response.impulse[node], response.way[node, 0]
        end = (impulse + response.damping * way) * speed + way * start
        rate = (1.0 - response.stiffness * way) * speed + impulse * start
        for power in range(1, count + 1):
            end += response.way[node, power] * powers[power]
            rate += power * per_spacing * response.way[node, power - 1] * powers[power]
        memory.ways[node], memory.speeds[node] = end, rate
