"""State space: the chain linearised at an operating point, stage by stage, as python-control's systems."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import control as ct
import numpy as np

from valvemodel.linear import electromagnet, nozzle, sensor, stem
from valvemodel.linear.block import Treatment, joined
from valvemodel.linear.point import OperatingPoint, numbers_of, operating_point
from valvemodel.model import Model

UNITS = {"current": "A", "pressure": "Pa", "position": "m", "reading": "m"}
"""Of the signals that a linearisation shows."""

PADE_ORDER = 4

TREATMENTS: dict[str, Treatment] = {
    **electromagnet.TREATMENTS, **nozzle.TREATMENTS, **stem.TREATMENTS, **sensor.TREATMENTS,
}  # fmt: skip
"""How each effect enters, by its key."""


@dataclass(frozen=True)
class Linearisation:
    """A valve's answer to small changes about an operating point; inputs and outputs are departures from it.

    Attributes
    ----------
    model : Model
    point : OperatingPoint
    blocks : tuple of control.StateSpace
        In series, each named for what it is; an output feeds the input of the same name.
    pade_order : int
        Of the approximation of the line's dead time.
    """

    model: Model
    point: OperatingPoint
    blocks: tuple[ct.StateSpace, ...]
    pade_order: int

    @property
    def system(self) -> ct.StateSpace:
        """From current to pressure, position and reading."""
        return self._between("valve", "current", ["pressure", "position", "reading"])

    @property
    def current_to_pressure(self) -> ct.StateSpace:
        """Electromagnet and nozzle."""
        return self._between("electromagnet_and_nozzle", "current", ["pressure"])

    @property
    def pressure_to_position(self) -> ct.StateSpace:
        """Stem."""
        return self._between("stem", "pressure", ["position"])

    @property
    def current_to_position(self) -> ct.StateSpace:
        """The chain without the sensor."""
        return self._between("chain", "current", ["position"])

    @property
    def current_to_reading(self) -> ct.StateSpace:
        """The whole chain, what a controller sees."""
        return self._between("chain_with_sensor", "current", ["reading"])

    @property
    def effects(self) -> dict[str, Treatment]:
        """How the effects that are switched on enter."""
        return {key: TREATMENTS[key] for key in self.model.effects}

    def _between(self, name: str, source: str, targets: list[str]) -> ct.StateSpace:
        sources = [block.input_labels[0] for block in self.blocks]
        ends = [block.output_labels[0] for block in self.blocks]
        first, last = sources.index(source), max(ends.index(target) for target in targets)
        return joined(name, self.blocks[first : last + 1], source, targets)


def linearise(
    model: Model, *, current: float, mode: str = "rising", speed: float = 0.0, pade_order: int = PADE_ORDER
) -> Linearisation:
    """Linearise a valve at an operating point, with derivatives from the derivations.

    Parameters
    ----------
    model : Model
        Effects that have no linearisation are left out; `Linearisation.effects` says which.
    current : float
        Of the operating point. [A]
    mode : str
        rising or falling: in slip on that branch; stuck: small moves before the stem breaks away.
    speed : float
        At which a slipping stem passes the point. [m/s]
    pade_order : int
        Order of the approximation of a dead time.

    Returns
    -------
    Linearisation

    Raises
    ------
    InputError
        If there is no such operating point.

    Examples
    --------
    >>> from valvemodel.model import Model
    >>> from valvemodel.valves import read_valve
    >>> valve = read_valve("calibrated")
    >>> found = linearise(Model(valve.name, valve.values), current=12e-3)
    >>> round(float(found.current_to_position.dcgain()), 2)
    12.64
    """
    point = operating_point(model, current=current, mode=mode, speed=speed)
    numbers = numbers_of(model)
    blocks = [
        *electromagnet.blocks(numbers, point, pade_order),
        *nozzle.blocks(numbers, point),
        *stem.blocks(numbers, point),
        *sensor.blocks(numbers, point),
    ]
    return Linearisation(model, point, tuple(blocks), pade_order)


def modes_of(system: ct.StateSpace) -> list[dict[str, Any]]:
    """Return each pole with its natural frequency, damping ratio and time constant.

    Returns
    -------
    list of dict
        `pole` real and imaginary part [1/s], `frequency` [rad/s], `damping_ratio` [1], `time_constant` [s].
    """
    return [
        {
            "pole": [float(pole.real), float(pole.imag)],
            "frequency": float(abs(pole)),
            "damping_ratio": float(-pole.real / abs(pole)) if pole != 0.0 else 1.0,
            "time_constant": float(-1.0 / pole.real) if pole.real != 0.0 else float("inf"),
        }
        for pole in np.sort_complex(system.poles())[::-1]
    ]
