"""Every number of a valve and of all effects by its name, neutral where a model is silent."""

from __future__ import annotations

from types import SimpleNamespace

from valvemodel.base_valve import BASE_PARAMETERS
from valvemodel.model import Model
from valvemodel.stages import EFFECTS


def numbers_of(model: Model) -> SimpleNamespace:
    """Return the numbers of a model as attributes. [SI]"""
    declared = BASE_PARAMETERS + tuple(parameter for effect in EFFECTS for parameter in effect.parameters)
    neutral = {parameter.name: parameter.neutral for parameter in declared}
    return SimpleNamespace(**{**neutral, **model.numbers})
