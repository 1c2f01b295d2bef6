"""A loop around the valve: PI control of its position, or of a process behind it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import control as ct
import numpy as np

from valvemodel.errors import InputError
from valvemodel.linear.electromagnet import delay
from valvemodel.linear.rates import SETTING
from valvemodel.linear.state_space import Linearisation, linearise
from valvemodel.model import Model

DEAD_TIME_ORDER = 6
"""Of Pade's approximation of a process's dead time: within 1e-6 up to half a turn of phase. [1]"""


@dataclass(frozen=True)
class Loop:
    """PI control of the valve alone, or of a process of first order and gain 1 that the stem's position drives.

    Attributes
    ----------
    model : Model
    current : float
        At which the loop works; the set point is the middle of the stuck band there. [A]
    proportional : float
        Gain. [A/m]
    integral : float
        Gain. [A/(m s)]
    lag, dead_time : float
        Of the process; both 0 for the valve alone. [s]
    period : float
        Of the controller. [s]
    """

    model: Model
    current: float
    proportional: float
    integral: float
    lag: float = 0.0
    dead_time: float = 0.0
    period: float = 1e-3

    def __post_init__(self) -> None:
        for name in ("proportional", "integral", "lag", "dead_time"):
            if not (math.isfinite(value := getattr(self, name)) and value >= 0.0):
                raise InputError(f"{name} is a number from 0 on", f"got {value}", "correct it")
        if not self.integral > 0.0:
            raise InputError("a limit cycle of stiction needs integral action", "integral is 0", "give it")
        if not self.period > 0.0:
            raise InputError("a controller has a period", f"got {self.period} s", "give one above 0 s")

    @property
    def has_process(self) -> bool:
        """Whether a process stands behind the valve."""
        return self.lag > 0.0 or self.dead_time > 0.0

    @property
    def point(self) -> Linearisation:
        """The valve in slip at the loop's current."""
        return linearise(self.model, current=self.current)

    @property
    def setpoint(self) -> float:
        """Middle of the stuck band at the loop's current. [m]"""
        return linearise(self.model, current=self.current, mode="stuck").point.position

    @property
    def slip_gain(self) -> float:
        """Position over current in slip. [m/A]"""
        return float(self.point.current_to_position.dcgain())

    @property
    def settings(self) -> np.ndarray:
        """The numbers of controller and process, shape (1,), dtype SETTING."""
        settings = np.zeros(1, SETTING)
        settings[0] = (
            self.setpoint, self.current, self.proportional, self.integral, self.lag, self.dead_time, 0.5 * self.period,
        )  # fmt: skip
        return settings

    def controller(self) -> ct.TransferFunction:
        """Return the controller without its sampling."""
        return ct.tf([self.proportional, self.integral], [1.0, 0.0])

    def process(self, *, delays: float = 0.0) -> ct.StateSpace:
        """Return the process with further dead time from the position to the controlled variable. [s]"""
        line = delay("line", self.dead_time + delays, DEAD_TIME_ORDER, "position", "delayed_position")
        if self.lag == 0.0:
            return line
        return ct.series(line, ct.ss([[-1.0 / self.lag]], [[1.0 / self.lag]], [[1.0]], [[0.0]]))

    def stickiness(self) -> tuple[float, float]:
        """Return breakaway force and sliding friction over the stiffness, of a rise. [m]"""
        stem = self.point.pressure_to_position
        area_over_mass, stiffness_over_mass = float(stem.B[1, 0]), -float(stem.A[1, 0])
        stiffness = stiffness_over_mass * self.model.values["stem_mass"]
        assert area_over_mass > 0.0
        sliding = self.point.point.friction / stiffness
        ratio = self.model.effects.get("static_friction", {}).get("static_friction_ratio", 1.0)
        return ratio * sliding, sliding
