"""Amplifier with unequal ports: the law of `asymmetric_filling` over the nodes of a part."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled
from valvemodel.stages.lag import follow_nodes, remember_lag
from valvemodel.stages.nodes import first_fall

ROUNDING = 1e-12
"""Share of the supply below which two pressures are equal."""


@compiled
def lay_amplifier(p, state, memory, spacing, count):
    """Follow the pressures at the nodes at the capacity of the direction; return where that ends, in spacings.

    Three ways of following: at the limited rate, as a first-order lag, or at once where there is no time constant.
    """
    pressures, aims, start = memory.pressures, memory.values, state.filled_pressure
    rounding = ROUNDING * p.supply_pressure
    for node in range(count + 1):
        aims[node] = pressures[node]
    ahead = aims[0] - start
    if abs(ahead) <= rounding:
        ahead = aims[1] - start
    side = 1.0 if ahead > 0.0 else -1.0
    time_constant = p.fill_time if side > 0.0 else p.vent_time
    slowness = abs(p.filling_slowness) if (side < 0.0) == (p.filling_slowness > 0.0) else 0.0
    lead = max(side * (aims[0] - start), 0.0)
    speed = side * (aims[1] - aims[0]) / spacing
    is_limited = slowness > 0.0 and (
        lead * slowness > time_constant + rounding * slowness or (time_constant == 0.0 and speed * slowness > 1.0)
    )
    if is_limited:
        for node in range(count + 1):
            pressures[node] = start + side * node * spacing / slowness
            memory.forces[node] = side * (aims[node] - pressures[node]) - time_constant / slowness + rounding
        return first_fall(count, memory.forces, memory.powers)
    if time_constant == 0.0:
        for node in range(1, count + 1):
            climb = side * (aims[node] - aims[node - 1])
            if climb < -rounding or climb * slowness > spacing * (1.0 + ROUNDING):
                return node - 0.5
        return math.inf
    lag = memory.lags[2]
    remember_lag(lag, 1.0 / time_constant, spacing, count)
    for node in range(count + 1):
        memory.forces[node] = aims[node] / time_constant
    follow_nodes(lag, start, memory.forces, memory.powers, pressures)
    for node in range(count + 1):
        memory.forces[node] = side * (aims[node] - pressures[node]) + rounding
    end = first_fall(count, memory.forces, memory.powers)
    if slowness > 0.0:
        for node in range(count + 1):
            lead = side * (aims[node] - pressures[node])
            memory.forces[node] = time_constant / slowness - lead + 2.0 * rounding
        end = min(end, first_fall(count, memory.forces, memory.powers))
    return end
