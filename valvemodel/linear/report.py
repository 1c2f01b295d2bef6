"""What a linearisation and a limit cycle say, as content of linearise.json."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import control as ct
import numpy as np

from valvemodel.linear.comparison import errors_of
from valvemodel.linear.feedback import Gains, margins
from valvemodel.linear.figures import moving
from valvemodel.linear.limit_cycle import LimitCycle
from valvemodel.linear.loop import Loop
from valvemodel.linear.state_space import UNITS, Linearisation, modes_of

SCHEMA = "valvemodel.linearise/1"

POINT_UNITS = {
    "current": "A", "effective_current": "A", "gap": "m", "resting_pressure": "Pa", "supplied_pressure": "Pa",
    "pressure": "Pa", "position": "m", "reading": "m", "speed": "m/s", "friction": "N",
}  # fmt: skip

TRANSFERS = {
    "current_to_pressure": "Pa/A",
    "pressure_to_position": "m/Pa",
    "current_to_position": "m/A",
    "current_to_reading": "m/A",
}
"""The transfer functions that are shown, and the units of their gains."""


def content(found: Sequence[Linearisation], gains: Gains) -> dict[str, Any]:
    """Return what linearise.json holds of linearisations at one current."""
    return {
        "schema": SCHEMA,
        "model": found[0].model.as_json(),
        "pade_order": found[0].pade_order,
        "controller": {
            "proportional": {"value": gains.proportional, "unit": "A/m"},
            "integral": {"value": gains.integral, "unit": "A/(m*s)"},
            "derivative": {"value": gains.derivative, "unit": "A*s/m"},
        },
        "linearisations": [_linearisation(each, gains) for each in found],
    }


def _linearisation(found: Linearisation, gains: Gains) -> dict[str, Any]:
    point = asdict(found.point)
    system = found.system
    return {
        "mode": point.pop("mode"),
        "operating_point": {name: {"value": value, "unit": POINT_UNITS[name]} for name, value in point.items()},
        "state_space": {
            "inputs": [{"name": name, "unit": UNITS[name]} for name in system.input_labels],
            "outputs": [{"name": name, "unit": UNITS[name]} for name in system.output_labels],
            "states": list(system.state_labels),
            "A": system.A, "B": system.B, "C": system.C, "D": system.D,
        },
        "transfer_functions": {
            name: _transfer(getattr(found, name), unit) for name, unit in TRANSFERS.items()
        },
        "poles": modes_of(system),
        "margins": margins(found, gains) if moving([found]) else None,
        "effects": {key: asdict(treatment) for key, treatment in found.effects.items()},
    }  # fmt: skip


def _transfer(system: ct.StateSpace, unit: str) -> dict[str, Any]:
    """Return a transfer function; python-control's coefficients, highest power of s first."""
    function = ct.ss2tf(system)
    zeros = np.atleast_1d(system.zeros())
    return {
        "numerator": function.num[0][0],
        "denominator": function.den[0][0],
        "zeros": [[float(zero.real), float(zero.imag)] for zero in zeros],
        "static_gain": {"value": float(np.real(system.dcgain())), "unit": unit},
    }


def loop_content(loop: Loop, cycles: dict[str, LimitCycle | None]) -> dict[str, Any]:
    """Return what linearise.json and the benchmark hold of a loop and its limit cycles."""
    static, kinetic = loop.stickiness()
    return {
        "current": {"value": loop.current, "unit": "A"},
        "setpoint": {"value": loop.setpoint, "unit": "m"},
        "proportional": {"value": loop.proportional, "unit": "A/m"},
        "integral": {"value": loop.integral, "unit": "A/(m*s)"},
        "process_lag": {"value": loop.lag, "unit": "s"},
        "process_dead_time": {"value": loop.dead_time, "unit": "s"},
        "controller_period": {"value": loop.period, "unit": "s"},
        "static_friction_over_stiffness": {"value": static, "unit": "m"},
        "kinetic_friction_over_stiffness": {"value": kinetic, "unit": "m"},
        "limit_cycles": {name: _cycle(cycle) for name, cycle in cycles.items()},
        "errors": errors_of(cycles),
    }


def _cycle(cycle: LimitCycle | None) -> dict[str, Any] | None:
    if cycle is None:
        return None
    return {
        "period": {"value": cycle.period, "unit": "s"},
        "amplitude": {"value": cycle.amplitude, "unit": "m"},
        "multiplier": None if math.isnan(cycle.multiplier) else cycle.multiplier,
        "is_stable": None if math.isnan(cycle.multiplier) else cycle.is_stable,
    }
