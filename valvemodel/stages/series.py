"""Slips in powers of time: friction that falls as an exponential of way or speed has a series that follows theirs."""

from __future__ import annotations

import math

import numpy as np

from valvemodel.compiled import compiled, inlined
from valvemodel.stages.nodes import CHOOSE, ORDER
from valvemodel.stages.part import pressure_at
from valvemodel.stages.presliding import fade_after, is_curved, with_sliders
from valvemodel.stages.rest import come_to_rest, meet_limit
from valvemodel.stages.sliders import (
    force_of_sliders,
    has_sliders,
    pull_sliders,
    stiffness_of_sliders,
    way_to_sliding,
)
from valvemodel.stages.slip import BEYOND, STOP_SPEED, first_stop
from valvemodel.stages.stem import room_to, sliding_friction, stribeck_excess, tangent_stiffness, thrust

TERM_SHARE = 1e-3
"""Share of the tolerance below which a term of the series is left out, and within which an event is met."""

REACH_SHARE = 1e-4
"""The same of the reach of the bristles, where that is shorter."""

ROUGH = 1e3
"""Share of the motion, over the tolerance, below which a term is left out while the speed feeds on itself. [1/m]"""

FADING = 8.0
"""Largest change of way or speed over its reach in a step."""

CONVERGING = 0.5
"""The same where the departure fades as a power: its series ends at 1, over what the exponent is above 1."""

LEAST_ROOM = 1e-12
"""Room of bristles over their limit below which they no longer grow, whatever their exponent."""

OF_WAY, OF_SPEED = 0, 1
"""With what friction falls."""

ROUNDS = 60
"""Most iterations of a bracketed root."""

SHARES = np.array([1.0 / ((order + 1.0) * (order + 2.0)) for order in range(ORDER)])
"""Share of an order of the force in the way two orders above."""


@compiled
def advance_series(p, state, memory, time, pressure, limit, duration, tolerance):
    """Move a stem on bristles of a held limit by one step, to its next event at most; return the time used. [s]

    w'' = f(t) - c w' - k w + d exp(-w / r) along its way w (Dahl): smooth, so that its series carries as far as its
    last terms allow.
    """
    side, position, mass, speed = state.mode, state.position, p.stem_mass, state.mode * state.velocity
    departure, reach = limit - side * state.bristle, limit * p.presliding_compliance
    bend = p.bristle_exponent - 1.0 if is_curved(p) else 0.0
    sliding, missing, yielding = limit, departure, math.inf
    if bend > 0.0:
        reach = reach / max(abs(departure / limit), LEAST_ROOM) ** bend
    bound = min(TERM_SHARE * tolerance, REACH_SHARE * reach)
    damping = p.viscous_friction * (1.0 + p.viscous_asymmetry * side) / mass
    stiffness = tangent_stiffness(p, side, position, pressure, 0.0) / mass
    if has_sliders(p):
        departure *= 1.0 - p.slider_share
        sliding = with_sliders(p, limit, side * force_of_sliders(p, state))
        stiffness += p.slider_share * stiffness_of_sliders(p, state, side, limit) / mass
        yielding = way_to_sliding(p, state, side, limit)
    push = (side * thrust(p, position, pressure, 0.0) - sliding) / mass
    start = push + departure / mass - damping * speed
    viscous = p.bristle_damping * p.presliding_compliance
    if viscous > 0.0:
        start -= viscous * departure / (reach * mass) * speed
    # From rest it goes on for half a swing, whatever sets it going.
    stiffest = stiffness + departure / (reach * mass)
    stop = first_stop(1.0, damping, stiffest, speed, start if speed > 0.0 else 1.0)
    step = min(duration, BEYOND * stop)
    lay_forces(memory, time, step, push, side * p.diaphragm_area / mass)
    order = lay_series(memory, step, speed, damping, stiffness, departure / mass, reach, OF_WAY, bound, bend, viscous)
    share = carried_share(memory, order, bound)
    most = FADING if bend == 0.0 else min(FADING, CONVERGING / bend)
    if (speed + max(start, 0.0) * step) * step > most * reach:
        share *= faded_share(way_at(memory, order, share) / reach, departure / mass * (share * step) ** 2, bound, most)
    has_stopped = rate_at(memory, order, share) <= 0.0
    if has_stopped:
        share = place_of_fall(memory, order, share, stop / step, 0.0, bound * step / state.plan_response)
    if way_at(memory, order, share) > yielding:
        share, has_stopped = place_of_way(memory, order, share, yielding), False
    share, way = leave_series(p, state, memory, order, share, step, has_stopped)
    if has_sliders(p):
        pull_sliders(p, state, side, way, limit, math.inf)
    state.bristle = side * (limit - missing * fade_after(p, missing / limit, way / (limit * p.presliding_compliance)))
    return share * step


@compiled
def advance_falling(p, state, memory, time, pressure, duration, tolerance):
    """Move a slip on friction that falls with speed by one step, to its next event at most; return the time used. [s]

    w'' = f(t) - c w' - k w - e exp(-w' / v) along its way w (Stribeck).
    """
    side, position, mass, speed = state.mode, state.position, p.stem_mass, state.mode * state.velocity
    bound = TERM_SHARE * state.plan_share * tolerance
    coulomb = sliding_friction(p, side, position, pressure, 0.0)
    excess = stribeck_excess(p, coulomb, speed) / mass
    damping = p.viscous_friction * (1.0 + p.viscous_asymmetry * side) / mass
    stiffness = tangent_stiffness(p, side, position, pressure, 0.0) / mass
    push = (side * thrust(p, position, pressure, 0.0) - coulomb) / mass
    start, growth = push - excess - damping * speed, excess / p.stribeck_velocity - damping
    stop = first_stop(1.0, -growth, stiffness, speed, start if speed > 0.0 else 1.0)
    step = min(duration, BEYOND * stop)
    # A term of the speed is that of the way many times over, and goes on moving the stem.
    bound *= min(1.0, step / (ORDER * state.plan_response))
    lay_forces(memory, time, step, push, side * p.diaphragm_area / mass)
    # What feeds on itself is resolved in shares of itself, down to the last order.
    least = bound if growth <= 0.0 else 0.0
    order = lay_series(memory, step, speed, damping, stiffness, -excess, p.stribeck_velocity, OF_SPEED, least, 0.0, 0.0)
    share = carried_share(memory, order, bound)
    if growth > 0.0:
        share = min(share, resolved_share(memory, order, min(ROUGH * tolerance, 0.01)))
    change = (rate_at(memory, order, share) / step - speed) / p.stribeck_velocity
    share *= faded_share(change, excess * (share * step) ** 2, bound, FADING)
    level, close = STOP_SPEED * step, bound * step / state.plan_response
    has_stopped = False
    if speed >= STOP_SPEED and rate_at(memory, order, share) < level:
        slow = place_of_fall(memory, order, share, stop / step, level, close)
        place = position + side * way_at(memory, order, slow)
        net = thrust(p, place, pressure_at(memory, time + slow * step), 0.0)
        has_stopped = abs(net) <= state.plan_ratio * coulomb
        share = slow if has_stopped else share
    if not has_stopped and rate_at(memory, order, share) <= 0.0:
        share, has_stopped = place_of_fall(memory, order, share, stop / step, 0.0, close), True
    share, _ = leave_series(p, state, memory, order, share, step, has_stopped)
    return share * step


@inlined
def leave_series(p, state, memory, order, share, step, has_stopped):
    """Take a stem along its series to a share of the step, or to the end of its travel; return share and way."""
    side, position = state.mode, state.position
    way = way_at(memory, order, share)
    room = room_to(state, side)
    has_hit = not way <= room
    if has_hit:
        share, way, has_stopped = place_of_way(memory, order, share, max(room, 0.0)), room, False
    state.position = position + side * way
    state.velocity = 0.0 if has_stopped else side * max(rate_at(memory, order, share), 0.0) / step
    state.trace_next_velocity = state.velocity
    if has_hit:
        meet_limit(p, state, abs(state.velocity))
    elif has_stopped:
        come_to_rest(state)
    return share, way


@inlined
def lay_forces(memory, time, step, push, area):
    """Write the orders of the force, over the mass, that do not depend on the motion: a moving pressure has several."""
    forces, count = memory.series_forces, int(memory.part_count)
    forces[0] = push
    if count > 0:
        place, scale = (time - memory.part_time) / memory.part_spacing, 1.0
        for order in range(1, count + 1):
            scale *= step / memory.part_spacing
            total = 0.0
            for power in range(count, order - 1, -1):
                total = total * place + CHOOSE[power, order] * memory.part_powers[power]
            forces[order] = area * scale * total


@inlined
def lay_series(memory, step, speed, damping, stiffness, departure, reach, of_what, bound, bend, viscous):
    """Write the orders of way and rate over a step, up to where they have died out; return the highest order.

    The departure fades with the way or with the speed, over its reach of it: as an exponential, or as a power of the
    way where the fading bends. What it loses a second is resisted, so many seconds of it, by viscous bristles.
    """
    ways, rates, fades, forces = memory.series_ways, memory.series_rates, memory.series_fades, memory.series_forces
    changes = memory.series_changes
    count = int(memory.part_count)
    per_reach, by_damping, by_stiffness, square = 1.0 / reach, damping * step, stiffness * step * step, step * step
    ways[0], ways[1], rates[1], changes[1], fades[0] = 0.0, speed * step, speed * step, speed * step, 1.0
    before = abs(ways[1])
    for order in range(ORDER - 1):
        if order > 0 and viscous == 0.0:
            fades[order] = faded_order(memory, order, per_reach, bend)
        force = square * departure * fades[order] - by_stiffness * ways[order] - by_damping * rates[order + 1]
        if viscous > 0.0:
            fades[order + 1] = faded_order(memory, order + 1, per_reach, bend)
            force += step * viscous * departure * (order + 1.0) * fades[order + 1]
        if order <= count:
            force += square * forces[order]
        way = force * SHARES[order]
        ways[order + 2], rates[order + 2] = way, (order + 2.0) * way
        if of_what == OF_WAY:
            changes[order + 2] = rates[order + 2]
        else:
            changes[order + 1] = (order + 1.0) * rates[order + 2] / step
        if order >= count and before + abs(way) <= bound:
            return order + 2
        before = abs(way)
    return ORDER


@inlined
def faded_order(memory, order, per_reach, bend):
    """Return an order of what is left of the departure, from the lower ones (Miller's recurrence for powers)."""
    changes, fades, ways = memory.series_changes, memory.series_fades, memory.series_ways
    even, odd = 0.0, 0.0
    for lower in range(1, order, 2):
        odd += changes[lower] * fades[order - lower]
        even += changes[lower + 1] * fades[order - lower - 1]
    if order % 2 == 1:
        odd += changes[order]
    total = odd + even
    if bend > 0.0:
        for lower in range(1, order):
            total += bend * (order - lower) * ways[lower] * fades[order - lower]
    return -total * per_reach / order


@inlined
def carried_share(memory, order, bound):
    """Return how far into the step its series carries."""
    last = max(abs(memory.series_ways[order]), abs(memory.series_ways[order - 1]))
    return 1.0 if last <= bound else math.exp(math.log(bound / last) / (order - 1.0))


@inlined
def faded_share(change, effect, bound, most):
    """Return which share of a step has no more fading than its series holds: beyond, its terms would still grow.

    What the departure does along the step, its way, does not count while it is below the bound.
    """
    if effect < bound:
        most = math.inf if change > 0.0 else FADING + math.log(bound / max(effect, 1e-300))
    return 1.0 if abs(change) <= most else most / abs(change)


@inlined
def resolved_share(memory, order, rough):
    """Return how far into the step the series carries but for a rough share of the motion itself."""
    ways = memory.series_ways
    last = max(abs(ways[order]), abs(ways[order - 1]))
    of_first, of_second = rough * abs(ways[1]), rough * abs(ways[2])
    if last <= max(of_first, of_second):
        return 1.0
    share = math.exp(math.log(of_first / last) / (order - 2.0)) if of_first > 0.0 else 0.0
    return max(share, math.exp(math.log(of_second / last) / (order - 3.0)) if of_second > 0.0 else 0.0)


@inlined
def way_at(memory, order, share):
    """Return the way at a share of the step. [m]"""
    way = 0.0
    for power in range(order, 0, -1):
        way = (way + memory.series_ways[power]) * share
    return way


@inlined
def rate_at(memory, order, share):
    """Return the speed at a share of the step, by step."""
    rate = 0.0
    for power in range(order, 0, -1):
        rate = rate * share + memory.series_rates[power]
    return rate


@compiled
def place_of_fall(memory, order, high, foreseen, level, bound):
    """Return the share of the step at which the rate falls to a level, by bracketed Newton iteration."""
    low, share = 0.0, min(foreseen, high)
    for _ in range(ROUNDS):
        rate, slope = 0.0, 0.0
        for power in range(order, 0, -1):
            slope = slope * share + rate
            rate = rate * share + memory.series_rates[power]
        rate -= level
        if rate > 0.0:
            low = share
        else:
            high = share
        following = share - rate / slope if slope < 0.0 else 0.5 * (low + high)
        if not low < following < high:
            following = 0.5 * (low + high)
        # The step after this one would gain as many digits again.
        is_met = slope < 0.0 and abs(rate * (following - share)) <= bound
        if is_met or high - low <= 1e-15 * high:
            return following
        share = following
    return share


@compiled
def place_of_way(memory, order, high, distance):
    """Return the share of the step at which a way is gone, by bracketed Newton iteration."""
    low, share = 0.0, high
    for _ in range(ROUNDS):
        missing, rate = distance - way_at(memory, order, share), rate_at(memory, order, share)
        if missing > 0.0:
            low = share
        else:
            high = share
        following = share + missing / rate if rate > 0.0 else 0.5 * (low + high)
        if not low < following < high:
            following = 0.5 * (low + high)
        if high - low <= 1e-15 * high or abs(following - share) <= 1e-15:
            break
        share = following
    return share
