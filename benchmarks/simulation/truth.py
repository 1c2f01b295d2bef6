"""The stem problem in 50 digits: closed-form slips, written from the equations with mpmath alone."""

from __future__ import annotations

from collections.abc import Callable

import mpmath as mp

from benchmarks.simulation.workload import PERIOD, STOP_SPEED, PositionLoop, Stem

DIGITS = 50

CREEP = 1
"""A slip that slows down harder than this stops at speed 0. [m/s^2]"""

HALVINGS = 70
"""Leave 1e-23 s of a period."""


class ExactStem:
    """A stem that moves period by period; `has_rule` says whether a creep ends by the stop-speed rule."""

    def __init__(self, stem: Stem, start: float, *, has_rule: bool) -> None:
        self.mass, self.damping, self.rate = mp.mpf(stem.mass), mp.mpf(stem.damping), mp.mpf(stem.rate)
        self.area, self.coulomb, self.static = mp.mpf(stem.area), mp.mpf(stem.coulomb), mp.mpf(stem.static)
        self.has_rule = has_rule
        self.alpha = self.damping / (2 * self.mass)
        self.square = self.rate / self.mass
        gap = self.alpha**2 - self.square
        self.is_ringing = gap < 0
        self.beta = mp.sqrt(abs(gap))
        assert not self.is_ringing or self.beta * PERIOD < mp.pi, "one stop a period at most"
        self.period = mp.mpf(PERIOD)
        self.whole = self.shapes(self.period)
        self.y = self.area * mp.mpf(start) / self.rate
        self.v, self.side = mp.mpf(0), 0

    def shapes(self, t: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
        """Return exp(-alpha t) times the two motions, cosh or cos and sinh or sin over beta."""
        even, odd = (mp.cos, mp.sin) if self.is_ringing else (mp.cosh, mp.sinh)
        decay = mp.exp(-self.alpha * t)
        return decay * even(self.beta * t), decay * odd(self.beta * t) / self.beta

    def hold(self, pressure: float) -> None:
        """Hold a pressure for a period."""
        force, left = self.area * mp.mpf(pressure), self.period
        while left > 0:
            if self.side == 0 or (self.has_rule and abs(self.v) < STOP_SPEED):
                net = force - self.rate * self.y
                if abs(net) <= self.static:
                    self.v, self.side = mp.mpf(0), 0
                    return
                self.side = self.side or (1 if net > 0 else -1)
            left -= self.slip(force, left)

    def slip(self, force: mp.mpf, left: mp.mpf) -> mp.mpf:
        """Slip to the stop, or for what is left of the period; return the time used."""
        side, centre = self.side, (force - self.side * self.coulomb) / self.rate
        x, v = self.y - centre, self.v

        def at(t: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
            even, odd = self.whole if t == self.period else self.shapes(t)
            return x * even + (v + self.alpha * x) * odd, v * even - (self.square * x + self.alpha * v) * odd

        used, (x_end, v_end) = left, at(left)
        has_stopped = side * v_end <= 0
        if has_stopped:
            used = self.stop(v, self.square * x + self.alpha * v)
            x_end, v_end = at(used)
        if self.has_rule and self.has_crept(x_end, v_end, force - self.rate * centre):
            used = last(lambda t: not self.has_crept(*at(t), force - self.rate * centre), used)
            x_end, v_end = at(used)
            has_stopped = True
        self.y, self.v = x_end + centre, v_end
        if has_stopped:
            self.v, self.side = mp.mpf(0), 0
        return used

    def stop(self, v: mp.mpf, pull: mp.mpf) -> mp.mpf:
        """Return when tanh or tan of beta t is beta v / pull."""
        if self.is_ringing:
            angle = mp.atan2(self.beta * abs(v), pull * self.side) if v != 0 else mp.pi
            return angle / self.beta
        return mp.atanh(self.beta * v / pull) / self.beta

    def has_crept(self, x: mp.mpf, v: mp.mpf, friction: mp.mpf) -> bool:
        """Return whether a slip at x from its centre is a creep that friction would hold."""
        slowing = -self.side * (self.square * x + 2 * self.alpha * v)
        is_creep = self.side * v < STOP_SPEED and -CREEP < slowing < 0
        return bool(is_creep and abs(friction - self.rate * x) <= self.static)


def last(holds: Callable[[mp.mpf], bool], high: mp.mpf) -> mp.mpf:
    """Return the last instant at which something holds that does so from 0 on, by bisection."""
    low = mp.mpf(0)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if holds(middle) else (low, middle)
    return high


def exact_positions(stem: Stem, pressures: list[float], *, has_rule: bool = True) -> list[mp.mpf]:
    """Return the positions just before each pressure acts. [m]"""
    with mp.workdps(DIGITS):
        exact = ExactStem(stem, pressures[0], has_rule=has_rule)
        positions = []
        for pressure in pressures:
            positions.append(exact.y)
            exact.hold(pressure)
        return positions


def loop_pressures(stem: Stem, periods: int) -> list[float]:
    """Return the pressures that the closed loop gives on the exact stem. [Pa]"""
    with mp.workdps(DIGITS):
        loop = PositionLoop()
        pressures = [loop.pressure(0, stem.rest(loop.integral))]
        exact = ExactStem(stem, pressures[0], has_rule=True)
        for sample in range(1, periods):
            exact.hold(pressures[-1])
            pressures.append(loop.pressure(sample, float(exact.y)))
        return pressures
