"""Integrated slips: steps of controlled error, each cut where an event falls into it."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled
from valvemodel.stages.bow import bow_left_out
from valvemodel.stages.linkage import TOUCHING, way_to_contact
from valvemodel.stages.nodes import COARSE_NODES, NODES, fall_between, fit_powers, slope_at, value_at
from valvemodel.stages.part import is_coarse
from valvemodel.stages.response import response_of_step
from valvemodel.stages.rest import come_to_rest, meet_limit
from valvemodel.stages.sliders import has_sliders, lay_sliders, way_to_sliding
from valvemodel.stages.slip import BEYOND, STOP_SPEED, first_stop
from valvemodel.stages.stem import room_to, sliding_friction, thrust
from valvemodel.stages.step import STEP_SHARE, begin_step, slip_force, sweep_step
from valvemodel.stages.transmitter import has_lag

SHORTEST_STEP = 1e-9
"""Steps are not made shorter: far below any time constant of a valve. [s]"""

UNSTABLE = 3.0
"""Longest step over the time in which an unstable speed grows by a factor of e."""

MEETING = 1e-3
"""Share of the tolerance within which an event is met."""

CORE = 1.0
"""Distance between two nodes, in half-widths, at which one lies in the core of a tight spot that they are about."""

ROUNDS = 40
"""Most trials of the length of a step that ends at an event; bisection alone gains a digit with three."""

NOTHING, STOP, LIMIT, CONTACT, REST = 0, 1, 2, 3, 4
"""What ends a step: the speed is 0, the travel ends, play closes or a slider slides, the stop-speed rule holds."""


@compiled
def advance_travel(p, state, memory, time, duration, tolerance):
    """Move a slip by one step, to its next event at most; return the time used. [s]"""
    begin_step(p, state, memory, time)
    if memory.step_speed * state.plan_response <= MEETING * tolerance and memory.step_start <= 0.0:
        # The rest of a creep is below the tolerance.
        come_to_rest(state)
        return 0.0
    count = COARSE_NODES if is_coarse(tolerance) else NODES
    step = first_length(state, memory, duration)
    while True:
        error = sweep_step(p, state, memory, step, count, tolerance)
        if state.plan_bowed == 1.0:
            error += bow_left_out(p, memory, count, tolerance) / (STEP_SHARE * tolerance)
        if p.tight_spot_excess != 0.0 and leaps_over_spot(p, state, memory, count):
            error = math.inf
        if error <= 1.0 or step <= SHORTEST_STEP:
            break
        # The error falls with a high power of the length.
        is_far = not error <= 2.0 ** (count + 2)
        step = max(step * (0.25 if is_far else 0.5), SHORTEST_STEP)
        state.trial_step = step
    if error < 0.5 ** (count + 3):
        state.trial_step = max(state.trial_step, 2.0 * step)
    ended = NOTHING
    room = room_to(state, state.mode)
    contact = math.inf
    if has_lag(p):
        contact = way_to_contact(p, state, state.mode)
    if has_sliders(p) and state.plan_elastic == 1.0:
        contact = min(contact, way_to_sliding(p, state, state.mode, memory.limits[0]))
    for _ in range(ROUNDS):
        kind, low, high = first_event(p, state, memory, count, ended, room, contact)
        if kind == NOTHING:
            break
        ended = kind
        step = meet(p, state, memory, count, tolerance, kind, low, high, room if kind == LIMIT else contact)
    finish_step(p, state, memory, count, ended)
    return step


@compiled
def leaps_over_spot(p, state, memory, count):
    """Return whether a tight spot may lie unseen between two nodes of the step, none of them well within it."""
    middle = memory.step_side * (p.tight_spot_position - memory.step_position)
    widest = min(state.plan_reach, CORE * p.tight_spot_width)
    for node in range(1, count + 1):
        low, high = memory.ways[node - 1], memory.ways[node]
        if high - low > widest > 0.0 and low < middle + widest and high > middle - widest:
            return True
    return False


@compiled
def first_length(state, memory, duration):
    """Return how long a step to try: equal parts of the duration, and not far past the foreseeable stop. [s]"""
    longest = min(state.trial_step, state.plan_longest)
    damping, stiffness = memory.step_damping, memory.step_stiffness
    if damping < 0.0:
        longest = min(longest, -UNSTABLE / damping)
    step = duration / math.ceil(duration / longest - 1e-6) if longest < duration else duration
    if memory.step_speed > 0.0:
        stop = first_stop(1.0, damping, stiffness, memory.step_speed, memory.step_start)
    else:
        # From rest it goes on for half a swing, whatever sets it going.
        stop = first_stop(1.0, damping, stiffness, 0.0, 1.0)
    return max(min(step, BEYOND * stop), min(SHORTEST_STEP, duration))


@compiled
def first_event(p, state, memory, count, ended, room, contact):
    """Return which event comes first in the step, and between which places it comes, in spacings."""
    last = count if ended == NOTHING else count - 1
    for node in range(1, count + 1):
        way, speed, before = memory.ways[node], memory.speeds[node], memory.speeds[node - 1]
        if node <= last and speed <= 0.0:
            return STOP, node - 1.0, float(node)
        after = memory.speeds[node + 1] if node < count else speed
        if speed < before and speed < after and speed < 0.5 * (before + after - 2.0 * speed):
            # Lowest about this node, and so low that it may dip below 0 between the nodes.
            lowest = lowest_place(memory, count, node)
            if value_at(count, memory.powers, lowest) <= 0.0:
                return STOP, node - 1.0, lowest
        # A slip that ends otherwise may have gone past the end of its travel, or a contact, on the way there.
        if (node <= last or ended != LIMIT) and not way <= room:
            return LIMIT, node - 1.0, float(node)
        if (node <= last or ended != CONTACT) and TOUCHING < contact < way and memory.ways[node - 1] < contact:
            return CONTACT, node - 1.0, float(node)
        # A slip that stops may have stuck on the way to its stop.
        may_stick = node <= last or (ended == STOP and p.stick_speed > STOP_SPEED)
        is_slow = may_stick and speed < p.stick_speed and state.plan_elastic == 0.0
        if is_slow and rest_excess(p, state, memory, node) <= 0.0:
            return REST, node - 1.0, float(node)
    return NOTHING, 0.0, 0.0


@compiled
def lowest_place(memory, count, node):
    """Return where the speed is lowest about a node, in spacings."""
    fit_powers(count, memory.speeds, memory.powers)
    low, high = node - 1.0, node + 1.0
    for _ in range(50):
        middle = 0.5 * (low + high)
        if slope_at(count, memory.powers, middle) < 0.0:
            low = middle
        else:
            high = middle
    return high


@compiled
def rest_excess(p, state, memory, node):
    """Return by how much a slow stem misses the stop-speed rule at a node: speed and forces, over their bounds."""
    position = memory.step_position + memory.step_side * memory.ways[node]
    time = memory.step_time + node * memory.step_spacing
    pressure = memory.step_pressures[node]
    net = thrust(p, position, pressure, time)
    side = 1.0 if net > 0.0 else -1.0
    breakaway = state.plan_ratio * sliding_friction(p, side, position, pressure, time)
    force_excess = (abs(net) - breakaway) / (breakaway + abs(net)) if net != 0.0 else -1.0
    excess = max(memory.speeds[node] / p.stick_speed - 1.0, force_excess)
    if p.stick_speed > STOP_SPEED and net != 0.0:
        # A slip that has only begun is slow too.
        drives = slip_force(p, state, memory, node, position, memory.speeds[node])
        excess = max(excess, drives / (breakaway + abs(net)))
    return excess


@compiled
def meet(p, state, memory, count, tolerance, kind, low, high, distance):
    """Cut the step to the length at whose end an event is, and return that; bracketed Newton iteration. [s]"""
    length = memory.step_spacing * place_of_fall(memory, count, kind, low, high, distance)
    low, high = memory.step_spacing * low, memory.step_spacing * high
    bound = MEETING * tolerance
    if kind == STOP:
        bound /= state.plan_response
    elif kind == CONTACT:
        bound = min(bound, TOUCHING)
    for _ in range(ROUNDS):
        sweep_step(p, state, memory, length, count, tolerance)
        speed, slope = memory.speeds[count], -memory.speeds[count]
        if kind == STOP:
            position = memory.step_position + memory.step_side * memory.ways[count]
            value, slope = speed, slip_force(p, state, memory, count, position, speed) / p.stem_mass
        elif kind == REST:
            value, slope = rest_excess(p, state, memory, count), 0.0
        else:
            value = distance - memory.ways[count]
        if value > 0.0:
            low = length
        else:
            high = length
        is_met = abs(value) <= bound
        if kind == REST:
            is_met = value <= 0.0 and (high - low) * p.stick_speed <= bound
        elif kind == STOP and value > 0.0 and slope >= 0.0:
            # The speed is small because the slip has only begun.
            is_met = False
        if is_met or high - low <= 1e-15 * high:
            break
        length = length - value / slope if slope < 0.0 else 0.5 * (low + high)
        if not low < length < high:
            length = 0.5 * (low + high)
    return length


@compiled
def place_of_fall(memory, count, kind, low, high, distance):
    """Return where the polynomial through speeds or ways says that an event is, in spacings."""
    if kind == REST:
        return high
    if kind == STOP:
        if low == 0.0 and memory.step_speed == 0.0:
            return 0.5 * high
        fit_powers(count, memory.speeds, memory.powers)
    else:
        for node in range(count + 1):
            memory.values[node] = distance - memory.ways[node]
        fit_powers(count, memory.values, memory.powers)
    return fall_between(count, memory.powers, low, high)


@compiled
def finish_step(p, state, memory, count, ended):
    """Take stem and bristles to the end of the step, and leave to the sensor what it needs to follow it."""
    response, side = response_of_step(memory), memory.step_side
    way, speed = memory.ways[count], max(memory.speeds[count], 0.0)
    acceleration = memory.step_start + memory.pulls[count] - response.stiffness * way
    acceleration -= response.damping * (memory.speeds[count] - memory.step_speed)
    state.trace_damping, state.trace_stiffness = response.damping, response.stiffness
    state.trace_velocity, state.trace_acceleration = side * memory.step_speed, side * memory.step_start
    state.trace_next_velocity, state.trace_next_acceleration = side * speed, side * acceleration
    memory.trace_count = count
    state.position, state.velocity = memory.step_position + side * way, side * speed
    if state.plan_elastic == 1.0:
        state.bristle = side * memory.bristles[count]
        if has_sliders(p):
            lay_sliders(p, state, memory, count, True)
    if ended == LIMIT:
        meet_limit(p, state, speed)
    elif ended in (STOP, REST):
        come_to_rest(state)
