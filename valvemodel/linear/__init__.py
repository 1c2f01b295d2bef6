"""How does the valve answer small changes, and when does a loop around it cycle?"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from valvemodel.linear.describing import stiction_nonlinearity
    from valvemodel.linear.limit_cycle import LimitCycle, describing_cycle, simulated_cycle
    from valvemodel.linear.loop import Loop
    from valvemodel.linear.point import OperatingPoint, operating_point
    from valvemodel.linear.return_map import ReturnMap
    from valvemodel.linear.state_space import Linearisation, linearise
    from valvemodel.linear.valve_system import exact_system

_HOMES = {
    "Linearisation": "state_space",
    "OperatingPoint": "point",
    "linearise": "state_space",
    "operating_point": "point",
}

__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'valvemodel.linear' has no attribute {name!r}")
    return getattr(import_module(f"valvemodel.linear.{_HOMES[name]}"), name)
