"""A controller: its kind and its settings, immutable; stepped in Python or handed to the compiled loop."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from valvemodel.compiled import compiled
from valvemodel.control.branches import Branches
from valvemodel.control.laws.law import step
from valvemodel.control.laws.settings import CHOICES, RECOLLECTION, SETTING_PARAMETERS, SETTINGS, TABLE_LENGTH
from valvemodel.errors import InputError, unknown_name


@dataclass(frozen=True)
class Controller:
    """A law with its settings.

    Parameters
    ----------
    name : str
    settings : mapping
        Of choices (`settings.CHOICES`) and numbers (`settings.SETTING_PARAMETERS`) by name [SI]; others are neutral.
    branches : Branches, optional
        What a model knows of the valve; needed by the feedforward of a model, the gain schedule and the landing.
    """

    name: str
    settings: Mapping[str, float]
    branches: Branches | None = None
    record: np.ndarray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        values: dict[str, float] = {name: 0.0 for name in CHOICES}
        values.update({parameter.name: parameter.neutral for parameter in SETTING_PARAMETERS})
        for name, value in self.settings.items():
            if name not in values:
                raise unknown_name("a setting of a controller", name, values)
            values[name] = _checked(name, float(value))
        object.__setattr__(self, "settings", MappingProxyType(dict(self.settings)))
        object.__setattr__(self, "record", self._record(values))

    def _record(self, values: Mapping[str, float]) -> np.ndarray:
        record = np.zeros(1, SETTINGS)
        if self.branches is not None:
            positions = np.linspace(self.branches.lowest, self.branches.highest, TABLE_LENGTH)
            record["rising_currents"][0] = self.branches.rising_current(positions)
            record["falling_currents"][0] = self.branches.falling_current(positions)
            record["table_low"], record["table_step"] = positions[0], positions[1] - positions[0]
        for name, value in values.items():
            if name in self.settings or not name.startswith("table_"):
                record[name] = value
        return record

    def with_settings(self, **settings: float) -> Controller:
        """Return the controller with settings changed."""
        return Controller(self.name, {**self.settings, **settings}, self.branches)

    def started(self) -> Stepper:
        """Return it ready to run, with nothing remembered."""
        return Stepper(self)


class Stepper:
    """A controller under way, called once a period."""

    def __init__(self, controller: Controller) -> None:
        self._settings = controller.record
        self._memory = np.zeros(1, RECOLLECTION)

    def __call__(self, setpoint: float, reading: float) -> float:
        """Return the current for the coming period [A] from set point and reading [m]."""
        return _step(self._settings, self._memory, setpoint, reading)


@compiled
def _step(settings, memories, setpoint, reading):
    """Step a controller once. [A]"""
    return step(settings[0], memories[0], setpoint, reading)


_PARAMETERS = {parameter.name: parameter for parameter in SETTING_PARAMETERS}


def _checked(name: str, value: float) -> float:
    if name in CHOICES:
        return value
    parameter = _PARAMETERS[name]
    if parameter.low <= value <= parameter.high and not math.isnan(value):
        return value
    raise InputError(
        f"{name} lies in {parameter.low:g}..{parameter.high:g} {parameter.unit}",
        f"got {value:g}",
        f"its meaning is: {parameter.meaning}",
    )
