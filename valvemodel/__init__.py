"""What happens in time? A control valve from current to position, simulated exactly; its public door.

Names are loaded when they are first used, so that `import valvemodel` costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from valvemodel.doors import door

if TYPE_CHECKING:
    from valvemodel.declarations import Effect, Parameter
    from valvemodel.effects import effect_of_key
    from valvemodel.errors import InputError
    from valvemodel.model import Model, read_model
    from valvemodel.records import Record, read_record, write_table
    from valvemodel.simulation import simulate
    from valvemodel.stepping import SteppedValve
    from valvemodel.trajectory import Trajectory
    from valvemodel.valves import Valve, read_valve, valve_names
    from valvemodel.valves.plausibility import plausibility

_HOMES = {
    "Effect": "valvemodel.declarations",
    "InputError": "valvemodel.errors",
    "Model": "valvemodel.model",
    "Parameter": "valvemodel.declarations",
    "Record": "valvemodel.records",
    "SteppedValve": "valvemodel.stepping",
    "Trajectory": "valvemodel.trajectory",
    "Valve": "valvemodel.valves",
    "effect_of_key": "valvemodel.effects",
    "plausibility": "valvemodel.valves",
    "read_model": "valvemodel.model",
    "read_record": "valvemodel.records",
    "read_valve": "valvemodel.valves",
    "simulate": "valvemodel.simulation",
    "valve_names": "valvemodel.valves",
    "write_table": "valvemodel.records",
}

__all__ = [
    "Effect",
    "InputError",
    "Model",
    "Parameter",
    "Record",
    "SteppedValve",
    "Trajectory",
    "Valve",
    "effect_of_key",
    "plausibility",
    "read_model",
    "read_record",
    "read_valve",
    "simulate",
    "valve_names",
    "write_table",
]

__getattr__, __dir__ = door(__name__, _HOMES)
