"""Chamber that fills through orifice and nozzle: the law of `chamber_filling` over the nodes of a part."""

from __future__ import annotations

from valvemodel.compiled import compiled
from valvemodel.equations import numeric
from valvemodel.stages.lag import follow_nodes, remember_lag

chamber_inflow = compiled(numeric.chamber_inflow)

SWEEPS = 12
"""Most passes until the nodes stand still."""

STANDING = 1e-12
"""Share of the supply by which the last pass may have moved a node."""

KEPT = 0.02
"""A rate that is off by this, times the part's length, still serves: the passes mend it."""

NEAR = 1e-6
"""Departure from rest, over the supply, below which the rate there is taken."""


@compiled
def lay_chamber(p, state, memory, spacing, count):
    """Let the chamber fill towards its resting pressures at the nodes, by eq. (15)."""
    supply, pressures, lag = p.supply_pressure, memory.pressures, memory.lags[1]
    rate = filling_rate(p, state.chamber_pressure, pressures[0], memory.gaps[0])
    if not abs(rate - state.chamber_rate) * spacing * count <= KEPT:
        state.chamber_rate = rate
    remember_lag(lag, state.chamber_rate, spacing, count)
    start = state.chamber_pressure
    for node in range(count + 1):
        memory.values[node] = start
    for sweep in range(SWEEPS):
        for node in range(count + 1):
            if sweep == 0 or node > 0:
                pressure = memory.values[node]
                inflow = filling_speed(p, pressure, pressures[node], memory.gaps[node])
                memory.forces[node] = inflow + lag.rate * pressure
        before, middle = memory.values[count], memory.values[1]
        follow_nodes(lag, start, memory.forces, memory.powers, memory.values)
        moved = abs(memory.values[count] - before) + abs(memory.values[1] - middle)
        if moved <= STANDING * supply:
            break
    for node in range(count + 1):
        pressures[node] = memory.values[node]


@compiled
def filling_speed(p, pressure, resting, gap):
    """Return how fast the pressure changes; 0 at rest. [Pa/s]"""
    supply = p.supply_pressure
    bounded, aim = min(max(pressure, 0.0), supply), min(max(resting, 0.0), supply)
    inflow = chamber_inflow(bounded, gap, supply, p.flow_ratio) - chamber_inflow(aim, gap, supply, p.flow_ratio)
    return inflow * supply / (p.chamber_filling_time * (1.0 + p.filling_growth * bounded / supply))


@compiled
def filling_rate(p, pressure, resting, gap):
    """Return the rate at which a departure from rest dies out, its secant in eq. (15). [1/s]"""
    supply = p.supply_pressure
    aim = min(max(resting, 0.0), supply)
    bounded = min(max(pressure, 0.0), supply)
    if abs(bounded - aim) <= NEAR * supply:
        bounded = aim * (1.0 - NEAR) + NEAR * supply if aim < 0.5 * supply else aim * (1.0 - NEAR)
    return max(-filling_speed(p, bounded, aim, gap) / (bounded - aim), 0.0)
