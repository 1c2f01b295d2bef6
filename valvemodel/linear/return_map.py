"""Return map: where a loop's stem stops, from turn to turn; its fixed point is the limit cycle."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from valvemodel.errors import InputError
from valvemodel.linear.limit_cycle import LimitCycle
from valvemodel.linear.loop import Loop
from valvemodel.linear.rates import (
    INTEGRAL,
    OUTPUT,
    POSITION,
    VELOCITY,
    controlled,
    excess,
    excess_force,
    rates,
    shown,
    static_pressure_at,
)

COVERED = frozenset(
    {
        "static_friction", "stribeck", "asymmetric_friction", "asymmetric_viscous_friction",
        "position_dependent_friction", "pressure_dependent_friction", "spring_hardening", "area_variation",
        "magnetic_saturation", "air_leak", "choked_flow",
    }
)  # fmt: skip
"""Effects without a memory of their own but for sticking."""

HORIZON = 1e5
"""A stem that has not moved for so long stays. [s]"""

RELATIVE, ABSOLUTE = 1e-9, 1e-12
"""Tolerances of the integration, in SI units."""

STEP = 1e-3
"""Step of the differences that give the map's derivative, over the slip jump."""

SETTLING, ROUNDS = 4, 15
"""Turns of the map before Newton's iteration, and its rounds."""

CLOSE = 1e-6
"""Change over the slip jump at which the fixed point is found."""

MOST_MOVES = 60
"""Moves in one turn after which a stem is taken to run away."""


@dataclass(frozen=True)
class Turn:
    """One turn: the section where it ends, its time, and the range of the controlled variable in it."""

    section: np.ndarray
    duration: float
    low: float
    high: float


class ReturnMap:
    """From the last stop before a rise to the next such stop, the controller being continuous.

    A section is the position at which the stem then breaks away upwards and, behind it, the output of the process;
    the controller's integral follows from the breakaway. The stem must have been at rest for the process's dead
    time by then: a loop in which it is not has no such map. Sticking and slipping are integrated by LSODA with
    events; nothing but the forces is shared with the simulator. A controller's period acts as a dead time of half of
    it, exact to first order.

    Parameters
    ----------
    loop : Loop

    Raises
    ------
    InputError
        If the model has an effect with a memory of its own.
    """

    def __init__(self, loop: Loop) -> None:
        for key in loop.model.effects:
            if key not in COVERED:
                raise InputError("the return map takes effects without memory", f"got {key}", "leave it out")
        self.loop = loop
        self._p = loop.model.rows()[0]
        self._s = loop.settings[0]
        static, kinetic = loop.stickiness()
        gain = 0.0 if loop.has_process else loop.proportional * loop.slip_gain
        self.jump = max((static - kinetic) / (1.0 + gain), 1e-3 * static)

    @property
    def start(self) -> np.ndarray:
        """Half a jump below the set point, the process at rest there. [m]"""
        return np.full(2 if self._s["lag"] > 0.0 else 1, float(self._s["setpoint"]) - 0.5 * self.jump)

    def states_at(self, section: np.ndarray) -> np.ndarray:
        """Return the states of the loop as the stem breaks away upwards."""
        from scipy.optimize import brentq

        position = float(section[0])

        def force(current: float) -> float:
            return excess_force(self._p, 1.0, position, static_pressure_at(self._p, current))

        reference = self.loop.current
        current = brentq(force, 0.0, 2.0 * reference, xtol=1e-15, rtol=1e-14)
        states = np.array([0.0, position, 0.0, float(section[-1])])
        error = float(self._s["setpoint"]) - controlled(self._s, states, 0.0, _at_rest(position))
        states[INTEGRAL] = current - reference - self.loop.proportional * error
        return states

    def turn(self, section: np.ndarray) -> Turn | None:
        """Follow the loop through one turn; None where the stem comes to rest, or the map is not closed."""
        course = _Course(self._p, self._s, self.states_at(section))
        side, has_fallen = 1.0, False
        for _ in range(MOST_MOVES):
            if not course.slip(side):
                return None
            stopped = course.time
            side = course.stick()
            if side == 0.0:
                return None
            if side > 0.0 and has_fallen:
                if course.time - stopped < self.loop.dead_time + 0.5 * self.loop.period:
                    return None
                values = np.concatenate(course.values)
                return Turn(course.section, course.time, float(values.min()), float(values.max()))
            has_fallen = has_fallen or side < 0.0
        return None

    def cycle(self, start: np.ndarray | None = None) -> LimitCycle | None:
        """Return the fixed point with its stability; None where the loop comes to rest or none is found."""
        section = self.start if start is None else start
        for _ in range(SETTLING):
            turn = self.turn(section)
            if turn is None:
                return None
            section = turn.section
        for _ in range(ROUNDS):
            turn, slope = self.turn(section), self.derivative(section)
            if turn is None or slope is None:
                return None
            change = np.linalg.solve(np.eye(len(section)) - slope, turn.section - section)
            if np.all(np.abs(change) < CLOSE * self.jump):
                multiplier = float(np.abs(np.linalg.eigvals(slope)).max())
                amplitude = 0.5 * (turn.high - turn.low)
                return LimitCycle("return map", turn.duration, amplitude, multiplier, self.states_at(section))
            section = section + np.clip(change, -0.5 * self.jump, 0.5 * self.jump)
        return None

    def derivative(self, section: np.ndarray) -> np.ndarray | None:
        """Return the derivative of the map, by central differences."""
        columns = []
        for number in range(len(section)):
            offset = np.zeros(len(section))
            offset[number] = STEP * self.jump
            above, below = self.turn(section + offset), self.turn(section - offset)
            if above is None or below is None:
                return None
            columns.append((above.section - below.section) / (2.0 * STEP * self.jump))
        return np.array(columns).T


def _at_rest(position: float) -> np.ndarray:
    return np.array([[0.0, position, 0.0]])


class _Course:
    """A loop that is followed from event to event, with the past of the stem."""

    def __init__(self, p: np.ndarray, s: np.ndarray, states: np.ndarray) -> None:
        self._p, self._s = p, s
        self._states, self.time = states, 0.0
        self._past = _at_rest(float(states[POSITION]))
        self.values: list[np.ndarray] = []

    @property
    def section(self) -> np.ndarray:
        """Position and, where there is a process with a lag, its output."""
        return self._states[[POSITION, OUTPUT] if self._s["lag"] > 0.0 else [POSITION]]

    def slip(self, side: float) -> bool:
        """Follow a slip to its stop; false where there is none."""

        def stops(time: float, states: np.ndarray) -> float:
            return float(side * states[VELOCITY] - self._p["stick_speed"])

        reached = self._flow(side, [stops], -1.0)
        self._states[VELOCITY] = 0.0
        self._past[-1, 2] = 0.0
        return reached

    def stick(self) -> float:
        """Wait until the stem breaks away and return the side; 0 where it never does."""
        excesses = [self._excess(side) for side in (1.0, -1.0)]
        now = [each(self.time, self._states) for each in excesses]
        if max(now) <= 0.0 and not self._flow(0.0, excesses, 1.0):
            return 0.0
        now = [each(self.time, self._states) for each in excesses]
        return 1.0 if now[0] > now[1] else -1.0

    def _excess(self, side: float) -> Callable[[float, np.ndarray], float]:
        def event(time: float, states: np.ndarray) -> float:
            return excess(self._p, self._s, side, states, time, self._past)

        return event

    def _flow(self, side: float, events: list, direction: float) -> bool:
        """Integrate until an event; false where there is none. Dead time: in parts, each with its past known."""
        from scipy.integrate import solve_ivp

        for event in events:
            event.terminal, event.direction = True, direction
        dead_time, end = float(self._s["dead_time"]), self.time + HORIZON
        emptied = self._past[-1, 0] + dead_time
        while self.time < end:
            is_quiet = dead_time == 0.0 or (side == 0.0 and self.time >= emptied)
            until = end if is_quiet else self.time + dead_time
            solution = solve_ivp(
                lambda time, states: rates(self._p, self._s, side, states, time, self._past),
                (self.time, until), self._states, method="LSODA", events=events, rtol=RELATIVE, atol=ABSOLUTE,
            )  # fmt: skip
            columns = np.ascontiguousarray(solution.y.T)
            pairs = zip(columns, solution.t, strict=True)
            self.values.append(np.array([shown(self._s, each, when, self._past) for each, when in pairs]))
            self._states, self.time = columns[-1].copy(), float(solution.t[-1])
            fresh = np.column_stack((solution.t, columns[:, POSITION], columns[:, VELOCITY]))
            self._past = np.concatenate((self._past, fresh[1:] if side != 0.0 else fresh[-1:]))
            if solution.status == 1:
                return True
        return False
