"""Supply that sags with the air drawn from it: the law of `supply_droop` over the nodes of a part."""

from __future__ import annotations

from valvemodel.compiled import compiled
from valvemodel.stages.lag import SUPPLY_LAG, follow_nodes, nearby_lag
from valvemodel.stages.nodes import first_fall, fit_powers, slope_at
from valvemodel.stages.nozzle import drawn_to_settle

SWEEPS = 8
"""Most passes until the nodes stand still; each gains a factor of the part's length over the recovery time."""

STANDING = 1e-13
"""Share of the supply, in a spacing, below which a pressure tends neither way."""


@compiled
def supply_after_switch(p, state, share):
    """Return the supply pressure once the share of it that rests at the nozzle has switched: a rise draws air. [Pa]"""
    supply = p.supply_pressure - state.droop
    if share > state.share:
        supply *= (1.0 + p.droop_gain * state.share) / (1.0 + p.droop_gain * share)
    return supply


@compiled
def lay_supply(p, state, memory, spacing, count, slack):
    """Let the pressures at the nodes sag with their supply; return where a rise turns to a fall or back, in spacings.

    While the pressure rises, (1 + g s) (P1 - d) is a first-order lag with a slowly changing rate, s being the share
    of the supply; while it falls, P1 - d is. The supply is known to within a slack. [Pa]
    """
    full, pressures, shares, supplies = p.supply_pressure, memory.pressures, memory.shares, memory.values
    for node in range(count + 1):
        shares[node] = pressures[node] / full
    supply = supply_after_switch(p, state, shares[0])
    fit_powers(count, shares, memory.powers)
    recovery = (drawn_to_settle(p, shares[0]) - full + supply) / p.droop_recovery_time
    tendency = supply * slope_at(count, memory.powers, 0.0) / spacing - shares[0] * recovery
    gain = p.droop_gain if tendency > 0.0 else 0.0
    rate = 1.0 / (p.droop_recovery_time * (1.0 + gain * shares[0]))
    lag = nearby_lag(memory, SUPPLY_LAG, rate, spacing, count)
    start = supply * (1.0 + gain * shares[0])
    for node in range(count + 1):
        supplies[node] = start
    for _ in range(SWEEPS):
        for node in range(count + 1):
            settled = full - drawn_to_settle(p, shares[node])
            own_rate = 1.0 / (p.droop_recovery_time * (1.0 + gain * shares[node]))
            memory.forces[node] = settled / p.droop_recovery_time + (lag.rate - own_rate) * supplies[node]
        before = supplies[count]
        follow_nodes(lag, start, memory.forces, memory.powers, supplies)
        if abs(supplies[count] - before) <= slack:
            break
    for node in range(count + 1):
        supplies[node] /= 1.0 + gain * shares[node]
        pressures[node] = supplies[node] * shares[node]
    return turning(p, memory, spacing, count, tendency)


@compiled
def turning(p, memory, spacing, count, tendency):
    """Return where the tendency of the pressure, known at the start, changes its sign, in spacings."""
    fit_powers(count, memory.shares, memory.powers)
    side = 1.0 if tendency > 0.0 else -1.0
    for node in range(count + 1):
        supply, share = memory.values[node], memory.shares[node]
        recovery = (drawn_to_settle(p, share) - p.supply_pressure + supply) / p.droop_recovery_time
        rise = supply * slope_at(count, memory.powers, float(node)) / spacing - share * recovery
        memory.forces[node] = side * rise + STANDING * p.supply_pressure / spacing
    return first_fall(count, memory.forces, memory.powers)
