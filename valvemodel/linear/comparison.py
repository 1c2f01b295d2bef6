"""Three answers on one loop: describing function, return map and simulation."""

from __future__ import annotations

import math
from typing import Any

from valvemodel.linear.limit_cycle import LimitCycle, describing_cycle
from valvemodel.linear.loop import Loop
from valvemodel.linear.return_map import ReturnMap
from valvemodel.linear.simulated import TURNS, simulated_cycle

FORGETFUL = 0.6
"""Multiplier below which a run need not start on its cycle: it gets there."""

LEFT = 1e-3
"""Share of a departure that may be left when the turns are measured."""

SETTLING = 1000.0
"""Length of a run for which nothing predicts a period, over dead time, lag and slip. [1]"""


def compare(loop: Loop) -> dict[str, LimitCycle | None]:
    """Return the limit cycle by each of the three ways, None where there is no steady one.

    The simulation starts half a slip jump off the set point; on the predicted cycle where that attracts so slowly
    that a run would take very long. Without any prediction the run lasts a thousand times as long as the slowest
    part of the loop.
    """
    described, mapped = describing_cycle(loop), ReturnMap(loop).cycle()
    start, turns = None, TURNS + 4.0
    if mapped is not None and mapped.multiplier > FORGETFUL:
        start = mapped.states
    elif mapped is not None:
        turns += math.log(LEFT) / math.log(max(mapped.multiplier, 1e-3))
    known = mapped or described
    slowest = loop.lag + loop.dead_time + 1.0 / (loop.integral * abs(loop.slip_gain))
    duration = SETTLING * slowest if known is None else turns * known.period
    return {
        "describing_function": described,
        "return_map": mapped,
        "simulation": simulated_cycle(loop, duration=duration, start=start),
    }


def errors_of(found: dict[str, LimitCycle | None]) -> dict[str, Any]:
    """Return the relative errors of period and amplitude of both predictions, against the simulation.

    Returns
    -------
    dict
        By prediction a verdict (both cycle, missed: the simulation cycles alone, false: the prediction does, none) and,
        where both cycle, the errors `period` and `amplitude`. [1]
    """
    truth = found["simulation"]
    errors: dict[str, Any] = {}
    for name in ("describing_function", "return_map"):
        cycle = found[name]
        if cycle is None or truth is None:
            verdict = "none" if cycle is truth else "missed" if cycle is None else "false"
            errors[name] = {"verdict": verdict, "period": math.nan, "amplitude": math.nan}
            continue
        errors[name] = {
            "verdict": "both cycle",
            "period": cycle.period / truth.period - 1.0,
            "amplitude": cycle.amplitude / truth.amplitude - 1.0,
        }
    return errors
