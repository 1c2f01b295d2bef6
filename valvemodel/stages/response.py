"""A slip under a force that is a polynomial in time, exact: a' = -c a - k v + f'(t), all over the mass."""

from __future__ import annotations

import math

import numpy as np

from valvemodel.compiled import compiled, inlined
from valvemodel.stages.nodes import CHOOSE, NODES, REMEMBERED, is_alike

NEARBY = 0.02
"""A linear part that is off by this share of the motion still serves where passes mend it."""

LONG = 4.0
"""Fastest rate times spacing up to which the power series is summed; a longer spacing is halved first."""

TERMS = 40
"""Of the power series at most; up to there 1e-18 is left of it."""

SHARES = np.array([[math.factorial(p) / math.factorial(p + n + 2) for n in range(TERMS)] for p in range(NODES + 1)])
"""[power, order]: share of a term of the series in the way under a power of time, in squares of the time."""


@inlined
def response_of_step(memory):
    """Return the response of the step that was laid last."""
    return memory.responses[int(memory.response_place)]


@inlined
def forget_responses(memory):
    """Forget all responses: what is near must not depend on an earlier run."""
    memory.response_turn = 0.0
    for place in range(REMEMBERED):
        memory.responses[place].spacing = -1.0


@compiled
def remember_response(memory, damping, stiffness, spacing, count):
    """Take a response as that of the step, laid anew unless it was among the last few."""
    take_response(memory, damping, stiffness, spacing, count, 0.0)


@compiled
def nearby_response(memory, damping, stiffness, spacing, count):
    """Take a response as that of the step where it is near enough for passes over the nodes to mend it."""
    take_response(memory, damping, stiffness, spacing, count, NEARBY)


@inlined
def take_response(memory, damping, stiffness, spacing, count, allowed):
    """Take the response that is off by least, at most by an allowed share of the motion, or lay one anew."""
    nearest = -1.0
    for place in range(REMEMBERED):
        response = memory.responses[place]
        if is_alike(response, spacing, count):
            off = abs(response.stiffness - stiffness) * abs(response.way[count, 0])
            off += abs(response.damping - damping) * abs(response.impulse[count])
            if off <= allowed:
                nearest, allowed = float(place), off
                if off == 0.0:
                    break
    if nearest >= 0.0:
        memory.response_place = nearest
        return
    memory.response_place = memory.response_turn
    memory.response_turn = (memory.response_turn + 1.0) % REMEMBERED
    lay_response(response_of_step(memory), damping, stiffness, spacing, count)


@compiled
def lay_response(response, damping, stiffness, spacing, count):
    """Write down the way from powers of time at all nodes.

    way[i, l] is the way up to node i under an acceleration (t / spacing)^l; impulse[i] that from a unit speed without
    a force, rate[i] its slope. All else follows from them.
    """
    response.damping, response.stiffness, response.spacing, response.count = damping, stiffness, spacing, count
    way, impulse, rate = response.way, response.impulse, response.rate
    respond(response, damping, stiffness, spacing, count)
    free, from_speed = 1.0 - stiffness * way[1, 0], impulse[1]
    for node in range(1, count):
        impulse[node + 1] = free * impulse[node] + from_speed * rate[node]
        rate[node + 1] = rate[1] * rate[node] - stiffness * from_speed * impulse[node]
        for power in range(count + 1):
            speed = power / spacing * way[node, power - 1] if power > 0 else impulse[node]
            total, scale = free * way[node, power] + from_speed * speed, 1.0
            for lower in range(power, -1, -1):
                total += CHOOSE[power, lower] * scale * way[1, lower]
                scale *= node
            way[node + 1, power] = total


@compiled
def respond(response, damping, stiffness, spacing, count):
    """Write the responses at the first node: by power series over a short enough time, then doubled."""
    way = response.way
    halvings = 0
    short = spacing
    fastest = max(abs(damping), math.sqrt(abs(stiffness)))
    while fastest * short > LONG:
        short *= 0.5
        halvings += 1
    by_damping, by_stiffness = damping * short, stiffness * short * short
    # Terms of the response to the highest two powers; the lower ones follow downwards, down to the impulse's.
    before, term = 0.0, 1.0
    highest, next_highest = 0.0, 0.0
    for order in range(TERMS):
        highest += term * SHARES[count, order]
        next_highest += term * SHARES[count - 1, order]
        before, term = term, -by_damping * term - by_stiffness * before
        if not (abs(term) + abs(before)) * SHARES[count - 1, order] > 1e-18:
            break
    way[1, count], way[1, count - 1] = highest * short * short, next_highest * short * short
    for power in range(count, 1, -1):
        way[1, power - 2] = (short * short - by_damping * power * way[1, power - 1] - by_stiffness * way[1, power]) / (
            power * (power - 1.0)
        )
    impulse = short - damping * way[1, 0] - stiffness * short * way[1, 1]
    rate = 1.0 - damping * impulse - stiffness * way[1, 0]
    for _ in range(halvings):
        free, scale = 1.0 - stiffness * way[1, 0], 1.0
        for power in range(count + 1):
            scale = 0.5**power
            speed = power / short * way[1, power - 1] if power > 0 else impulse
            total = free * way[1, power] + impulse * speed
            for lower in range(power + 1):
                total += CHOOSE[power, lower] * way[1, lower]
            response.doubled[power] = scale * total
        impulse, rate = impulse * (free + rate), rate * rate - stiffness * impulse * impulse
        for power in range(count + 1):
            way[1, power] = response.doubled[power]
        short *= 2.0
    response.impulse[1], response.rate[1] = impulse, rate
