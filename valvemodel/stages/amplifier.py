"""Amplifier with unequal ports or orifices: the laws of `asymmetric_filling` over the nodes of a part."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled, inlined
from valvemodel.stages.chamber import SWEEPS
from valvemodel.stages.lag import AMPLIFIER_LAG, follow_nodes, nearby_lag, remembered_lag
from valvemodel.stages.nodes import first_fall, fit_powers, left_out
from valvemodel.stages.nozzle import stiffness_of_gas, time_to_fill, time_to_vent

ROUNDING = 1e-12
"""Share of the supply below which two pressures are equal."""

INSTANT = 1e-10
"""What a limited rate makes up for within this takes no time: a stem moves by less than a nanometre. [s]"""

LEAST_ROOT = 1e-3
"""Where no pressure is left to vent, or the supply is reached, orifices would act at once; about a thousandth of P1."""


@inlined
def quickness(p, pressure, aim):
    """Return the rate at which the pressure follows its aim over that of first order: a secant of the square roots."""
    if p.orifice_share == 0.0:
        return 1.0
    resting = min(max(aim / p.supply_pressure, 0.0), 1.0)
    return quickness_of_orifices(p, pressure, resting, math.sqrt(resting * (1.0 - resting)))


@inlined
def quickness_of_orifices(p, pressure, resting, spread):
    """Return `quickness` towards a share of the supply at rest, whose spread is known: aims are mostly held."""
    share = min(max(pressure / p.supply_pressure, 0.0), 1.0)
    root = resting * math.sqrt(1.0 - share) + spread * math.sqrt(share)
    stiffness = stiffness_of_gas(share * p.supply_pressure, p.orifices_of_gas)
    return 1.0 + p.orifice_share * (stiffness / max(root, LEAST_ROOT) - 1.0)


@compiled
def lay_amplifier(p, state, memory, spacing, count, slack, kept):
    """Follow the pressures at the nodes at the capacity of the direction; return where that ends, in spacings.

    Three ways of following: at the limited rate, at its own, or at once where there is no time constant. An error at
    the end of a part, however short, is kept, for where the capacities are unequal it may die out slowly: the part is
    halved where the pressures are not known well enough between the nodes.
    """
    pressures, aims, start = memory.pressures, memory.values, state.filled_pressure
    rounding = ROUNDING * p.supply_pressure
    for node in range(count + 1):
        aims[node] = pressures[node]
    ahead = aims[0] - start
    if abs(ahead) <= rounding:
        ahead = aims[1] - start
    side = 1.0 if ahead > 0.0 else -1.0
    time_constant = time_to_fill(p) if side > 0.0 else time_to_vent(p)
    slowness = abs(p.filling_slowness) if (side < 0.0) == (p.filling_slowness > 0.0) else 0.0
    if slowness * fastest_lead(p) <= time_constant:
        slowness = 0.0
    speed = side * (aims[1] - aims[0]) / spacing
    is_limited = slowness > 0.0 and (
        max(side * (aims[0] - start), 0.0) * quickness(p, start, aims[0]) * slowness
        > time_constant + INSTANT + rounding * slowness
        or (time_constant == 0.0 and speed * slowness > 1.0)
    )
    if is_limited:
        for node in range(count + 1):
            pressures[node] = start + side * node * spacing / slowness
            lead = side * (aims[node] - pressures[node]) * quickness(p, pressures[node], aims[node])
            memory.forces[node] = lead - time_constant / slowness + rounding
        return first_fall(count, memory.forces, memory.powers)
    if time_constant == 0.0:
        for node in range(1, count + 1):
            climb = side * (aims[node] - aims[node - 1])
            if climb < -rounding or climb * slowness > spacing * (1.0 + ROUNDING):
                return node - 0.5
        return math.inf
    if p.orifice_share == 0.0:
        lag = remembered_lag(memory, AMPLIFIER_LAG, 1.0 / time_constant, spacing, count)
        follow_through_ports(state, memory, lag, time_constant, count)
    else:
        rate = quickness(p, start, aims[0]) / time_constant
        lag = nearby_lag(memory, AMPLIFIER_LAG, rate, spacing, count)
        if not follow_through_orifices(p, state, memory, lag, time_constant, count, slack):
            return 0.5 * count
    fit_powers(count, aims, memory.powers)
    if left_out(count, memory.powers) * (1.0 - lag.decay[count]) > kept:
        return 0.5 * count
    for node in range(count + 1):
        memory.forces[node] = side * (aims[node] - pressures[node]) + rounding
    end = first_fall(count, memory.forces, memory.powers)
    if slowness > 0.0:
        for node in range(count + 1):
            lead = side * (aims[node] - pressures[node]) * quickness(p, pressures[node], aims[node])
            memory.forces[node] = (time_constant + INSTANT) / slowness - lead + 2.0 * rounding
        end = min(end, first_fall(count, memory.forces, memory.powers))
    return end


@inlined
def fastest_lead(p):
    """Return more than any pressure can lead what follows it, times the quickness of that. [Pa]"""
    stiffest = stiffness_of_gas(p.supply_pressure, p.orifices_of_gas)
    return p.supply_pressure * (1.0 + p.orifice_share * (stiffest / LEAST_ROOT - 1.0))


@inlined
def follow_through_ports(state, memory, lag, time_constant, count):
    """Write the pressures at the nodes as a first-order lag lets them follow."""
    for node in range(count + 1):
        memory.forces[node] = memory.values[node] / time_constant
    follow_nodes(lag, state.filled_pressure, memory.forces, memory.powers, memory.pressures)


@compiled
def follow_through_orifices(p, state, memory, lag, time_constant, count, slack):
    """Write the pressures at the nodes as orifices let them follow; return whether the passes came to a stand."""
    aims, pressures, start = memory.values, memory.pressures, state.filled_pressure
    aim, resting, spread = math.nan, 0.0, 0.0
    for node in range(count + 1):
        pressures[node] = aims[node] + (start - aims[node]) * lag.decay[node]
    before = math.inf
    for _ in range(SWEEPS):
        for node in range(count + 1):
            pressure = pressures[node]
            if aims[node] != aim:
                aim = aims[node]
                resting = min(max(aim / p.supply_pressure, 0.0), 1.0)
                spread = math.sqrt(resting * (1.0 - resting))
            own_rate = quickness_of_orifices(p, pressure, resting, spread) / time_constant
            memory.forces[node] = own_rate * (aim - pressure) + lag.rate * pressure
        end, middle = pressures[count], pressures[1]
        follow_nodes(lag, start, memory.forces, memory.powers, pressures)
        moved = abs(pressures[count] - end) + abs(pressures[1] - middle)
        # Each pass gains by as much as the last one did.
        if (moved * min(moved / before, 1.0) if before < math.inf else moved) <= slack:
            return True
        before = moved
    return False
