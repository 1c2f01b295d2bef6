"""The smooth chain of a model: one CasADi function from period to period, made of the effects that are switched on."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np

from valvemodel.model import Model
from valvemodel.periods import finer
from valvemodel.smooth import electromagnet, nozzle, sensor, stem
from valvemodel.smooth.contact import CONTACTS
from valvemodel.smooth.delay import delayed_current
from valvemodel.smooth.rounding import Expression

WIDTH = "smoothing_width"
"""Name of the smoothing width among the parameters. [N]"""

INPUTS = ("current", "duration")
"""What a period holds. [A], [s]"""

TIMED = frozenset({"gap_drift", "sensor_drift", "load_force", "friction_drift"})
"""Effects that make the time a state."""

SCALES = {
    "flux_current": 1e-3, "less_lagged_flux": 1e-3, "hysteresis_input": 1e-3, "hysteresis": 1.0,
    **dict.fromkeys(electromagnet.PLAY_STATES, 1e-3),
    "droop": 1e4, "supplied_pressure": 1e4, "chamber_pressure": 1e4, "filled_pressure": 1e4, "pressure": 1e4,
    "position": 1e-2, "velocity": 1e-1, "bristle": 1e2, **dict.fromkeys(stem.SLIDER_STATES, 1e-4),
    "linkage": 1e-2, "tight_linkage": 1e-2, "loose_linkage": 1e-2,
    "lagged_reading": 1e-2, "less_lagged_reading": 1e-2, "time": 1.0,
}  # fmt: skip
"""Size of a change of each state that counts. [SI]"""

WITHOUT_SMOOTH_FORM = frozenset({"quantisation", "transport_delay"})
"""A grid of readings is left out; a delay acts on the input, before the chain (`valvemodel.smooth.delay`)."""

LONGEST_SWING = 0.5 * math.pi
"""A part is at most this over the natural frequency of a stem that swings: a slip stops once in it at most."""

LONGEST_PART = 5e-3
"""A part is not longer where forces or pressure bend within it. [s]"""

BENDING = frozenset(
    {"coil_lag", "transport_delay", "chamber_filling", "asymmetric_filling", "supply_droop", "sensor_lag",
     "spring_hardening", "position_dependent_friction", "presliding", "stribeck"}
)  # fmt: skip
"""Effects that the closed form of a part takes as straight, or as its mean."""


class SmoothChain:
    """A model as CasADi functions of a state x, an input u and parameters p.

    Parameters
    ----------
    model : Model
        Its effects that are switched on, and no others, enter the graph.
    parts : int
        Parts into which a period is cut; `parts_for` says how many it takes.

    Attributes
    ----------
    model : Model
    states, parameters : tuple of str
        Names in the order of x and p. The last parameter is the smoothing width: the force over which the dead zone
        of the friction, and in proportion every other kink, is rounded. [N]
    step : Function
        `step(x, u, p) -> x` at the end of a period that holds u = (current, duration). [A], [s]
    part : Function
        The same for one part of a period, as one expression.
    reading, pressure : Function
        `reading(x, p)`, what the sensor shows [m]; `pressure(x, p)`, that of the actuator [Pa].
    start : Function
        `start(reading, current, p) -> x`, at rest.
    """

    def __init__(self, model: Model, *, parts: int = 1) -> None:
        self.effects = frozenset(model.effects) - WITHOUT_SMOOTH_FORM
        numbers = {name: number for name, number in model.numbers.items() if math.isfinite(number)}
        self.model, self.parts = model, parts
        self.remembers = model.numbers.get("return_point_memory", 0.0) > 0.0
        self.slides = model.numbers.get("slider_share", 0.0) > 0.0
        self.has_eddies = model.numbers.get("eddy_time_constant", 0.0) > 0.0
        self.filters = model.numbers.get("sensor_second_time_constant", 0.0) > 0.0
        self.smears = model.numbers.get("line_dispersion", 0.0) > 0.0
        self.wears = model.numbers.get("backlash_wear", 0.0) > 0.0
        self.lags_behind_core = model.numbers.get("lag_behind_core", 0.0) > 0.0
        self.saturates_as_tanh = model.numbers.get("saturation_law", 0.0) > 0.0
        self.leaks_gas = model.numbers.get("leak_chokes", 0.0) > 0.0
        self.turns = model.numbers.get("linkage_arm", 0.0) > 0.0 and model.numbers["linkage_skew"] != 0.0
        self.parameters = (*numbers, WIDTH)
        self.states = (
            *electromagnet.states_of(self.effects, has_eddies=self.has_eddies, remembers=self.remembers),
            *nozzle.states_of(self.effects, smears=self.smears),
            *stem.states_of(self.effects, slides=self.slides),
            *sensor.states_of(self.effects, filters=self.filters, wears=self.wears),
            *(("time",) if self.effects & TIMED else ()),
        )
        self.part = self._make_part()
        self.step = self._make_step()
        self.start = self._make_start()
        self.reading = self._make_output("reading", lambda p, x: sensor.read_sensor(p, x, _time(x)))
        self.pressure = self._make_output("pressure", lambda p, x: x.pressure)

    def values(self, width: float, numbers: Mapping[str, float] | None = None) -> np.ndarray:
        """Return p of the model, or of other numbers, at a smoothing width [N], shape (parameters,). [SI]"""
        given = {**self.model.numbers, **(numbers or {}), WIDTH: width}
        return np.array([given[name] for name in self.parameters])

    @property
    def scales(self) -> np.ndarray:
        """Size of a change of each state that counts, shape (states,). [SI]"""
        return np.array([SCALES[name] for name in self.states])

    @cached_property
    def _p(self) -> Any:
        """The parameters by name, and what the stages ask of them."""
        p = SimpleNamespace(**{name: ca.SX.sym(name) for name in self.parameters})
        p.effects, p.remembers, p.slides = self.effects, self.remembers, self.slides
        p.has_eddies, p.saturates_as_tanh = self.has_eddies, self.saturates_as_tanh
        p.lags_behind_core, p.leaks_gas = self.lags_behind_core, self.leaks_gas
        p.filters, p.smears, p.wears, p.turns = self.filters, self.smears, self.wears, self.turns
        p.curves = self.model.numbers.get("bristle_exponent", 1.0) > 1.0
        p.has_orifices = self.model.numbers.get("orifice_share", 0.0) > 0.0
        p.waves = int(self.model.numbers.get("load_waves", 1.0))
        p.is_affine = self.model.values["pressure_per_current"] > 0.0
        yields = self.model.numbers.get("stop_compliance", 0.0) > 0.0
        p.contacts = [each for each in CONTACTS if yields and each[1] in self.parameters]
        dead = set(self.parameters) - {name for _, name in p.contacts}
        p.highest = [name for name in ("travel_max", "upper_stop") if name in dead]
        p.lowest = [name for name in ("travel_min", "lower_stop") if name in dead]
        p.smoothing_length = p.smoothing_width / p.spring_rate
        p.smoothing_pressure = p.smoothing_width / p.diaphragm_area
        p.smoothing_share = p.smoothing_width / (p.smoothing_width + p.coulomb_friction)
        return p

    @property
    def _vector(self) -> ca.SX:
        return ca.vertcat(*(getattr(self._p, name) for name in self.parameters))

    def _state(self) -> Any:
        return SimpleNamespace(**{name: ca.SX.sym(name) for name in self.states})

    def _stacked(self, x: Any) -> ca.SX:
        return ca.vertcat(*(getattr(x, name) for name in self.states))

    def _make_part(self) -> ca.Function:
        x, current, duration = self._state(), ca.SX.sym("current"), ca.SX.sym("duration")
        before = self._stacked(x)
        self._advance(x, current, duration)
        arguments = [before, ca.vertcat(current, duration), self._vector]
        return ca.Function("part", arguments, [self._stacked(x)], ["x", "u", "p"], ["next"])

    def _make_step(self) -> ca.Function:
        if self.parts == 1:
            return self.part
        x, u, p = (ca.MX.sym(name, self.part.size1_in(name)) for name in ("x", "u", "p"))
        held = ca.repmat(ca.vertcat(u[0], u[1] / self.parts), 1, self.parts)
        return ca.Function("step", [x, u, p], [self.part.fold(self.parts)(x, held, p)], ["x", "u", "p"], ["next"])

    def _advance(self, x: Any, current: Expression, duration: Expression) -> None:
        p, middle = self._p, _time(x) + 0.5 * duration
        effective = electromagnet.advance_flux(p, x, current, duration)
        gap = electromagnet.gap_of_current(p, effective, middle)
        pressure = nozzle.advance_nozzle(p, x, gap, effective, duration)
        before = sensor.bow(p, sensor.indicated(p, x))
        stem.advance_stem(p, x, pressure, middle, duration)
        sensor.follow_stem(p, x, before, duration)
        if "time" in self.states:
            x.time += duration

    def _make_start(self) -> ca.Function:
        p, x = self._p, SimpleNamespace()
        reading, current = ca.SX.sym("reading"), ca.SX.sym("current")
        if "time" in self.states:
            x.time = 0.0
        effective = electromagnet.rest_electromagnet(p, x, current)
        nozzle.rest_nozzle(p, x, electromagnet.gap_of_current(p, effective, 0.0), effective)
        stem.put_stem(p, x, sensor.unbow(p, reading), 0.0)
        sensor.rest_sensor(p, x)
        return ca.Function("start", [reading, current, self._vector], [self._stacked(x)], ["reading", "u", "p"], ["x"])

    def _make_output(self, name: str, output: Any) -> ca.Function:
        x = self._state()
        return ca.Function(name, [self._stacked(x), self._vector], [output(self._p, x)], ["x", "p"], [name])


def _time(x: Any) -> Expression:
    return getattr(x, "time", 0.0)


def parts_for(model: Model, period: float) -> int:
    """Return into how many parts a period must be cut for the closed form of each to hold.

    Parameters
    ----------
    model : Model
    period : float [s]
    """
    values, longest = model.values, math.inf
    if values["viscous_friction"] ** 2 < 4.0 * values["stem_mass"] * values["spring_rate"]:
        longest = LONGEST_SWING * math.sqrt(values["stem_mass"] / values["spring_rate"])
    if BENDING & set(model.effects):
        longest = min(longest, LONGEST_PART)
    return max(1, math.ceil(period / longest - 1e-6))


def run_smooth(
    chain: SmoothChain,
    *,
    time: np.ndarray,
    current: np.ndarray,
    start_position: float,
    width: float,
    numbers: Mapping[str, float] | None = None,
) -> np.ndarray:
    """Run a smooth chain over currents held from each row to the next; readings as `simulate` gives them.

    Parameters
    ----------
    time : array, shape (n,), increasing [s]
    current : array, shape (n,) [A]
    start_position : float
        Reading at the start. [m]
    width : float
        Smoothing width. [N]
    numbers : mapping, or None
        Numbers other than the model's. [SI]

    Returns
    -------
    array, shape (n,) [m]
    """
    values = {**chain.model.numbers, **(numbers or {})}
    p = chain.values(width, values)
    start = chain.start(start_position, current[0], p)
    arriving = np.repeat(current[:-1], chain.parts)
    if "transport_delay" in values:
        arriving = ca.evalf(delayed_current(time, current, values["transport_delay"], chain.parts)).full()
    held = np.vstack([arriving, np.diff(finer(time, chain.parts))])
    states = chain.part.mapaccum(held.shape[1])(start, held, p)[:, chain.parts - 1 :: chain.parts]
    return np.asarray(chain.reading.map(len(time))(ca.horzcat(start, states), p)).ravel()
