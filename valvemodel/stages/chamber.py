"""Chamber that fills through orifice and nozzle: the law of `chamber_filling` over the nodes of a part."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined
from valvemodel.equations import numeric
from valvemodel.stages.lag import CHAMBER_LAG, follow_nodes, nearby_lag
from valvemodel.stages.nozzle import stiffness_of_gas

chamber_inflow = inlined(numeric.chamber_inflow)

SWEEPS = 12
"""Most passes until the nodes stand still."""

NEAR = 1e-6
"""Departure from rest, over the supply, below which the rate there is taken."""


@compiled
def lay_chamber(p, state, memory, spacing, count, slack):
    """Let the chamber fill towards its resting pressures at the nodes, by eq. (15), to within a slack. [Pa]"""
    aims, values, start = memory.pressures, memory.values, state.chamber_pressure
    lag = nearby_lag(memory, CHAMBER_LAG, filling_rate(p, start, aims[0], memory.gaps[0]), spacing, count)
    per_supply = 1.0 / p.supply_pressure
    for node in range(count + 1):
        is_same = node > 0 and aims[node] == aims[node - 1] and memory.gaps[node] == memory.gaps[node - 1]
        # The flow at rest is 0 but where the resting pressure is not that of eq. (16).
        flow = memory.shares[node - 1] if is_same else chamber_flow(p, aims[node] * per_supply, memory.gaps[node])
        memory.shares[node] = flow
        values[node] = aims[node] + (start - aims[node]) * lag.decay[node]
    moved = math.inf
    for _ in range(SWEEPS):
        for node in range(count + 1):
            speed = filling_speed(p, values[node] * per_supply, memory.gaps[node], memory.shares[node])
            memory.forces[node] = speed + lag.rate * values[node]
        end, middle = values[count], values[1]
        follow_nodes(lag, start, memory.forces, memory.powers, values)
        before = moved
        moved = abs(values[count] - end) + abs(values[1] - middle)
        # Each pass gains by as much as the last one did.
        if (moved * min(moved / before, 1.0) if before < math.inf else moved) <= slack:
            break
    for node in range(count + 1):
        aims[node] = values[node]


@inlined
def chamber_flow(p, share, gap):
    """Return the flow into the chamber over that of the open orifice at a share of the supply, eq. (15).

    A laminar one is as the pressure lacks: counted from that at rest, only its slope tells.
    """
    flow = chamber_inflow(min(max(share, 0.0), 1.0), gap, 1.0, p.flow_ratio)
    if p.laminar_filling > 0.0:
        flow -= p.laminar_filling * (flow + share)
    return flow


@inlined
def filling_speed(p, share, gap, flow_at_rest):
    """Return how fast the pressure changes at a share of the supply; 0 at rest. [Pa/s]"""
    speed = (chamber_flow(p, share, gap) - flow_at_rest) * (p.supply_pressure / p.chamber_filling_time)
    bounded = min(max(share, 0.0), 1.0)
    if p.filling_growth != 0.0:
        speed /= 1.0 + p.filling_growth * bounded
    if p.filling_of_gas != 0.0:
        speed *= stiffness_of_gas(bounded * p.supply_pressure, p.filling_of_gas)
    return speed


@compiled
def filling_rate(p, pressure, resting, gap):
    """Return the rate at which a departure from rest dies out, its secant in eq. (15). [1/s]"""
    supply = p.supply_pressure
    aim, bounded = min(max(resting / supply, 0.0), 1.0), min(max(pressure / supply, 0.0), 1.0)
    if abs(bounded - aim) <= NEAR:
        bounded = aim + NEAR if aim < 0.5 else aim - NEAR
    return max(-filling_speed(p, bounded, gap, chamber_flow(p, aim, gap)) / (supply * (bounded - aim)), 0.0)
