"""How a slip comes to rest, and at what a stem that rests breaks away."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined
from valvemodel.stages.nodes import COARSE_NODES, NODES, fit_powers, slope_at
from valvemodel.stages.part import is_coarse, pressure_at
from valvemodel.stages.slip import STOP_SPEED
from valvemodel.stages.stem import FALLING, RISING, STUCK, lay_span, sliding_friction, stribeck_excess, thrust

BRACKET = 1e-15
"""Share of the time by which a breakaway is located."""


@compiled
def come_to_rest(state):
    """End a slip where the stem is."""
    state.velocity = 0.0
    state.mode = STUCK


@inlined
def are_forces_held(state, memory):
    """Return whether neither pressure nor load nor friction change while the current is held."""
    return memory.part_count == 0.0 and state.plan_varies == 0.0


@inlined
def is_blocked(state, position, side):
    """Return whether an end of the travel bars the way to a side."""
    return position >= state.plan_highest if side > 0.0 else position <= state.plan_lowest


@inlined
def break_away(p, state, side):
    """Set a resting stem going to a side."""
    state.velocity, state.mode = 0.0, side
    if p.stop_compliance > 0.0:
        # It may rest just where a stop begins to act.
        lay_span(p, state, side)


@compiled
def meet_limit(p, state, speed):
    """Stop a slip at the end of the travel, or throw it back with the restitution's share of its speed.

    A rebound slower than the stop speed rests, so that the bounces end. At a stop that gives way the slip goes on.
    """
    side = state.mode
    end = state.plan_highest if side > 0.0 else state.plan_lowest
    state.position = state.span_highest if side > 0.0 else state.span_lowest
    if state.position != end:
        state.velocity = side * speed
        lay_span(p, state, side)
        return
    rebound = p.restitution * speed
    if rebound < STOP_SPEED:
        come_to_rest(state)
    else:
        state.velocity, state.mode = -side * rebound, -side


@compiled
def breakaway_side(p, state, pressure, time):
    """Return the side to which a resting stem breaks away, STUCK where friction or an end of the travel holds it."""
    position = state.position
    net = thrust(p, position, pressure, time)
    side = RISING if net > 0.0 else FALLING
    if abs(net) <= state.plan_ratio * sliding_friction(p, side, position, pressure, time):
        return STUCK
    return STUCK if is_blocked(state, position, side) else side


@compiled
def sticks(p, state, pressure, time):
    """Return whether a slip has ended: it is held, and creeps or slows down below the stick speed."""
    speed = abs(state.velocity)
    if speed >= p.stick_speed or breakaway_side(p, state, pressure, time) != STUCK:
        return False
    if speed < STOP_SPEED:
        return True
    side = state.mode
    friction = sliding_friction(p, side, state.position, pressure, time)
    if p.stribeck_ratio > 1.0:
        friction += stribeck_excess(p, friction, speed)
    viscous = p.viscous_friction * (1.0 + p.viscous_asymmetry * side)
    return side * thrust(p, state.position, pressure, time) < friction + viscous * speed


@compiled
def time_stuck(p, state, memory, time, duration, tolerance):
    """Return how long a stem that holds at an instant goes on holding, at most a duration. [s]"""
    if are_forces_held(state, memory):
        return duration
    count = COARSE_NODES if is_coarse(tolerance) else NODES
    length = min(duration, state.plan_longest)
    instant = math.inf
    if memory.part_count == 0.0:
        rising = breakaway_excess(p, state, memory, time, RISING)
        falling = breakaway_excess(p, state, memory, time, FALLING)
        if max(rising, falling) < -state.plan_drift * length:
            return length
    for side in (RISING, FALLING):
        if not is_blocked(state, state.position, side):
            instant = min(instant, breakaway_instant(p, state, memory, time, length, count, side))
    return instant if instant < length else length


@compiled
def breakaway_excess(p, state, memory, time, side):
    """Return by how much the force to a side exceeds what holds the stem. [N]"""
    pressure, position = pressure_at(memory, time), state.position
    friction = sliding_friction(p, side, position, pressure, time)
    return side * thrust(p, position, pressure, time) - state.plan_ratio * friction


@compiled
def breakaway_instant(p, state, memory, time, length, count, side):
    """Return when within a length the force to a side first exceeds what holds the stem, else infinity. [s]"""
    spacing, excesses, powers = length / count, memory.values, memory.powers
    highest = lowest = excesses[0] = breakaway_excess(p, state, memory, time, side)
    for node in range(1, count + 1):
        excess = breakaway_excess(p, state, memory, time + node * spacing, side)
        excesses[node], highest, lowest = excess, max(highest, excess), min(lowest, excess)
    # Between the nodes a polynomial that is resolved by them goes beyond their range by a part of it only.
    if highest + 0.5 * (highest - lowest) < 0.0:
        return math.inf
    fit_powers(count, excesses, powers)
    for node in range(1, count + 1):
        low, high = node - 1.0, float(node)
        if excesses[node] <= 0.0:
            if not slope_at(count, powers, low) > 0.0 > slope_at(count, powers, high):
                continue
            high = highest_place(count, powers, low, high)
            if breakaway_excess(p, state, memory, time + high * spacing, side) <= 0.0:
                continue
        return meet_breakaway(p, state, memory, time, low * spacing, high * spacing, side)
    return math.inf


@compiled
def highest_place(count, powers, low, high):
    """Return where a polynomial that rises first and falls then is highest."""
    for _ in range(50):
        middle = 0.5 * (low + high)
        if slope_at(count, powers, middle) > 0.0:
            low = middle
        else:
            high = middle
    return high


@compiled
def meet_breakaway(p, state, memory, time, low, high, side):
    """Return when the excess, not positive at the lower end of a bracket, is positive; by regula falsi (Illinois)."""
    at_low, at_high = breakaway_excess(p, state, memory, time + low, side), 0.0
    at_high = breakaway_excess(p, state, memory, time + high, side)
    last = 0
    while high - low > BRACKET * (time + high):
        middle = (low * at_high - high * at_low) / (at_high - at_low)
        # Where rounding would repeat an end, it is halved.
        if not low < middle < high:
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
        excess = breakaway_excess(p, state, memory, time + middle, side)
        if excess > 0.0:
            high, at_high = middle, excess
            at_low *= 0.5 if last == 1 else 1.0
            last = 1
        else:
            low, at_low = middle, min(excess, -1e-300)
            at_high *= 0.5 if last == -1 else 1.0
            last = -1
    return high
