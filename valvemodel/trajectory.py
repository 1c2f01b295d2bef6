"""A simulated run: samples, events, energies, and what stands at any instant between the samples."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from valvemodel import runs
from valvemodel.display import Card, Shown, trajectory_card
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.parameters import EVENT, MEMORY, SAMPLE, STATE
from valvemodel.plots import Plotted
from valvemodel.stages.stem import highest_position, lowest_position

if TYPE_CHECKING:
    import pandas

TOLERANCE = 1e-9
"""What a run may be off in position. [m]"""

MODE_NAMES = {-1.0: "falling", 0.0: "stuck", 1.0: "rising"}

EVENT_ROOM = 1024
"""Events for which room is made at first."""

NODES, WEIGHTS = (table / 2.0 for table in np.polynomial.legendre.leggauss(6))
"""Gauss's rule on -1/2..1/2."""


@dataclass(frozen=True, eq=False)
class Setting:
    """What a run is made from.

    Attributes
    ----------
    model : Model
    start_position : float
        Reading at the start; NaN at rest in the middle of the stuck band. [m]
    anchors : array, shape (0,) or (n,)
        Readings at which the run is put anew, NaN where it runs free. [m]
    at_rest : bool
        Whether only a stem that has just come to rest is put anew.
    tolerance : float
        As in `simulate`. [m]
    """

    model: Model
    start_position: float = math.nan
    anchors: np.ndarray = field(default_factory=lambda: runs.FREE)
    at_rest: bool = False
    tolerance: float = TOLERANCE

    def trace(
        self, time: np.ndarray, current: np.ndarray, instants: np.ndarray, room: int
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return samples (n,), what stands at increasing instants (k,) [s] between them, and all events."""
        rows = self.model.rows(start_position=self.start_position)
        rows["anchors_at_rest"] = self.at_rest
        samples, between = np.empty(len(time), SAMPLE), np.empty(len(instants), SAMPLE)
        start = time[0]
        while True:
            events = np.empty(room, EVENT)
            found = runs.trace_chain(
                rows, np.zeros(2, STATE), np.zeros(1, MEMORY), time - start, current, self.anchors,
                self.tolerance, samples, instants - start, between, events,
            )  # fmt: skip
            if found <= room or room == 0:
                events = events[:found]
                events["time"] += start
                return samples, between, events
            room = found


@dataclass(frozen=True)
class Events:
    """Changes of mode in the order in which they happen; arrays of shape (k,).

    Attributes
    ----------
    time : array [s]
    kind : array of str
        breakaway (from rest), stop, reversal (without a rest), impact (at an end of the travel, or at a stop that
        gives way), release (the stem leaves such a stop).
    position : array
        Of the stem. [m]
    speed : array
        Just before it. [m/s]
    """

    time: np.ndarray
    kind: np.ndarray
    position: np.ndarray
    speed: np.ndarray

    def __len__(self) -> int:
        return len(self.time)


@dataclass(frozen=True)
class Energies:
    """Where the work goes, up to each sample; arrays of shape (n,). [J]

    Attributes
    ----------
    kinetic, stored : array
        In the moving mass, and in the spring above its preload at position 0.
    supplied : array
        Work of the pressure, and of the load where there is one, since the start.
    dissipated : array
        What has gone into friction and impacts since the start: supplied less the rise of the other two. Where a run
        is put anew at anchors, that shift is in it.
    """

    kinetic: np.ndarray
    stored: np.ndarray
    supplied: np.ndarray
    dissipated: np.ndarray


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(Shown, Plotted):
    """What a simulation gives, a row for each input row: the state just before the current of that row acts.

    Attributes
    ----------
    time : array, shape (n,) [s]
    current : array, shape (n,) [A]
    pressure : array, shape (n,) [Pa]
    position : array, shape (n,) [m]
        The sensor's reading.
    mode : array, shape (n,)
        1 rising, 0 stuck, -1 falling.
    stem_position, velocity : array, shape (n,) [m], [m/s]
        Of the stem itself.
    setting : Setting
        What the run was made from; events, energies and what stands between the samples are computed when asked for.
    """

    time: np.ndarray
    current: np.ndarray
    pressure: np.ndarray
    position: np.ndarray
    mode: np.ndarray
    stem_position: np.ndarray
    velocity: np.ndarray
    setting: Setting

    def __len__(self) -> int:
        return len(self.time)

    @property
    def mode_names(self) -> list[str]:
        """The mode of each row in words."""
        return [MODE_NAMES[mode] for mode in self.mode.tolist()]

    def columns(self) -> dict[str, Any]:
        """Return the rows as a file has them: time, current, pressure, position with their units, and the mode."""
        from valvemodel.records.table import usual_columns

        signals = {name: getattr(self, name) for name in ("time", "current", "pressure", "position")}
        return {**usual_columns(**signals), "mode": self.mode_names}

    def to_pandas(self) -> pandas.DataFrame:
        """Return a DataFrame of the rows, as `valvemodel simulate` writes them.

        Raises
        ------
        InputError
            If pandas is not installed.
        """
        from valvemodel.records.frame import make_frame

        return make_frame(self.columns())

    def _card(self) -> Card:
        return trajectory_card(self)

    @cached_property
    def events(self) -> Events:
        """Every breakaway, stop, reversal, impact and release at its own instant."""
        _, _, found = self.setting.trace(self.time, self.current, np.empty(0), EVENT_ROOM)
        row = self.setting.model.rows()[0]
        highest, lowest = highest_position(row), lowest_position(row)
        found = _without_instant_rests(found)
        kind = np.where(found["mode_after"] == 0.0, "stop", "reversal")
        at_end = np.where(found["mode_before"] > 0.0, found["position"] >= highest, found["position"] <= lowest)
        kind = np.where(at_end, "impact", kind)
        kind = np.where(found["mode_before"] == 0.0, "breakaway", kind)
        meets_stop = found["position"] == np.where(found["mode_after"] > 0.0, row["upper_stop"], row["lower_stop"])
        goes_on = found["mode_after"] == found["mode_before"]
        kind = np.where(goes_on, np.where(meets_stop, "impact", "release"), kind)
        return Events(found["time"], kind, found["position"], found["speed_before"])

    def at(self, instants: np.ndarray | list[float]) -> Trajectory:
        """Return what stands at instants within the run: exact, no interpolation; the samples stay as they are.

        Parameters
        ----------
        instants : array, shape (k,), increasing, within the times of the run [s]

        Raises
        ------
        InputError
            If an instant is outside the run, or they do not increase.
        """
        wanted = np.ascontiguousarray(instants, float)
        if wanted.ndim != 1 or not np.all(np.diff(wanted) >= 0.0):
            raise InputError("instants are a row that does not fall", f"got {wanted}", "sort them")
        if len(wanted) and not (self.time[0] <= wanted[0] and wanted[-1] <= self.time[-1]):
            raise InputError(
                f"instants lie within the run, {self.time[0]:g}..{self.time[-1]:g} s",
                f"got {wanted[0]:g}..{wanted[-1]:g} s",
                "simulate longer, or ask for fewer",
            )
        _, between, _ = self.setting.trace(self.time, self.current, wanted, 0)
        held = self.current[np.searchsorted(self.time, wanted, side="right") - 1]
        return trajectory_of(wanted, held, between, self.setting)

    @cached_property
    def energies(self) -> Energies:
        """Where the work of the pressure goes.

        The work is integrated by Gauss's rule of 6 nodes between samples and events, to about 1e-8 of it.
        """
        numbers = self.setting.model.numbers
        kinetic = 0.5 * numbers["stem_mass"] * self.velocity**2
        stored = stored_energy(numbers, self.stem_position)
        cuts = np.union1d(self.time, self.events.time)
        lengths = np.diff(cuts)
        instants = (cuts[:-1, None] + lengths[:, None] * (NODES + 0.5)).ravel()
        inside = self.at(instants)
        power = driving_force(numbers, inside, self.time[0]) * inside.velocity
        work = (power.reshape(-1, len(WEIGHTS)) * WEIGHTS).sum(axis=1) * lengths
        supplied = np.concatenate([[0.0], np.cumsum(work)])[np.searchsorted(cuts, self.time)]
        dissipated = supplied - (kinetic - kinetic[0]) - (stored - stored[0])
        return Energies(kinetic, stored, supplied, dissipated)


def trajectory_of(time: np.ndarray, current: np.ndarray, samples: np.ndarray, setting: Setting) -> Trajectory:
    """Make a trajectory of samples, dtype SAMPLE."""
    return Trajectory(
        time,
        current,
        np.ascontiguousarray(samples["pressure"]),
        np.ascontiguousarray(samples["reading"]),
        np.ascontiguousarray(samples["mode"]),
        np.ascontiguousarray(samples["position"]),
        np.ascontiguousarray(samples["velocity"]),
        setting,
    )


def _without_instant_rests(found: np.ndarray) -> np.ndarray:
    """Make a stop and the breakaway at the same instant, to the other side, one reversal."""
    is_stop = np.zeros(len(found), bool)
    is_stop[:-1] = (found["mode_after"][:-1] == 0.0) & (found["time"][1:] == found["time"][:-1])
    is_stop[:-1] &= found["mode_after"][1:] == -found["mode_before"][:-1]
    found["mode_after"][is_stop] = found["mode_after"][1:][is_stop[:-1]]
    return np.delete(found, np.flatnonzero(is_stop) + 1)


def stored_energy(numbers: dict[str, float], position: np.ndarray) -> np.ndarray:
    """Return the energy of the spring, preload and hardening included, and of a stop that gives way. [J]"""
    progression, hardening = numbers.get("spring_progression", 0.0), numbers.get("spring_hardening", 0.0)
    square = position * position
    spring = numbers["spring_rate"] * square * (0.5 + progression * position / 3.0 + 0.25 * hardening * square)
    energy = spring + numbers["spring_preload"] * position
    if numbers.get("stop_compliance", 0.0) > 0.0:
        depth = np.maximum(position - numbers["upper_stop"], 0.0) + np.maximum(numbers["lower_stop"] - position, 0.0)
        energy += 0.5 * depth**2 / numbers["stop_compliance"]
    return energy


def driving_force(numbers: dict[str, float], run: Trajectory, start: float) -> np.ndarray:
    """Return the force of pressure and load on the stem, of a load that began at a start [s]. [N]"""
    position = run.stem_position
    slope, curvature = numbers.get("area_slope", 0.0), numbers.get("area_curvature", 0.0)
    force = numbers["diaphragm_area"] * (1.0 + slope * position + curvature * position**2) * run.pressure
    if "load_period" in numbers:
        angle = 2.0 * math.pi * (run.time - start) / numbers["load_period"]
        force += numbers["load_sine"] * np.sin(angle) + numbers["load_cosine"] * np.cos(angle)
        for wave in range(2, int(numbers["load_waves"]) + 1):
            sine, cosine = numbers[f"load_sine_{wave}"], numbers[f"load_cosine_{wave}"]
            force += sine * np.sin(wave * angle) + cosine * np.cos(wave * angle)
    return force
