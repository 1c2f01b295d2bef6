"""How does the valve answer small changes, and when does a loop around it cycle?"""

from __future__ import annotations

from typing import TYPE_CHECKING

from valvemodel.doors import door

if TYPE_CHECKING:
    from valvemodel.linear.describing import stiction_nonlinearity
    from valvemodel.linear.limit_cycle import LimitCycle, describing_cycle, describing_response
    from valvemodel.linear.loop import Loop
    from valvemodel.linear.point import OperatingPoint, operating_point
    from valvemodel.linear.return_map import ReturnMap
    from valvemodel.linear.simulated import simulated_cycle
    from valvemodel.linear.state_space import Linearisation, linearise
    from valvemodel.linear.valve_system import exact_system

_HOMES = {
    "LimitCycle": "valvemodel.linear.limit_cycle",
    "Linearisation": "valvemodel.linear.state_space",
    "Loop": "valvemodel.linear.loop",
    "OperatingPoint": "valvemodel.linear.point",
    "ReturnMap": "valvemodel.linear.return_map",
    "describing_cycle": "valvemodel.linear.limit_cycle",
    "describing_response": "valvemodel.linear.limit_cycle",
    "exact_system": "valvemodel.linear.valve_system",
    "linearise": "valvemodel.linear.state_space",
    "operating_point": "valvemodel.linear.point",
    "simulated_cycle": "valvemodel.linear.simulated",
    "stiction_nonlinearity": "valvemodel.linear.describing",
}

__all__ = [
    "LimitCycle",
    "Linearisation",
    "Loop",
    "OperatingPoint",
    "ReturnMap",
    "describing_cycle",
    "describing_response",
    "exact_system",
    "linearise",
    "operating_point",
    "simulated_cycle",
    "stiction_nonlinearity",
]

__getattr__, __dir__ = door(__name__, _HOMES)
