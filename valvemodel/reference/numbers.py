"""Every number of a valve and of all effects by its name, neutral where a model is silent."""

from __future__ import annotations

from types import SimpleNamespace

from valvemodel.base_valve import BASE_PARAMETERS
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.stages import EFFECTS

INTEGRATED = {
    "coil_lag", "gap_drift", "chamber_filling", "asymmetric_filling", "supply_droop",
    "stribeck", "position_dependent_friction", "presliding", "spring_hardening", "load_force", "friction_drift",
}  # fmt: skip
"""Effects without a closed form."""


def numbers_of(model: Model) -> SimpleNamespace:
    """Return the numbers of a model as attributes. [SI]"""
    if not INTEGRATED.isdisjoint(model.effects):
        arrived = f"got {', '.join(sorted(INTEGRATED.intersection(model.effects)))}"
        raise InputError("the reference in plain Python knows effects in closed form", arrived, "switch them off")
    declared = BASE_PARAMETERS + tuple(parameter for effect in EFFECTS for parameter in effect.parameters)
    neutral = {parameter.name: parameter.neutral for parameter in declared}
    return SimpleNamespace(**{**neutral, **model.numbers})
